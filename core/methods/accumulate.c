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

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "lens/params.h"
#include "rackfocus/rackfocus.h"

struct rf_accumulator {
    const struct rf_context *context;
    struct rf_params params;
    int width, height, channels;
    int64_t count;
    float *view; /* one picture in the blend space, planes */
    double *sum; /* as view */
};

static size_t plane_size(const struct rf_accumulator *a)
{
    return (size_t)a->width * (size_t)a->height;
}

static void list_planes(const struct rf_accumulator *a, float *planes[4])
{
    for (int c = 0; c < a->channels; c++)
        planes[c] = a->view + plane_size(a) * (size_t)c;
}

static rf_result check_size(int32_t width, int32_t height, int32_t channels,
                            struct rf_error *error)
{
    if (width < 1 || height < 1 || width > UINT16_MAX || height > UINT16_MAX)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       width < 1 || width > UINT16_MAX ? "width" : "height",
                       "%d x %d px: each side must lie in 1 to 65535", width, height);
    if (channels != 1 && channels != 3 && channels != 4)
        return rf_fail(error, RF_ERROR_ARGUMENT, "channels",
                       "%d channels were given; pictures have 1, 3 or 4", channels);
    return RF_OK;
}

rf_result rf_accumulator_create(struct rf_accumulator **accumulator,
                                const struct rf_context *context,
                                const struct rf_params *params, int32_t width,
                                int32_t height, int32_t channels,
                                struct rf_error *error)
{
    if (!accumulator || !context)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       accumulator ? "context" : "accumulator", "a pointer is NULL");
    rf_result result = rf_params_check(params, error);
    if (result == RF_OK)
        result = check_size(width, height, channels, error);
    if (result != RF_OK)
        return result;
    struct rf_accumulator *a = rf_calloc(context, 1, sizeof *a);
    if (!a)
        return rf_fail_memory(error, 1, sizeof *a);
    a->context = context;
    a->width = width;
    a->height = height;
    a->channels = channels;
    rf_params_complete(&a->params, params);
    size_t n = plane_size(a) * (size_t)channels;
    a->view = rf_alloc(context, n, sizeof *a->view);
    a->sum = rf_calloc(context, n, sizeof *a->sum);
    if (!a->view || !a->sum) {
        rf_accumulator_destroy(a);
        return rf_fail_memory(error, n, sizeof *a->view + sizeof *a->sum);
    }
    *accumulator = a;
    return RF_OK;
}

void rf_accumulator_destroy(struct rf_accumulator *accumulator)
{
    if (!accumulator)
        return;
    rf_free(accumulator->context, accumulator->sum);
    rf_free(accumulator->context, accumulator->view);
    rf_free(accumulator->context, accumulator);
}

static rf_result check_image(const struct rf_accumulator *a,
                             const struct rf_image *image, const char *name,
                             struct rf_error *error)
{
    if (!a)
        return rf_fail(error, RF_ERROR_ARGUMENT, "accumulator", "a pointer is NULL");
    rf_result result = rf_image_check(image, name, a->width, a->height, error);
    if (result == RF_OK && image->channels != a->channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, name,
                         "%s has %d channels, but the pictures that are added up have "
                         "%d",
                         name, image->channels, a->channels);
    return result;
}

rf_result rf_accumulator_add(struct rf_accumulator *accumulator,
                             const struct rf_image *colour, struct rf_error *error)
{
    float *planes[4];
    rf_result result = check_image(accumulator, colour, "colour", error);
    if (result != RF_OK)
        return result;
    struct rf_accumulator *a = accumulator;
    list_planes(a, planes);
    result = rf_frame_load(a->context, &a->params, colour, NULL, planes, error);
    if (result != RF_OK)
        return result;
    int64_t n = (int64_t)plane_size(a) * a->channels;
#pragma omp parallel for num_threads(a->context->n_threads) schedule(static)
    for (int64_t i = 0; i < n; i++)
        a->sum[i] += (double)a->view[i];
    a->count++;
    return RF_OK;
}

int64_t rf_accumulator_count(const struct rf_accumulator *accumulator)
{
    return accumulator->count;
}

rf_result rf_accumulator_mean(const struct rf_accumulator *accumulator,
                              const struct rf_image *out, struct rf_error *error)
{
    float *planes[4];
    rf_result result = check_image(accumulator, out, "out", error);
    if (result != RF_OK)
        return result;
    const struct rf_accumulator *a = accumulator;
    if (a->count == 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "accumulator",
                       "nothing was added, so there is no mean");
    int64_t n = (int64_t)plane_size(a) * a->channels;
#pragma omp parallel for num_threads(a->context->n_threads) schedule(static)
    for (int64_t i = 0; i < n; i++)
        a->view[i] = (float)(a->sum[i] / (double)a->count);
    list_planes(a, planes);
    rf_frame_store(a->context, &a->params, planes, (size_t)out->width, out);
    return RF_OK;
}

/* ---- as a method of the filter ------------------------------------------------- */

rf_result rf_accumulate_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    (void)error;
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
