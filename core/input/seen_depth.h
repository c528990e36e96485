/* SPDX-License-Identifier: Apache-2.0 */
/* The depth of what is seen in mirrors and through glass, from several views. */
#ifndef RF_INPUT_SEEN_DEPTH_H
#define RF_INPUT_SEEN_DEPTH_H

#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/*
 * The planar distance of what the light of each pixel of views[0] shows, into `planar`,
 * packed; NAN where it is that of the surface. lights[j] is the same light of views[j],
 * in order; the arguments are checked.
 */
rf_result rf_seen_find(const struct rf_frame *frame, const struct rf_view *views,
                       int n_views, const struct rf_image *lights, float *planar,
                       struct rf_error *error);

/* The same of one view whose rays' ways are known: `planar` has them at first. */
rf_result rf_seen_keep_flat(const struct rf_frame *frame, const struct rf_view *view,
                            const struct rf_image *light, float *planar,
                            struct rf_error *error);

#endif
