/* SPDX-License-Identifier: Apache-2.0 */
/* Loops on the threads of a context. */
#include "base/parallel.h"

#include <stdint.h>

#include "base/context.h"
#include "base/log.h"
#include "base/threads.h"
#include "rackfocus/rackfocus.h"

static void run_task(void *loop, int32_t index)
{
    rf_loop_run(loop, index);
}

static void run_on_host(const struct rf_context *context, struct rf_loop *loop)
{
    int64_t n_parts = rf_loop_parts(loop);
    int n_tasks = n_parts < context->n_threads ? (int)n_parts : context->n_threads;
    if (n_tasks > 1)
        context->params.parallel_for(context->params.user, n_tasks, run_task, loop);
    rf_loop_run(loop, 0); /* what the host has left out */
}

void rf_parallel(const struct rf_context *context, int64_t count, int64_t grain,
                 rf_body_fn body, void *data)
{
    struct rf_loop loop = rf_loop_make(count, grain, context->n_threads, body, data);
    if (context->params.parallel_for) {
        run_on_host(context, &loop);
        return;
    }
    const int n_asked = context->params.n_threads;
    if (context->n_threads > 1 && rf_threads_start(context->threads) &&
        rf_threads_count(context->threads) < n_asked)
        rf_log(context, RF_LOG_WARNING, "only %d of %d threads can be made here",
               rf_threads_count(context->threads), n_asked);
    rf_threads_run(context->threads, context->n_threads, &loop);
}
