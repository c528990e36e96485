/* SPDX-License-Identifier: Apache-2.0 */
/*
 * accumulate: the mean of several views.
 *
 *   out = (1/N sum over i of V_i^(1/g))^g
 *
 *   V_i   view from point i of the lens, the plane in focus held fixed by the camera
 *   N     number of views
 *   g     blend gamma: 1 sums linear light
 *
 * Source: OpenGL programming guide, "depth of field": the accumulation buffer, each
 * view weighted 1/N. Physically exact as N grows, mirrors and glass included; the views
 * know all that the filter must guess.
 *
 * Known artefact: N separate copies of what is far out of focus. An 8 bit accumulation
 * buffer loses levels at 1/N; sums here are double.
 *
 * Cost: N renders; of the sum itself, N reads and writes of 8 bytes per sample. Memory
 * of the accumulator: 12 bytes per sample, whatever N is.
 */
#include "methods/accumulate.h"

#include <stddef.h>
#include <stdint.h>

#include "base/parallel.h"
#include "base/task.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

static void average_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct rf_work *work = data;
    int width = work->frame->width;
    for (int64_t y = begin; y < end && !rf_task_is_cancelled(work->task); y++) {
        for (int c = 0; c < work->n_planes; c++)
            for (int x = 0; x < width; x++) {
                size_t at = (size_t)y * (size_t)width + (size_t)x;
                double sum = 0;
                for (int j = 0; j < work->n_views; j++)
                    sum += (double)work->views[j].colour[c][at];
                work->colour[c][at] = (float)(sum / work->n_views);
            }
        rf_task_step(work->task);
    }
}

rf_result rf_accumulate_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    rf_result result = rf_work_unpack(work, error);
    if (result != RF_OK)
        return result;
    rf_task_phase(work->task, 1, f->height);
    rf_parallel(f->context, f->height, RF_EQUAL_PARTS, average_rows, work);
    return RF_OK;
}
