/* SPDX-License-Identifier: Apache-2.0 */
#include "console/options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/frame_list.h"
#include "console/cli.h"
#include "filter/filter_shrink.h"
#include "console/help.h"
#include "file.h"
#include "sources/settings.h"

/* One run of the parser. */
struct parser {
    const struct command *command;
    int argc;
    char **argv;
    int next; /* index of the argument to look at */
    void *values;
    struct settings *settings;
    bool wants_help;
    struct operands *operands;
};

static const char *const boolean_words[] = {"true", "false", "yes", "no",
                                            "on",   "off",   "1",   "0"};

static bool is_boolean_word(const char *text)
{
    for (size_t i = 0; i < sizeof(boolean_words) / sizeof(boolean_words[0]); i++)
        if (strcmp(text, boolean_words[i]) == 0)
            return true;
    return false;
}

/* ---- unknown names -------------------------------------------------------------- */

#define MAX_NAME 48

/* Edits that turn a into b: insertions, deletions, substitutions, swapped neighbours.
 */
static int edit_distance(const char *a, const char *b)
{
    const int n = (int)strlen(a), m = (int)strlen(b);
    if (n >= MAX_NAME || m >= MAX_NAME)
        return MAX_NAME;
    int rows[MAX_NAME + 1][MAX_NAME + 1];
    for (int i = 0; i <= n; i++)
        rows[i][0] = i;
    for (int j = 0; j <= m; j++)
        rows[0][j] = j;
    for (int i = 1; i <= n; i++) {
        for (int j = 1; j <= m; j++) {
            int best = rows[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            if (rows[i - 1][j] + 1 < best)
                best = rows[i - 1][j] + 1;
            if (rows[i][j - 1] + 1 < best)
                best = rows[i][j - 1] + 1;
            const bool is_swap =
                i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            if (is_swap && rows[i - 2][j - 2] + 1 < best)
                best = rows[i - 2][j - 2] + 1;
            rows[i][j] = best;
        }
    }
    return rows[n][m];
}

const char *nearest_name(const char *name, const char *const *candidates, size_t n)
{
    const size_t length = strlen(name);
    const int limit = length < 6 ? 2 : (int)(length / 3);
    const char *best = NULL;
    int best_distance = limit + 1;
    for (size_t i = 0; i < n; i++) {
        int distance = edit_distance(name, candidates[i]);
        /* The beginning of a longer name counts as near: "focus" is focus-distance. */
        if (length >= 3 && strncmp(name, candidates[i], length) == 0)
            distance = 1;
        if (distance < best_distance) {
            best_distance = distance;
            best = candidates[i];
        }
    }
    return best;
}

static int fail_unknown(const struct parser *parser, const char *name)
{
    const struct command *command = parser->command;
    size_t n_params = 0;
    const struct rf_param_info *params = rf_param_list(&n_params);
    if (!command->takes_params)
        n_params = 0;
    const char **names =
        app_memory(command->n_options + n_params, sizeof(*names), NULL);
    if (!names)
        return exit_without_memory();
    size_t n = 0;
    for (size_t i = 0; i < command->n_options; i++)
        names[n++] = command->options[i].name;
    for (size_t i = 0; i < n_params; i++)
        names[n++] = params[i].key;
    const char *near = nearest_name(name, names, n);
    if (near)
        message("unknown option --%s; did you mean --%s?", name, near);
    else
        message("unknown option --%s; see rackfocus %s --help", name, command->name);
    free(names);
    return EXIT_USAGE;
}

/* ---- values --------------------------------------------------------------------- */

static int fail_number(const struct option *option, const char *text)
{
    message("--%s: '%s' is not a number from %g to %g", option->name, text, option->min,
            option->max);
    return EXIT_USAGE;
}

static int set_number(const struct option *option, const char *text, char *target)
{
    char *end;
    const double number = strtod(text, &end);
    const bool is_int = option->kind == OPTION_INT;
    if (end == text || *end || strpbrk(text, "xX") || /* no 0x10, as of parameters */
        !(number >= option->min && number <= option->max))
        return fail_number(option, text);
    if (is_int && number != (double)(int32_t)number) {
        message("--%s: '%s' is not a whole number", option->name, text);
        return EXIT_USAGE;
    }
    if (is_int)
        *(int32_t *)target = (int32_t)number;
    else
        *(double *)target = number;
    return OPTIONS_GO_ON;
}

static int set_choice(const struct option *option, const char *text, int32_t *target)
{
    const size_t length = strlen(text);
    int32_t index = 0;
    for (const char *choice = option->choices; choice; index++) {
        const char *bar = strchr(choice, '|');
        const size_t n = bar ? (size_t)(bar - choice) : strlen(choice);
        if (n == length && strncmp(choice, text, n) == 0) {
            *target = index;
            return OPTIONS_GO_ON;
        }
        choice = bar ? bar + 1 : NULL;
    }
    message("--%s: '%s' is none of %s", option->name, text, option->choices);
    return EXIT_USAGE;
}

static void note_given(struct operands *operands, const char *name)
{
    if (!options_given(operands, name))
        operands->given[operands->n_given++] = name;
}

/* A second number replaces the first, as of a script and of who calls it. Of files and
 * names both may be meant: looks, parameters, outputs. */
static void note_twice(struct parser *parser, const struct option *option,
                       const char *text)
{
    struct operands *operands = parser->operands;
    const char *before = *(const char **)((char *)parser->values + option->offset);
    if (!options_given(operands, option->name) || strcmp(before, text) == 0)
        return;
    operands->twice = option->name;
    operands->dropped = before;
    operands->counts = text;
}

static int set_text(struct parser *parser, const struct option *option,
                    const char *text)
{
    if (!*text) {
        message("--%s: the value is empty; give %s", option->name, option->value);
        return EXIT_USAGE;
    }
    note_twice(parser, option, text);
    *(const char **)((char *)parser->values + option->offset) = text;
    return OPTIONS_GO_ON;
}

static int set_value(struct parser *parser, const struct option *option,
                     const char *text)
{
    char *target = (char *)parser->values + option->offset;
    switch (option->kind) {
    case OPTION_FLAG:
        if (strcmp(option->name, "help") == 0)
            parser->wants_help = true;
        else
            *(bool *)target = true;
        return OPTIONS_GO_ON;
    case OPTION_TEXT:
    case OPTION_FILE:
        return set_text(parser, option, text);
    case OPTION_INT:
    case OPTION_NUMBER:
        return set_number(option, text, target);
    case OPTION_CHOICE:
        return set_choice(option, text, (int32_t *)target);
    }
    return EXIT_USAGE;
}

static int set_option(struct parser *parser, const struct option *option,
                      const char *text)
{
    const int code = set_value(parser, option, text);
    note_given(parser->operands, option->name);
    return code;
}

static int set_param(struct parser *parser, const struct rf_param_info *info,
                     const char *text)
{
    struct rf_error error;
    if (settings_set(parser->settings, info->key, text, &error) == RF_OK)
        return OPTIONS_GO_ON;
    /* The library's messages begin with the key: "f-stop is 0; its range is ...". */
    const bool has_key = strncmp(error.message, info->key, strlen(info->key)) == 0;
    message("--%s%s%s", has_key ? "" : info->key, has_key ? "" : ": ", error.message);
    return EXIT_USAGE;
}

/* The value of an option: what followed '=', else the next argument. */
static const char *take_value(struct parser *parser, const char *attached)
{
    if (attached)
        return attached;
    if (parser->next < parser->argc)
        return parser->argv[parser->next++];
    return NULL;
}

static int fail_no_value(const char *name)
{
    message("--%s: the value is missing; give it as --%s VALUE", name, name);
    return EXIT_USAGE;
}

/* ---- arguments ------------------------------------------------------------------ */

static int parse_param(struct parser *parser, const struct rf_param_info *info,
                       bool is_negated, const char *attached)
{
    if (info->type == RF_TYPE_BOOL) {
        if (is_negated && attached) {
            message("--no-%s takes no value; leave out '=%s'", info->key, attached);
            return EXIT_USAGE;
        }
        const char *text = is_negated ? "false" : attached ? attached : "true";
        const bool has_next = parser->next < parser->argc;
        if (!is_negated && !attached && has_next &&
            is_boolean_word(parser->argv[parser->next]))
            text = parser->argv[parser->next++];
        return set_param(parser, info, text);
    }
    const char *text = take_value(parser, attached);
    return text ? set_param(parser, info, text) : fail_no_value(info->key);
}

static const struct option *find_option(const struct command *command, const char *name,
                                        char letter)
{
    for (size_t i = 0; i < command->n_options; i++) {
        const struct option *option = &command->options[i];
        if (name ? strcmp(option->name, name) == 0 : option->letter == letter)
            return option;
    }
    return NULL;
}

/* The parameter of this name; fields, with underscores, are no options. */
static const struct rf_param_info *find_param(const struct command *command,
                                              const char *name)
{
    const struct rf_param_info *info =
        command->takes_params ? rf_param_find(name) : NULL;
    return info && !strchr(name, '_') ? info : NULL;
}

static int parse_long(struct parser *parser, const char *argument)
{
    char name[MAX_NAME];
    const char *equals = strchr(argument, '=');
    const size_t length = equals ? (size_t)(equals - argument) : strlen(argument);
    snprintf(name, sizeof(name), "%.*s", (int)(length < 1000 ? length : 1000),
             argument);
    const char *attached = equals ? equals + 1 : NULL;

    const struct option *option = find_option(parser->command, name, 0);
    if (option && option->kind == OPTION_FLAG) {
        if (!attached)
            return set_option(parser, option, NULL);
        message("--%s takes no value; leave out '=%s'", name, attached);
        return EXIT_USAGE;
    }
    if (option) {
        const char *text = take_value(parser, attached);
        return text ? set_option(parser, option, text) : fail_no_value(name);
    }
    const struct rf_param_info *info = find_param(parser->command, name);
    if (info)
        return parse_param(parser, info, false, attached);
    const bool is_negated = strncmp(name, "no-", 3) == 0;
    info = is_negated ? find_param(parser->command, name + 3) : NULL;
    if (info && info->type == RF_TYPE_BOOL)
        return parse_param(parser, info, true, attached);
    return fail_unknown(parser, name);
}

/* A file whose name begins with a dash, as far as can be told. */
static bool is_like_file(const char *argument)
{
    return strchr(argument, '.') || os_file_facts(argument).kind != OS_FILE_NONE;
}

/* "-q", "-j4", "-j 4", "-qo out.exr". */
static int parse_short(struct parser *parser, const char *letters)
{
    const char *argument = letters - 1;
    for (; *letters; letters++) {
        const struct option *option = find_option(parser->command, NULL, *letters);
        if (!option && is_like_file(argument)) {
            message("unknown option -%c; if '%s' is a file, name it ./%s", *letters,
                    argument, argument);
            return EXIT_USAGE;
        }
        if (!option) {
            message("unknown option -%c; see rackfocus %s --help", *letters,
                    parser->command->name);
            return EXIT_USAGE;
        }
        if (option->kind != OPTION_FLAG) {
            const char *text = take_value(parser, letters[1] ? letters + 1 : NULL);
            return text ? set_option(parser, option, text)
                        : fail_no_value(option->name);
        }
        set_option(parser, option, NULL);
    }
    return OPTIONS_GO_ON;
}

static int parse_arguments(struct parser *parser, struct operands *operands)
{
    while (parser->next < parser->argc) {
        char *argument = parser->argv[parser->next++];
        int code = OPTIONS_GO_ON;
        bool is_line = parser->command->takes_line && argument[0] != '-';
        if (is_line || strcmp(argument, "--") == 0) {
            parser->next -= is_line;
            operands->rest = parser->argv + parser->next;
            operands->n_rest = parser->argc - parser->next;
            return OPTIONS_GO_ON;
        }
        if (strncmp(argument, "--", 2) == 0)
            code = parse_long(parser, argument + 2);
        else if (argument[0] == '-' && argument[1])
            code = parse_short(parser, argument + 1);
        else
            operands->items[operands->n++] = argument;
        if (code != OPTIONS_GO_ON)
            return code;
    }
    return OPTIONS_GO_ON;
}

int options_warn_twice(const struct operands *operands)
{
    const bool is_strict = options_given(operands, "strict");
    if (!operands->twice)
        return OPTIONS_GO_ON;
    warning(!is_strict && options_given(operands, "quiet"),
            "--%s: is given twice: '%s' counts and '%s' does not; leave one of them "
            "out",
            operands->twice, operands->counts, operands->dropped);
    return is_strict ? EXIT_USAGE : OPTIONS_GO_ON;
}

const char *options_refuse_pixel_filter(const struct operands *operands,
                                        int32_t supersample, int32_t kind)
{
    const bool has_width = options_given(operands, "pixel-filter-width");
    if (supersample < 2 && (has_width || options_given(operands, "pixel-filter")))
        return "--pixel-filter and --pixel-filter-width go with --supersample";
    if (kind == FILTER_PIXELS_BOX && has_width)
        return "--pixel-filter box is the mean of N x N pixels, without a width; leave "
               "out --pixel-filter-width";
    return NULL;
}

bool options_are_of_one_frame(const struct operands *operands, const char *command)
{
    for (int i = 0; i < operands->n; i++) {
        char guessed[4096];
        const char *name = operands->items[i], *pattern = name;
        struct frame_list list = {0};
        struct image_error ignored;
        if (os_file_facts(name).kind != OS_FILE_NONE)
            continue;
        if (frame_guess_foreign(name, guessed, sizeof(guessed)))
            pattern = guessed;
        else if (!frame_is_pattern(name))
            continue;
        const bool is_found = frame_list_find(&list, pattern, &ignored) && list.n > 0;
        char *first = frame_name(pattern, is_found ? list.numbers[0] : 1, &ignored);
        frame_list_free(&list);
        message("%s: %s takes pictures of one frame; name the file, such as %s", name,
                command, first ? first : "shot.0001.exr");
        free(first);
        return false;
    }
    return true;
}

int options_parse(const struct command *command, int argc, char **argv, void *values,
                  struct settings *settings, struct operands *operands)
{
    struct parser parser = {.command = command,
                            .argc = argc,
                            .argv = argv,
                            .next = 1,
                            .values = values,
                            .settings = settings,
                            .operands = operands};
    *operands = (struct operands){
        .items = app_memory((size_t)argc, sizeof(char *), NULL),
        .given = app_memory(command->n_options, sizeof(char *), NULL)};
    if (!operands->items || !operands->given) {
        operands_free(operands);
        return exit_without_memory();
    }
    if (settings)
        settings_init(settings);
    int code = parse_arguments(&parser, operands);
    if (code == OPTIONS_GO_ON && parser.wants_help) {
        help_print_command(command);
        code = EXIT_DONE;
    }
    if (code == OPTIONS_GO_ON && !command->is_handed_over)
        code = options_warn_twice(operands);
    if (!command->keeps_rest)
        for (int i = 0; i < operands->n_rest; i++)
            operands->items[operands->n++] = operands->rest[i];
    if (code != OPTIONS_GO_ON)
        operands_free(operands);
    return code;
}

bool options_given(const struct operands *operands, const char *name)
{
    for (int i = 0; i < operands->n_given; i++)
        if (strcmp(operands->given[i], name) == 0)
            return true;
    return false;
}

void operands_free(struct operands *operands)
{
    free(operands->items);
    free(operands->given);
    *operands = (struct operands){0};
}
