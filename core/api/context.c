/* SPDX-License-Identifier: Apache-2.0 */
#include <omp.h>
#include <pthread.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/log.h"
#include "base/pool.h"
#include "base/system.h"
#include "compose/footprint_shelf.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

enum { RF_MAX_THREADS = 1024 };

static void *default_allocate(void *user, size_t n_bytes)
{
    return rf_system_allocate(RF_ALIGNMENT, n_bytes);
}

static void default_release(void *user, void *memory)
{
    rf_system_release(memory);
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

static void *wait_for_gate(void *gate)
{
    pthread_mutex_lock(gate);
    pthread_mutex_unlock(gate);
    return NULL;
}

/*
 * How many of n threads the system gives, the caller's own among them. OpenMP ends the
 * program where it cannot have what it was told to take, and the program is a host's.
 */
static int probe_threads(int n)
{
    pthread_t threads[RF_MAX_THREADS];
    pthread_mutex_t gate = PTHREAD_MUTEX_INITIALIZER;
    int n_made = 0;
    pthread_mutex_lock(&gate);
    while (n_made < n - 1 &&
           pthread_create(&threads[n_made], NULL, wait_for_gate, &gate) == 0)
        n_made++;
    pthread_mutex_unlock(&gate);
    for (int i = 0; i < n_made; i++)
        pthread_join(threads[i], NULL);
    return n_made + 1;
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
    const char *cpu = p.cpu && *p.cpu ? p.cpu : NULL;
    const struct rf_kernels *kernels = rf_kernels_find(cpu);
    if (!kernels)
        return fail_cpu(error, cpu);
    if (!p.allocate != !p.release)
        return rf_fail(error, RF_ERROR_ARGUMENT, "allocate",
                       "set both allocate and release, or neither");
    if (!p.allocate) {
        p.allocate = default_allocate;
        p.release = default_release;
    }
    struct {
        struct rf_context context;
        struct rf_pool pool;
    } * both;
    size_t n_bytes = (sizeof *both + rf_shelf_bytes() + RF_ALIGNMENT - 1) /
                     RF_ALIGNMENT * RF_ALIGNMENT;
    both = p.allocate(p.user, n_bytes);
    if (!both)
        return rf_fail_memory(error, 1, n_bytes);
    struct rf_context *c = &both->context;
    both->pool = (struct rf_pool){.free = NULL};
    c->pool = &both->pool;
    c->shelf = (struct rf_shelf *)(both + 1);
    memset(c->shelf, 0, rf_shelf_bytes());
    c->params = p;
    c->kernels = kernels;
    c->n_threads = probe_threads(p.n_threads ? p.n_threads : omp_get_num_procs());
    if (p.n_threads && c->n_threads < p.n_threads)
        rf_log(c, RF_LOG_WARNING, "only %d of %d threads can be made here",
               c->n_threads, p.n_threads);
    *context = c;
    return RF_OK;
}

void rf_context_destroy(struct rf_context *context)
{
    if (!context)
        return;
    rf_shelf_clear(context);
    rf_pool_clear(context);
    context->params.release(context->params.user, context);
}

int32_t rf_context_threads(const struct rf_context *context)
{
    return context->n_threads;
}

const char *rf_context_cpu(const struct rf_context *context)
{
    return context->kernels->name;
}
