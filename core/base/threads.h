/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pool of threads, and loops that run on it. It knows nothing of rackfocus and is a
 * library of its own (rackfocus_threads): a context of the core has a pool, and the
 * command's own loops have one through os/parallel.h.
 */
#ifndef RF_BASE_THREADS_H
#define RF_BASE_THREADS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RF_MAX_THREADS = 1024 };

/*
 * Runs steps begin to end - 1 of a loop. `thread` is below the loop's number of threads,
 * and no two threads that are in the loop at once have the same: scratch memory may be
 * chosen by it. Which thread runs which steps, and in which order, is not said.
 */
typedef void (*rf_body_fn)(void *data, int64_t begin, int64_t end, int thread);

/* A loop, whose parts go to whoever comes for the next. */
struct rf_loop {
    int64_t count, grain; /* steps, and those of a part */
    rf_body_fn body;
    void *data;
    int64_t next; /* atomic: the first step that nobody has taken */
};

/*
 * A loop of `count` steps (may be 0) in parts of `grain`; 0: in equal parts, four for
 * each of n_threads threads, so that one that comes late finds less to do.
 */
struct rf_loop rf_loop_make(int64_t count, int64_t grain, int n_threads,
                            rf_body_fn body, void *data);

/* Parts of a loop, which is how many threads it can use. */
int64_t rf_loop_parts(const struct rf_loop *loop);

/* Takes parts and runs them until none is left. */
void rf_loop_run(struct rf_loop *loop, int thread);

/*
 * A pool for n_threads threads, the caller's among them, 1 to RF_MAX_THREADS, in memory
 * of rf_threads_bytes(n_threads) bytes, aligned as pointers are. No thread is started.
 */
struct rf_threads;
size_t rf_threads_bytes(int n_threads);
struct rf_threads *rf_threads_init(void *memory, int n_threads);

/* Ends its threads; no loop runs on it. In a forked child it has none. */
void rf_threads_end(struct rf_threads *threads);

/*
 * Starts the threads, if this process has none: a forked child makes its own. True if
 * they were started by this call. Where the system gives fewer, loops run on fewer.
 */
bool rf_threads_start(struct rf_threads *threads);

/* Threads that loops run on, the caller's among them; before rf_threads_start() those
 * that are wanted. */
int rf_threads_count(const struct rf_threads *threads);

/*
 * Runs a loop on at most n_threads threads, and returns when all of it is done. The
 * caller, thread 0 of it, takes part; others join as they are free. Any number of
 * threads may call this at once, bodies too.
 */
void rf_threads_run(struct rf_threads *threads, int n_threads, struct rf_loop *loop);

#endif
