/* SPDX-License-Identifier: Apache-2.0 */
/* Planar means of distances from mean lengths of rays. */
#ifndef APP_PLANAR_MEANS_H
#define APP_PLANAR_MEANS_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"

/*
 * Of the mean lengths of rays in `mean`, packed, makes what struct rf_view has as
 * mean_depth, by the planar distances of single samples, view->depth, packed too. Room
 * for as many floats in `scratch`. pixel_aspect is the parameter of that name. False: they do not fit; the plane is of no use.
 */
bool planar_means_make(const struct rf_lens *lens, double pixel_aspect,
                       const struct rf_view *view, float *mean, float *scratch);

#endif
