/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the sub-commands of `rackfocus` share: how one is described, the list of them,
 * exit codes and messages (report.h).
 *
 * A new sub-command is one file, cmd_NAME.c, that defines
 *
 *     const struct command command_NAME = {.name = "NAME", ..., .run = cmd_NAME};
 *
 * and one line in COMMAND_LIST. Help, man page and completion follow from it.
 */
#ifndef CLI_CLI_H
#define CLI_CLI_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "common/report.h"
#include "console/options.h"
#include "console/progress.h"
#include "thread.h"

enum exit_code {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_USAGE = 2,
    EXIT_INTERRUPTED = 130,
};

struct command {
    const char *name;
    const char *summary;     /* one line, no full stop */
    const char *usage;       /* what follows "rackfocus NAME" */
    const char *description; /* paragraphs parted by an empty line; may be "" */
    const char *examples;    /* command lines, one per line; may be NULL */
    const struct option *options;
    size_t n_options;
    bool takes_params;   /* also accepts every parameter of params.def */
    bool keeps_rest;     /* what follows "--" is not for this program */
    bool takes_line;     /* ... nor what its first word begins: "--" may be left out */
    bool is_handed_over; /* another program parses the same words again */
    /* argv[0] is the sub-command's name; returns an exit code. */
    int (*run)(int argc, char **argv);
};

/* X(name), in the order in which help shows them. */
#define COMMAND_LIST(X)                                                                \
    X(filter)                                                                          \
    X(finish)                                                                          \
    X(info)                                                                            \
    X(focus)                                                                           \
    X(compare)                                                                         \
    X(compare_methods)                                                                 \
    X(accumulate)                                                                      \
    X(frames)                                                                          \
    X(submit)                                                                          \
    X(aperture)                                                                        \
    X(methods)                                                                         \
    X(looks)                                                                           \
    X(povray)                                                                          \
    X(view)

#define DECLARE_COMMAND(name) extern const struct command command_##name;
COMMAND_LIST(DECLARE_COMMAND)
#undef DECLARE_COMMAND

/* All sub-commands. */
const struct command *const *command_list(size_t *n);

/* `rackfocus --help` on stdout. */
void command_print_overview(void);

/* The sub-command of this name, or NULL. */
const struct command *command_find(const char *name);

/* "rackfocus: " and the text on stderr. The text reads "FILE: what; way out". */
void message(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* What messages and results call a file of ours that stands for something else, such as
 * standard input. Two at most; the texts must stay. */
void message_show_as(const char *path, const char *name);
/* That name, or the path where it has none. */
const char *message_shown(const char *path);

/* The same as a warning; nothing where `is_quiet`. */
void warning(bool is_quiet, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The exit code for an enum app_code; says the error. */
int exit_code(int code, const struct image_error *error);

/* Says that memory lacks; EXIT_FAILED. */
int exit_without_memory(void);

/* Warnings and results of app/ on the terminal. */
struct cli_host {
    struct app_host host;
    struct progress bar;
    bool is_quiet, is_strict;
    FILE *results;     /* stdout, or stderr where the picture goes to stdout */
    uint32_t said[64]; /* hashes of warnings: each is said once */
    int n_said;
    struct os_lock lock;
};

/* The struct must stay where it is. */
const struct app_host *cli_host_open(struct cli_host *host, bool is_quiet,
                                     bool is_strict);

#endif
