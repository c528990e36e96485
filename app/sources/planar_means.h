/* SPDX-License-Identifier: Apache-2.0 */
/* Planar means of distances from mean lengths of rays. */
#ifndef APP_PLANAR_MEANS_H
#define APP_PLANAR_MEANS_H

#include <stdbool.h>
#include <stddef.h>

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

/*
 * The camera's near clip, from which on Cycles counts the way of rays: what is missing
 * most often from the ways of n pixels to their samples, both planar and in one unit. NAN
 * where a tenth of them does not fit so, or something is before it. Room for n floats in `scratch`.
 */
float planar_means_near_clip(const float *depth, const float *way, size_t n,
                             float *scratch);

#endif
