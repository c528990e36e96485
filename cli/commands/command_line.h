/* SPDX-License-Identifier: Apache-2.0 */
/* The command line of a sub-command, read and written by another one (submit, frames). */
#ifndef CLI_COMMAND_LINE_H
#define CLI_COMMAND_LINE_H

#include <stdbool.h>
#include <stdio.h>

struct command;

struct command_line {
    const struct command *command;
    int argc;
    char **argv; /* argv[0] is the sub-command's name */
};

/* The sub-command that argv[0] names; false, with a message, where `of` (the command
 * that asks) cannot do with it. */
bool command_line_open(struct command_line *line, int argc, char **argv,
                       const char *of);

/* Runs it with these words; with a report (may be NULL) it makes nothing and fills that,
 * as filter_command_run() does. An exit code. */
struct frames_report;
int command_line_run(const struct command_line *line, int argc, char **argv,
                     struct frames_report *report);

/* The value of its option `name`, the last where it is given twice; NULL: not given. */
const char *command_line_value(const struct command_line *line, const char *name);

/* Index of the i-th word that is neither an option nor its value, and stands before
 * "--"; -1: there is none. */
int command_line_operand(const struct command_line *line, int i);

/* Its words without the option `left_out` (may be NULL) into `words`, which has room for
 * argc. Returns how many; *n_head of them stand before "--". */
int command_line_words(const struct command_line *line, const char *left_out,
                       char **words, int *n_head);

/* Every word of it that may be a name, patterns for each frame of the report, must be no
 * output: an input, a table, what the line writes itself. False without memory. */
struct outputs;
bool command_line_spare(const struct command_line *line,
                        const struct frames_report *report, struct outputs *outputs);

/* Writes them for a shell, each after a blank, and `added` (may be NULL), as it is,
 * before "--". */
void command_line_print(FILE *file, const struct command_line *line,
                        const char *left_out, const char *added);

/* A word as a POSIX shell reads it. */
void command_line_print_word(FILE *file, const char *word);

#endif
