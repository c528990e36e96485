/* SPDX-License-Identifier: Apache-2.0 */
/* Loops on threads of the process, for all that is not the core's. */
#ifndef OS_PARALLEL_H
#define OS_PARALLEL_H

#include <stdint.h>

/*
 * Runs steps begin to end - 1 of a loop. `thread` is below the loop's n_threads, and no
 * two threads that are in the loop at once have the same.
 */
typedef void (*os_body_fn)(void *data, int64_t begin, int64_t end, int thread);

/*
 * Runs all steps from 0 to count - 1 in parts of `grain` steps, and returns when all is
 * done; grain 0: in equal parts. At most n_threads threads take part, 0: as many as
 * there are, this one among them; where the system gives none, it does all. From any
 * thread, from bodies too; a forked child has threads of its own.
 */
void os_parallel(int n_threads, int64_t count, int64_t grain, os_body_fn body,
                 void *data);

/* Processors that the process may run on, at least 1. */
int os_processors(void);

/* How many threads there are, at least 1; instead of one for each processor. Counts if
 * it is said before the first loop. */
void os_parallel_most(int n_threads);

#endif
