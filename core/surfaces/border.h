/* SPDX-License-Identifier: Apache-2.0 */
/* What continues a picture beyond its border. */
#ifndef RF_SURFACES_BORDER_H
#define RF_SURFACES_BORDER_H

#include "base/context.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/*
 * Continues the `width` x `height` pixels from (x0, y0) on to all of `pixels`: colours,
 * luminances and radii, by no more than `border` px on each side.
 */
rf_result rf_border_continue(const struct rf_context *context,
                             const struct rf_pixels *pixels, int x0, int y0, int width,
                             int height, int border, struct rf_error *error);

#endif
