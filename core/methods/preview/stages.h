/* SPDX-License-Identifier: Apache-2.0 */
/* The stages of the real-time family as pictures, for who wants to see how it works. */
#ifndef RF_METHODS_PREVIEW_STAGES_H
#define RF_METHODS_PREVIEW_STAGES_H

#include "methods/preview/blur.h"
#include "methods/preview/leak.h"
#include "rackfocus/rackfocus.h"

/*
 * The chain of levels that mipmap and mipmap-offset take their samples from, in place of
 * the result: level 1 at the top left, 2 and further ones below each other at its right,
 * black elsewhere.
 */
rf_result rf_stage_levels(struct rf_preview *preview, struct rf_error *error);

/* Black in place of what is sharp, so that only what is painted over it shows. */
void rf_stage_blacken(struct rf_preview *preview);

#endif
