/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The journal of a sequence: which frames are finished, and who made them.
 *
 * Many processes on many machines write at once, in a folder that they share and whose
 * locks and appends may not reach the others (NFS). So each process has a file of its
 * own, PATTERN.frames.HOST-PROCESS-TIME, to which nobody else writes, and reads those
 * of all. Where a process finds at its end that no other is at work (those of its own
 * machine may be dead) it folds the files into PATTERN.frames, as journal_fold() does
 * whoever is at work: the new one is written beside it and renamed, and only then are
 * the folded ones removed.
 *
 * Lines, each in one write that begins and ends with an end of line:
 *
 *     NUMBER HASH SUM:BYTES[ SUM:BYTES...] @ HOST PROCESS DATE SECONDS
 *     # NUMBER KIND @ HOST PROCESS DATE TEXT
 *
 * The first is a finished frame: what it was made of and with (a hash), checksum and
 * size of its files, the date in seconds since 1970 and how long it took. The second is
 * a note on a frame. What follows @ may be missing, as in journals of version 0.1.
 *
 * Nothing in a line is believed alone: a frame counts as finished where line, hash,
 * size and checksum agree with the files that are there. So a line that was cut off, or
 * one lost when two processes fold at once, costs at most a frame made again.
 */
#ifndef APP_JOURNAL_H
#define APP_JOURNAL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "image.h"
#include "thread.h"

enum journal_kind {
    JOURNAL_FINISHED,
    JOURNAL_MADE,    /* what the filter said of the frame */
    JOURNAL_WARNING, /* of which it warned */
    JOURNAL_FAILED,  /* why an attempt failed */
    JOURNAL_N_KINDS,
};

/* A line as read; its texts belong to the journal. */
struct journal_line {
    int32_t number; /* of the frame */
    enum journal_kind kind;
    uint64_t hash;    /* of what finished */
    const char *text; /* "SUM:BYTES ..." of what finished, else the note */
    const char *host; /* "" where the line does not say */
    int64_t process;  /* 0: likewise */
    double date_s;    /* since 1970; 0: likewise */
    double seconds;   /* that a finished frame took; 0: likewise */
    int32_t order;    /* of reading */
};

struct journal {
    char *path;     /* PATTERN.frames */
    char *own_path; /* this process's */
    char host[40];
    char **buffers; /* files as read: the texts of the lines */
    int n_buffers;
    struct journal_line *lines; /* by number, then as read */
    int n_lines;
    bool is_loaded;
    struct os_lock lock;
};

/* The journal of the output `pattern`, one for all its spellings (####, %04d, $F4), with
 * #; reads nothing yet. False without memory: there
 * is nothing to close. */
bool journal_open(struct journal *journal, const char *pattern,
                  struct image_error *error);

/* Folds the files where no other process is at work, and frees. */
void journal_close(struct journal *journal);

/* Reads all files, once; may be called on several threads. False where there is no
 * memory; what cannot be read is as if it were not there. */
bool journal_load(struct journal *journal, struct image_error *error);

/* The lines of a frame, of a loaded journal: the first, and how many follow it. */
const struct journal_line *journal_lines(const struct journal *journal, int32_t number,
                                         int *n);

/* Adds the line of a finished frame; `files` is "SUM:BYTES ...". 0 or errno. */
int journal_add_finished(struct journal *journal, int32_t number, uint64_t hash,
                         const char *files, double seconds);

/* Adds a note, which is not JOURNAL_FINISHED; ends of lines in it become blanks. 0 or
 * errno. */
int journal_add_note(struct journal *journal, int32_t number, enum journal_kind kind,
                     const char *text);

/* Folds the files of all processes into PATTERN.frames. A process that is still at work
 * loses at most what it adds meanwhile. False with the error; then nothing is lost. */
bool journal_fold(struct journal *journal, struct image_error *error);

#endif
