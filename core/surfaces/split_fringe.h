/* SPDX-License-Identifier: Apache-2.0 */
/* Fringes of highlights, split into the bright thing and what is around it. */
#ifndef RF_SURFACES_SPLIT_FRINGE_H
#define RF_SURFACES_SPLIT_FRINGE_H

#include <stdbool.h>

#include "kernels/data.h"
#include "surfaces/surfaces.h"

/* Would the lower third of the pixels around let the pixel be a fringe of `peak`? */
bool rf_may_be_fringe(const struct rf_pixels *p, int x, int y, float peak);

/* Splits a pixel; false: it is none. `share` is that of the near part. */
bool rf_split_fringe(const struct rf_pixels *p, int x, int y, struct rf_surface *near,
                     struct rf_surface *far, float *share);

#endif
