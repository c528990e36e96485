/* SPDX-License-Identifier: Apache-2.0 */
/* The context's memory. */
#ifndef RF_BASE_POOL_H
#define RF_BASE_POOL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"

struct rf_block;

/* Memory that the context's pictures share, one after the other (pool.c). */
struct rf_pool {
    bool lock;
    struct rf_block *free;
    size_t total_bytes, used_bytes, peak_bytes; /* of blocks that may be kept */
};

/* Gives back what the pool keeps; nothing of it is in use. */
void rf_pool_clear(const struct rf_context *context);

/* 64-byte aligned memory, not cleared; NULL where there is none. Size 0 gives memory.
 */
void *rf_alloc(const struct rf_context *context, size_t count, size_t size);

void *rf_calloc(const struct rf_context *context, size_t count, size_t size);

void rf_free(const struct rf_context *context, void *memory);

#endif
