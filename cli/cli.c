/* SPDX-License-Identifier: Apache-2.0 */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <omp.h>

#include "cli.h"

static void print(const char *kind, const char *format, va_list arguments)
{
    fflush(stdout);
    fprintf(stderr, "rackfocus: %s", kind);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
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
    return asked > 0 ? asked : omp_get_max_threads();
}
