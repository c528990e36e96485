/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "common/report.h"
#include "console/cli.h"
#include "console/progress.h"
#include "interrupt.h"

/* Of the command line, which is one; set before any work begins. */
static struct {
    const char *path, *name;
} shown_as[2];

void message_show_as(const char *path, const char *name)
{
    const int i = shown_as[0].path != NULL;
    shown_as[i].path = path;
    shown_as[i].name = name;
}

const char *message_shown(const char *path)
{
    for (int i = 0; i < 2; i++)
        if (shown_as[i].path && strcmp(shown_as[i].path, path) == 0)
            return shown_as[i].name;
    return path;
}

/* Writes a text with the names that its files are shown by. */
static void write_shown(FILE *file, const char *text)
{
    while (*text) {
        const char *next = NULL, *name = "";
        size_t n_path = 0;
        for (int i = 0; i < 2; i++) {
            const char *at = shown_as[i].path ? strstr(text, shown_as[i].path) : NULL;
            if (at && (!next || at < next)) {
                next = at;
                name = shown_as[i].name;
                n_path = strlen(shown_as[i].path);
            }
        }
        const size_t n = next ? (size_t)(next - text) : strlen(text);
        fwrite(text, 1, n, file);
        fputs(name, file);
        text += n + n_path;
    }
}

static void print(const char *kind, const char *format, va_list arguments)
{
    char text[8192];
    vsnprintf(text, sizeof(text), format, arguments);
    fflush(stdout);
    flockfile(stderr);
    fprintf(stderr, "rackfocus: %s", kind);
    write_shown(stderr, text);
    fputc('\n', stderr);
    funlockfile(stderr);
}

void message(const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    print("", format, arguments);
    va_end(arguments);
}

void warning(bool is_quiet, const char *format, ...)
{
    if (is_quiet)
        return;
    va_list arguments;
    va_start(arguments, format);
    print("warning: ", format, arguments);
    va_end(arguments);
}

int exit_code(int code, const struct image_error *error)
{
    switch ((enum app_code)code) {
    case APP_DONE:
        return EXIT_DONE;
    case APP_INTERRUPTED:
        return os_interrupt_code();
    case APP_USAGE:
    case APP_FAILED:
    case APP_NO_MEMORY:
        break;
    }
    if (error->message[0])
        message("%s", error->message);
    return code == APP_USAGE ? EXIT_USAGE : EXIT_FAILED;
}

int exit_without_memory(void)
{
    message("out of memory");
    return EXIT_FAILED;
}

/* ---- the host of app/ ------------------------------------------------------------ */

/* Frames of a sequence have the same to say. */
static bool is_new(struct cli_host *host, const char *text)
{
    enum { ROOM = sizeof(host->said) / sizeof(host->said[0]) };
    uint32_t hash = 2166136261u;
    bool is_known = false;
    for (const char *at = text; *at; at++)
        hash = (hash ^ (unsigned char)*at) * 16777619u;
    os_lock_take(&host->lock);
    for (int i = 0; i < host->n_said; i++)
        is_known |= host->said[i] == hash;
    if (!is_known && host->n_said < ROOM)
        host->said[host->n_said++] = hash;
    os_lock_release(&host->lock);
    return !is_known;
}

static bool host_warn(void *user, const char *text)
{
    struct cli_host *host = user;
    if (host->is_strict)
        return false;
    if (is_new(host, text))
        warning(host->is_quiet, "%s", text);
    return true;
}

static void host_fail(void *user, const char *text)
{
    (void)user;
    message("%s", text);
}

static void host_say(void *user, const char *text)
{
    const struct cli_host *host = user;
    if (host->is_quiet)
        return;
    write_shown(host->results, text);
    fputc('\n', host->results);
    /* That nobody reads it is no failure of the work. */
    if (fflush(host->results) != 0 && errno == EPIPE)
        clearerr(host->results);
}

static void host_begin(void *user, const char *what)
{
    struct cli_host *host = user;
    progress_start(&host->bar, what, host->is_quiet);
}

static bool host_progress(void *user, double fraction)
{
    struct cli_host *host = user;
    return progress_report(&host->bar, fraction);
}

static void host_end(void *user)
{
    struct cli_host *host = user;
    progress_end(&host->bar);
}

const struct app_host *cli_host_open(struct cli_host *host, bool is_quiet,
                                     bool is_strict)
{
    *host = (struct cli_host){
        .is_quiet = is_quiet, .is_strict = is_strict, .results = stdout};
    os_lock_init(&host->lock);
    host->host = (struct app_host){.user = host,
                                   .warn = host_warn,
                                   .fail = host_fail,
                                   .say = host_say,
                                   .begin = host_begin,
                                   .progress = host_progress,
                                   .end = host_end};
    if (is_quiet)
        host->host.say = NULL;
    if (is_quiet && !is_strict)
        host->host.warn = NULL;
    return &host->host;
}
