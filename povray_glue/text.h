/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory, growing text, files and paths for the other modules of the glue.
 *
 * Where memory lacks, what is asked for here is NULL, or a text stays as it was; this
 * thread remembers it, and glue_settle() makes an error of it at the end of each
 * function of povray.h. So those between need only go on without harm: what they make
 * then is thrown away.
 */
#ifndef POVRAY_TEXT_H
#define POVRAY_TEXT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

#include "povray.h"

/* Zero-terminated once anything was added, data NULL before; start with {0}, end with
 * text_free. */
struct text {
    char *data;
    size_t n, capacity;
};

void text_add(struct text *text, const char *data, size_t n);
void text_addf(struct text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void text_free(struct text *text);

/* The whole text as a new string; the caller frees. NULL without memory. */
char *text_format(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Adds a whole file; false with errno set. */
bool text_read_file(struct text *text, const char *path);
bool text_write_file(const struct text *text, const char *path);

/* Zeroed memory, and realloc(): where it fails the old memory stays. NULL without
 * memory. */
void *glue_alloc(size_t n_items, size_t item_bytes);
void *glue_grow(void *memory, size_t n_items, size_t item_bytes);

/* Has memory been missing since glue_settle()? */
bool glue_is_lost(void);

/* is_good; but false with a message where memory was missing, which is then forgotten.
 */
bool glue_settle(bool is_good, struct povray_error *error);

/* The folder of a path: "" for a bare name, else with its final slash. The caller
 * frees; NULL without memory. */
char *path_folder(const char *path);
bool path_is_file(const char *path);

#endif
