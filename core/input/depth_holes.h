/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels without depth that are scattered over surfaces. */
#ifndef RF_INPUT_DEPTH_HOLES_H
#define RF_INPUT_DEPTH_HOLES_H

#include <stdint.h>

#include "base/context.h"
#include "rackfocus/rackfocus.h"

struct rf_hole_count;

/* For rows of `width` px; NULL without memory. */
struct rf_hole_count *rf_hole_count_create(const struct rf_context *context,
                                           int32_t width, double infinity);

/* Adds the rows of a strip, which go on below those before. */
void rf_hole_count_add(struct rf_hole_count *count,
                       const struct rf_depth_channel *strip);

/* Fills n_holes, hole_share and is_speckled, and frees the count. */
void rf_hole_count_judge(struct rf_hole_count *count, struct rf_depth_stats *stats);

#endif
