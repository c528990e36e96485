/* SPDX-License-Identifier: Apache-2.0 */
/* The list of sub-commands, and what `rackfocus --help` says of it. */
#include <stdio.h>
#include <string.h>

#include "console/cli.h"

#define COMMAND_ADDRESS(name) &command_##name,
static const struct command *const commands[] = {COMMAND_LIST(COMMAND_ADDRESS)};
#define N_COMMANDS (sizeof(commands) / sizeof(commands[0]))

const struct command *const *command_list(size_t *n)
{
    *n = N_COMMANDS;
    return commands;
}

const struct command *command_find(const char *name)
{
    for (size_t i = 0; i < N_COMMANDS; i++)
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    return NULL;
}

void command_print_overview(void)
{
    printf(
        "Usage: rackfocus COMMAND [options]\n\n"
        "Depth of field after the render: turns a pinhole render (colour and depth)\n"
        "into the picture that the scene's own lens would have made.\n\n"
        "Commands:\n");
    for (size_t i = 0; i < N_COMMANDS; i++)
        printf("  %-10s %s\n", commands[i]->name, commands[i]->summary);
    printf("  %-10s %s\n", "help", "show the options of a command");
    printf("\nOptions:\n"
           "  -h, --help     Show this help.\n"
           "  --version      Show the version.\n\n"
           "rackfocus COMMAND --help shows every option of a command.\n"
           "Exit status: 0 done, 1 failed, 2 wrong usage, 130 interrupted.\n");
}
