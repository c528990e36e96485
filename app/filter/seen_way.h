/* SPDX-License-Identifier: Apache-2.0 */
/* The way of rays through mirrors and glass, Cycles' Denoising Depth. */
#ifndef APP_SEEN_WAY_H
#define APP_SEEN_WAY_H

#include <stdbool.h>

#include "filter/seen.h"

struct source;

/* What stands for that channel in options, and its layer. */
#define DENOISING "denoising"
#define DENOISING_LAYER "Denoising Depth"

/* The full name of that channel in the colour's file; NULL: it has none. */
const char *seen_find_way(const struct source *source);

/* Planar distances from depths, NAN where they are 0 or less: of the kind that the
 * parameters say, or along the rays, in their unit. An enum app_code. */
int seen_make_planar(const struct run *run, const char *option, bool is_way,
                     const float *depth, float *planar);

/* Adds to planar ways what Cycles leaves out: the near clip, and sky in mirrors, by the
 * light of these, three floats per pixel (NULL: not the sky). *fits:
 * do they end at the depth in a tenth of the picture? An enum app_code. */
int seen_complete_way(const struct run *run, const struct source *source,
                      const struct rf_view *view, const char *option,
                      const float *light, float *way, bool *fits);

/* Where nobody asked for depths of what is seen: warns where Denoising Depth, `rays`, shows
 * flat mirrors and panes. Of one view. An enum app_code. */
int seen_warn(struct run *run, const float *rays);

#endif
