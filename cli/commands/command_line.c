/* SPDX-License-Identifier: Apache-2.0 */
#include "commands/command_line.h"

#include <stdlib.h>
#include <string.h>

#include "commands/accumulate_command.h"
#include "commands/filter_command.h"
#include "commands/povray_command.h"
#include "common/outputs.h"
#include "console/cli.h"
#include "rackfocus/rackfocus.h"
#include "sequence/frames_check.h"

bool command_line_open(struct command_line *line, int argc, char **argv, const char *of)
{
    static const struct command *const able[] = {&command_filter, &command_povray,
                                                 &command_accumulate};
    *line = (struct command_line){.argc = argc, .argv = argv};
    if (argc == 0) {
        message("%s needs a command line after --, such as: -- filter 'in.####.exr' -o "
                "'out.####.exr'; see rackfocus %s --help",
                of, of);
        return false;
    }
    for (size_t i = 0; i < sizeof(able) / sizeof(able[0]); i++)
        if (strcmp(argv[0], able[i]->name) == 0)
            line->command = able[i];
    if (!line->command)
        message("'%s' makes no sequence; after -- goes the command line of filter, "
                "povray or accumulate",
                argv[0]);
    return line->command != NULL;
}

int command_line_run(const struct command_line *line, int argc, char **argv,
                     struct frames_report *report)
{
    return line->command == &command_filter ? filter_command_run(argc, argv, report)
           : line->command == &command_povray
               ? povray_command_run(argc, argv, report)
               : accumulate_command_run(argc, argv, report);
}

/* One word of the line and what belongs to it. */
struct word {
    const char *name;  /* of the option, "" for an operand */
    const char *value; /* NULL: none */
    int n;             /* words: 2 where the value is the next one */
    bool is_operand, is_end;
};

static const struct option *find_option(const struct command *command, const char *name,
                                        size_t n_name, char letter)
{
    for (size_t i = 0; i < command->n_options; i++) {
        const struct option *option = &command->options[i];
        if (name ? strlen(option->name) == n_name &&
                       strncmp(option->name, name, n_name) == 0
                 : option->letter == letter)
            return option;
    }
    return NULL;
}

/* A parameter of params.def takes the next word but where it is a flag. */
static bool param_takes_next(const char *key, size_t n_key, const char *next)
{
    static const char *const boolean_words[] = {"true", "false", "yes", "no",
                                                "on",   "off",   "1",   "0"};
    char name[64];
    snprintf(name, sizeof(name), "%.*s", (int)n_key, key);
    const struct rf_param_info *info = rf_param_find(name);
    if (!info || info->type != RF_TYPE_BOOL)
        return info != NULL;
    for (size_t i = 0; i < sizeof(boolean_words) / sizeof(boolean_words[0]); i++)
        if (next && strcmp(next, boolean_words[i]) == 0)
            return true;
    return false;
}

static void read_long(const struct command_line *line, const char *text,
                      const char *next, struct word *word)
{
    const char *equals = strchr(text, '=');
    const size_t n = equals ? (size_t)(equals - text) : strlen(text);
    const struct option *option = find_option(line->command, text, n, 0);
    word->name = option ? option->name : text;
    if (equals)
        word->value = equals + 1;
    else if (option ? option->kind != OPTION_FLAG : param_takes_next(text, n, next))
        word->value = next;
    word->n = word->value && !equals ? 2 : 1;
}

static void read_short(const struct command_line *line, const char *letters,
                       const char *next, struct word *word)
{
    for (; *letters; letters++) {
        const struct option *option = find_option(line->command, NULL, 0, *letters);
        if (!option || option->kind == OPTION_FLAG)
            continue;
        word->name = option->name;
        word->value = letters[1] ? letters + 1 : next;
        word->n = !letters[1] && next ? 2 : 1;
        return;
    }
}

static struct word read_word(const struct command_line *line, int at)
{
    const char *text = line->argv[at];
    const char *next = at + 1 < line->argc ? line->argv[at + 1] : NULL;
    struct word word = {.name = "", .n = 1};
    if (strcmp(text, "--") == 0)
        word.is_end = true;
    else if (strncmp(text, "--", 2) == 0)
        read_long(line, text + 2, next, &word);
    else if (text[0] == '-' && text[1])
        read_short(line, text + 1, next, &word);
    else
        word.is_operand = true;
    return word;
}

const char *command_line_value(const struct command_line *line, const char *name)
{
    const char *value = NULL;
    for (int at = 1; at < line->argc;) {
        const struct word word = read_word(line, at);
        if (word.is_end)
            break;
        if (strcmp(word.name, name) == 0 && word.value)
            value = word.value;
        at += word.n;
    }
    return value;
}

bool command_line_spare(const struct command_line *line,
                        const struct frames_report *report, struct outputs *outputs)
{
    struct frame_list frames = {.n = report->n};
    frames.numbers = app_memory((size_t)report->n, sizeof(*frames.numbers), NULL);
    for (int i = 0; frames.numbers && i < report->n; i++)
        frames.numbers[i] = report->frames[i].number;
    for (int at = 1; frames.numbers && at < line->argc;) {
        const struct word word = read_word(line, at);
        const char *path = word.is_operand ? line->argv[at] : word.value;
        if (word.is_end)
            break;
        outputs->frames = path && frame_is_pattern(path) ? &frames : NULL;
        outputs_spare(outputs, word.is_operand ? NULL : word.name, path);
        at += word.n;
    }
    const bool is_good = frames.numbers != NULL;
    outputs->frames = NULL;
    frame_list_free(&frames);
    return is_good;
}

int command_line_operand(const struct command_line *line, int i)
{
    for (int at = 1; at < line->argc;) {
        const struct word word = read_word(line, at);
        if (word.is_end)
            break;
        if (word.is_operand && i-- == 0)
            return at;
        at += word.n;
    }
    return -1;
}

void command_line_print_word(FILE *file, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                "0123456789_-./,:=+%@";
    if (*word && word[strspn(word, plain)] == '\0') {
        fputs(word, file);
        return;
    }
    fputc('\'', file);
    for (; *word; word++)
        if (*word == '\'')
            fputs("'\\''", file);
        else
            fputc(*word, file);
    fputc('\'', file);
}

static void print_words(FILE *file, char *const *words, int n)
{
    for (int i = 0; i < n; i++) {
        fputc(' ', file);
        command_line_print_word(file, words[i]);
    }
}

int command_line_words(const struct command_line *line, const char *left_out,
                       char **words, int *n_head)
{
    int at = 1, n = 0;
    words[n++] = line->argv[0];
    while (at < line->argc) {
        const struct word word = read_word(line, at);
        if (word.is_end)
            break;
        for (int i = 0; i < word.n; i++)
            if (!left_out || strcmp(word.name, left_out) != 0)
                words[n++] = line->argv[at + i];
        at += word.n;
    }
    *n_head = n;
    while (at < line->argc)
        words[n++] = line->argv[at++];
    return n;
}

void command_line_print(FILE *file, const struct command_line *line,
                        const char *left_out, const char *added)
{
    int n_head;
    char **words = app_memory((size_t)line->argc, sizeof(*words), NULL);
    if (!words)
        return;
    const int n = command_line_words(line, left_out, words, &n_head);
    print_words(file, words, n_head);
    if (added)
        fprintf(file, " %s", added);
    print_words(file, words + n_head, n - n_head);
    free(words);
}
