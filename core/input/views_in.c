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
#include "base/pool.h"
#include "input/depth.h"
#include "input/film.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "rackfocus/rackfocus.h"

/*
 * How views shift: rf_work_view.shift_*. A view moved by R u sees a point at distance z
 * moved by u R f_px (1/D - 1/z), D the plane that its shear keeps fixed (1/D = 0 for
 * parallel cameras); with the lens' r = bias + scale / z that is linear in r.
 * Orthographic: u R p (z / D - 1), r = bias + scale z.
 */
void rf_work_view_place(struct rf_work_view *w, const double lens_offset[2],
                        double shear_distance, const struct rf_lens *lens)
{
    double d = shear_distance, radius = lens->lens_radius;
    w->lens[0] = (float)(lens_offset[0] / radius);
    w->lens[1] = (float)(lens_offset[1] / radius);
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

/* Without sign, floats are in the order of their bits. */
static float largest_of(const struct rf_filter *f, const float *radius)
{
    size_t n = (size_t)f->width * (size_t)f->height;
    int32_t most = 0;
#pragma omp parallel for num_threads(f->context->n_threads) schedule(static)           \
    reduction(max                                                                      \
              : most)
    for (size_t i = 0; i < n; i++) {
        int32_t bits;
        memcpy(&bits, &radius[i], sizeof bits);
        bits &= INT32_MAX;
        most = bits > most ? bits : most;
    }
    float largest;
    memcpy(&largest, &most, sizeof largest);
    return largest;
}

rf_result rf_work_load(struct rf_work *work, int j, const struct rf_view *view,
                       float *memory, int64_t *n_known, const struct rf_image *out,
                       bool *is_copied, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    struct rf_work_view *w = &work->views[j];
    size_t n = (size_t)f->width * (size_t)f->height;
    for (int c = 0; c < work->n_planes; c++)
        w->colour[c] = memory + n * (size_t)(c + 1);
    float largest;
    rf_result result =
        rf_depth_to_radius(f, &view->depth, memory, NULL, n_known, &largest, error);
    if (result != RF_OK)
        return result;
    if (out && work->n_views == 1 && largest < RF_SHARP_PX &&
        rf_frame_copy(f->context, &view->colour, out)) {
        *is_copied = true;
        return RF_OK;
    }
    result = rf_frame_load(f->context, &f->params, &view->colour, &f->place, w->colour,
                           error);
    if (result != RF_OK)
        return result;
    bool is_filled = false;
    if (work->n_planes == 4)
        result = rf_film_fill(f, w->colour[3], memory, &is_filled, error);
    if (is_filled)
        largest = largest_of(f, memory);
    w->radius = memory;
    rf_work_view_place(w, view->lens_offset, view->shear_distance, &f->lens);
    work->largest_radius = rf_max_float(largest, work->largest_radius);
    return result;
}

void rf_work_drop_views(struct rf_work *work)
{
    if (!work->memory)
        return;
    rf_free(work->filter->context, work->memory);
    work->memory = NULL;
    memset(work->colour, 0, sizeof work->colour);
    work->radius = NULL;
}

rf_result rf_view_check_place(const struct rf_view *view, struct rf_error *error)
{
    if (isfinite(view->lens_offset[0]) && isfinite(view->lens_offset[1]) &&
        view->shear_distance >= 0)
        return RF_OK;
    return rf_fail(error, RF_ERROR_ARGUMENT, "lens_offset",
                   "a view's place on the lens must be finite and its shear distance 0 "
                   "or more");
}
