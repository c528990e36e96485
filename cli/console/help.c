/* SPDX-License-Identifier: Apache-2.0 */
#include "console/help.h"

#include <stdio.h>
#include <string.h>

#include "console/cli.h"
#include "rackfocus/rackfocus.h"

#define WIDTH 80
#define COLUMN 30 /* where descriptions begin */

bool help_has_option(const struct command *command, const char *name)
{
    for (size_t i = 0; i < command->n_options; i++)
        if (strcmp(command->options[i].name, name) == 0)
            return true;
    return false;
}

const char *help_group_title(int group)
{
    static const char *const titles[HELP_N_GROUPS] = {"Lens", "Aperture", "Depth",
                                                      "Method", "Highlights"};
    return titles[group];
}

/* Prints `text` wrapped, the cursor being at `column`; later lines begin at `indent`.
 */
static void print_wrapped(const char *text, int column, int indent)
{
    bool is_line_start = true;
    while (*text) {
        const int length = (int)strcspn(text, " \n");
        if (!is_line_start && column + 1 + length > WIDTH) {
            printf("\n%*s", indent, "");
            column = indent;
            is_line_start = true;
        }
        column += printf("%s%.*s", is_line_start ? "" : " ", length, text);
        is_line_start = false;
        text += length;
        while (*text == ' ')
            text++;
        if (*text == '\n') {
            printf("\n%*s", text[1] == '\n' ? 0 : indent, "");
            column = indent;
            is_line_start = true;
            text++;
        }
    }
    putchar('\n');
}

static void print_row(const char *synopsis, const char *help)
{
    int column = printf("  %s", synopsis);
    if (column + 2 > COLUMN) {
        putchar('\n');
        column = 0;
    }
    printf("%*s", COLUMN - column, "");
    print_wrapped(help, COLUMN, COLUMN);
}

static void option_synopsis(const struct option *option, char *text, size_t n_bytes)
{
    const char letter[] = {option->letter ? '-' : ' ',
                           option->letter ? option->letter : ' ',
                           option->letter ? ',' : ' ', ' ', 0};
    snprintf(text, n_bytes, "%s--%s%s%s", letter, option->name,
             option->value ? " " : "", option->value ? option->value : "");
}

void help_param_synopsis(const struct rf_param_info *info, char *text, size_t n_bytes)
{
    static const char *const values[] = {"NUMBER", "COUNT", "", "KIND"};
    if (info->type == RF_TYPE_BOOL)
        snprintf(text, n_bytes, "--[no-]%s", info->key);
    else
        snprintf(text, n_bytes, "--%s %s", info->key, values[info->type]);
}

void help_param_range(const struct rf_param_info *info, char *text, size_t n_bytes)
{
    struct rf_params defaults;
    char value[64];
    rf_params_init(&defaults);
    rf_params_get(&defaults, info->key, value, sizeof(value));
    if (info->choices)
        snprintf(text, n_bytes, "default %s", value);
    else if (info->type == RF_TYPE_BOOL)
        snprintf(text, n_bytes, "default %s",
                 strcmp(value, "true") == 0 ? "on" : "off");
    else
        snprintf(text, n_bytes, "%s%s%g to %g, default %s",
                 strcmp(info->unit, "1") == 0 ? "" : info->unit,
                 strcmp(info->unit, "1") == 0 ? "" : ", ", info->min, info->max, value);
}

static void print_param(const struct rf_param_info *info)
{
    char synopsis[96], range[160], text[512];
    help_param_synopsis(info, synopsis, sizeof(synopsis));
    help_param_range(info, range, sizeof(range));
    snprintf(text, sizeof(text), "%s [%s]", info->help, range);
    print_row(synopsis, text);
    for (int i = 0; i < info->n_choices; i++) {
        snprintf(text, sizeof(text), "%s: %s", info->choices[i].name,
                 info->choices[i].help);
        printf("%*s", COLUMN + 2, "");
        print_wrapped(text, COLUMN + 2, COLUMN + 4);
    }
}

static void print_params(const struct command *command)
{
    size_t n;
    const struct rf_param_info *params = rf_param_list(&n);
    for (int group = 0; group < HELP_N_GROUPS; group++) {
        printf("\n%s:\n", help_group_title(group));
        for (size_t i = 0; i < n; i++)
            if ((int)params[i].group == group &&
                !help_has_option(command, params[i].key))
                print_param(&params[i]);
    }
    printf("\n");
    print_wrapped("Each of these may also stand in the header of the file: the command "
                  "line wins over the header, and the header over the default.",
                  0, 0);
}

static void print_examples(const char *examples)
{
    printf("\nExamples:\n");
    for (const char *line = examples; *line;) {
        const int length = (int)strcspn(line, "\n");
        printf("  %.*s\n", length, line);
        line += length + (line[length] == '\n');
    }
}

void help_print_command(const struct command *command)
{
    printf("Usage: rackfocus %s %s\n\n", command->name, command->usage);
    print_wrapped(command->description, 0, 0);
    printf("\nOptions:\n");
    for (size_t i = 0; i < command->n_options; i++) {
        char synopsis[96];
        option_synopsis(&command->options[i], synopsis, sizeof(synopsis));
        print_row(synopsis, command->options[i].help);
    }
    if (command->takes_params)
        print_params(command);
    if (command->examples)
        print_examples(command->examples);
}
