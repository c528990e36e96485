/* SPDX-License-Identifier: Apache-2.0 */
/* Mean distances beside the depth of a source: struct rf_view's mean_depth. */
#ifndef APP_MEAN_DEPTH_H
#define APP_MEAN_DEPTH_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"
#include "sources/source.h"

/* Has a source a layer of mean distances? */
bool mean_depth_is_there(const struct source *source);

/*
 * Reads Blender's Denoising Depth of a view, the mean along the rays from where the
 * camera begins to see, as planar distances; view->mean_depth is packed and of malloc().
 * Its `depth` has been read, as planar distances. It stays empty where the file has no
 * such layer, or one of something else. False on failure.
 */
bool mean_depth_read(const struct source *source, const struct rf_lens *lens,
                     double pixel_aspect, int n_threads, struct rf_view *view,
                     struct image_error *error);

#endif
