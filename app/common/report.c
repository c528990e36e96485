/* SPDX-License-Identifier: Apache-2.0 */
#include "common/report.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include "file.h"
#include "interrupt.h"
#include "parallel.h"
#include "rackfocus/rackfocus.h"

/* What the format reads may lie in the error itself. */
static void fill(struct image_error *error, const char *format, va_list arguments)
{
    char text[sizeof(error->message)];
    vsnprintf(text, sizeof(text), format, arguments);
    snprintf(error->message, sizeof(error->message), "%s", text);
    error->code = IMAGE_FAILED;
}

int app_fail(struct image_error *error, enum app_code code, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fill(error, format, arguments);
    va_end(arguments);
    if (code == APP_NO_MEMORY)
        error->code = IMAGE_NO_MEMORY;
    return code;
}

int app_code_of(const struct image_error *error)
{
    return error->code == IMAGE_NO_MEMORY ? APP_NO_MEMORY : APP_FAILED;
}

bool set_error(struct image_error *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    fill(error, format, arguments);
    va_end(arguments);
    return false;
}

bool app_missing(struct image_error *error, const char *option, const char *path)
{
    if (error->code == IMAGE_NO_MEMORY || os_file_facts(path).kind != OS_FILE_NONE)
        return false;
    return set_error(error,
                     "--%s: there is no file %s; correct its name or folder, or leave "
                     "the option out",
                     option, path);
}

int app_warn(const struct app_host *host, struct image_error *error, const char *format,
             ...)
{
    char text[sizeof(error->message)];
    va_list arguments;
    if (!host || !host->warn)
        return APP_DONE;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    return host->warn(host->user, text) ? APP_DONE
                                        : app_fail(error, APP_FAILED, "%s", text);
}

struct app_host app_host_of_part(const struct app_host *host)
{
    struct app_host of_part = host ? *host : (struct app_host){0};
    of_part.say = NULL;
    return of_part;
}

void app_say(const struct app_host *host, const char *format, ...)
{
    char text[2048];
    va_list arguments;
    if (!host || !host->say)
        return;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    host->say(host->user, text);
}

void app_begin(const struct app_host *host, const char *what)
{
    if (host && host->begin)
        host->begin(host->user, what);
}

bool app_progress(void *user, double fraction)
{
    const struct app_host *host = user;
    return host && host->progress ? host->progress(host->user, fraction)
                                  : !os_is_interrupted();
}

void app_end(const struct app_host *host)
{
    if (host && host->end)
        host->end(host->user);
}

void *app_memory(size_t n_items, size_t item_bytes, struct image_error *error)
{
    void *memory = calloc(n_items ? n_items : 1, item_bytes ? item_bytes : 1);
    if (!memory && error)
        app_fail(error, APP_NO_MEMORY,
                 "out of memory; %zu items of %zu bytes were asked for", n_items,
                 item_bytes);
    return memory;
}

int thread_count(int asked)
{
    const int n = asked > 0 ? asked : os_processors();
    os_parallel_most(n); /* for what takes as many as there are */
    return n;
}
