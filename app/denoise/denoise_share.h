/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Several views share what they see before their grain is taken out: each gets the
 * samples that the others have of the same points.
 */
#ifndef APP_DENOISE_SHARE_H
#define APP_DENOISE_SHARE_H

#include <stdbool.h>
#include <stdint.h>

#include "denoise/denoise.h"

struct image_error;

/* One view. Planes and packed pixels of the size of struct share. */
struct share_view {
    const float *samples; /* scene-linear, n_channels */
    /* Px that a pixel's point moves to the right as the eye moves to the right by a
     * scene unit; not finite: not known, shared with nobody. */
    const float *shift_px;
    struct denoise_guides guides;
    double offset[2]; /* of the eye, scene units right and up */
};

/* All views. Any number of threads may read it. */
struct share {
    struct share_view *views;
    int32_t n, width, height, n_channels; /* of n_channels the fourth is alpha */
    double lens_radius;                   /* scene units */
    float white; /* luminance that is shown as white, a power of two */
    int n_threads;
    float *tones; /* of share_open() */
};

/* Finds how far the grain of the views goes; false where memory is missing. */
bool share_open(struct share *share, struct image_error *error);
void share_close(struct share *share);

/*
 * What all views know of the pixels of view j: `samples` and, where `guides` has them,
 * albedo and normals, of the views that show the same point in the same colour; and, in
 * `n_shared`, how many these are, this one counted; it may be NULL. Returns the mean of
 * these.
 */
double share_collect(const struct share *share, int j, float *samples, float *n_shared,
                     struct denoise_guides *guides);

#endif
