/* SPDX-License-Identifier: Apache-2.0 */
/* Loops on the threads of a context: the one way of the core to use more than one. */
#ifndef RF_BASE_PARALLEL_H
#define RF_BASE_PARALLEL_H

#include <stdint.h>

#include "base/context.h"
#include "base/threads.h"

/* For `grain`: parts of the same size, of steps that take equally long. */
enum { RF_EQUAL_PARTS = 0 };

/*
 * Runs body(data, begin, end, thread) for all steps from 0 to count - 1, in parts of
 * `grain` steps, on the context's threads or its host's, and returns when all is done.
 * `thread` is in 0 .. context->n_threads - 1; see rf_body_fn. What a body writes must
 * not depend on which thread runs it, and sums of floats not on the order of parts.
 */
void rf_parallel(const struct rf_context *context, int64_t count, int64_t grain,
                 rf_body_fn body, void *data);

#endif
