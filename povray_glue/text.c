/* SPDX-License-Identifier: Apache-2.0 */
#include "text.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"
#include "path.h"

static _Thread_local bool is_lost;

bool glue_is_lost(void)
{
    return is_lost;
}

bool glue_settle(bool is_good, struct povray_error *error)
{
    if (!is_lost)
        return is_good;
    is_lost = false;
    if (!error->is_interrupted)
        snprintf(error->message, sizeof error->message, "out of memory");
    return false;
}

void *glue_grow(void *memory, size_t n_items, size_t item_bytes)
{
    size_t n_bytes;
    const bool is_too_large =
        __builtin_mul_overflow(n_items ? n_items : 1, item_bytes, &n_bytes);
    void *grown = is_too_large ? NULL : realloc(memory, n_bytes);
    is_lost |= !grown;
    return grown;
}

void *glue_alloc(size_t n_items, size_t item_bytes)
{
    void *memory = calloc(n_items ? n_items : 1, item_bytes);
    is_lost |= !memory;
    return memory;
}

void text_add(struct text *text, const char *data, size_t n)
{
    if (text->n + n + 1 > text->capacity) {
        const size_t capacity = 2 * (text->n + n) + 64;
        char *grown = glue_grow(text->data, capacity, 1);
        if (!grown)
            return;
        text->capacity = capacity;
        text->data = grown;
    }
    if (n)
        memcpy(text->data + text->n, data, n);
    text->n += n;
    text->data[text->n] = 0;
}

static void add_formatted(struct text *text, const char *format, va_list arguments)
{
    char *line = NULL;
    const int n = vasprintf(&line, format, arguments);
    is_lost |= n < 0;
    if (n < 0)
        return;
    text_add(text, line, (size_t)n);
    free(line);
}

void text_addf(struct text *text, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    add_formatted(text, format, arguments);
    va_end(arguments);
}

char *text_format(const char *format, ...)
{
    struct text text = {0};
    va_list arguments;
    va_start(arguments, format);
    add_formatted(&text, format, arguments);
    va_end(arguments);
    return text.data;
}

void text_free(struct text *text)
{
    free(text->data);
    *text = (struct text){0};
}

bool text_read_file(struct text *text, const char *path)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return false;
    char block[65536];
    size_t n;
    text_add(text, "", 0);
    while ((n = fread(block, 1, sizeof block, file)) > 0)
        text_add(text, block, n);
    const bool is_read = !ferror(file) && !is_lost;
    const int code = is_lost ? ENOMEM : errno;
    fclose(file);
    errno = code;
    return is_read;
}

bool text_write_file(const struct text *text, const char *path)
{
    errno = ENOMEM;
    FILE *file = path && !is_lost ? fopen(path, "wb") : NULL;
    if (!file)
        return false;
    bool is_written = fwrite(text->data, 1, text->n, file) == text->n;
    return fclose(file) == 0 && is_written;
}

char *path_folder(const char *path)
{
    return text_format("%.*s", (int)(os_path_name(path) - path), path);
}

bool path_is_file(const char *path)
{
    return path && os_file_facts(path).kind == OS_FILE_REGULAR;
}
