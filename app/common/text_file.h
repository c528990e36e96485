/* SPDX-License-Identifier: Apache-2.0 */
/* Text that is written beside its place and renamed: an old file survives any failure. */
#ifndef APP_TEXT_FILE_H
#define APP_TEXT_FILE_H

#include <stdbool.h>
#include <stdio.h>

#include "image.h"

/* Prints `data`; whether all of it could be written is asked afterwards. */
typedef void (*text_print_fn)(FILE *file, const void *data);

bool text_file_write(const char *path, text_print_fn print, const void *data,
                     struct image_error *error);

#endif
