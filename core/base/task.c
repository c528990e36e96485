/* SPDX-License-Identifier: Apache-2.0 */
/* Progress of one method over its phases, and cancelling. */
#include "base/task.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/system_threads.h"
#include "rackfocus/rackfocus.h"

static const double LEAST_STEP = 1.0 / 4096; /* callers may redraw at each report */

static bool is_caller(const struct rf_task *task)
{
    return rf_thread_self() == task->caller;
}

static void ask(struct rf_task *task)
{
    if (task->progress && task->progress->report &&
        !task->progress->report(task->progress->user, task->last))
        __atomic_store_n(&task->cancelled, 1, __ATOMIC_RELAXED);
}

static void report(struct rf_task *task, double fraction)
{
    if (task->last >= 0 && fraction < task->last + LEAST_STEP && fraction < 1)
        return;
    task->last = fraction;
    ask(task);
}

void rf_task_begin(struct rf_task *task, const struct rf_progress *progress)
{
    *task =
        (struct rf_task){.progress = progress, .last = -1, .caller = rf_thread_self()};
    report(task, 0);
}

void rf_task_end(struct rf_task *task)
{
    report(task, 1);
}

void rf_task_phase(struct rf_task *task, double to, int64_t n_steps)
{
    task->from = task->to;
    task->to = to;
    task->n_steps = n_steps;
    task->n_done = 0;
}

bool rf_task_poll(struct rf_task *task)
{
    if (is_caller(task) && !rf_task_is_cancelled(task))
        ask(task);
    return !rf_task_is_cancelled(task);
}

bool rf_task_is_cancelled(const struct rf_task *task)
{
    return __atomic_load_n(&task->cancelled, __ATOMIC_RELAXED) != 0;
}

bool rf_task_step(struct rf_task *task)
{
    int64_t done = __atomic_add_fetch(&task->n_done, 1, __ATOMIC_RELAXED);
    if (is_caller(task) && !rf_task_is_cancelled(task))
        report(task, fmin(task->from + (task->to - task->from) * (double)done /
                                           (double)task->n_steps,
                          0.999));
    return !rf_task_is_cancelled(task);
}

/* The `report` of the tasks of a frame. */
static bool report_task(void *user, double fraction)
{
    struct rf_frame_progress *frame = user;
    if (fraction < 1 && !frame->is_cancelled)
        frame->is_cancelled = !frame->caller->report(frame->caller->user, fraction);
    return !frame->is_cancelled;
}

bool rf_frame_progress_begin(struct rf_frame_progress *frame,
                             const struct rf_progress *caller)
{
    *frame =
        (struct rf_frame_progress){.caller = caller && caller->report ? caller : NULL};
    return !frame->caller || report_task(frame, 0);
}

const struct rf_progress *rf_frame_progress_tasks(struct rf_frame_progress *frame)
{
    frame->tasks = (struct rf_progress){report_task, frame};
    return frame->caller ? &frame->tasks : NULL;
}

void rf_frame_progress_end(struct rf_frame_progress *frame)
{
    if (frame->caller)
        frame->caller->report(frame->caller->user, 1);
}

bool rf_progress_report_part(void *user, double fraction)
{
    const struct rf_progress_part *part = user;
    return part->whole->report(part->whole->user, (part->i + fraction) / part->n);
}
