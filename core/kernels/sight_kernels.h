/* SPDX-License-Identifier: Apache-2.0 */
/* What the search for what views do not see (views_sight.c) and its loops share. */
#ifndef RF_SIGHT_KERNELS_H
#define RF_SIGHT_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RF_SIGHT_BLOCK = 8, RF_SIGHT_PARTS = 2 * RF_SIGHT_BLOCK };

/* A view that is looked at: radii of its near parts, and where it was rendered. */
struct rf_sight {
    const float *radius;
    size_t stride;
    float lens[2], shift_scale, shift_bias; /* as in struct rf_work_view */
    int x0, y0, x1, y1;                     /* pixels that were rendered */
};

/* Places of the centre's view, with the radius there. */
struct rf_sight_places {
    float x[RF_SIGHT_PARTS], y[RF_SIGHT_PARTS], r[RF_SIGHT_PARTS];
};

/* Where a view looks for such places: bit i, place i. */
struct rf_sight_found {
    int32_t x[RF_SIGHT_PARTS], y[RF_SIGHT_PARTS];
    unsigned rendered;
    unsigned clear; /* of those: the near part is known, and not nearer */
};

/* Radii of 8 x 8 pixels: a plane, at their middle and per px, and how far off it. */
struct rf_sight_plane {
    float lowest, highest;
    float level, slope[2], rough;
};

#endif
