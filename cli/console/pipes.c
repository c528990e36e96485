/* SPDX-License-Identifier: Apache-2.0 */
#include "console/pipes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "common/report.h"
#include "console/cli.h"
#include "folder.h"
#include "leftovers.h"
#include "terminal.h"

static bool is_dash(const char *name)
{
    return name && strcmp(name, "-") == 0;
}

bool pipes_are_named(const struct operands *operands, const char *output)
{
    bool is_named = is_dash(output);
    for (int i = 0; i < operands->n; i++)
        is_named |= is_dash(operands->items[i]);
    return is_named;
}

/* Copies all of a stream; 0 or errno. */
static int copy(FILE *from, FILE *to)
{
    char block[1 << 14];
    size_t n;
    errno = 0;
    while ((n = fread(block, 1, sizeof(block), from)) > 0)
        if (fwrite(block, 1, n, to) != n)
            return errno ? errno : EIO;
    return ferror(from) ? (errno ? errno : EIO) : 0;
}

static bool take_input(struct pipes *pipes, struct image_error *error)
{
    snprintf(pipes->input, sizeof(pipes->input), "%s/standard-input.exr",
             pipes->folder);
    FILE *file = fopen(pipes->input, "wb");
    int reason = file ? copy(stdin, file) : errno;
    if (file && fclose(file) != 0 && reason == 0)
        reason = errno;
    if (reason == ENOSPC || reason == EDQUOT)
        return set_error(error,
                         "standard input: no space left in %s, where it is kept; free "
                         "some space there or name another folder in TMPDIR",
                         os_folder_for_temporary());
    return reason == 0 || set_error(error, "standard input: %s", strerror(reason));
}

/* Are the streams there that are named, before anything is read or done? */
static bool check_open(int n_inputs, const char *output, struct image_error *error)
{
    if (n_inputs > 0 && !os_stream_is_open(stdin))
        return set_error(error, "-: standard input is closed; send it a file");
    if (is_dash(output) && !os_stream_is_open(stdout))
        return set_error(error, "-: standard output is closed; send it into a file or "
                                "a program");
    return true;
}

static bool check_usage(int n, const char *output, struct image_error *error)
{
    if (n > 1)
        return set_error(error, "-: standard input can be one of the inputs only");
    if (n == 1 && os_terminal_is_one(stdin))
        return set_error(error, "-: standard input is a terminal; send it a file");
    if (is_dash(output) && os_terminal_is_one(stdout))
        return set_error(error, "-: standard output is a terminal; send it into a file "
                                "or a program");
    return true;
}

/* A private folder for both. */
static bool make_folder(struct pipes *pipes, struct image_error *error)
{
    char prefix[300];
    snprintf(prefix, sizeof(prefix), "%.200s/rackfocus-", os_folder_for_temporary());
    os_leftovers_remove(prefix);
    const int reason =
        os_folder_make_temporary(prefix, pipes->folder, sizeof(pipes->folder));
    if (reason == 0)
        return true;
    pipes->folder[0] = '\0';
    return set_error(error,
                     "%s: no temporary folder can be made there: %s; name another in "
                     "TMPDIR",
                     os_folder_for_temporary(), strerror(reason));
}

enum app_code pipes_open(struct pipes *pipes, struct operands *operands,
                         const char **output, bool is_png, struct image_error *error)
{
    const char *out = output ? *output : NULL;
    int n = 0;
    *pipes = (struct pipes){.has_output = is_dash(out)};
    for (int i = 0; i < operands->n; i++)
        n += is_dash(operands->items[i]);
    if (!check_usage(n, out, error))
        return APP_USAGE;
    if (!check_open(n, out, error) || !make_folder(pipes, error))
        return APP_FAILED;
    for (int i = 0; i < operands->n; i++)
        if (is_dash(operands->items[i])) {
            if (!take_input(pipes, error))
                return APP_FAILED;
            operands->items[i] = pipes->input;
            message_show_as(pipes->input, "standard input");
        }
    snprintf(pipes->output, sizeof(pipes->output), "%s/standard-output.%s",
             pipes->folder, is_png ? "png" : "exr");
    if (output && pipes->has_output) {
        *output = pipes->output;
        message_show_as(pipes->output, "standard output");
    }
    return APP_DONE;
}

bool pipes_send(const struct pipes *pipes, struct image_error *error)
{
    FILE *file = fopen(pipes->output, "rb");
    int reason = file ? copy(file, stdout) : errno;
    if (file)
        fclose(file);
    if (reason == 0 && fflush(stdout) != 0)
        reason = errno;
    return reason == 0 || set_error(error, "standard output: %s", strerror(reason));
}

void pipes_close(struct pipes *pipes)
{
    if (pipes->folder[0])
        os_folder_remove(pipes->folder);
    pipes->folder[0] = '\0';
}
