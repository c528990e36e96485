/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus accumulate, for the commands that take its command line. */
#ifndef CLI_ACCUMULATE_COMMAND_H
#define CLI_ACCUMULATE_COMMAND_H

struct frames_report;

/* As filter_command_run() (filter_command.h), with "accumulate". */
int accumulate_command_run(int argc, char **argv, struct frames_report *report);

#endif
