/* SPDX-License-Identifier: Apache-2.0 */
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "base/system.h"
#include "base/system_threads.h"
#include "base/threads.h"
#include "compose/footprint_shelf.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

static void *default_allocate(void *user, size_t n_bytes)
{
    return rf_system_allocate(RF_ALIGNMENT, n_bytes);
}

static void default_release(void *user, void *memory)
{
    rf_system_release(memory);
}

/* Parts of a block of memory begin aligned. */
static size_t round_up(size_t n_bytes)
{
    return (n_bytes + RF_ALIGNMENT - 1) / RF_ALIGNMENT * RF_ALIGNMENT;
}

/* ---- contexts ------------------------------------------------------------------ */

static rf_result fail_cpu(struct rf_error *error, const char *cpu)
{
    char names[64] = "";
    const struct rf_kernels *level;
    for (int i = 0; (level = rf_kernels_at(i)); i++)
        snprintf(names + strlen(names), sizeof names - strlen(names), "%s%s",
                 i ? ", " : "", level->name);
    return rf_fail(error, RF_ERROR_PARAMETER, "cpu",
                   "no instruction set \"%.32s\" on this machine, which has %s", cpu,
                   names);
}

/* Fills in what params leave to the library; checks them. */
static rf_result complete_params(struct rf_context_params *p, struct rf_error *error)
{
    if (p->n_threads < 0 || p->n_threads > RF_MAX_THREADS)
        return rf_fail(error, RF_ERROR_PARAMETER, "n_threads",
                       "%d threads: the range is 0 (all processors) to %d",
                       p->n_threads, RF_MAX_THREADS);
    if (p->cpu && !*p->cpu)
        p->cpu = NULL;
    if (!rf_kernels_find(p->cpu))
        return fail_cpu(error, p->cpu);
    if (!p->allocate != !p->release)
        return rf_fail(error, RF_ERROR_ARGUMENT, "allocate",
                       "set both allocate and release, or neither");
    if (!p->allocate) {
        p->allocate = default_allocate;
        p->release = default_release;
    }
    return RF_OK;
}

/* The context and what belongs to it, in one block of memory. */
static rf_result allocate_context(const struct rf_context_params *p,
                                  struct rf_context **context, struct rf_error *error)
{
    int n_threads = p->n_threads ? p->n_threads
                                 : rf_min_int(rf_system_processors(), RF_MAX_THREADS);
    size_t n_own = round_up(sizeof **context),
           n_pool = round_up(sizeof(struct rf_pool));
    size_t n_shelf = round_up(rf_shelf_bytes());
    size_t n_bytes = n_own + n_pool + n_shelf + round_up(rf_threads_bytes(n_threads));
    char *memory = p->allocate(p->user, n_bytes);
    if (!memory)
        return rf_fail_memory(error, 1, n_bytes);
    memset(memory, 0, n_bytes);
    struct rf_context *c = (struct rf_context *)memory;
    c->params = *p;
    c->n_threads = n_threads;
    c->pool = (struct rf_pool *)(memory + n_own);
    c->shelf = (struct rf_shelf *)(memory + n_own + n_pool);
    c->threads = rf_threads_init(memory + n_own + n_pool + n_shelf, n_threads);
    *context = c;
    return RF_OK;
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
    struct rf_context *made = NULL;
    rf_result result = complete_params(&p, error);
    if (result == RF_OK)
        result = allocate_context(&p, &made, error);
    if (result != RF_OK)
        return result;
    made->kernels = rf_kernels_find(p.cpu);
    *context = made;
    return RF_OK;
}

void rf_context_destroy(struct rf_context *context)
{
    if (!context)
        return;
    rf_threads_end(context->threads);
    rf_shelf_clear(context);
    rf_pool_clear(context);
    context->params.release(context->params.user, context);
}

int32_t rf_context_threads(const struct rf_context *context)
{
    return context->params.parallel_for ? context->n_threads
                                        : rf_threads_count(context->threads);
}

const char *rf_context_cpu(const struct rf_context *context)
{
    return context->kernels->name;
}
