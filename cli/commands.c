/* SPDX-License-Identifier: Apache-2.0 */
/* The list of sub-commands. */
#include <string.h>

#include "cli.h"

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
