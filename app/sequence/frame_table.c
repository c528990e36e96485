/* SPDX-License-Identifier: Apache-2.0 */
#include "sequence/frame_table.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/frame_list.h"
#include "common/report.h"
#include "common/text_file.h"
#include "rackfocus/rackfocus.h"

static char *trim(char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    char *end = text + strlen(text);
    while (end > text && isspace((unsigned char)end[-1]))
        *--end = '\0';
    return text;
}

static bool grow(void **memory, size_t n_old, size_t n, size_t item_bytes,
                 struct image_error *error)
{
    void *grown = app_memory(n, item_bytes, error);
    if (!grown)
        return false;
    if (n_old)
        memcpy(grown, *memory, n_old * item_bytes);
    free(*memory);
    *memory = grown;
    return true;
}

static bool copy_text(char **copy, const char *text, struct image_error *error)
{
    *copy = app_memory(strlen(text) + 1, 1, error);
    if (*copy)
        strcpy(*copy, text);
    return *copy != NULL;
}

/* A column may be named by key or by field. */
static bool has_column(const struct frame_table *table, const char *word)
{
    for (int i = 0; i < table->n_keys; i++)
        if (strcmp(table->keys[i], word) == 0 ||
            (i != table->easing_key && rf_param_find(word) &&
             rf_param_find(word) == rf_param_find(table->keys[i])))
            return true;
    return false;
}

/* Spreadsheets separate by what their language says. */
static bool check_commas(const char *line, const char *path, int number,
                         struct image_error *error)
{
    const char *other = strpbrk(line, ";\t");
    if (strchr(line, ',') || !other)
        return true;
    const bool is_tab = *other == '\t';
    return set_error(
        error,
        "%s:%d: there are %s between the columns; separate them by commas, "
        "as in frame,focus-distance, and write decimals with a point",
        path, number, is_tab ? "tabs" : "semicolons (;)");
}

/* The next cell of a line, without blanks and quotes around it: many programs write all
 * cells in quotes. */
static char *next_cell(char **rest)
{
    char *word = trim(strsep(rest, ","));
    const size_t n = strlen(word);
    if (n < 2 || word[0] != '"' || word[n - 1] != '"')
        return word;
    word[n - 1] = '\0';
    return trim(word + 1);
}

/* A whole number, of tables of floats too: 12 or 12.0. */
static bool read_frame(const char *word, int32_t *frame)
{
    char whole[16];
    const char *point = strchr(word, '.');
    const size_t n = point ? (size_t)(point - word) : 0;
    if (n == 0 || n >= sizeof(whole) || strspn(point + 1, "0") != strlen(point + 1))
        return frame_number_parse(word, frame);
    memcpy(whole, word, n);
    whole[n] = '\0';
    return frame_number_parse(whole, frame);
}

static bool read_keys(struct frame_table *table, char *line, const char *path,
                      int number, struct image_error *error)
{
    if (!check_commas(line, path, number, error))
        return false;
    char *rest = line, *word = next_cell(&rest);
    if (strcasecmp(word, "frame") != 0 || !rest)
        return set_error(error,
                         "%s:%d: the first line names the columns: frame, then "
                         "parameters, as in frame,focus-distance",
                         path, number);
    while (rest) {
        word = next_cell(&rest);
        const bool is_easing = strcmp(word, "easing") == 0;
        if (has_column(table, word))
            return set_error(error,
                             "%s:%d: there are two columns '%s'; leave one of them out",
                             path, number, word);
        if (is_easing)
            table->easing_key = table->n_keys;
        else if (!rf_param_find(word))
            return set_error(error, "%s:%d: there is no parameter '%s'; %s", path,
                             number, word,
                             strcmp(word, "look") == 0
                                 ? "--look is of all frames, and what `rackfocus "
                                   "looks` lists for it may be columns"
                                 : "`rackfocus filter --help` lists them, and a "
                                   "column may be called easing");
        const size_t n = (size_t)table->n_keys;
        if (!grow((void **)&table->keys, n, n + 1, sizeof(*table->keys), error) ||
            !copy_text(&table->keys[n], word, error))
            return false;
        table->n_keys++;
    }
    return true;
}

/* In the order of easing_words. */
enum easing { HOLD, LINEAR, EASE_IN, EASE_OUT, EASE_IN_OUT, N_EASINGS };
static const char *const easing_words[N_EASINGS] = {"hold", "linear", "ease-in",
                                                    "ease-out", "ease-in-out"};

/* N_EASINGS: it is none. */
static enum easing easing_of(const char *word)
{
    int i = 0;
    while (i < N_EASINGS && strcmp(word, easing_words[i]) != 0)
        i++;
    return (enum easing)i;
}

static bool check_easing(const char *word, const char *path, int number,
                         struct image_error *error)
{
    return easing_of(word) != N_EASINGS ||
           set_error(error,
                     "%s:%d: '%s' is no easing; there are hold, linear, ease-in, "
                     "ease-out and ease-in-out",
                     path, number, word);
}

static bool has_row(const struct frame_table *table, int32_t frame)
{
    for (int i = 0; i < table->n_rows; i++)
        if (table->frames[i] == frame)
            return true;
    return false;
}

static bool read_row(struct frame_table *table, char *line, const char *path,
                     int number, struct image_error *error)
{
    const size_t n_rows = (size_t)table->n_rows, n_keys = (size_t)table->n_keys;
    if (!check_commas(line, path, number, error))
        return false;
    char *rest = line;
    const char *word = next_cell(&rest);
    int32_t frame;
    bool is_good = read_frame(word, &frame);
    if (!is_good)
        return set_error(error,
                         "%s:%d: '%s' is no number of a frame; a row begins with a "
                         "whole one",
                         path, number, word);
    if (has_row(table, frame))
        return set_error(error,
                         "%s:%d: frame %s has a row before this one; leave one of "
                         "them out",
                         path, number, word);
    if (!grow((void **)&table->frames, n_rows, n_rows + 1, sizeof(*table->frames),
              error) ||
        !grow((void **)&table->values, n_rows * n_keys, (n_rows + 1) * n_keys,
              sizeof(*table->values), error))
        return false;
    table->frames[n_rows] = frame;
    table->n_rows++;
    for (size_t i = 0; i < n_keys && is_good; i++) {
        char *value = rest ? next_cell(&rest) : NULL;
        is_good = value && *value;
        if (is_good && !copy_text(&table->values[n_rows * n_keys + i], value, error))
            return false;
    }
    if (is_good && !rest && table->easing_key >= 0)
        return check_easing(table->values[n_rows * n_keys + (size_t)table->easing_key],
                            path, number, error);
    return (is_good && !rest) ||
           set_error(error, "%s:%d: a row is a frame and %d value%s", path, number,
                     table->n_keys, table->n_keys == 1 ? "" : "s");
}

static bool read_table(struct frame_table *table, char *text, const char *path,
                       struct image_error *error)
{
    char *line;
    for (int number = 1; (line = text_next_line(&text)) != NULL; number++) {
        char *row = trim(line);
        if (*row == '\0' || *row == '#')
            continue;
        if (table->keys ? !read_row(table, row, path, number, error)
                        : !read_keys(table, row, path, number, error))
            return false;
    }
    return table->n_rows > 0 ||
           set_error(error, "%s: has no rows; give frames and their values", path);
}

bool frame_table_read(struct frame_table *table, const char *path,
                      struct image_error *error)
{
    *table = (struct frame_table){.easing_key = -1};
    char *text = text_file_read(path, error);
    const bool is_good = text ? read_table(table, text, path, error)
                              : app_missing(error, "frame-parameters", path);
    free(text);
    if (!is_good)
        frame_table_free(table);
    return is_good;
}

/* How far along to the next row. */
static double ease(enum easing easing, double t)
{
    switch (easing) {
    case LINEAR:
        return t;
    case EASE_IN:
        return t * t;
    case EASE_OUT:
        return 1 - (1 - t) * (1 - t);
    case EASE_IN_OUT:
        return t * t * (3 - 2 * t);
    default:
        return 0;
    }
}

/* The last row at or before the frame and the first one behind it; -1: there is none. */
static void find_rows(const struct frame_table *table, int32_t frame, int *before,
                      int *after)
{
    const int32_t *frames = table->frames;
    *before = *after = -1;
    for (int i = 0; i < table->n_rows; i++) {
        if (frames[i] <= frame && (*before < 0 || frames[i] > frames[*before]))
            *before = i;
        if (frames[i] > frame && (*after < 0 || frames[i] < frames[*after]))
            *after = i;
    }
}

static const char *cell(const struct frame_table *table, int row, int key)
{
    return table->values[row * table->n_keys + key];
}

/*
 * Is 0 a word of this parameter, for none or for what follows from others? Nothing lies
 * between it and a number: on the way from no split diopter to one at 3 is none at 1.
 */
static bool has_word_at_0(const struct rf_param_info *param)
{
    static const char *const keys[] = {
        "lens-radius",   "focal-length-px", "screen-position", "aperture-coefficient",
        "max-radius",    "blur-radius",     "region-size",     "region-slope",
        "split-diopter", "highlight-clamp"};
    for (size_t i = 0; i < sizeof(keys) / sizeof(*keys); i++)
        if (strcmp(param->key, keys[i]) == 0)
            return true;
    return false;
}

/* Is the text a number and the parameter one that can lie between two? */
static bool read_number(const struct frame_table *table, int row, int key, double *v)
{
    char *end;
    const char *text = cell(table, row, key);
    const struct rf_param_info *param = rf_param_find(table->keys[key]);
    *v = strtod(text, &end);
    return end != text && *end == '\0' && !strpbrk(text, "xX") && /* no 0x10 */
           param->type == RF_TYPE_FLOAT && !(*v == 0 && has_word_at_0(param));
}

bool frame_table_value(const struct frame_table *table, int key, int32_t frame,
                       char value[FRAME_VALUE])
{
    int before, after;
    double a, b;
    find_rows(table, frame, &before, &after);
    const bool is_row = before >= 0 && table->frames[before] == frame;
    if (!is_row && table->easing_key < 0)
        return false;
    const bool is_between = !is_row && before >= 0 && after >= 0;
    if (is_between && read_number(table, before, key, &a) &&
        read_number(table, after, key, &b)) {
        const double t = ((double)frame - table->frames[before]) /
                         ((double)table->frames[after] - table->frames[before]);
        const double u = ease(easing_of(cell(table, before, table->easing_key)), t);
        /* 17 digits are the number itself, and a hold is the text's own. */
        snprintf(value, FRAME_VALUE, "%.17g", u == 0 ? a : (1 - u) * a + u * b);
    } else {
        snprintf(value, FRAME_VALUE, "%s",
                 cell(table, before >= 0 ? before : after, key));
    }
    return true;
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
