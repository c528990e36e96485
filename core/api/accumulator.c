/* SPDX-License-Identifier: Apache-2.0 */
/* The mean of pictures, one in memory at a time. */
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "lens/params.h"
#include "rackfocus/rackfocus.h"

struct rf_accumulator {
    struct rf_frame frame; /* context, parameters, size */
    int channels;
    int64_t count;
    float *view; /* one picture in the blend space, planes */
    double *sum; /* as view */
};

static size_t plane_size(const struct rf_accumulator *a)
{
    return (size_t)a->frame.width * (size_t)a->frame.height;
}

static void list_planes(const struct rf_accumulator *a, float *planes[4])
{
    for (int c = 0; c < a->channels; c++)
        planes[c] = a->view + plane_size(a) * (size_t)c;
}

static rf_result check_size(int32_t width, int32_t height, int32_t channels,
                            struct rf_error *error)
{
    const rf_result result = rf_lens_check_size(width, height, error);
    if (result == RF_OK && channels != 1 && channels != 3 && channels != 4)
        return rf_fail(error, RF_ERROR_ARGUMENT, "channels",
                       "%d channels were given; pictures have 1, 3 or 4", channels);
    return result;
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
    a->frame.context = context;
    a->frame.width = width;
    a->frame.height = height;
    a->channels = channels;
    rf_params_complete(&a->frame.params, params);
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
    const struct rf_context *context = accumulator->frame.context;
    rf_free(context, accumulator->sum);
    rf_free(context, accumulator->view);
    rf_free(context, accumulator);
}

static rf_result check_image(const struct rf_accumulator *a,
                             const struct rf_image *image, const char *name,
                             struct rf_error *error)
{
    if (!a)
        return rf_fail(error, RF_ERROR_ARGUMENT, "accumulator", "a pointer is NULL");
    rf_result result =
        rf_image_check(image, name, a->frame.width, a->frame.height, error);
    if (result == RF_OK && image->channels != a->channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, name,
                         "%s has %d channels, but the pictures that are added up have "
                         "%d",
                         name, image->channels, a->channels);
    return result;
}

static void add_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct rf_accumulator *a = data;
    for (int64_t i = begin; i < end; i++)
        a->sum[i] += (double)a->view[i];
}

static void divide_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct rf_accumulator *a = data;
    for (int64_t i = begin; i < end; i++)
        a->view[i] = (float)(a->sum[i] / (double)a->count);
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
    result = rf_frame_load(&a->frame, colour, planes, error);
    if (result != RF_OK)
        return result;
    int64_t n = (int64_t)plane_size(a) * a->channels;
    rf_parallel(a->frame.context, n, RF_EQUAL_PARTS, add_some, a);
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
    const struct rf_accumulator *a = accumulator;
    if (result == RF_OK)
        result =
            rf_image_check_out(out, "out", a->frame.width, a->frame.height, 0, error);
    if (result != RF_OK)
        return result;
    if (a->count == 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "accumulator",
                       "nothing was added, so there is no mean");
    int64_t n = (int64_t)plane_size(a) * a->channels;
    struct rf_accumulator shared = *a; /* the threads only read it */
    rf_parallel(a->frame.context, n, RF_EQUAL_PARTS, divide_some, &shared);
    list_planes(a, planes);
    rf_frame_store(a->frame.context, &a->frame.params, planes, (size_t)out->width, out);
    return RF_OK;
}
