/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Parameters in a text file: a line `key value` each, as on the command line without
 * the dashes; empty lines and lines that begin with # are skipped.
 */
#ifndef APP_PARAMS_FILE_H
#define APP_PARAMS_FILE_H

#include <stdbool.h>

#include "image.h"
#include "sources/settings.h"

/* Sets what the file says, as if typed; what was typed before stays. A message names
 * file and line. `n_named`, if not NULL, receives how many lines name a parameter. */
bool params_file_read(const char *path, struct settings *settings, int *n_named,
                      struct image_error *error);

/* What to tell of a file that names none; takes its name. */
#define PARAMS_FILE_IS_EMPTY                                                           \
    "%s: has no effect: no parameter stands in it (empty, or remarks alone); each "    \
    "has "                                                                             \
    "a line, such as 'f-stop 2.8'"

/* The same of a text; `name` is the file's in messages. */
bool params_text_read(const char *name, const char *text, struct settings *settings,
                      struct image_error *error);

/* Writes what was typed; beside its place and renamed. */
bool params_file_write(const char *path, const struct settings *settings,
                       struct image_error *error);

#endif
