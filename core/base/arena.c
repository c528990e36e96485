/* SPDX-License-Identifier: Apache-2.0 */
#include "base/arena.h"

#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "base/pool.h"

enum {
    LEAST_CHUNK = 256 << 10, /* bytes */
    HEAD = 64,
    ALIGNMENT = 16,
    ROUND_W = 64, /* sizes are rounded up to: so that few of them differ, px */
    ROUND_H = 32
};

struct rf_chunk {
    struct rf_chunk *next;
};

struct rf_arena rf_arena_make(const struct rf_context *context, int width, int height)
{
    size_t columns = ((size_t)width + ROUND_W - 1) / ROUND_W * ROUND_W;
    size_t rows = ((size_t)height + ROUND_H - 1) / ROUND_H * ROUND_H;
    size_t bytes = columns * rows; /* one per pixel */
    return (struct rf_arena){.context = context,
                             .chunk_bytes = bytes > LEAST_CHUNK ? bytes : LEAST_CHUNK};
}

static bool begin_chunk(struct rf_arena *arena, struct rf_room *room, size_t n_bytes)
{
    size_t size = n_bytes + HEAD;
    size = size > arena->chunk_bytes ? size : arena->chunk_bytes;
    struct rf_chunk *chunk = rf_alloc(arena->context, size, 1);
    if (!chunk)
        return false;
    chunk->next = __atomic_load_n(&arena->chunks, __ATOMIC_RELAXED);
    while (!__atomic_compare_exchange_n(&arena->chunks, &chunk->next, chunk, false,
                                        __ATOMIC_RELEASE, __ATOMIC_RELAXED))
        ;
    *room = (struct rf_room){(char *)chunk + HEAD, (char *)chunk + size};
    return true;
}

void *rf_arena_take(struct rf_arena *arena, struct rf_room *room, size_t n_bytes)
{
    n_bytes = (n_bytes + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    if ((!room->at || n_bytes > (size_t)(room->end - room->at)) &&
        !begin_chunk(arena, room, n_bytes))
        return NULL;
    void *memory = room->at;
    room->at += n_bytes;
    return memory;
}

void rf_arena_give_back(struct rf_room *room, const void *end)
{
    size_t n_bytes = (size_t)(room->at - (const char *)end);
    room->at -= n_bytes / ALIGNMENT * ALIGNMENT;
}

void rf_arena_free(struct rf_arena *arena)
{
    for (struct rf_chunk *next, *chunk = arena->chunks; chunk; chunk = next) {
        next = chunk->next;
        rf_free(arena->context, chunk);
    }
    arena->chunks = NULL;
}
