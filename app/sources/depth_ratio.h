/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth as numbers whose ratios tell surfaces apart, as those of distances do. A z-buffer
 * has 0.998 at 50 and 0.9995 at 200: its averages are looked for, and undone, in 1 /
 * distance, to which it is linear, so that a mean stays a mean:
 *
 *   normalised               z = n + v (f - n)
 *   buffer                   1 / z = 1 / n + v (1 / f - 1 / n); reversed: v -> 1 - v
 *   buffer-infinite          1 / z = (1 - v) / n
 *   the others               v
 *
 * with v = scale * value + offset, n and f the near and far plane. Worth 1.3 dB on a scene
 * of POV-Ray's (docs/notebook/depth.md).
 */
#ifndef APP_DEPTH_RATIO_H
#define APP_DEPTH_RATIO_H

#include <stdbool.h>
#include <stddef.h>

#include "rackfocus/rackfocus.h"

/* factor * value + offset; a factor of 0: the values are such numbers as they are. A range
 * that is far from 0 is taken nearer to it, so that what it tells apart are steps. */
struct depth_ratio {
    double factor, offset;
    double nothing; /* the value where nothing was hit, which is 0 to rf_depth_snap() */
};

/* What the values of a depth become. */
struct depth_ratio depth_ratio_of(const struct rf_params *params);

/* Of n values, in place. */
void depth_ratio_make(const struct depth_ratio *ratio, float *depth, size_t n);

/* As rf_depth_snap(), which it calls; values that it does not change keep their bits.
 * False without memory. */
bool depth_ratio_snap(const struct depth_ratio *ratio, struct rf_depth_channel *channel,
                      size_t *n_changed);

#endif
