/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Help, manual page and shell completion, all made from the same tables: the list of
 * sub-commands, their options, and the parameters of params.def.
 */
#ifndef CLI_HELP_H
#define CLI_HELP_H

#include <stddef.h>

struct command;
struct option;
struct rf_param_info;

/* `rackfocus --help` on stdout. */
void help_print_overview(void);

/* `rackfocus NAME --help` on stdout. */
void help_print_command(const struct command *command);

/* rackfocus.1 and the bash completion on stdout; the build installs them. */
void help_print_man(void);
void help_print_completion(void);

#define HELP_N_GROUPS 4

/* Heading of a group of parameters, "Lens". */
const char *help_group_title(int group);

/* "--f-stop F-NUMBER", "--depth KIND", "--[no-]split-edges". */
void help_param_synopsis(const struct rf_param_info *info, char *text, size_t n_bytes);

/* "f-number, 0.001 to 1e+06, default 2.8"; the choices of an enum are not in it. */
void help_param_range(const struct rf_param_info *info, char *text, size_t n_bytes);

#endif
