/* SPDX-License-Identifier: Apache-2.0 */
/* Progress and cancelling. */
#ifndef RF_BASE_TASK_H
#define RF_BASE_TASK_H

#include <stdbool.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/*
 * Progress over the phases of one method: fractions [from, to] of the whole. Worker
 * threads count finished tiles with rf_task_step(); the caller's thread reports.
 */
struct rf_task {
    const struct rf_progress *progress;
    double from, to; /* of the current phase */
    double last;     /* last fraction reported */
    int64_t n_steps; /* of the current phase */
    int64_t n_done;  /* atomic */
    int cancelled;   /* atomic */
    uint64_t caller; /* the thread that reports */
};

void rf_task_begin(struct rf_task *task, const struct rf_progress *progress);

/* Reports 1. */
void rf_task_end(struct rf_task *task);

void rf_task_phase(struct rf_task *task, double to, int64_t n_steps);

/* Counts one tile; true while work goes on. Any thread. */
bool rf_task_step(struct rf_task *task);

/* Reports the last fraction again, if the caller's thread calls it; true while work
 * goes on. Any thread. */
bool rf_task_poll(struct rf_task *task);

bool rf_task_is_cancelled(const struct rf_task *task);

/*
 * The progress of a frame that several tasks make, some of which may have nothing to do:
 * begins with 0, and ends with 1 when all is done, not when the last task is. What was
 * cancelled once stays cancelled.
 */
struct rf_frame_progress {
    const struct rf_progress *caller; /* NULL: nobody asks */
    struct rf_progress tasks;         /* for the tasks, where somebody does */
    bool is_cancelled;
};

/* Reports 0; false: cancelled. */
bool rf_frame_progress_begin(struct rf_frame_progress *frame,
                             const struct rf_progress *caller);

/* What tasks are given; NULL: nobody asks. */
const struct rf_progress *rf_frame_progress_tasks(struct rf_frame_progress *frame);

/* Reports 1. */
void rf_frame_progress_end(struct rf_frame_progress *frame);

/* The progress of picture `i` of the n that make a whole. */
struct rf_progress_part {
    const struct rf_progress *whole;
    int i, n;
};

/* The `report` of a struct rf_progress whose user is a struct rf_progress_part. */
bool rf_progress_report_part(void *user, double fraction);

#endif
