/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus: finds the sub-command and hands over to it. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "arguments.h"
#include "clean_up.h"
#include "console/cli.h"
#include "generate.h"
#include "console/help.h"
#include "interrupt.h"
#include "rackfocus/rackfocus.h"
#include "terminal.h"

static int fail_unknown_command(const char *name)
{
    size_t n;
    const struct command *const *commands = command_list(&n);
    const char **names = app_memory(n + 1, sizeof(*names), NULL);
    if (!names)
        return exit_without_memory();
    for (size_t i = 0; i < n; i++)
        names[i] = commands[i]->name;
    names[n] = "help";
    const char *near = nearest_name(name, names, n + 1);
    free(names);
    if (near)
        message("unknown command '%s'; did you mean 'rackfocus %s'?", name, near);
    else
        message("unknown command '%s'; see rackfocus --help", name);
    return EXIT_USAGE;
}

/* `rackfocus help [COMMAND]` */
static int run_help(const char *name)
{
    const struct command *command = name ? command_find(name) : NULL;
    if (name && !command)
        return fail_unknown_command(name);
    if (command)
        help_print_command(command);
    else
        command_print_overview();
    return EXIT_DONE;
}

/* Options that stand before any sub-command; the last four are for the build. */
static int run_global_option(const char *option)
{
    if (strcmp(option, "--help") == 0 || strcmp(option, "-h") == 0)
        command_print_overview();
    else if (strcmp(option, "--version") == 0 || strcmp(option, "-V") == 0)
        printf("rackfocus %s\n", rf_version());
    else if (strcmp(option, "--generate-man") == 0)
        generate_man();
    else if (strcmp(option, "--generate-completion") == 0)
        generate_completion();
    else if (strcmp(option, "--generate-fish") == 0)
        generate_fish();
    else if (strcmp(option, "--generate-zsh") == 0)
        generate_zsh();
    else {
        message("unknown option %s; options follow the command, see rackfocus --help",
                option);
        return EXIT_USAGE;
    }
    return EXIT_DONE;
}

static int run(int argc, char **argv)
{
    if (argc < 2) {
        command_print_overview();
        return EXIT_USAGE;
    }
    if (argv[1][0] == '-')
        return run_global_option(argv[1]);
    if (strcmp(argv[1], "help") == 0)
        return run_help(argc > 2 ? argv[2] : NULL);
    const struct command *command = command_find(argv[1]);
    if (!command)
        return fail_unknown_command(argv[1]);
    os_interrupt_catch();
    return command->run(argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    argv = os_arguments(&argc, argv);
    /* A closed pipe or a file size limit is an error to report, not a way to die. */
    os_interrupt_not_by_writing();
    /* Whoever ends the program: no half files. */
    atexit(os_clean_up);
    const int code = run(argc, argv);
    const bool is_reader_gone =
        fflush(stdout) != 0 && os_interrupt_is_reader_gone(errno);
    const bool is_read = os_stream_is_open(stdout) && !is_reader_gone;
    if (ferror(stdout) && is_read && code == EXIT_DONE) {
        message("standard output: %s", strerror(errno));
        return EXIT_FAILED;
    }
    return code;
}
