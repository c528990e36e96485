/* SPDX-License-Identifier: Apache-2.0 */
/* The job of a sequence in the words of a scheduler: a file. */
#ifndef CLI_FARM_JOB_H
#define CLI_FARM_JOB_H

#include <stdbool.h>
#include <stdint.h>

#include "commands/command_line.h"
#include "image.h"

/* In the order of the choices of --to. */
enum farm_kind { FARM_SLURM, FARM_OPENJD, FARM_SCRIPT, FARM_N_KINDS };
#define FARM_CHOICES "slurm|openjd|script"

/* Tasks that a job has at most: Slurm's MaxArraySize is 1001 unless a site says more, and
 * Open Job Description allows 1024 values of a parameter. */
enum { FARM_MAX_CHUNKS = 1000 };

struct farm_job {
    const char *program;      /* rackfocus on the machines of the farm */
    const char *folder;       /* from the root; names are seen from there */
    const char *name;         /* of the output, shown by the scheduler */
    struct command_line line; /* what makes the frames */
    const char *frames;       /* all, as a list: what the last step checks */
    char *const *chunks;      /* lists, one per task; no blanks in them */
    int n_chunks;
    /* Where the views of a frame are rendered by tasks of their own, before those that
     * merge them: which each renders, "0-3"; 0 of them: the frames are made whole. */
    char *const *views;
    int n_views;
    int32_t n_threads; /* of a task; 0: one per processor of its machine */
    const char *html;  /* the report of the last step; NULL: none */
};

/* Writes it to `path`, beside it and renamed. False with the error. */
bool farm_job_write(const struct farm_job *job, enum farm_kind kind, const char *path,
                    struct image_error *error);

#endif
