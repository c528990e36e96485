/* SPDX-License-Identifier: Apache-2.0 */
/* One pool of the core's threads for the process. */
#include "parallel.h"

#include <stdbool.h>
#include <stdlib.h>

#include "base/system_threads.h"
#include "base/threads.h"

static int wanted; /* atomic: threads; 0: one for each processor */

static int smaller(int a, int b)
{
    return a < b ? a : b;
}

/* Made when it is first needed; it stays for the process. NULL: out of memory. */
static struct rf_threads *find_pool(void)
{
    static struct rf_threads *pool; /* atomic */
    struct rf_threads *found = __atomic_load_n(&pool, __ATOMIC_ACQUIRE);
    if (found)
        return found;
    int n = __atomic_load_n(&wanted, __ATOMIC_RELAXED);
    n = smaller(n > 0 ? n : os_processors(), RF_MAX_THREADS);
    void *memory = malloc(rf_threads_bytes(n));
    if (!memory)
        return NULL;
    struct rf_threads *made = rf_threads_init(memory, n);
    if (__atomic_compare_exchange_n(&pool, &found, made, false, __ATOMIC_ACQ_REL,
                                    __ATOMIC_ACQUIRE))
        return made;
    free(memory); /* another thread was first */
    return found;
}

void os_parallel(int n_threads, int64_t count, int64_t grain, os_body_fn body,
                 void *data)
{
    struct rf_threads *pool = n_threads == 1 ? NULL : find_pool();
    int n = pool ? rf_threads_count(pool) : 1;
    if (n_threads > 0)
        n = smaller(n_threads, n);
    struct rf_loop loop = rf_loop_make(count, grain, n, body, data);
    if (pool)
        rf_threads_run(pool, n, &loop);
    else
        rf_loop_run(&loop, 0);
}

int os_processors(void)
{
    return rf_system_processors();
}

void os_parallel_most(int n_threads)
{
    __atomic_store_n(&wanted, n_threads, __ATOMIC_RELAXED);
}
