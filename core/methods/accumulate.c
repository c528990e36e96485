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

#include "base/task.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_accumulate_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    rf_result result = rf_work_unpack(work, error);
    if (result != RF_OK)
        return result;
    rf_task_phase(work->task, 1, f->height);
#pragma omp parallel for num_threads(f->context->n_threads) schedule(static)
    for (int y = 0; y < f->height; y++) {
        if (rf_task_is_cancelled(work->task))
            continue;
        for (int c = 0; c < work->n_planes; c++)
            for (int x = 0; x < f->width; x++) {
                size_t at = (size_t)y * (size_t)f->width + (size_t)x;
                double sum = 0;
                for (int j = 0; j < work->n_views; j++)
                    sum += (double)work->views[j].colour[c][at];
                work->colour[c][at] = (float)(sum / work->n_views);
            }
        rf_task_step(work->task);
    }
    return RF_OK;
}
