/* SPDX-License-Identifier: Apache-2.0 */
/* The views on their way into a method: where they were taken, radii and planes. */
#include "input/views_in.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/depth.h"
#include "input/field.h"
#include "input/film.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "rackfocus/rackfocus.h"

/*
 * How views shift: rf_work_view.shift_*. A view moved by R u sees a point at distance z
 * moved by u R f_px (1/D - 1/z), D the plane that its shear keeps fixed (1/D = 0 for
 * parallel cameras); with the lens' r = bias + scale / z that is linear in r.
 * Orthographic: u R p (z / D - 1), r = bias + scale z. Along v rows are counted, of which
 * a px has pixel_aspect; places on the lens are v / pixel_aspect again.
 */
void rf_work_view_place(struct rf_work_view *w, const double lens_offset[2],
                        double shear_distance, const struct rf_lens *lens,
                        double pixel_aspect)
{
    double d = shear_distance, radius = lens->lens_radius;
    w->lens[0] = (float)(lens_offset[0] / radius);
    w->lens[1] = (float)(lens_offset[1] / radius * pixel_aspect);
    double slope, base;
    if (lens->projection == RF_PROJECTION_PERSPECTIVE) {
        slope = -radius * lens->focal_length_px;
        base = d > 0 ? -slope / d : 0;
    } else {
        slope = d > 0 ? radius * lens->px_per_unit / d : 0;
        base = -radius * lens->px_per_unit;
    }
    w->shift_scale = (float)(slope / lens->scale);
    w->shift_bias = (float)(base - slope * lens->bias_px / lens->scale);
}

/* The largest radius, which threads look for together. */
struct largest {
    const float *radius;
    int32_t most; /* its bits, atomic: without sign, floats are in their order */
};

static void find_largest(void *data, int64_t begin, int64_t end, int thread)
{
    struct largest *l = data;
    int32_t most = 0, known = __atomic_load_n(&l->most, __ATOMIC_RELAXED);
    for (int64_t i = begin; i < end; i++) {
        int32_t bits;
        memcpy(&bits, &l->radius[i], sizeof bits);
        bits &= INT32_MAX;
        most = bits > most ? bits : most;
    }
    while (most > known &&
           !__atomic_compare_exchange_n(&l->most, &known, most, true, __ATOMIC_RELAXED,
                                        __ATOMIC_RELAXED))
        ;
}

static float largest_of(const struct rf_frame *f, const float *radius)
{
    struct largest l = {.radius = radius};
    rf_parallel(f->context, (int64_t)f->width * f->height, RF_EQUAL_PARTS, find_largest,
                &l);
    float largest;
    memcpy(&largest, &l.most, sizeof largest);
    return largest;
}

rf_result rf_work_load_depth(struct rf_work *work, const struct rf_view *views,
                             int64_t *n_known, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    size_t n = (size_t)f->width * (size_t)f->height, n_views = (size_t)work->n_views;
    work->memory = rf_alloc(f->context, n * n_views, sizeof *work->memory);
    if (!work->memory)
        return rf_fail_memory(error, n * n_views, sizeof *work->memory);
    for (size_t j = 0; j < n_views; j++) {
        struct rf_work_view *w = &work->views[j];
        const struct rf_view *view = &views[j];
        float *radius = work->memory + n * j;
        rf_result result = rf_depth_to_radius(f, &view->depth, radius, NULL, n_known,
                                              &w->largest_radius, error);
        if (result != RF_OK)
            return result;
        w->radius = radius;
        w->behind = view->behind_colour.data || view->n_unseen_lights ? view : NULL;
        /* Radii that depend on the place do not tell distances. */
        bool has_mean = view->mean_depth.data && !rf_field_is_used(f);
        w->mean_depth = has_mean ? &view->mean_depth : NULL;
        rf_work_view_place(w, view->lens_offset, view->shear_distance, &f->lens,
                           f->params.pixel_aspect);
        if (!f->apart)
            w->shift_bias -=
                w->shift_scale * (float)f->radius_shift; /* no colour moves */
    }
    work->radius = work->memory;
    return RF_OK;
}

bool rf_frame_is_sharp(const struct rf_frame *f, float largest_radius)
{
    static const float SHARP_PX = 1.0f / 64;
    return largest_radius < SHARP_PX && f->params.spherical == 0;
}

bool rf_work_is_sharp(const struct rf_work *work)
{
    return work->n_views == 1 &&
           rf_frame_is_sharp(work->frame, work->views->largest_radius) &&
           !rf_field_is_used(work->frame) &&
           !(work->frame->by_colour && work->frame->params.axial_chroma != 0);
}

/* What is partly transparent and has no depth. */
static rf_result fill_film(struct rf_work *work, int j, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    struct rf_work_view *w = &work->views[j];
    float *radius = work->memory + (size_t)f->width * (size_t)f->height * (size_t)j;
    struct rf_film film = {.pixel = 1, .row = f->width};
    if (w->image)
        film = (struct rf_film){.pixel = 4,
                                .row = w->image->row_bytes / (ptrdiff_t)sizeof(float)};
    for (int c = 0; c < 4; c++)
        film.at[c] = w->image ? rf_image_at(w->image, 0, 0, c) : w->colour[c];
    bool is_filled = false;
    rf_result result = rf_film_fill(f, &film, radius, &is_filled, error);
    if (is_filled)
        w->largest_radius = largest_of(f, radius);
    return result;
}

/* Room for the planes of views that have none, and their pixels there. */
static rf_result load_planes(struct rf_work *work, const struct rf_image *images[],
                             struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    size_t n = (size_t)f->width * (size_t)f->height;
    size_t n_all = n * (size_t)work->n_planes * (size_t)work->n_views;
    float *at = work->planes = rf_alloc(f->context, n_all, sizeof *work->planes);
    if (!at)
        return rf_fail_memory(error, n_all, sizeof *work->planes);
    for (int j = 0; j < work->n_views; j++) {
        struct rf_work_view *w = &work->views[j];
        for (int c = 0; c < work->n_planes; c++, at += n)
            w->colour[c] = at;
        w->image = NULL;
        rf_result result = rf_frame_load(f, images[j], w->colour, error);
        if (result != RF_OK)
            return result;
    }
    memcpy(work->colour, work->views->colour, sizeof work->colour);
    return RF_OK;
}

rf_result rf_work_load_light(struct rf_work *work, const struct rf_view *views,
                             struct rf_error *error)
{
    const struct rf_image *images[RF_MAX_VIEWS];
    bool is_plain = true;
    for (int j = 0; j < work->n_views; j++) {
        images[j] = &views[j].colour;
        is_plain &= rf_image_is_light(&work->frame->params, images[j]);
    }
    rf_result result = is_plain ? RF_OK : load_planes(work, images, error);
    for (int j = 0; j < work->n_views && result == RF_OK; j++) {
        struct rf_work_view *w = &work->views[j];
        if (is_plain)
            w->image = &views[j].colour;
        if (work->n_planes == 4)
            result = fill_film(work, j, error);
        size_t n = (size_t)work->frame->width * (size_t)work->frame->height;
        rf_field_apply(work->frame, work->memory + n * (size_t)j, &w->largest_radius);
        work->largest_radius = rf_max_float(w->largest_radius, work->largest_radius);
        if (work->frame->apart)
            work->largest_radius = rf_max_float(
                rf_field_largest(work->frame, w->radius), work->largest_radius);
    }
    return result;
}

rf_result rf_work_unpack(struct rf_work *work, struct rf_error *error)
{
    const struct rf_image *images[RF_MAX_VIEWS];
    if (!work->views->image)
        return RF_OK;
    for (int j = 0; j < work->n_views; j++)
        images[j] = work->views[j].image;
    return load_planes(work, images, error);
}

void rf_work_drop_views(struct rf_work *work)
{
    if (!work->memory)
        return;
    rf_work_free(work);
    memset(work->colour, 0, sizeof work->colour);
    work->radius = NULL;
}

void rf_work_free(struct rf_work *work)
{
    rf_free(work->frame->context, work->memory);
    rf_free(work->frame->context, work->planes);
    work->memory = NULL;
    work->planes = NULL;
}

/* The members of version 0.1, which is the oldest. */
enum { LEAST_VIEW_SIZE = sizeof(struct rf_view) };

rf_result rf_view_check_size(const struct rf_view *view, struct rf_error *error)
{
    if (view->size == 0 || view->size >= LEAST_VIEW_SIZE)
        return RF_OK;
    return rf_fail(error, RF_ERROR_ARGUMENT, "size",
                   "set rf_view.size to its sizeof, or to 0");
}

void rf_views_copy(struct rf_view *known, const struct rf_view *views, int n)
{
    size_t step = views->size ? views->size : LEAST_VIEW_SIZE;
    for (int j = 0; j < n; j++) {
        memset(&known[j], 0, sizeof known[j]);
        memcpy(&known[j], (const char *)views + step * (size_t)j,
               step < sizeof known[j] ? step : sizeof known[j]);
        known[j].size = sizeof known[j];
    }
}

rf_result rf_view_check_place(const struct rf_view *view, struct rf_error *error)
{
    if (!isfinite(view->lens_offset[0]) || !isfinite(view->lens_offset[1]))
        return rf_fail(error, RF_ERROR_ARGUMENT, "lens_offset",
                       "a view's place on the lens must be finite");
    if (!(view->shear_distance >= 0))
        return rf_fail(error, RF_ERROR_ARGUMENT, "shear_distance",
                       "a view's shear_distance must be 0 or more");
    return RF_OK;
}
