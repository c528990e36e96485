/* SPDX-License-Identifier: Apache-2.0 */
/* Mean distances beside the depth of a source: struct rf_view's mean_depth. */
#ifndef APP_MEAN_DEPTH_H
#define APP_MEAN_DEPTH_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"
#include "sources/source.h"

/*
 * Reads Blender's Denoising Depth of a view, the mean along the rays from where the
 * camera begins to see, as planar distances; view->mean_depth is packed and of malloc().
 * Its `depth` has been read, as planar distances. It stays empty where the file has no
 * such layer, or one of something else. False on failure.
 */
bool mean_depth_read(const struct source *source, const struct rf_lens *lens,
                     int n_threads, struct rf_view *view, struct image_error *error);

/*
 * The planar distances of such a plane, by the distances of single samples, in place.
 * False: they do not fit; the plane is of no use. Room for as many floats in `scratch`.
 */
bool mean_depth_make_planar(const struct rf_lens *lens, const struct rf_view *view,
                            float *mean, float *scratch);

#endif
