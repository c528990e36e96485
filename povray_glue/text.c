/* SPDX-License-Identifier: Apache-2.0 */
#include "text.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "file.h"

void *glue_grow(void *memory, size_t n_items, size_t item_bytes)
{
    void *grown = reallocarray(memory, n_items ? n_items : 1, item_bytes);
    if (!grown) {
        fputs("rackfocus: out of memory\n", stderr);
        exit(1);
    }
    return grown;
}

void *glue_alloc(size_t n_items, size_t item_bytes)
{
    void *memory = glue_grow(NULL, n_items, item_bytes);
    memset(memory, 0, (n_items ? n_items : 1) * item_bytes);
    return memory;
}

void text_add(struct text *text, const char *data, size_t n)
{
    if (text->n + n + 1 > text->capacity) {
        text->capacity = 2 * (text->n + n) + 64;
        text->data = glue_grow(text->data, text->capacity, 1);
    }
    if (n)
        memcpy(text->data + text->n, data, n);
    text->n += n;
    text->data[text->n] = 0;
}

static void add_formatted(struct text *text, const char *format, va_list arguments)
{
    char *line = NULL;
    int n = vasprintf(&line, format, arguments);
    if (n < 0) {
        fputs("rackfocus: out of memory\n", stderr);
        exit(1);
    }
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
    bool is_read = !ferror(file);
    int code = errno;
    fclose(file);
    errno = code;
    return is_read;
}

bool text_write_file(const struct text *text, const char *path)
{
    FILE *file = fopen(path, "wb");
    if (!file)
        return false;
    bool is_written = fwrite(text->data, 1, text->n, file) == text->n;
    return fclose(file) == 0 && is_written;
}

char *path_folder(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? text_format("%.*s", (int)(slash - path + 1), path)
                 : text_format("%s", "");
}

bool path_is_file(const char *path)
{
    return os_file_facts(path).kind == OS_FILE_REGULAR;
}
