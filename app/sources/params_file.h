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
 * file and line. */
bool params_file_read(const char *path, struct settings *settings,
                      struct image_error *error);

/* The same of a text; `name` is the file's in messages. */
bool params_text_read(const char *name, const char *text, struct settings *settings,
                      struct image_error *error);

/* Writes what was typed; beside its place and renamed. */
bool params_file_write(const char *path, const struct settings *settings,
                       struct image_error *error);

#endif
