/* SPDX-License-Identifier: Apache-2.0 */
/*
 * "-" as a name: standard input and output. Pictures are read and written in any order,
 * which a pipe does not allow, so they pass through a private folder.
 */
#ifndef CLI_PIPES_H
#define CLI_PIPES_H

#include <stdbool.h>

#include "common/operands.h"
#include "common/report.h"
#include "image.h"

struct pipes {
    char folder[512]; /* "" where none was needed */
    char input[600], output[600];
    bool has_output;
};

/* Is "-" among the inputs or the output? */
bool pipes_are_named(const struct operands *operands, const char *output);

/*
 * Reads standard input to its end where it is an input, and puts the name of the file
 * in its place. `*output` (may be NULL) that is "-" becomes a file, EXR, or PNG where
 * `is_png`. APP_DONE, APP_USAGE or APP_FAILED with the error; close in any case.
 */
enum app_code pipes_open(struct pipes *pipes, struct operands *operands,
                         const char **output, bool is_png, struct image_error *error);

/* Copies the output to standard output. */
bool pipes_send(const struct pipes *pipes, struct image_error *error);

void pipes_close(struct pipes *pipes);

#endif
