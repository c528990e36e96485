/* SPDX-License-Identifier: Apache-2.0 */
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

#include "internal.h"
#include "kernels/kernels.h"

enum { RF_ALIGNMENT = 64, RF_MAX_THREADS = 1024, HUGE_PAGE = 2 << 20 };

/*
 * Buffers of a picture are touched once and given back: with pages of 4 kB a third of
 * the filter's time goes into the faults, so large blocks ask for huge ones.
 */
static void *default_allocate(void *user, size_t n_bytes)
{
#ifdef MADV_HUGEPAGE
    if (n_bytes >= 2 * HUGE_PAGE) {
        n_bytes = (n_bytes + HUGE_PAGE - 1) / HUGE_PAGE * HUGE_PAGE;
        void *memory = aligned_alloc(HUGE_PAGE, n_bytes);
        if (memory)
            madvise(memory, n_bytes, MADV_HUGEPAGE); /* only advice: may fail */
        return memory;
    }
#endif
    return aligned_alloc(RF_ALIGNMENT, n_bytes);
}

static void default_release(void *user, void *memory)
{
    free(memory);
}

rf_result rf_context_create(struct rf_context **context,
                            const struct rf_context_params *params,
                            struct rf_error *error)
{
    if (!context)
        return rf_fail(error, RF_ERROR_ARGUMENT, "context", "context is NULL");
    struct rf_context_params p = {0};
    if (params) {
        if (params->size == 0 || params->size > sizeof p)
            return rf_fail(error, RF_ERROR_ARGUMENT, "size",
                           "set rf_context_params.size to its sizeof");
        memcpy(&p, params, params->size);
    }
    if (p.n_threads < 0 || p.n_threads > RF_MAX_THREADS)
        return rf_fail(error, RF_ERROR_PARAMETER, "n_threads",
                       "%d threads: the range is 0 (all processors) to %d", p.n_threads,
                       RF_MAX_THREADS);
    if (!p.allocate != !p.release)
        return rf_fail(error, RF_ERROR_ARGUMENT, "allocate",
                       "set both allocate and release, or neither");
    if (!p.allocate) {
        p.allocate = default_allocate;
        p.release = default_release;
    }
    struct rf_context *c = p.allocate(p.user, RF_ALIGNMENT * 4);
    if (!c)
        return rf_fail_memory(error, 1, sizeof *c);
    _Static_assert(sizeof *c <= RF_ALIGNMENT * 4, "grow the allocation");
    c->params = p;
    c->n_threads = p.n_threads ? p.n_threads : omp_get_num_procs();
    *context = c;
    return RF_OK;
}

void rf_context_destroy(struct rf_context *context)
{
    if (context)
        context->params.release(context->params.user, context);
}

int32_t rf_context_threads(const struct rf_context *context)
{
    return context->n_threads;
}

const char *rf_context_cpu(const struct rf_context *context)
{
    return rf_kernels_best()->name;
}

int rf_thread_num(void)
{
    return omp_get_thread_num();
}

void *rf_alloc(const struct rf_context *context, size_t count, size_t size)
{
    size_t n_bytes;
    if (__builtin_mul_overflow(count, size, &n_bytes) ||
        n_bytes > SIZE_MAX - RF_ALIGNMENT)
        return NULL;
    n_bytes = (n_bytes + RF_ALIGNMENT) / RF_ALIGNMENT * RF_ALIGNMENT;
    return context->params.allocate(context->params.user, n_bytes);
}

void *rf_calloc(const struct rf_context *context, size_t count, size_t size)
{
    void *memory = rf_alloc(context, count, size);
    if (memory)
        memset(memory, 0, count * size);
    return memory;
}

void rf_free(const struct rf_context *context, void *memory)
{
    if (memory)
        context->params.release(context->params.user, memory);
}

rf_result rf_fail_memory(struct rf_error *error, size_t count, size_t size)
{
    return rf_fail(error, RF_ERROR_MEMORY, "", "out of memory: %.1f MiB were needed",
                   (double)count * (double)size / (1024.0 * 1024.0));
}

void rf_log(const struct rf_context *context, enum rf_log_level level,
            const char *format, ...)
{
    if (!context->params.log)
        return;
    char message[256];
    va_list args;
    va_start(args, format);
    vsnprintf(message, sizeof message, format, args);
    va_end(args);
    context->params.log(context->params.user, level, message);
}
