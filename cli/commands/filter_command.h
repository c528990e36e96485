/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus filter, for the commands that take its command line. */
#ifndef CLI_FILTER_COMMAND_H
#define CLI_FILTER_COMMAND_H

struct frames_report;

/*
 * Runs the command: argv[0] is "filter". With a report, which takes a sequence, it makes
 * nothing and fills that (frames_check.h); the caller frees it. Returns an exit code;
 * messages have been printed.
 */
int filter_command_run(int argc, char **argv, struct frames_report *report);

#endif
