/* SPDX-License-Identifier: Apache-2.0 */
/* Mean distances beside the depth of a source: struct rf_view's mean_depth. */
#ifndef APP_MEAN_DEPTH_H
#define APP_MEAN_DEPTH_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"
#include "sources/source.h"

/* Is a picture with these parameters made with them? */
bool mean_depth_is_used(const struct rf_params *params);

/* Has a source a layer of mean lengths of rays, Blender's Denoising Depth? */
bool mean_depth_is_there(const struct source *source);

/* Reads that layer, packed; *rays, of malloc(), is NULL where there is none. False on
 * failure. */
bool mean_depth_read_rays(const struct source *source, int n_threads, float **rays,
                          struct image_error *error);

/*
 * Makes view->mean_depth, packed and of malloc(), of mean lengths of rays. Its `depth`
 * has been read, as planar distances. It stays empty where the lengths are of something
 * else. False without memory.
 */
bool mean_depth_make(const struct rf_lens *lens, const struct rf_params *params,
                     const float *rays, struct rf_view *view,
                     struct image_error *error);

#endif
