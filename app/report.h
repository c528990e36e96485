/* SPDX-License-Identifier: Apache-2.0 */
/* Errors, warnings, memory and threads for all of app/. */
#ifndef APP_REPORT_H
#define APP_REPORT_H

#include <stdbool.h>
#include <stddef.h>

enum exit_code {
    EXIT_DONE = 0,
    EXIT_FAILED = 1,
    EXIT_USAGE = 2,
    EXIT_INTERRUPTED = 130,
};

/* "rackfocus: " and the text on stderr. The text reads "FILE: what; way out". */
void message(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Until it is called with NULL, messages of this thread are also kept in `text`. */
void message_capture(char *text, size_t n_bytes);

/* The same as a warning; nothing where `is_quiet`. */
void warning(bool is_quiet, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

struct image_error;

/* Puts the text into *error; always false, to be returned. */
bool set_error(struct image_error *error, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* Memory of n_items * item_bytes, zeroed; says so and ends the program where there is
 * none. */
void *need_memory(size_t n_items, size_t item_bytes);

/* The number of threads for -j `asked`; 0 is one per processor. */
int thread_count(int asked);

#endif
