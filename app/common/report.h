/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How app/ speaks to the program that uses it: errors are returned, as a code with a
 * text; remarks, results and progress go to a struct app_host. Nothing in app/ prints,
 * exits or aborts.
 */
#ifndef APP_REPORT_H
#define APP_REPORT_H

#include <stdbool.h>
#include <stddef.h>

#include "image.h"

/* What a piece of work ended with. The text is in the struct image_error that went with
 * the call; there is none for APP_INTERRUPTED. */
enum app_code {
    APP_DONE,
    APP_FAILED,      /* files, or what they hold */
    APP_USAGE,       /* what was asked for */
    APP_NO_MEMORY,   /* the same call may work later, or with fewer threads */
    APP_INTERRUPTED, /* os_is_interrupted(), or the host's progress said so */
};

/* Who asked for the work; any function may be NULL. They may be called on the threads
 * of a sequence, several at a time. */
struct app_host {
    void *user;
    /* Something that the user should know: "FILE: what; way out". False: it is an error
     * to this user, and the work ends. */
    bool (*warn)(void *user, const char *text);
    /* What one of several pieces of work ended with; the others go on. */
    void (*fail)(void *user, const char *text);
    /* A result, one line. */
    void (*say)(void *user, const char *text);
    /* A longer piece of work begins, is at 0 to 1 of its time, ends. False from
     * `progress` cancels. Not in a sequence, which says its frames. */
    void (*begin)(void *user, const char *what);
    bool (*progress)(void *user, double fraction);
    void (*end)(void *user);
};

/* Fills the error; returns the code. */
int app_fail(struct image_error *error, enum app_code code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The code of what a function of image.h or one like it said. */
int app_code_of(const struct image_error *error);

/* The same, with false to be returned in place of a code. */
bool set_error(struct image_error *error, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/*
 * The error of reading the file that an option names: says the option where the file is
 * missing, whose name alone does not tell which of a command's files it is. Returns
 * false.
 */
bool app_missing(struct image_error *error, const char *option, const char *path);

/* APP_DONE; or, where the host wants none, APP_FAILED with the warning as the error. */
int app_warn(const struct app_host *host, struct image_error *error, const char *format,
             ...) __attribute__((format(printf, 3, 4)));

/* The host, deaf to results: for work that is a part of other work. */
struct app_host app_host_of_part(const struct app_host *host);

void app_say(const struct app_host *host, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The longer pieces of work of a host; app_progress() takes the host as a pointer
 * without const, for struct rf_progress, and without one asks os_is_interrupted(). */
void app_begin(const struct app_host *host, const char *what);
bool app_progress(void *host, double fraction);
void app_end(const struct app_host *host);

/* Zeroed memory of n_items * item_bytes, at least a byte; NULL with the error filled
 * (which may be NULL) where there is none. */
void *app_memory(size_t n_items, size_t item_bytes, struct image_error *error);

/* The number of threads for -j `asked`; 0 is one per processor. */
int thread_count(int asked);

#endif
