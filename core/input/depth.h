/* SPDX-License-Identifier: Apache-2.0 */
/* Depth channels to signed radii. */
#ifndef RF_INPUT_DEPTH_H
#define RF_INPUT_DEPTH_H

#include <stdint.h>

#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/*
 * Signed radius in px of every pixel of `depth` (any of rf_depth) into `radius`, packed
 * width x height; with `planar` not NULL also the planar distance. `n_known` receives
 * how many depths are not infinite by a 0 alone; with NULL none at all is an error.
 * `largest` (or NULL) receives the greatest magnitude of a radius.
 */
rf_result rf_depth_to_radius(const struct rf_frame *frame, const struct rf_image *depth,
                             float *radius, float *planar, int64_t *n_known,
                             float *largest, struct rf_error *error);

/* RF_ERROR_DEPTH: all is infinite by a 0 alone, as in a channel without any depth. */
rf_result rf_fail_empty_depth(struct rf_error *error);

/*
 * Why `value` cannot be a depth, as the end of a sentence that names it: what scale and
 * offset make of it, and what it has to be.
 */
enum { RF_BAD_DEPTH_WORDS = 128 };
void rf_bad_depth_words(const struct rf_params *params, double value,
                        char words[RF_BAD_DEPTH_WORDS]);

/*
 * One value of a depth channel at pixel (x, y): its planar distance, INFINITY where
 * nothing was hit, NAN where it cannot be a depth; *radius receives its signed radius.
 */
double rf_depth_of_value(const struct rf_params *params, const struct rf_lens *lens,
                         float value, int x, int y, float *radius);

#endif
