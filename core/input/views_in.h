/* SPDX-License-Identifier: Apache-2.0 */
/* The views on their way into a method. */
#ifndef RF_INPUT_VIEWS_IN_H
#define RF_INPUT_VIEWS_IN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/task.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* One view, in the blend space. */
struct rf_work_view {
    float *colour[4];
    /* Instead of colours: plain pixels, whose rows are read where they are needed. */
    const struct rf_image *image;
    const float *radius;
    float lens[2]; /* where on the unit lens it was taken, u right and v up */
    /*
     * A point of radius r lies at (x, y) + (u, -v) (shift_scale r + shift_bias) in the
     * view, with (x, y) its place in the view of the lens' centre.
     */
    float shift_scale, shift_bias;
    const struct rf_survey *survey; /* of the whole picture; NULL: it is at hand */
};

rf_result rf_view_check_place(const struct rf_view *view, struct rf_error *error);

/* Sets where a view was taken: `lens` and `shift_*`. */
void rf_work_view_place(struct rf_work_view *w, const double lens_offset[2],
                        double shear_distance, const struct rf_lens *lens);

/*
 * What a method gets: planes of colour (in the blend space) and the signed radius of
 * every pixel, width x height each, packed; it overwrites the colour with the result.
 * The methods of one view need only colour and radius, which are those of views[0].
 */
struct rf_work {
    const struct rf_filter *filter;
    int n_planes; /* 1, 3 or 4; the fourth is alpha */
    float *colour[4];
    size_t stride; /* floats between the rows of the result */
    /*
     * Plain pixels of the caller that the result may go to as soon as the views are
     * dropped; NULL: it is wanted in `colour`. Only layered and views write it, and
     * set is_stored.
     */
    const struct rf_image *out;
    bool is_stored;
    /* Of the planes, where they are the work's own: who loads them frees it. */
    float *memory;
    const float *radius;
    int n_views;
    struct rf_work_view *views;
    float largest_radius; /* of all views, without sign */
    /* Set by layered and views: an image is not so simple, and planes are needed. */
    bool needs_planes;
    struct rf_task *task;
};

/*
 * Loads view j from the caller's pixels to `memory`, which holds n_planes + 1 planes;
 * `n_known` as in rf_depth_to_radius(). A lone view that is sharp all over is only
 * copied where `out` is not NULL, and *is_copied then true.
 */
rf_result rf_work_load(struct rf_work *work, int j, const struct rf_view *view,
                       float *memory, int64_t *n_known, const struct rf_image *out,
                       bool *is_copied, struct rf_error *error);

/*
 * Gives work->memory back, for what comes after the views' planes. rf_composite_crop()
 * then gives the result planes of its own, in other memory.
 */
void rf_work_drop_views(struct rf_work *work);

/* A picture whose every radius is below this is its own blur: half a step of the
 * radius. */
static const float RF_SHARP_PX = 1.0f / 64;

#endif
