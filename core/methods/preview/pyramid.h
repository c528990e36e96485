/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Levels of detail: level 0 is the picture, each further one has half the size, every
 * sample the mean of 2 x 2 (an odd last row or column counts twice).
 */
#ifndef RF_METHODS_PREVIEW_PYRAMID_H
#define RF_METHODS_PREVIEW_PYRAMID_H

#include <stdbool.h>

#include "base/context.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

enum { RF_MAX_LEVELS = 17 };

struct rf_pyramid {
    int n_levels;
    struct rf_grid level[RF_MAX_LEVELS]; /* level 0 belongs to the caller */
    /* Where the first sample of levels 1 and up lies, in samples from the border. */
    float origin;
};

/*
 * Builds levels down to a single sample, whatever the radii. With `is_offset`
 * levels from 1 on hold the mean of four diagonal shifts by half a sample, on the
 * corners between the samples (see mipmap_offset.c). The first half of the blur's
 * progress.
 */
rf_result rf_pyramid_build(struct rf_pyramid *pyramid, const struct rf_blur *blur,
                           bool is_offset, struct rf_error *error);

void rf_pyramid_free(struct rf_pyramid *pyramid, const struct rf_context *context);

/*
 * Trilinear samples at every pixel, level log2 T with T = sqrt(1 + s r^2), s the scale;
 * between two levels the weight is linear in T. The second half of the progress.
 */
void rf_pyramid_sample(const struct rf_pyramid *pyramid, const struct rf_blur *blur,
                       float scale);

#endif
