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

/*
 * One view. Its colours lie in planes in the blend space, or are plain pixels of the
 * caller whose rows are read where they are needed.
 */
struct rf_work_view {
    const struct rf_image *image; /* plain pixels; NULL: planes */
    float *colour[4];             /* planes, width x height, packed */
    const float *radius;          /* signed, likewise */
    float largest_radius;         /* of them, without sign */
    float
        lens[2]; /* where on the unit lens it was taken, u right and v up, v in rows */
    /*
     * A point of radius r lies at (x, y) + (u, -v) (shift_scale r + shift_bias) in the
     * view, with (x, y) its place in the view of the lens' centre.
     */
    float shift_scale, shift_bias;
    const struct rf_survey *survey; /* of the whole picture; NULL: it is at hand */
    const struct rf_view *behind;   /* knows what is not seen; NULL: nothing is known */
    const struct rf_image *mean_depth; /* of the caller, as in rf_view; NULL: none */
};

/*
 * What a method gets, and leaves. It reads the views row by row where they are plain
 * pixels, or asks for all of them as planes with rf_work_unpack(), and takes what it
 * needs before rf_work_drop_views(). The result goes to `out`, where that is given and
 * the method can write plain pixels, or to the planes `colour`.
 */
struct rf_work {
    const struct rf_frame *frame;
    int n_planes; /* 1, 3 or 4; the fourth is alpha */
    int n_views;
    struct rf_work_view *views;
    const float *radius;  /* of views[0] */
    float largest_radius; /* of all views, without sign */
    /* Plain pixels of the caller for the result; NULL: it is wanted in `colour`. */
    const struct rf_image *out;
    float *colour[4]; /* the result; NULL where it went to `out`. At first views[0]'s */
    size_t stride;    /* floats between the rows of the result */
    float *memory;    /* of the views' radii: who loads them calls rf_work_free() */
    float *planes;    /* of their colours, or of the result */
    struct rf_task *task;
};

/*
 * Views of a caller whose struct may be another version's: its size is known, and
 * their members that are known here.
 */
rf_result rf_view_check_size(const struct rf_view *view, struct rf_error *error);
void rf_views_copy(struct rf_view *known, const struct rf_view *views, int n);

rf_result rf_view_check_place(const struct rf_view *view, struct rf_error *error);

/* Sets where a view was taken: `lens` and `shift_*`. */
void rf_work_view_place(struct rf_work_view *w, const double lens_offset[2],
                        double shear_distance, const struct rf_lens *lens,
                        double pixel_aspect);

/*
 * Loading, in this order: depths to radii, and where the views were taken; then their
 * light. `n_known` (or NULL) is as in rf_depth_to_radius(), of the last view.
 */
rf_result rf_work_load_depth(struct rf_work *work, const struct rf_view *views,
                             int64_t *n_known, struct rf_error *error);
rf_result rf_work_load_light(struct rf_work *work, const struct rf_view *views,
                             struct rf_error *error);

/*
 * Is a picture whose radii are at most largest_radius px its own blur? Where they are all
 * below half a step of the radius, and spherical aberration gives what is in focus no glow.
 */
bool rf_frame_is_sharp(const struct rf_frame *f, float largest_radius);

/* Once depths are loaded: is the picture its own blur? */
bool rf_work_is_sharp(const struct rf_work *work);

/* Colours as planes, for who does not read rows: of all views that have none. */
rf_result rf_work_unpack(struct rf_work *work, struct rf_error *error);

/*
 * Gives back the memory of the views that the work has loaded, for what comes after
 * them. rf_composite_crop() then gives the result planes of its own.
 */
void rf_work_drop_views(struct rf_work *work);
void rf_work_free(struct rf_work *work);

#endif
