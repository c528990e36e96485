/* SPDX-License-Identifier: Apache-2.0 */
/* Mirrors and panes as regions of a picture: which are flat, what is known of each. */
#ifndef RF_INPUT_SEEN_REGIONS_H
#define RF_INPUT_SEEN_REGIONS_H

#include "base/context.h"
#include "input/seen_match.h"
#include "rackfocus/rackfocus.h"

/*
 * Marks with 1 the pixels that belong to a mirror's edge at the most, and to no mirror
 * of their own: of which few are beside each other. The depth of a mixed pixel is that
 * of either side.
 */
void rf_seen_mark_edges(const struct rf_context *context,
                        const struct rf_seen_problem *problem, uint8_t *is_edge);

/*
 * Takes what lies on curved surfaces out of `tones`, which are those of the problem's
 * first view: its image is at two distances, or before the surface.
 */
rf_result rf_seen_drop_curved(const struct rf_context *context,
                              const struct rf_seen_problem *problem, float *tones,
                              struct rf_error *error);

/*
 * Settles what was found by regions, each a mirror: drops what may be grain, and fills
 * what is open of the rest from around.
 */
rf_result rf_seen_settle(const struct rf_context *context,
                         const struct rf_seen_problem *problem,
                         const struct rf_seen_match *match, struct rf_error *error);

#endif
