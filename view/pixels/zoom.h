/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the picture lies in the window: scale and place, zooming, panning and picking.
 * Pure numbers. Window px have their origin at the top left corner of the window's
 * drawable area, x to the right, y down; picture px likewise, centres at +0.5.
 */
#ifndef VIEW_ZOOM_H
#define VIEW_ZOOM_H

#include <stdbool.h>
#include <stdint.h>

/* Part of the window, px. */
struct area {
    int32_t x, y, width, height;
};

struct zoom {
    double scale;   /* window px per picture px along y */
    double aspect;  /* width / height of a picture px; x is scaled by scale * aspect */
    double x, y;    /* window px of the picture's top left corner */
    bool is_fitted; /* follows the window's size */
};

bool area_has(const struct area *area, double x, double y);

/* The whole picture as large as the area allows; magnified in steps of a half, so that
 * windows that are about as large as the picture show its px as they are. */
void zoom_fit(struct zoom *zoom, const struct area *area, int32_t width,
              int32_t height);

/* One picture px is one window px, the point (x, y) of the window stays. */
void zoom_to_actual(struct zoom *zoom, double x, double y);

/* Scales by `factor` about the window's point (x, y), from 1/64 to 64. */
void zoom_by(struct zoom *zoom, double factor, double x, double y);

void zoom_pan(struct zoom *zoom, double dx, double dy);

/* Moves the picture so far back that some of it is seen in the area; also rounds its
 * place to whole px where the scale is whole, so that px are shown as they are. */
void zoom_settle(struct zoom *zoom, const struct area *area, int32_t width,
                 int32_t height);

/* The picture's point below the window's. */
void zoom_to_picture(const struct zoom *zoom, double window_x, double window_y,
                     double *x, double *y);

/* The px of a picture of width x height there; false outside. */
bool zoom_pick(const struct zoom *zoom, int32_t width, int32_t height, double window_x,
               double window_y, int32_t *x, int32_t *y);

#endif
