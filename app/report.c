/* SPDX-License-Identifier: Apache-2.0 */
#include "report.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <omp.h>

#include "image.h"
#include "rackfocus/rackfocus.h"

static _Thread_local struct {
    char *text;
    size_t n_bytes;
} capture;

void message_capture(char *text, size_t n_bytes)
{
    capture.text = text;
    capture.n_bytes = n_bytes;
}

static void print(const char *kind, const char *format, va_list arguments)
{
    fflush(stdout);
    flockfile(stderr);
    fprintf(stderr, "rackfocus: %s", kind);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    funlockfile(stderr);
}

void message(const char *format, ...)
{
    va_list arguments;
    if (capture.text) {
        char *text = need_memory(capture.n_bytes, 1);
        va_start(arguments, format);
        vsnprintf(text, capture.n_bytes, format, arguments);
        va_end(arguments);
        memcpy(capture.text, text, capture.n_bytes); /* may be among the arguments */
        free(text);
    }
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

bool set_error(struct image_error *error, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(error->message, sizeof(error->message), format, arguments);
    va_end(arguments);
    return false;
}

void *need_memory(size_t n_items, size_t item_bytes)
{
    void *memory = calloc(n_items ? n_items : 1, item_bytes ? item_bytes : 1);
    if (!memory) {
        message("out of memory; %zu items of %zu bytes were asked for", n_items,
                item_bytes);
        exit(EXIT_FAILED);
    }
    return memory;
}

int thread_count(int asked)
{
    const struct rf_context_params params = {
        .size = sizeof(params), .n_threads = asked > 0 ? asked : omp_get_max_threads()};
    struct rf_context *context;
    if (rf_context_create(&context, &params, NULL) != RF_OK)
        return 1;
    const int n = rf_context_threads(context);
    rf_context_destroy(context);
    omp_set_num_threads(n); /* for what takes as many as there are */
    return n;
}
