/* SPDX-License-Identifier: Apache-2.0 */
/* The filter object: checks, and the way from views to pixels. */
#include <omp.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/depth.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "lens/aperture.h"
#include "lens/params.h"
#include "methods/layered/layered_preview.h"
#include "methods/methods.h"
#include "methods/scatter/distribution.h"
#include "rackfocus/rackfocus.h"

enum { NORMAL_CELLS = 3 }; /* quality normal: 0.07 dB below 4 at the most */

/* ---- filter -------------------------------------------------------------------- */

rf_result rf_filter_create(struct rf_filter **filter, const struct rf_context *context,
                           const struct rf_params *params, int32_t width,
                           int32_t height, struct rf_error *error)
{
    if (!filter || !context || !params)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter    ? "filter"
                       : !context ? "context"
                                  : "params",
                       "a pointer is NULL");
    if (width < 1 || height < 1 || width > UINT16_MAX || height > UINT16_MAX)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       width < 1 || width > UINT16_MAX ? "width" : "height",
                       "%d x %d px: each side must lie in 1 to 65535", width, height);
    struct rf_lens lens;
    rf_result result = rf_lens_init(&lens, params, width, height, error);
    if (result != RF_OK)
        return result;
    struct rf_filter *f = rf_alloc(context, 1, sizeof *f);
    if (!f)
        return rf_fail_memory(error, 1, sizeof *f);
    *f = (struct rf_filter){
        .context = context,
        .lens = lens,
        .width = width,
        .height = height,
        .place = {0, 0, width, height},
    };
    rf_params_complete(&f->params, params);
    if (f->params.quality == RF_QUALITY_NORMAL)
        f->params.sub_apertures = rf_min_int(f->params.sub_apertures, NORMAL_CELLS);
    rf_shape_init(&f->shape, &f->params);
    *filter = f;
    return RF_OK;
}

void rf_filter_destroy(struct rf_filter *filter)
{
    if (!filter)
        return;
    rf_bokeh_free(filter);
    rf_free(filter->context, filter);
}

const struct rf_lens *rf_filter_lens(const struct rf_filter *filter)
{
    return &filter->lens;
}

/* Do two pictures share memory, other than pixel by pixel? */
static bool is_tangled(const struct rf_image *a, const struct rf_image *b)
{
    if (a->data == b->data && a->row_bytes == b->row_bytes)
        return false;
    const char *ends[2][2];
    const struct rf_image *both[] = {a, b};
    for (int i = 0; i < 2; i++) {
        const char *first = (const char *)rf_image_at(both[i], 0, 0, 0);
        const char *last =
            (const char *)rf_image_at(both[i], 0, both[i]->height - 1, 0);
        ends[i][0] = first < last ? first : last;
        ends[i][1] =
            (first < last ? last : first) + (size_t)both[i]->width * 4 * sizeof(float);
    }
    return ends[0][0] < ends[1][1] && ends[1][0] < ends[0][1];
}

/* May the preview read and write the caller's pixels by itself? */
static bool can_stream(const struct rf_work *work, const struct rf_view *view,
                       const struct rf_image *out)
{
    const struct rf_params *p = &work->filter->params;
    return p->method == RF_METHOD_LAYERED && p->quality == RF_QUALITY_PREVIEW &&
           work->n_views == 1 && rf_image_is_plain(p, &view->colour) &&
           rf_image_is_plain(p, out) && !is_tangled(&view->colour, out);
}

/* `memory` holds the radii of a view, which it fills. */
static rf_result stream(struct rf_work *work, const struct rf_view *view, float *memory,
                        const struct rf_image *out, bool *is_done,
                        struct rf_error *error)
{
    rf_result result = rf_depth_to_radius(work->filter, &view->depth, memory, NULL,
                                          NULL, &work->largest_radius, error);
    if (result != RF_OK)
        return result;
    work->radius = work->views->radius = memory;
    if (work->largest_radius < RF_SHARP_PX)
        *is_done = rf_frame_copy(work->filter->context, &view->colour, out);
    else
        result = rf_layered_preview_stream(work, &view->colour, out, is_done, error);
    return result;
}

/* May the method layered or views read the caller's pixels by itself? */
static bool can_read(const struct rf_work *work, const struct rf_view *views)
{
    const struct rf_params *p = &work->filter->params;
    bool is_layered = p->method == RF_METHOD_LAYERED && work->n_views == 1;
    bool is_able = is_layered || p->method == RF_METHOD_VIEWS;
    for (int j = 0; j < work->n_views && is_able; j++)
        is_able = rf_image_is_plain(p, &views[j].colour);
    return is_able && p->quality != RF_QUALITY_PREVIEW;
}

/* Radii and places of the views; work->memory is to hold the radii. */
static rf_result read_depths(struct rf_work *work, const struct rf_view *views,
                             struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    size_t n = (size_t)f->width * (size_t)f->height;
    for (int j = 0; j < work->n_views; j++) {
        struct rf_work_view *w = &work->views[j];
        const struct rf_view *view = &views[j];
        float *radius = work->memory + n * (size_t)j;
        float largest;
        rf_result result =
            rf_depth_to_radius(f, &view->depth, radius, NULL, NULL, &largest, error);
        if (result != RF_OK)
            return result;
        w->radius = radius;
        work->largest_radius = rf_max_float(largest, work->largest_radius);
        rf_work_view_place(w, view->lens_offset, view->shear_distance, &f->lens);
    }
    work->radius = work->memory;
    return RF_OK;
}

/*
 * The method layered or views, from the caller's pixels. *is_done is false where their
 * planes are needed.
 */
static rf_result read(struct rf_work *work, const struct rf_view *views,
                      const struct rf_image *out, bool *is_done, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    rf_result result = read_depths(work, views, error);
    if (result != RF_OK)
        return result;
    if (work->n_views == 1 && work->largest_radius < RF_SHARP_PX) {
        *is_done = rf_frame_copy(f->context, &views->colour, out);
        return RF_OK;
    }
    for (int j = 0; j < work->n_views; j++)
        work->views[j].image = &views[j].colour;
    work->out = rf_image_is_plain(&f->params, out) ? out : NULL;
    result = rf_method_run(f->params.method)(work, error);
    *is_done = !work->needs_planes;
    if (result == RF_OK && *is_done && !work->is_stored &&
        !rf_task_is_cancelled(work->task))
        rf_frame_store(f->context, &f->params, work->colour, work->stride, out);
    for (int j = 0; j < work->n_views; j++)
        work->views[j].image = NULL;
    work->out = NULL;
    return result;
}

/* Fills radius and colour of every view and runs the method. */
static rf_result run(struct rf_work *work, const struct rf_view *views,
                     const struct rf_image *out, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    size_t n_pixels = (size_t)f->width * (size_t)f->height;
    size_t n = n_pixels * (size_t)(work->n_planes + 1);
    size_t n_all = n * (size_t)work->n_views;
    bool is_copied = false, is_done = false;
    bool streams = can_stream(work, views, out), reads = can_read(work, views);
    size_t n_first = reads ? n_pixels * (size_t)work->n_views : n_all;
    work->memory = rf_alloc(f->context, n_first, sizeof(float));
    if (!work->memory)
        return rf_fail_memory(error, n_first, sizeof(float));
    if (streams || reads) {
        rf_result result = streams
                               ? stream(work, views, work->memory, out, &is_done, error)
                               : read(work, views, out, &is_done, error);
        if (result == RF_OK && is_done && rf_task_is_cancelled(work->task))
            result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
        if (result != RF_OK || is_done)
            return result;
        work->largest_radius = 0;
    }
    if (reads) {
        rf_free(f->context, work->memory);
        work->memory = rf_alloc(f->context, n_all, sizeof(float));
        if (!work->memory)
            return rf_fail_memory(error, n_all, sizeof(float));
    }
    float *memory = work->memory;
    for (int j = 0; j < work->n_views; j++) {
        rf_result result = rf_work_load(work, j, &views[j], memory + n * (size_t)j,
                                        NULL, out, &is_copied, error);
        if (result != RF_OK || is_copied)
            return result;
    }
    memcpy(work->colour, work->views[0].colour, sizeof work->colour);
    work->radius = work->views[0].radius;
    if (work->largest_radius < RF_SHARP_PX && work->n_views == 1) {
        rf_image_copy(&views->colour, out);
        return RF_OK;
    }
    rf_result result = rf_method_run(f->params.method)(work, error);
    if (result == RF_OK && rf_task_is_cancelled(work->task))
        result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    if (result == RF_OK)
        rf_frame_store(f->context, &f->params, work->colour, work->stride, out);
    return result;
}

static rf_result check_view(const struct rf_filter *f, const struct rf_view *view,
                            const struct rf_image *out, struct rf_error *error)
{
    rf_result result =
        rf_image_check(&view->colour, "colour", f->width, f->height, error);
    if (result == RF_OK)
        result = rf_image_check(&view->depth, "depth", f->width, f->height, error);
    if (result == RF_OK && out->channels != view->colour.channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, "out",
                         "out has %d channels and colour %d: give both the same",
                         out->channels, view->colour.channels);
    return result == RF_OK ? rf_view_check_place(view, error) : result;
}

static rf_result check_views(const struct rf_filter *f, const struct rf_view *views,
                             int32_t n_views, const struct rf_image *out,
                             struct rf_error *error)
{
    if (!f || !views || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !f       ? "filter"
                       : !views ? "views"
                                : "out",
                       "a pointer is NULL");
    const struct rf_method_info *method = rf_method_find(f->params.method);
    if (n_views < 1 || n_views > method->max_views)
        return rf_fail(error, RF_ERROR_ARGUMENT, "n_views",
                       "%d views were given; the method %s takes 1 to %d", n_views,
                       method->name, method->max_views);
    rf_result result = rf_image_check(out, "out", f->width, f->height, error);
    for (int j = 0; j < n_views && result == RF_OK; j++)
        result = check_view(f, &views[j], out, error);
    return result;
}

rf_result rf_filter_process(const struct rf_filter *filter, const struct rf_view *views,
                            int32_t n_views, const struct rf_image *out,
                            const struct rf_progress *progress, struct rf_error *error)
{
    rf_result result = check_views(filter, views, n_views, out, error);
    if (result != RF_OK)
        return result;
    struct rf_task task;
    rf_task_begin(&task, progress);
    if (rf_task_is_cancelled(&task))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    struct rf_work_view work_views[RF_MAX_VIEWS] = {{.radius = NULL}};
    struct rf_work work = {.filter = filter,
                           .n_planes = views->colour.channels,
                           .stride = (size_t)filter->width,
                           .n_views = n_views,
                           .views = work_views,
                           .task = &task};
    result = run(&work, views, out, error);
    rf_free(filter->context, work.memory);
    if (result == RF_OK)
        rf_task_end(&task);
    return result;
}

static rf_result convert(const struct rf_filter *filter, const struct rf_image *depth,
                         const struct rf_image *out, bool is_radius,
                         struct rf_error *error)
{
    if (!filter)
        return rf_fail(error, RF_ERROR_ARGUMENT, "filter", "filter is NULL");
    int w = filter->width, h = filter->height;
    rf_result result = rf_image_check(depth, "depth", w, h, error);
    if (result == RF_OK)
        result = rf_image_check(out, "out", w, h, error);
    if (result != RF_OK)
        return result;
    const struct rf_context *context = filter->context;
    size_t n = (size_t)w * (size_t)h;
    float *memory = rf_alloc(context, n, sizeof(float));
    if (!memory)
        return rf_fail_memory(error, n, sizeof(float));
    result = rf_depth_to_radius(filter, depth, is_radius ? memory : NULL,
                                is_radius ? NULL : memory, NULL, NULL, error);
    if (result == RF_OK) {
        struct rf_image packed = rf_image_packed(memory, w, h, 1);
        struct rf_image one = *out;
        one.channels = 1;
        rf_image_copy(&packed, &one);
    }
    rf_free(context, memory);
    return result;
}

rf_result rf_filter_coc(const struct rf_filter *filter, const struct rf_image *depth,
                        const struct rf_image *out, struct rf_error *error)
{
    return convert(filter, depth, out, true, error);
}

rf_result rf_filter_planar_depth(const struct rf_filter *filter,
                                 const struct rf_image *depth,
                                 const struct rf_image *out, struct rf_error *error)
{
    return convert(filter, depth, out, false, error);
}

rf_result rf_apply(const struct rf_params *params, const struct rf_image *colour,
                   const struct rf_image *depth, const struct rf_image *out,
                   struct rf_error *error)
{
    if (!params || !colour || !depth || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT, "",
                       "params, colour, depth and out must not be NULL");
    struct rf_context *context;
    rf_result result = rf_context_create(&context, NULL, error);
    if (result != RF_OK)
        return result;
    struct rf_filter *filter;
    result = rf_filter_create(&filter, context, params, colour->width, colour->height,
                              error);
    if (result == RF_OK) {
        struct rf_view view = {.colour = *colour, .depth = *depth};
        result = rf_filter_process(filter, &view, 1, out, NULL, error);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return result;
}
