/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Sequences: names with #### for the number of the frame, filtered frame by frame.
 *
 * The journal beside the output (journal.h) has a line per finished frame: its number,
 * what it was made of and with (a hash), size and checksum of the files. A frame is
 * skipped when a line still says what would be made and the files are as it says. So
 * any number of processes may work on one sequence, and a crash costs at most a frame
 * that is made again; two that make the same frame at once write the same bytes.
 */
#ifndef APP_SEQUENCE_H
#define APP_SEQUENCE_H

#include "filter/filter_run.h"
#include "sources/settings.h"

/* Is this the name of a sequence: with a place for the number (frame_list.h), and no
 * file itself? */
bool sequence_is_pattern(const char *name);

struct frames_report;

struct sequence_options {
    const char *frames;     /* "1-240x2,300"; NULL: those that there are */
    const char *parameters; /* CSV file or NULL */
    /* What was typed wins over the file, not what looks and files say; or NULL. */
    const struct settings *typed;
    int32_t n_jobs; /* frames at a time, 0: 2 */
    bool is_anew;   /* skip nothing */
    /* Not NULL: makes nothing, and fills it with what is there of each frame. */
    struct frames_report *report;
};

/*
 * Filters all frames: `tool` and `paths` as for one, with patterns in place of names.
 * `settings` is the command line. Failed frames are listed at the end; the others are
 * made. An enum app_code; its error has no words where the host was told of each frame.
 */
int sequence_run(const struct sequence_options *sequence,
                 const struct filter_options *tool, const struct settings *settings,
                 char *const *paths, int n_paths, struct image_error *error);

#endif
