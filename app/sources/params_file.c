/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/params_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "common/text_file.h"

/* What stands between key and value in other programs' files; 0: a space, as here. */
static char other_separator(const char *line)
{
    const char *at = line + strspn(line, " \t");
    at += strcspn(at, " \t=;:,");
    at += strspn(at, " \t");
    return strchr("=;:,", *at) ? *at : '\0';
}

/* What was typed wins over the file, the last of two lines over the first. */
static bool read_line(const char *path, int number, char *line,
                      const struct settings *typed, struct settings *found,
                      struct image_error *error)
{
    char word[64], value[64], more[64];
    struct rf_error wrong;
    line[strcspn(line, "#")] = 0;
    const int n = sscanf(line, " %63s %63s %63s", word, value, more);
    if (n < 1)
        return true;
    /* As it is typed, and as `rackfocus looks` prints it. */
    const char *key = strncmp(word, "--", 2) == 0 ? word + 2 : word;
    const char other = other_separator(line);
    if (other)
        return set_error(error,
                         "%s:%d: '%s': there is a '%c' behind the parameter; a space "
                         "stands between it and its value, as in 'f-stop 2.8'",
                         path, number, key, other);
    const struct rf_param_info *info = rf_param_find(key);
    if (strcmp(key, "aperture-image") == 0)
        return set_error(
            error,
            "%s:%d: a picture is no parameter; type it beside the file, as "
            "--aperture-image FILE, and leave this line out",
            path, number);
    if (n > 1 && !info)
        return set_error(error,
                         "%s:%d: there is no parameter '%s' (of another version, or "
                         "misspelt?); rackfocus help filter lists them",
                         path, number, key);
    if (n < 2)
        return set_error(
            error, "%s:%d: '%s' is not a parameter and its value, such as 'f-stop 2.8'",
            path, number, key);
    if (n > 2)
        return set_error(error,
                         "%s:%d: there is more behind %s and its value: '%s'; a remark "
                         "begins with #, and every parameter has a line of its own",
                         path, number, key, more);
    if (settings_origin(typed, info->key) == ORIGIN_COMMAND_LINE ||
        settings_set(found, info->key, value, &wrong) == RF_OK)
        return true;
    return set_error(error, "%s:%d: %s: %s", path, number, key, wrong.message);
}

/* Takes the text apart; `n_named` receives how many of its lines are no remarks. */
static bool read_lines(const char *name, char *text, struct settings *settings,
                       int *n_named, struct image_error *error)
{
    const struct settings typed = *settings;
    char *line;
    *n_named = 0;
    for (int number = 1; (line = text_next_line(&text)) != NULL; number++) {
        if (!read_line(name, number, line, &typed, settings, error))
            return false;
        *n_named += line[strspn(line, " \t\v\f")] != 0; /* without its remark now */
    }
    return true;
}

bool params_file_read(const char *path, struct settings *settings, int *n_named,
                      struct image_error *error)
{
    int n;
    char *text = text_file_read(path, error);
    const bool is_good =
        text && read_lines(path, text, settings, n_named ? n_named : &n, error);
    free(text);
    return is_good;
}

bool params_text_read(const char *name, const char *text, struct settings *settings,
                      struct image_error *error)
{
    int n;
    char *copy = app_memory(strlen(text) + 1, 1, error);
    if (!copy)
        return false;
    strcpy(copy, text);
    const bool is_good = read_lines(name, copy, settings, &n, error);
    free(copy);
    return is_good;
}

static void print_lines(FILE *file, const void *data)
{
    const struct settings *settings = data;
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    fprintf(file, "# rackfocus %s; read with --params FILE\n", rf_version());
    for (size_t i = 0; i < n; i++) {
        char value[64];
        if (settings_origin(settings, list[i].key) != ORIGIN_COMMAND_LINE)
            continue;
        rf_params_get(&settings->params, list[i].key, value, sizeof(value));
        fprintf(file, "%s %s\n", list[i].key, value);
    }
}

bool params_file_write(const char *path, const struct settings *settings,
                       struct image_error *error)
{
    return text_file_write(path, print_lines, settings, error);
}
