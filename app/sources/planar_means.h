/* SPDX-License-Identifier: Apache-2.0 */
/* Planar means of distances from mean lengths of rays. */
#ifndef APP_PLANAR_MEANS_H
#define APP_PLANAR_MEANS_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"

/*
 * Of the mean lengths of rays in `mean`, packed, makes what struct rf_view has as
 * mean_depth, by the planar distances of single samples, view->depth, packed too. Both
 * are as the file has them: params->depth_scale and depth_offset make scene units of the
 * means, as they do of the depth. Room for as many floats in `scratch`. False: they do not fit; the
 * plane is of no use.
 */
bool planar_means_make(const struct rf_lens *lens, const struct rf_params *params,
                       const struct rf_view *view, float *mean, float *scratch);

#endif
