/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/params_file.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "common/text_file.h"

#define MAX_LINE 256

/* What was typed wins over the file, the last of two lines over the first. */
static bool read_line(const char *path, int number, char *line,
                      const struct settings *typed, struct settings *found,
                      struct image_error *error)
{
    char key[64], value[64];
    struct rf_error wrong;
    line[strcspn(line, "#\n")] = 0;
    const int n = sscanf(line, " %63s %63s", key, value);
    if (n < 1)
        return true;
    const struct rf_param_info *info = rf_param_find(key);
    if (n < 2 || !info)
        return set_error(
            error, "%s:%d: '%s' is not a parameter and its value, such as 'f-stop 2.8'",
            path, number, key);
    if (settings_origin(typed, info->key) == ORIGIN_COMMAND_LINE ||
        settings_set(found, info->key, value, &wrong) == RF_OK)
        return true;
    return set_error(error, "%s:%d: %s: %s", path, number, key, wrong.message);
}

bool params_file_read(const char *path, struct settings *settings,
                      struct image_error *error)
{
    char line[MAX_LINE];
    bool is_good = true;
    const struct settings typed = *settings;
    FILE *file = fopen(path, "r");
    if (!file)
        return set_error(error, "%s: cannot be read: %s", path, strerror(errno));
    for (int number = 1; is_good && fgets(line, sizeof(line), file); number++)
        is_good = read_line(path, number, line, &typed, settings, error);
    fclose(file);
    return is_good;
}

bool params_text_read(const char *name, const char *text, struct settings *settings,
                      struct image_error *error)
{
    char line[MAX_LINE];
    const struct settings typed = *settings;
    for (int number = 1; *text; number++) {
        const size_t n = strcspn(text, "\n");
        snprintf(line, sizeof(line), "%.*s", (int)n, text);
        if (!read_line(name, number, line, &typed, settings, error))
            return false;
        text += n + (text[n] == '\n');
    }
    return true;
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
