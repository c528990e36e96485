/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Files that a run writes may be neither each other nor what it reads: one of them would
 * be lost without a word. First all that is written is added, then all that is read:
 *
 *     struct outputs outputs = {.error = error};
 *     outputs_add(&outputs, "output", tool->output);
 *     outputs_add(&outputs, "output-error", tool->output_error);
 *     outputs_spare(&outputs, NULL, paths[0]);
 *     return outputs.code;
 */
#ifndef APP_OUTPUTS_H
#define APP_OUTPUTS_H

#include <stdbool.h>

#include "common/frame_list.h"
#include "image.h"

struct output_file {
    const char *option; /* "output-coc" or "output_coc"; NULL: an input by itself */
    const char *path;
};

struct outputs {
    /* A sequence: the names are patterns (frame_list.h) and these are its frames. NULL:
     * they are names of files. */
    const struct frame_list *frames;
    int code; /* enum app_code; after the first error nothing is done */
    struct image_error *error;
    struct output_file files[4];
    int n;
};

/* A file that is written; it must be no other output. A path that is NULL is none. */
void outputs_add(struct outputs *outputs, const char *option, const char *path);

/* A file that is read; it must be no output. */
void outputs_spare(struct outputs *outputs, const char *option, const char *path);

/* The same of several, separated by commas. */
void outputs_spare_list(struct outputs *outputs, const char *option, const char *paths);

#endif
