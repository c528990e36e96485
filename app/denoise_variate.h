/* SPDX-License-Identifier: Apache-2.0 */
/* Grain of colours that the grain of albedo and normals explains. */
#ifndef APP_DENOISE_VARIATE_H
#define APP_DENOISE_VARIATE_H

#include <stdbool.h>

#include "denoise.h"

struct image_error;

/* A picture and what is known of it; all of its size. */
struct variates {
    struct denoise_picture picture;       /* with its grain; alpha is kept */
    const float *denoised;                /* the same without, packed as the picture */
    const struct denoise_guides *sampled; /* of the same samples as the picture */
    const struct denoise_guides *clean;   /* without grain; normals where both have */
    int n_threads;
};

/*
 * Writes the picture less the grain that its guides explain to `made`, packed as the
 * picture. One with NaN or infinity is copied. False where memory is missing.
 */
bool variates_remove(const struct variates *variates, float *made,
                     struct image_error *error);

#endif
