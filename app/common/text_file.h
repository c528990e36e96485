/* SPDX-License-Identifier: Apache-2.0 */
/* Text files: read as a whole, and written beside their place and renamed, so that an
 * old file survives any failure. */
#ifndef APP_TEXT_FILE_H
#define APP_TEXT_FILE_H

#include <stdbool.h>
#include <stdio.h>

#include "image.h"

/* Prints `data`; whether all of it could be written is asked afterwards. */
typedef void (*text_print_fn)(FILE *file, const void *data);

bool text_file_write(const char *path, text_print_fn print, const void *data,
                     struct image_error *error);

/*
 * All of a text, to be freed by the caller, without a byte-order mark; NULL where it
 * cannot be read or is no text, such as a folder or UTF-16. Pipes are read too.
 */
char *text_file_read(const char *path, struct image_error *error);

/* The next line, which is ended in place, by LF, CR LF or, as spreadsheets for Macs have
 * it, by CR alone; NULL behind the last. */
char *text_next_line(char **rest);

#endif
