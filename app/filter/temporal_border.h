/* SPDX-License-Identifier: Apache-2.0 */
/* What lies beyond a frame's border, as the frames beside it show it. */
#ifndef APP_TEMPORAL_BORDER_H
#define APP_TEMPORAL_BORDER_H

#include <stdbool.h>
#include <stdint.h>

struct image_error;
struct rf_view;
struct run;

struct border_pixel;

/* `pixels` is of the frame and `margin` px on each side of it. */
struct temporal_border {
    int32_t width, height, margin; /* px, of the frame without the border */
    struct border_pixel *pixels;
    /* px on the left, on top, right and below in which something is known */
    int32_t sides[4];
};

/*
 * Can the frame of this run be continued, once its pixels are read? Not several views,
 * nor what depends on the place in the picture, nor a frame that does not cover its
 * pixels.
 */
bool temporal_border_is_of(const struct run *run);

/* A border that nothing is known of; NULL without memory. */
struct temporal_border *temporal_border_make(const struct run *run, int32_t margin,
                                             struct image_error *error);
void temporal_border_free(struct temporal_border *border);

/*
 * A share `weight` of a pixel at (x, y) of the frame, of radius r px, distance z and a
 * colour of as many channels as the frame has: what lies inside is left out, and the
 * nearest surface counts.
 */
void temporal_border_add(struct temporal_border *border, int32_t x, int32_t y,
                         float weight, float r, float z, const float *colour,
                         int n_channels);

/* Once all is added: which sides there are; false: none. */
bool temporal_border_finish(struct temporal_border *border);

/*
 * Makes the lens's picture of a view of the run, continued by its border, in `samples`,
 * packed. An enum app_code.
 */
int temporal_border_filter(struct run *run, const struct rf_view *view, float *samples);

#endif
