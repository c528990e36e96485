/* SPDX-License-Identifier: Apache-2.0 */
/* What lies one little step behind a surface. */
#ifndef RF_SURFACES_HIDDEN_STEPS_H
#define RF_SURFACES_HIDDEN_STEPS_H

#include "surfaces/hidden_blocks.h"

/* Gives pixel (x, y) beside a little step of the radius the surface behind it as its
 * answer, where that was something far behind. */
void rf_hidden_behind_step(const struct rf_hidden_search *search, int x, int y,
                           struct rf_surface *answer);

#endif
