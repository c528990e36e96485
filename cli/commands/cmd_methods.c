/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus methods: what --method can be. */
#include <stdio.h>

#include "console/cli.h"
#include "console/json.h"
#include "rackfocus/rackfocus.h"

struct methods_options {
    bool is_json;
};

static const struct option options[] = {
    {.name = "json",
     .kind = OPTION_FLAG,
     .offset = offsetof(struct methods_options, is_json),
     .help = "Print the list as JSON."},
    OPTION_HELP_ROW,
};

static void print_text(const struct rf_method_info *methods, size_t n)
{
    for (size_t i = 0; i < n; i++)
        printf("%s%s\n    %s\n    Cost: %s\n    Source: %s\n", i ? "\n" : "",
               methods[i].name, methods[i].help, methods[i].cost, methods[i].source);
}

static void print_json(const struct rf_method_info *methods, size_t n)
{
    struct json json = {0};
    json_open(&json, NULL, '[');
    for (size_t i = 0; i < n; i++) {
        json_open(&json, NULL, '{');
        json_text(&json, "name", methods[i].name);
        json_text(&json, "help", methods[i].help);
        json_text(&json, "cost", methods[i].cost);
        json_text(&json, "source", methods[i].source);
        json_close(&json, '}');
    }
    json_close(&json, ']');
}

static int cmd_methods(int argc, char **argv)
{
    struct methods_options tool = {0};
    struct operands operands;
    const int code =
        options_parse(&command_methods, argc, argv, &tool, NULL, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    const int n_operands = operands.n;
    operands_free(&operands);
    if (n_operands > 0) {
        message("methods takes no file; see rackfocus methods --help");
        return EXIT_USAGE;
    }
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    if (tool.is_json)
        print_json(methods, n);
    else
        print_text(methods, n);
    return EXIT_DONE;
}

const struct command command_methods = {
    .name = "methods",
    .summary = "list the ways to make the blur, with cost and source",
    .usage = "[--json]",
    .description = "Lists the methods that --method accepts: what each does, how its "
                   "time grows and where it comes from.",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .run = cmd_methods,
};
