/* SPDX-License-Identifier: Apache-2.0 */
/* A blurred copy, mixed into the sharp picture without leaks. */
#ifndef RF_METHODS_PREVIEW_LEAK_H
#define RF_METHODS_PREVIEW_LEAK_H

#include "input/views_in.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

/* A frame on its way through a method of this family. */
struct rf_preview {
    struct rf_work *work;
    rf_generator_fn generate;
    struct rf_grid sharp;
    float radius_px; /* of the blurred copy in the blends region and slices */
};

typedef rf_result (*rf_blend_fn)(struct rf_preview *preview, struct rf_error *error);

/*
 * How far each of n pixels from (x, y) is out of focus by the rules of a blend, 0 to 1.
 */
typedef void (*rf_alpha_fn)(const struct rf_preview *preview, const void *user, int x,
                            int y, int n, float *alpha);

/* One blurred copy, mixed into `base` (which is also where the result goes). */
struct rf_layer {
    struct rf_preview *preview;
    struct rf_grid *base; /* NULL: the sharp picture below, the result to the planes */
    const float *radius_map;
    float radius_px;
    rf_alpha_fn alpha;
    const void *alpha_user;
    int slice; /* of blend slices, below 0 before the focus; else 0 */
    double progress_from, progress_to;
};

/* leak.c: base += w (blurred - base), w as the parameters of leak control say. */
rf_result rf_layer_run(const struct rf_layer *layer, struct rf_error *error);

#endif
