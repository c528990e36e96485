/* SPDX-License-Identifier: Apache-2.0 */
/* Growing text, files and paths for the other modules of the glue. */
#ifndef POVRAY_TEXT_H
#define POVRAY_TEXT_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

/* Zero-terminated once anything was added; start with {0}, end with text_free. */
struct text {
    char *data;
    size_t n, capacity;
};

void text_add(struct text *text, const char *data, size_t n);
void text_addf(struct text *text, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void text_free(struct text *text);

/* The whole text as a new string; the caller frees. */
char *text_format(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Reads a whole file; false with errno set. */
bool text_read_file(struct text *text, const char *path);
bool text_write_file(const struct text *text, const char *path);

/* Memory or the end of the program: the glue works on small texts. */
void *glue_alloc(size_t n_items, size_t item_bytes);
void *glue_grow(void *memory, size_t n_items, size_t item_bytes);

/* The folder of a path: "" for a bare name, else with its final slash. */
char *path_folder(const char *path);
bool path_is_file(const char *path);

#endif
