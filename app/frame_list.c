/* SPDX-License-Identifier: Apache-2.0 */
#include "frame_list.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "folder.h"
#include "rackfocus/rackfocus.h"
#include "report.h"

enum { MAX_FRAMES = 1000000, MAX_LINE = 4096 };

/* ---- lists ---------------------------------------------------------------------- */

static int compare_numbers(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

static void sort_once(struct frame_list *list)
{
    int n = 0;
    qsort(list->numbers, (size_t)list->n, sizeof(*list->numbers), compare_numbers);
    for (int i = 0; i < list->n; i++)
        if (i == 0 || list->numbers[i] != list->numbers[n - 1])
            list->numbers[n++] = list->numbers[i];
    list->n = n;
}

static void add(struct frame_list *list, int32_t number)
{
    if ((list->n & (list->n - 1)) == 0) {
        const size_t room = list->n ? 2 * (size_t)list->n : 1;
        int32_t *grown = need_memory(room, sizeof(*grown));
        if (list->n)
            memcpy(grown, list->numbers, (size_t)list->n * sizeof(*grown));
        free(list->numbers);
        list->numbers = grown;
    }
    list->numbers[list->n++] = number;
}

/* A whole number at *text, which moves behind it. */
static bool take_number(const char **text, int32_t *number)
{
    char *end;
    errno = 0;
    const long v = strtol(*text, &end, 10);
    if (end == *text || isspace((unsigned char)**text) || errno || v < -MAX_FRAMES ||
        v > 100 * MAX_FRAMES)
        return false;
    *number = (int32_t)v;
    *text = end;
    return true;
}

static bool take_range(const char **text, int32_t *first, int32_t *last, int32_t *step)
{
    *step = 1;
    if (!take_number(text, first))
        return false;
    *last = *first;
    if (**text == '-') {
        (*text)++;
        if (!take_number(text, last) || *last < *first)
            return false;
    }
    if (**text == 'x') {
        (*text)++;
        if (!take_number(text, step) || *step < 1)
            return false;
    }
    return **text == ',' || **text == '\0';
}

bool frame_list_parse(struct frame_list *list, const char *text, char *message,
                      size_t n_bytes)
{
    *list = (struct frame_list){0};
    for (const char *at = text;; at++) {
        int32_t first, last, step;
        if (!take_range(&at, &first, &last, &step) ||
            (last - first) / step + 1 > MAX_FRAMES - list->n) {
            snprintf(message, n_bytes,
                     "'%s' is no list of frames; write 1-240, 1-240x2 for every second "
                     "one, or 1-10,20,30-40",
                     text);
            frame_list_free(list);
            return false;
        }
        for (int64_t k = first; k <= last; k += step)
            add(list, (int32_t)k);
        if (*at == '\0')
            break;
    }
    sort_once(list);
    return true;
}

void frame_list_free(struct frame_list *list)
{
    free(list->numbers);
    *list = (struct frame_list){0};
}

/* ---- names ---------------------------------------------------------------------- */

static const char *last_part(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* The last run of # in the last part; NULL where there is none. */
static const char *find_run(const char *pattern, size_t *n)
{
    const char *name = last_part(pattern), *end = strrchr(name, '#');
    if (!end)
        return NULL;
    const char *begin = end;
    while (begin > name && begin[-1] == '#')
        begin--;
    *n = (size_t)(end - begin) + 1;
    return begin;
}

char *frame_name(const char *pattern, int32_t number)
{
    size_t n = 0;
    const char *run = find_run(pattern, &n);
    const size_t size = strlen(pattern) + 16;
    char *name = need_memory(size, 1);
    if (run)
        snprintf(name, size, "%.*s%0*d%s", (int)(run - pattern), pattern, (int)n,
                 (int)number, run + n);
    else
        snprintf(name, size, "%s", pattern);
    return name;
}

/* The frames that a folder has. */
struct search {
    struct frame_list *list;
    const char *name; /* the pattern without its folder */
    size_t n_before;  /* characters before the number */
};

static bool visit_file(void *user, const char *file)
{
    const struct search *search = user;
    int32_t number;
    if (strncmp(file, search->name, search->n_before) != 0)
        return true;
    const char *at = file + search->n_before;
    if (!take_number(&at, &number))
        return true;
    char *again = frame_name(search->name, number);
    if (strcmp(again, file) == 0)
        add(search->list, number);
    free(again);
    return true;
}

bool frame_list_find(struct frame_list *list, const char *pattern, char *message,
                     size_t n_bytes)
{
    size_t n = 0;
    const char *run = find_run(pattern, &n), *name = last_part(pattern);
    char *folder = need_memory((size_t)(name - pattern) + 2, 1);
    memcpy(folder, name == pattern ? "." : pattern,
           name == pattern ? 1 : (size_t)(name - pattern));
    *list = (struct frame_list){0};
    struct search search = {list, name, (size_t)(run - name)};
    const int reason = os_folder_list(folder, visit_file, &search);
    if (reason != 0)
        snprintf(message, n_bytes, "%s: %s", folder, strerror(reason));
    free(folder);
    if (reason != 0)
        return false;
    if (list->n == 0) {
        snprintf(message, n_bytes, "%s: no such frames; is the number of # right?",
                 pattern);
        return false;
    }
    sort_once(list);
    return true;
}

/* ---- CSV ------------------------------------------------------------------------ */

static char *trim(char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    char *end = text + strlen(text);
    while (end > text && isspace((unsigned char)end[-1]))
        *--end = '\0';
    return text;
}

static char *copy_text(const char *text)
{
    char *copy = need_memory(strlen(text) + 1, 1);
    strcpy(copy, text);
    return copy;
}

static void *grow(void *memory, size_t n_old, size_t n, size_t item_bytes)
{
    void *grown = need_memory(n, item_bytes);
    if (n_old)
        memcpy(grown, memory, n_old * item_bytes);
    free(memory);
    return grown;
}

static bool read_keys(struct frame_table *table, char *line, const char *path,
                      char *message, size_t n_bytes)
{
    char *rest = line, *word = trim(strsep(&rest, ","));
    if (strcmp(word, "frame") != 0 || !rest) {
        snprintf(
            message, n_bytes,
            "%s:1: the first line names the columns: frame, then parameters, as in "
            "frame,focus-distance",
            path);
        return false;
    }
    while (rest) {
        word = trim(strsep(&rest, ","));
        if (!rf_param_find(word)) {
            snprintf(message, n_bytes, "%s:1: there is no parameter '%s'", path, word);
            return false;
        }
        const size_t n = (size_t)table->n_keys;
        table->keys = grow(table->keys, n, n + 1, sizeof(*table->keys));
        table->keys[table->n_keys++] = copy_text(word);
    }
    return true;
}

static bool read_row(struct frame_table *table, char *line, const char *path,
                     int number, char *message, size_t n_bytes)
{
    const size_t n_rows = (size_t)table->n_rows, n_keys = (size_t)table->n_keys;
    char *rest = line;
    const char *word = trim(strsep(&rest, ","));
    int32_t frame;
    bool is_good = take_number(&word, &frame) && *word == '\0';
    table->frames = grow(table->frames, n_rows, n_rows + 1, sizeof(*table->frames));
    table->values = grow(table->values, n_rows * n_keys, (n_rows + 1) * n_keys,
                         sizeof(*table->values));
    table->frames[n_rows] = is_good ? frame : 0;
    table->n_rows++;
    for (size_t i = 0; i < n_keys && is_good; i++) {
        char *value = rest ? trim(strsep(&rest, ",")) : NULL;
        is_good = value && *value;
        if (is_good)
            table->values[n_rows * n_keys + i] = copy_text(value);
    }
    if (is_good && !rest)
        return true;
    snprintf(message, n_bytes, "%s:%d: a row is a frame and %d value%s", path, number,
             table->n_keys, table->n_keys == 1 ? "" : "s");
    return false;
}

bool frame_table_read(struct frame_table *table, const char *path, char *message,
                      size_t n_bytes)
{
    char line[MAX_LINE];
    *table = (struct frame_table){0};
    FILE *file = fopen(path, "r");
    if (!file) {
        snprintf(message, n_bytes, "%s: %s", path, strerror(errno));
        return false;
    }
    bool is_good = true;
    int number = 0;
    while (is_good && fgets(line, sizeof(line), file)) {
        char *text = trim(line);
        number++;
        if (*text == '\0' || *text == '#')
            continue;
        is_good = table->keys ? read_row(table, text, path, number, message, n_bytes)
                              : read_keys(table, text, path, message, n_bytes);
    }
    if (is_good && table->n_rows == 0) {
        snprintf(message, n_bytes, "%s: has no rows", path);
        is_good = false;
    }
    fclose(file);
    if (!is_good)
        frame_table_free(table);
    return is_good;
}

int frame_table_row(const struct frame_table *table, int32_t frame)
{
    for (int i = 0; i < table->n_rows; i++)
        if (table->frames[i] == frame)
            return i;
    return -1;
}

void frame_table_free(struct frame_table *table)
{
    for (int i = 0; i < table->n_keys; i++)
        free(table->keys[i]);
    for (int i = 0; i < table->n_keys * table->n_rows; i++)
        free(table->values[i]);
    free(table->keys);
    free(table->frames);
    free(table->values);
    *table = (struct frame_table){0};
}
