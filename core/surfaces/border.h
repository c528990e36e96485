/* SPDX-License-Identifier: Apache-2.0 */
/* What continues a picture beyond its border. */
#ifndef RF_SURFACES_BORDER_H
#define RF_SURFACES_BORDER_H

#include "input/frame.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/*
 * Continues the frame's pixels, the first of which lies at (x0, y0), to all of `pixels`:
 * colours, luminances and radii, by no more than `border` px on each side. Linear in the
 * colours where the frame's parameters neither split edges nor trace highlights.
 */
rf_result rf_border_continue(const struct rf_frame *frame,
                             const struct rf_pixels *pixels, int x0, int y0, int border,
                             struct rf_error *error);

#endif
