/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Memory of the pictures of a context.
 *
 * The first touch of new memory is dear: the system must find and clear its pages. So
 * large blocks are kept when they are given back, and what asks for memory next gets
 * the smallest that holds it: in the same picture, where the passes do not all need
 * theirs at once, and in the next one. What is left of a block is a block of its own;
 * free neighbours join again.
 *
 * What is in use and what is kept never exceed the most that was in use at once by more
 * than a half, as far as whole blocks can be given back, nor max_bytes.
 */
#include "base/pool.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/context.h"
#include "rackfocus/rackfocus.h"

enum {
    LEAST_KEPT = 32 << 10, /* bytes from which a block is kept */
    /*
     * Bytes from which one is cut out of a larger one. Small ones may stay for long,
     * as footprints do, and would keep the rest of a large one from joining again.
     */
    LEAST_CUT = 1 << 20
};

/* Before every block. */
struct rf_block {
    size_t n_bytes; /* of the whole block */
    /* Of those that may be kept: */
    char *region; /* what it was cut from, as the system gave it */
    size_t region_bytes;
    struct rf_block *before;                /* in the region */
    struct rf_block *next_free, *last_free; /* in the list of the free ones */
    bool is_free;
};

_Static_assert(sizeof(struct rf_block) <= RF_ALIGNMENT, "blocks stay aligned");

static void lock(struct rf_pool *pool)
{
    while (__atomic_test_and_set(&pool->lock, __ATOMIC_ACQUIRE))
        ;
}

static void unlock(struct rf_pool *pool)
{
    __atomic_clear(&pool->lock, __ATOMIC_RELEASE);
}

static void list(struct rf_pool *pool, struct rf_block *block)
{
    block->is_free = true;
    block->last_free = NULL;
    block->next_free = pool->free;
    if (pool->free)
        pool->free->last_free = block;
    pool->free = block;
}

static void unlist(struct rf_pool *pool, struct rf_block *block)
{
    block->is_free = false;
    if (block->last_free)
        block->last_free->next_free = block->next_free;
    else
        pool->free = block->next_free;
    if (block->next_free)
        block->next_free->last_free = block->last_free;
}

/* The block after one, in its region; NULL: it is the last. */
static struct rf_block *after(const struct rf_block *block)
{
    char *end = (char *)block + block->n_bytes;
    return end < block->region + block->region_bytes ? (struct rf_block *)end : NULL;
}

/* Cuts a block in two, the first of n_bytes; returns the second. */
static struct rf_block *cut(struct rf_block *block, size_t n_bytes)
{
    struct rf_block *rest = (struct rf_block *)((char *)block + n_bytes);
    *rest = (struct rf_block){.n_bytes = block->n_bytes - n_bytes,
                              .region = block->region,
                              .region_bytes = block->region_bytes,
                              .before = block};
    block->n_bytes = n_bytes;
    struct rf_block *next = after(rest);
    if (next)
        next->before = rest;
    return rest;
}

/* Joins a block with the one after it. */
static void join(struct rf_block *block, const struct rf_block *next)
{
    block->n_bytes += next->n_bytes;
    struct rf_block *following = after(block);
    if (following)
        following->before = block;
}

/* The smallest free block that holds n_bytes, cut to size; NULL: there is none. */
static struct rf_block *take(struct rf_pool *pool, size_t n_bytes)
{
    struct rf_block *best = NULL;
    for (struct rf_block *b = pool->free; b; b = b->next_free)
        if (b->n_bytes >= n_bytes && (!best || b->n_bytes < best->n_bytes) &&
            (n_bytes >= LEAST_CUT || b->n_bytes / 2 <= n_bytes))
            best = b;
    if (!best)
        return NULL;
    unlist(pool, best);
    if (n_bytes >= LEAST_CUT && best->n_bytes - n_bytes >= LEAST_KEPT)
        list(pool, cut(best, n_bytes));
    return best;
}

/* Takes whole regions out until no more than `most` bytes are held; their list. */
static struct rf_block *shrink(struct rf_pool *pool, size_t most)
{
    struct rf_block *out = NULL;
    for (struct rf_block *next, *b = pool->free; b; b = next) {
        next = b->next_free;
        if (b->n_bytes < b->region_bytes || pool->total_bytes <= most)
            continue;
        unlist(pool, b);
        pool->total_bytes -= b->n_bytes;
        b->next_free = out;
        out = b;
    }
    return out;
}

/* How much may be held before n_bytes more are asked of the system. */
static size_t most_before(const struct rf_pool *pool, size_t n_bytes, size_t max_bytes)
{
    size_t used = pool->used_bytes + n_bytes;
    size_t most = used > pool->peak_bytes ? used : pool->peak_bytes;
    most += most / 2;
    if (max_bytes && most > max_bytes)
        most = max_bytes;
    return most > n_bytes ? most - n_bytes : 0;
}

static void release_all(const struct rf_context *context, struct rf_block *regions)
{
    for (struct rf_block *next; regions; regions = next) {
        next = regions->next_free;
        context->params.release(context->params.user, regions);
    }
}

static void use(struct rf_pool *pool, size_t n_bytes)
{
    pool->used_bytes += n_bytes;
    if (pool->used_bytes > pool->peak_bytes)
        pool->peak_bytes = pool->used_bytes;
}

/* Memory of the system. What is kept and not in use makes room where there is none. */
static struct rf_block *ask(const struct rf_context *context, size_t n_bytes)
{
    const struct rf_context_params *params = &context->params;
    struct rf_block *block = params->allocate(params->user, n_bytes);
    if (block)
        return block;
    lock(context->pool);
    struct rf_block *kept = shrink(context->pool, 0);
    unlock(context->pool);
    if (!kept)
        return NULL;
    release_all(context, kept);
    return params->allocate(params->user, n_bytes);
}

/* A block that is a region of its own. */
static struct rf_block *allocate_region(const struct rf_context *context,
                                        size_t n_bytes)
{
    struct rf_pool *pool = context->pool;
    struct rf_block *block = ask(context, n_bytes);
    if (block) {
        *block = (struct rf_block){
            .n_bytes = n_bytes, .region = (char *)block, .region_bytes = n_bytes};
        return block;
    }
    lock(pool);
    pool->used_bytes -= n_bytes;
    pool->total_bytes -= n_bytes;
    unlock(pool);
    return NULL;
}

static struct rf_block *pool_allocate(const struct rf_context *context, size_t n_bytes)
{
    struct rf_pool *pool = context->pool;
    size_t max_bytes = context->params.max_bytes;
    lock(pool);
    struct rf_block *block = take(pool, n_bytes), *excess = NULL;
    bool has_room = true;
    if (!block) {
        excess = shrink(pool, most_before(pool, n_bytes, max_bytes));
        has_room = !max_bytes || pool->total_bytes + n_bytes <= max_bytes;
        pool->total_bytes += has_room ? n_bytes : 0;
    }
    if (has_room)
        use(pool, block ? block->n_bytes : n_bytes);
    unlock(pool);
    release_all(context, excess);
    return block || !has_room ? block : allocate_region(context, n_bytes);
}

static void pool_release(struct rf_pool *pool, struct rf_block *block)
{
    lock(pool);
    pool->used_bytes -= block->n_bytes;
    struct rf_block *next = after(block), *before = block->before;
    if (next && next->is_free) {
        unlist(pool, next);
        join(block, next);
    }
    if (before && before->is_free) {
        unlist(pool, before);
        join(before, block);
        block = before;
    }
    list(pool, block);
    unlock(pool);
}

void rf_pool_clear(const struct rf_context *context)
{
    release_all(context, context->pool->free);
    context->pool->free = NULL;
}

void *rf_alloc(const struct rf_context *context, size_t count, size_t size)
{
    size_t n_bytes;
    if (__builtin_mul_overflow(count, size, &n_bytes) ||
        n_bytes > SIZE_MAX - 2 * RF_ALIGNMENT)
        return NULL;
    n_bytes = (n_bytes + 2 * RF_ALIGNMENT - 1) / RF_ALIGNMENT * RF_ALIGNMENT;
    struct rf_block *block;
    if (n_bytes >= LEAST_KEPT) {
        block = pool_allocate(context, n_bytes);
    } else {
        block = ask(context, n_bytes);
        if (block)
            block->n_bytes = n_bytes;
    }
#ifdef RF_POISON /* for tests: what is read before it is written shows */
    if (block)
        memset((char *)block + RF_ALIGNMENT, 0x7f, n_bytes - RF_ALIGNMENT);
#endif
    return block ? (char *)block + RF_ALIGNMENT : NULL;
}

void rf_free(const struct rf_context *context, void *memory)
{
    if (!memory)
        return;
    struct rf_block *block = (struct rf_block *)((char *)memory - RF_ALIGNMENT);
    if (block->n_bytes >= LEAST_KEPT)
        pool_release(context->pool, block);
    else
        context->params.release(context->params.user, block);
}

void *rf_calloc(const struct rf_context *context, size_t count, size_t size)
{
    void *memory = rf_alloc(context, count, size);
    if (memory)
        memset(memory, 0, count * size);
    return memory;
}
