/* SPDX-License-Identifier: Apache-2.0 */
/* Completion for fish and zsh. */
#include <stdio.h>
#include <string.h>

#include "console/cli.h"
#include "generate.h"
#include "console/help.h"
#include "rackfocus/rackfocus.h"

/* One option as both shells want to know it. */
struct word {
    const char *name; /* without -- */
    char letter;      /* 0: none */
    const char *help;
    bool has_value, is_file;
    const char *choices; /* parted by blanks or |; NULL */
};

/* The first sentence, quoted for a shell, without what it takes for its own; a
 * parenthesis that goes on after it is closed. */
static void print_brief(const char *help, const char *own)
{
    int n_open = 0;
    for (; *help && *help != '\n'; help++) {
        if (help[0] == '.' && (help[1] == ' ' || !help[1]))
            break;
        if (help[0] == ';' && help[1] == ' ')
            break;
        if (*help == '\'')
            fputs("\342\200\231", stdout); /* the apostrophe that no shell quotes by */
        else if (!strchr(own, *help))
            putchar(*help);
        n_open += (*help == '(') - (*help == ')');
    }
    for (; n_open > 0; n_open--)
        putchar(')');
}

static const char OF_FISH[] = "\\`", OF_ZSH[] = "[]:\\`";

static void print_choices(const char *choices)
{
    for (; *choices; choices++)
        putchar(*choices == '|' ? ' ' : *choices);
}

static void print_fish(const char *command, const struct word *word)
{
    printf("complete -c rackfocus -n '__fish_seen_subcommand_from %s' -l %s", command,
           word->name);
    if (word->letter)
        printf(" -s %c", word->letter);
    if (word->has_value)
        fputs(word->is_file ? " -rF" : " -x", stdout);
    if (word->choices) {
        fputs(" -a '", stdout);
        print_choices(word->choices);
        putchar('\'');
    }
    fputs(" -d '", stdout);
    print_brief(word->help, OF_FISH);
    puts("'");
}

static void print_zsh(const char *command, const struct word *word)
{
    (void)command;
    printf("            '--%s%s[", word->name, word->has_value ? "=" : "");
    print_brief(word->help, OF_ZSH);
    putchar(']');
    if (word->choices) {
        printf(":%s:(", word->name);
        print_choices(word->choices);
        putchar(')');
    } else if (word->has_value) {
        printf(":%s:%s", word->name, word->is_file ? "_files" : " ");
    }
    puts("' \\");
}

typedef void (*print_word_fn)(const char *command, const struct word *word);

static void print_param(const struct command *command, const struct rf_param_info *info,
                        print_word_fn print)
{
    char choices[512] = "", no[80];
    for (int k = 0; info->choices && k < info->n_choices; k++)
        snprintf(choices + strlen(choices), sizeof choices - strlen(choices), "%s%s",
                 k ? " " : "", info->choices[k].name);
    const bool is_bool = info->type == RF_TYPE_BOOL;
    print(command->name, &(struct word){.name = info->key,
                                        .help = info->help,
                                        .has_value = !is_bool,
                                        .choices = choices[0] ? choices : NULL});
    if (!is_bool)
        return;
    snprintf(no, sizeof no, "no-%s", info->key);
    print(command->name, &(struct word){.name = no, .help = info->help});
}

static void print_words(const struct command *command, print_word_fn print)
{
    for (size_t i = 0; i < command->n_options; i++) {
        const struct option *option = &command->options[i];
        print(command->name, &(struct word){.name = option->name,
                                            .letter = option->letter,
                                            .help = option->help,
                                            .has_value = option->kind != OPTION_FLAG,
                                            .is_file = option->kind == OPTION_FILE,
                                            .choices = option->choices});
    }
    size_t n = 0;
    const struct rf_param_info *params = rf_param_list(&n);
    for (size_t i = 0; command->takes_params && i < n; i++)
        if (!help_has_option(command, params[i].key))
            print_param(command, &params[i], print);
}

void generate_fish(void)
{
    size_t n;
    const struct command *const *commands = command_list(&n);
    puts("# Completion of rackfocus for fish; generated, do not edit.");
    for (size_t i = 0; i < n; i++) {
        printf("complete -c rackfocus -n __fish_use_subcommand -f -a %s -d '",
               commands[i]->name);
        print_brief(commands[i]->description, OF_FISH);
        puts("'");
        print_words(commands[i], print_fish);
    }
}

void generate_zsh(void)
{
    size_t n;
    const struct command *const *commands = command_list(&n);
    puts("#compdef rackfocus\n"
         "# Completion of rackfocus for zsh; generated, do not edit.\n"
         "_rackfocus() {\n"
         "    if (( CURRENT == 2 )); then\n"
         "        local -a commands=(");
    for (size_t i = 0; i < n; i++) {
        printf("            '%s:", commands[i]->name);
        print_brief(commands[i]->description, OF_ZSH);
        puts("'");
    }
    puts("        )\n"
         "        _describe command commands\n"
         "        return\n"
         "    fi\n"
         "    case $words[2] in");
    for (size_t i = 0; i < n; i++) {
        printf("    %s)\n        _arguments \\\n", commands[i]->name);
        print_words(commands[i], print_zsh);
        puts("            '*:file:_files'\n        ;;");
    }
    puts("    esac\n"
         "}\n"
         "_rackfocus \"$@\"");
}
