/* SPDX-License-Identifier: Apache-2.0 */
/* Are the frames of a sequence there, whole, and made as they should be? */
#ifndef APP_FRAMES_CHECK_H
#define APP_FRAMES_CHECK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "common/frame_list.h"
#include "image.h"
#include "sequence/journal.h"

enum frame_verdict {
    FRAME_FINISHED,
    FRAME_MISSING, /* there is no file */
    FRAME_DAMAGED, /* its file is not as it was written, or cannot be read */
    FRAME_OTHER,   /* made of other inputs, with other parameters or another version */
    FRAME_UNKNOWN, /* no journal says what it was made of */
    FRAME_N_VERDICTS,
};

/* The word for it: "finished", "missing", ... */
const char *frame_verdict_word(enum frame_verdict verdict);

/* What is known of a frame. Texts that are not known are empty, numbers 0. */
struct frame_check {
    int32_t number;
    enum frame_verdict verdict;
    char *path;    /* of its picture; NULL without memory */
    char why[480]; /* what is wrong, and what the last attempt said */
    /* Of the line that says it is finished: */
    char host[40];
    int64_t process;
    double date_s, seconds;
    char made[240]; /* what the filter said of it */
    bool has_radii;
    double least_radius_px, most_radius_px; /* signed, positive behind the focus */
    int32_t n_warnings;
    char warning[480]; /* the last of them */
};

struct frames_report {
    struct frame_check *frames;
    int n;
};

/* Room for the frames of a list, of which nothing is known yet. False without memory. */
bool frames_report_start(struct frames_report *report, const struct frame_list *list,
                         struct image_error *error);
void frames_report_free(struct frames_report *report);
int frames_report_count(const struct frames_report *report, enum frame_verdict verdict);

/* The frames that are not finished as a list, "3,7-9,12"; the caller frees. NULL
 * without memory. */
char *frames_report_open_list(const struct frames_report *report);

/* The files of a frame; NULL where there is none of a kind. The first is its picture. */
enum { FRAME_MAX_FILES = 3 };
struct frame_files {
    const char *paths[FRAME_MAX_FILES];
};

/* "SUM:BYTES ...", CRC-32 and size of the files; false where one cannot be read. */
enum { FRAME_SUMS = 128 };
bool frame_sum_files(const struct frame_files *files, char sums[FRAME_SUMS]);

/*
 * What a frame is made of and with, as one number (FNV-1a) to which each of these adds:
 * bytes, a text or none, and a file by its name, size and time, not by what it holds,
 * which would cost reading it.
 */
#define FRAME_HASH_START UINT64_C(0xcbf29ce484222325)
void frame_hash_bytes(uint64_t *hash, const void *data, size_t n);
void frame_hash_text(uint64_t *hash, const char *text);
void frame_hash_file(uint64_t *hash, const char *path);
/* All parameters, and where each came from. */
struct settings;
void frame_hash_settings(uint64_t *hash, const struct settings *settings);

/* Does a line of the journal say that the frame was made so (its hash), and are the
 * files as it says? Reads the journal and the files only where that may be. */
bool frame_is_finished(struct journal *journal, int32_t number, uint64_t hash,
                       const struct frame_files *files);

/*
 * Fills the verdict on a frame and what the journal knows. `hash`: what it should be
 * made of and with; NULL: whatever that was, and where no journal knows the frame its
 * picture must be one that can be read. False without memory.
 */
bool frame_check_files(struct frame_check *check, struct journal *journal,
                       const uint64_t *hash, const struct frame_files *files,
                       struct image_error *error);

/*
 * Checks the pictures that `pattern` names: the frames of `list`, or without one (NULL)
 * all from the first to the last that is there. False with the error.
 */
bool frames_check_pattern(struct frames_report *report, const char *pattern,
                          const struct frame_list *list, struct image_error *error);

#endif
