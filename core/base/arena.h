/* SPDX-License-Identifier: Apache-2.0 */
/* Memory that the threads of one step take parts of, given back all together. */
#ifndef RF_BASE_ARENA_H
#define RF_BASE_ARENA_H

#include <stddef.h>

#include "base/context.h"

struct rf_chunk;

struct rf_arena {
    const struct rf_context *context;
    size_t chunk_bytes;
    struct rf_chunk *chunks;
};

/* What a thread has left of its chunk; {NULL, NULL} at first. */
struct rf_room {
    char *at, *end;
};

/*
 * An arena for a picture. All arenas of a picture have chunks of one size, so that one
 * takes the memory that another has given back.
 */
struct rf_arena rf_arena_make(const struct rf_context *context, int width, int height);

/* n_bytes, 16-byte aligned, not cleared; NULL: out of memory. */
void *rf_arena_take(struct rf_arena *arena, struct rf_room *room, size_t n_bytes);

/* Gives back what was taken last of the room, from `end` on. */
void rf_arena_give_back(struct rf_room *room, const void *end);

void rf_arena_free(struct rf_arena *arena);

#endif
