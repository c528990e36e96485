/* SPDX-License-Identifier: Apache-2.0 */
#include "threads.h"

#ifdef __wasm_atomics__

#include <stdatomic.h>
#include <stdlib.h>

/* The loop that is open to helpers; one at a time, as one worker calls the library. */
static struct {
    _Atomic int32_t generation; /* grows with every loop; helpers wait for that */
    _Atomic int32_t is_open, n_inside;
    _Atomic int32_t next;
    int32_t n_tasks;
    void (*task)(void *data, int32_t index);
    void *data;
} loop;

static void take_part(void)
{
    int32_t i;
    while ((i = atomic_fetch_add(&loop.next, 1)) < loop.n_tasks)
        loop.task(loop.data, i);
}

static void wait_while(_Atomic int32_t *at, int32_t value)
{
    __builtin_wasm_memory_atomic_wait32((int32_t *)at, value, -1);
}

static void wake(_Atomic int32_t *at)
{
    __builtin_wasm_memory_atomic_notify((int32_t *)at, ~0u);
}

/* Never returns: what a helper's worker runs until it is ended. */
__attribute__((export_name("rw_help"))) void rw_help(void)
{
    for (int32_t seen = 0;; seen = atomic_load(&loop.generation)) {
        wait_while(&loop.generation, seen);
        /* Inside before looking: the caller waits for who has seen an open loop. */
        atomic_fetch_add(&loop.n_inside, 1);
        if (atomic_load(&loop.is_open))
            take_part();
        if (atomic_fetch_sub(&loop.n_inside, 1) == 1)
            wake(&loop.n_inside);
    }
}

static void parallel_for(void *user, int32_t n_tasks,
                         void (*task)(void *data, int32_t index), void *data)
{
    (void)user;
    loop.task = task;
    loop.data = data;
    loop.n_tasks = n_tasks;
    atomic_store(&loop.next, 0);
    atomic_store(&loop.is_open, 1);
    atomic_fetch_add(&loop.generation, 1);
    wake(&loop.generation);
    take_part();
    atomic_store(&loop.is_open, 0);
    int32_t n_inside;
    while ((n_inside = atomic_load(&loop.n_inside)) != 0)
        wait_while(&loop.n_inside, n_inside);
}

/* The C library's own memory knows no threads. */
static atomic_flag is_allocating = ATOMIC_FLAG_INIT;

static void lock(void)
{
    while (atomic_flag_test_and_set(&is_allocating))
        ;
}

static void *allocate(void *user, size_t n_bytes)
{
    (void)user;
    lock();
    void *memory = aligned_alloc(64, (n_bytes + 63) / 64 * 64);
    atomic_flag_clear(&is_allocating);
    return memory;
}

static void release(void *user, void *memory)
{
    (void)user;
    lock();
    free(memory);
    atomic_flag_clear(&is_allocating);
}

struct rf_context_params threads_params(int n_threads)
{
    return (struct rf_context_params){.size = sizeof(struct rf_context_params),
                                      .n_threads = n_threads,
                                      .allocate = allocate,
                                      .release = release,
                                      .parallel_for = parallel_for};
}

#else

struct rf_context_params threads_params(int n_threads)
{
    (void)n_threads;
    return (struct rf_context_params){.size = sizeof(struct rf_context_params),
                                      .n_threads = 1};
}

#endif
