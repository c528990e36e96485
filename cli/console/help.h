/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What --help says of a sub-command, made from the table of its options and the
 * parameters of params.def.
 */
#ifndef CLI_HELP_H
#define CLI_HELP_H

#include <stdbool.h>
#include <stddef.h>

struct command;
struct option;
struct rf_param_info;

/* `rackfocus NAME --help` on stdout. */
void help_print_command(const struct command *command);

/* Has the sub-command an option of its own with this name? It hides the parameter that
 * is called the same. */
bool help_has_option(const struct command *command, const char *name);

#define HELP_N_GROUPS 5

/* Heading of a group of parameters, "Lens". */
const char *help_group_title(int group);

/* "--f-stop F-NUMBER", "--depth KIND", "--[no-]split-edges". */
void help_param_synopsis(const struct rf_param_info *info, char *text, size_t n_bytes);

/* "f-number, 0.001 to 1e+06, default 2.8"; the choices of an enum are not in it. */
void help_param_range(const struct rf_param_info *info, char *text, size_t n_bytes);

#endif
