/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus looks: what --look can be, and looks of one's own. */
#include <stdio.h>

#include "console/cli.h"
#include "console/json.h"
#include "sources/looks.h"
#include "sources/settings.h"

enum { MOST_LOOKS = 256 };

struct looks_options {
    const char *save;
    bool is_json;
};

#define AT(member) offsetof(struct looks_options, member)

static const struct option options[] = {
    {.name = "save",
     .kind = OPTION_TEXT,
     .offset = AT(save),
     .value = "NAME",
     .help = "Keep the parameters of this command line as the look NAME."},
    OPTION_FLAG_ROW("json", AT(is_json), "Print the list as JSON."),
    OPTION_HELP_ROW,
};

/* Its parameters as they are typed; false with a message. */
static bool describe(const char *name, char *text, size_t n_bytes)
{
    struct settings settings;
    struct image_error error;
    settings_init(&settings);
    if (!look_read(name, &settings, &error)) {
        message("%s", error.message);
        return false;
    }
    settings_print_options(&settings.params, text, n_bytes);
    return true;
}

static int print_looks(bool is_json)
{
    static struct look_about list[MOST_LOOKS];
    struct json json = {0};
    char text[2048];
    int code = EXIT_DONE;
    const int n = look_list(list, MOST_LOOKS);
    if (is_json)
        json_open(&json, NULL, '[');
    for (int i = 0; i < n; i++) {
        if (!describe(list[i].name, text, sizeof(text))) {
            code = EXIT_FAILED;
        } else if (is_json) {
            json_open(&json, NULL, '{');
            json_text(&json, "name", list[i].name);
            json_text(&json, "about", list[i].about);
            json_text(&json, "options", text);
            json_close(&json, '}');
        } else {
            printf("%s: %s\n    %s\n", list[i].name, list[i].about, text);
        }
    }
    if (is_json)
        json_close(&json, ']');
    return code;
}

static bool has_typed(const struct settings *settings)
{
    size_t n;
    const struct rf_param_info *infos = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        if (settings_origin(settings, infos[i].key) == ORIGIN_COMMAND_LINE)
            return true;
    return false;
}

static int save_look(const char *name, const struct settings *settings)
{
    struct image_error error;
    if (!has_typed(settings)) {
        message("--save %s: nothing is to be kept; add parameters, as in rackfocus "
                "looks --save %s --cat-eye 0.5 --swirl 0.3",
                name, name);
        return EXIT_USAGE;
    }
    char path[4096];
    if (!look_save(name, settings, &error)) {
        message("--save: %s", error.message);
        return EXIT_FAILED;
    }
    if (look_is_given(name) && look_path(name, path, sizeof(path)))
        printf(
            "--look %s has these parameters from now on, in place of the look of that "
            "name that comes with the program; remove %s to have that again\n",
            name, path);
    else
        printf("--look %s has these parameters from now on\n", name);
    return EXIT_DONE;
}

static int cmd_looks(int argc, char **argv)
{
    struct looks_options tool = {0};
    struct settings settings;
    struct operands operands;
    const int code =
        options_parse(&command_looks, argc, argv, &tool, &settings, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    const int n_operands = operands.n;
    operands_free(&operands);
    if (n_operands == 0 && tool.save)
        return save_look(tool.save, &settings);
    if (n_operands == 0 && !has_typed(&settings))
        return print_looks(tool.is_json);
    message(n_operands > 0
                ? "looks takes no file; see rackfocus looks --help"
                : "looks: parameters are kept with --save NAME; see rackfocus looks "
                  "--help");
    return EXIT_USAGE;
}

const struct command command_looks = {
    .name = "looks",
    .summary = "list the looks of lenses, keep your own",
    .usage = "[--json]\n       rackfocus looks --save NAME [parameters]",
    .description = "Lists the looks that --look of rackfocus filter and the window "
                   "know: those that come with the program and yours, each with its "
                   "parameters.\n\n"
                   "--save keeps the parameters of the command line as a look of "
                   "yours, a text file in rackfocus/looks of XDG_CONFIG_HOME (or "
                   "~/.config).",
    .examples = "rackfocus looks\n"
                "rackfocus looks --save mine --cat-eye 0.5 --swirl 0.3",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_looks,
};
