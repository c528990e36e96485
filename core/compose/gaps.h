/* SPDX-License-Identifier: Apache-2.0 */
/* What is still open looks like the pixels around. */
#ifndef RF_COMPOSE_GAPS_H
#define RF_COMPOSE_GAPS_H

#include "base/context.h"
#include "compose/scene.h"

/* Notes for n pixels how much of a gap they are, 0 for those that are none. */
void rf_gaps_note(unsigned char *gaps, const float *coverage, int n);

/* Fills the gaps of a finished part, whose size `gaps` has, from around them. */
void rf_gaps_fill(const struct rf_crop *crop, const unsigned char *gaps,
                  const struct rf_context *context);

#endif
