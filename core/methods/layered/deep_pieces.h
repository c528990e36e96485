/* SPDX-License-Identifier: Apache-2.0 */
/* The samples of a deep pixel, checked, cut into slices and sorted. */
#ifndef RF_METHODS_LAYERED_DEEP_PIECES_H
#define RF_METHODS_LAYERED_DEEP_PIECES_H

#include <stddef.h>

#include "compose/scene.h"
#include "input/frame.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

enum { RF_DEEP_SLICES = 16 };

/* A sample or a slice of one, with its place. */
struct rf_deep_piece {
    double z;    /* planar distance */
    float r;     /* signed radius, px */
    float a;     /* opacity */
    float c[4];  /* premultiplied, blend space */
    float value; /* of the depth channel */
};

struct rf_deep_work {
    const struct rf_frame *frame;
    const struct rf_deep *deep;
    int n_planes;
    size_t most_samples;           /* in one pixel */
    struct rf_deep_piece *scratch; /* per thread, most_samples * RF_DEEP_SLICES + 1 */
    float *planes[4], *radius;     /* the flat picture */
    float empty_radius;            /* of what is infinitely far */
    struct rf_picture picture;
    struct rf_estimates hidden;
    size_t *row_start;
    struct rf_samples samples;
};

/* The pieces of pixel (x, y), near to far; returns how many. */
int rf_deep_pieces_of(const struct rf_deep_work *d, int x, int y,
                      struct rf_deep_piece *pieces);

/* Room of a thread for those of any pixel. */
struct rf_deep_piece *rf_deep_scratch(const struct rf_deep_work *d, int thread);

/* Finds the most samples of a pixel. RF_ERROR_ARGUMENT, RF_ERROR_DEPTH or
 * RF_ERROR_PIXEL names the first that is wrong. */
rf_result rf_deep_check(struct rf_deep_work *d, struct rf_error *error);

#endif
