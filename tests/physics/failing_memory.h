/* SPDX-License-Identifier: Apache-2.0 */
/* Memory for a context that ends at its k-th request, and counts what is not freed. */
#ifndef FAILING_MEMORY_H
#define FAILING_MEMORY_H

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "portable.h"
#include "rackfocus/rackfocus.h"

struct memory {
    pthread_mutex_t lock;
    int n_requests, fails_from; /* the k-th and all after it; 0: none */
    int n_live;
};

static inline void *memory_allocate(void *user, size_t n_bytes)
{
    struct memory *m = user;
    pthread_mutex_lock(&m->lock);
    bool fails = ++m->n_requests >= m->fails_from && m->fails_from;
    void *memory = fails ? NULL : aligned_alloc(64, (n_bytes + 63) / 64 * 64);
    m->n_live += memory != NULL;
    pthread_mutex_unlock(&m->lock);
    if (memory)
        memset(memory, 0x7f, n_bytes); /* what is not initialised shows */
    return memory;
}

static inline void memory_release(void *user, void *memory)
{
    struct memory *m = user;
    pthread_mutex_lock(&m->lock);
    m->n_live -= memory != NULL;
    pthread_mutex_unlock(&m->lock);
    aligned_release(memory);
}

/* How a context is to be made that takes its memory from `memory`; two threads. */
static inline struct rf_context_params memory_context(struct memory *memory)
{
    return (struct rf_context_params){.size = sizeof(struct rf_context_params),
                                      .n_threads = 2,
                                      .allocate = memory_allocate,
                                      .release = memory_release,
                                      .user = memory};
}

#endif
