/* SPDX-License-Identifier: Apache-2.0 */
#include <omp.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

#include "footprint.h"
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

/* ---- the pool ------------------------------------------------------------------- */

/*
 * Large blocks are kept when they are given back and serve the next picture: their
 * pages have been touched already. What is in use and what is kept never exceed the
 * most that was in use at once by more than a quarter, nor max_bytes: with no room to
 * spare the blocks of one step of a picture would drive out those of another.
 */
enum { POOL_BLOCK = 32 << 10 }; /* bytes from which a block is kept */

/* Before every block, so that its size is known when it is given back. */
struct head {
    size_t n_bytes; /* of the whole block */
};

_Static_assert(sizeof(struct head) <= RF_ALIGNMENT, "blocks stay aligned");

static void pool_lock(struct rf_pool *pool)
{
    while (__atomic_test_and_set(&pool->lock, __ATOMIC_ACQUIRE))
        ;
}

static void pool_unlock(struct rf_pool *pool)
{
    __atomic_clear(&pool->lock, __ATOMIC_RELEASE);
}

static struct head *pool_remove(struct rf_pool *pool, int i)
{
    struct head *block = pool->kept[i];
    pool->kept_bytes -= block->n_bytes;
    pool->kept[i] = pool->kept[--pool->n_kept];
    return block;
}

static void pool_keep(struct rf_pool *pool, struct head *block)
{
    pool->kept[pool->n_kept++] = block;
    pool->kept_bytes += block->n_bytes;
}

/* The smallest kept block that holds n_bytes and is not twice as large; or NULL. */
static struct head *pool_take(struct rf_pool *pool, size_t n_bytes)
{
    int best = -1;
    for (int i = 0; i < pool->n_kept; i++) {
        const struct head *block = pool->kept[i];
        if (block->n_bytes >= n_bytes && block->n_bytes / 2 <= n_bytes &&
            (best < 0 || block->n_bytes < ((struct head *)pool->kept[best])->n_bytes))
            best = i;
    }
    return best < 0 ? NULL : pool_remove(pool, best);
}

/* Takes out kept blocks until `room` bytes fit under the limit; returns how many. */
static int pool_shrink(struct rf_pool *pool, size_t room, size_t max_bytes, void **out)
{
    size_t most = pool->peak_bytes + pool->peak_bytes / 4;
    if (max_bytes && most > max_bytes)
        most = max_bytes;
    int n = 0;
    while (pool->n_kept && pool->used_bytes + pool->kept_bytes + room > most)
        out[n++] = pool_remove(pool, 0);
    return n;
}

static void release_all(const struct rf_context *context, void **blocks, int n)
{
    for (int i = 0; i < n; i++)
        context->params.release(context->params.user, blocks[i]);
}

static void *pool_allocate(const struct rf_context *context, size_t n_bytes)
{
    struct rf_pool *pool = context->pool;
    void *excess[RF_POOL_BLOCKS];
    pool_lock(pool);
    struct head *block = pool_take(pool, n_bytes);
    size_t used = pool->used_bytes + (block ? block->n_bytes : n_bytes);
    if (context->params.max_bytes && used > context->params.max_bytes) {
        if (block)
            pool_keep(pool, block);
        pool_unlock(pool);
        return NULL;
    }
    pool->peak_bytes = used > pool->peak_bytes ? used : pool->peak_bytes;
    int n_excess =
        block ? 0 : pool_shrink(pool, n_bytes, context->params.max_bytes, excess);
    pool->used_bytes = used;
    pool_unlock(pool);
    release_all(context, excess, n_excess);
    if (block)
        return block;
    block = context->params.allocate(context->params.user, n_bytes);
    if (block) {
        block->n_bytes = n_bytes;
        return block;
    }
    pool_lock(pool);
    pool->used_bytes -= n_bytes;
    pool_unlock(pool);
    return NULL;
}

static void pool_release(const struct rf_context *context, struct head *block)
{
    struct rf_pool *pool = context->pool;
    pool_lock(pool);
    pool->used_bytes -= block->n_bytes;
    bool is_kept = pool->n_kept < RF_POOL_BLOCKS;
    if (is_kept)
        pool_keep(pool, block);
    pool_unlock(pool);
    if (!is_kept)
        context->params.release(context->params.user, block);
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
    both->pool = (struct rf_pool){.n_kept = 0};
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
    release_all(context, context->pool->kept, context->pool->n_kept);
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

int rf_thread_num(void)
{
    return omp_get_thread_num();
}

void *rf_alloc(const struct rf_context *context, size_t count, size_t size)
{
    size_t n_bytes;
    if (__builtin_mul_overflow(count, size, &n_bytes) ||
        n_bytes > SIZE_MAX - 2 * RF_ALIGNMENT)
        return NULL;
    n_bytes = (n_bytes + 2 * RF_ALIGNMENT - 1) / RF_ALIGNMENT * RF_ALIGNMENT;
    struct head *block;
    if (n_bytes >= POOL_BLOCK) {
        block = pool_allocate(context, n_bytes);
    } else {
        block = context->params.allocate(context->params.user, n_bytes);
        if (block)
            block->n_bytes = n_bytes;
    }
    return block ? (char *)block + RF_ALIGNMENT : NULL;
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
    if (!memory)
        return;
    struct head *block = (struct head *)((char *)memory - RF_ALIGNMENT);
    if (block->n_bytes >= POOL_BLOCK)
        pool_release(context, block);
    else
        context->params.release(context->params.user, block);
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
