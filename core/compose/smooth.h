/* SPDX-License-Identifier: Apache-2.0 */
/* Smooth surfaces near the focus have no holes. */
#ifndef RF_COMPOSE_SMOOTH_H
#define RF_COMPOSE_SMOOTH_H

#include "compose/composer.h"
#include "kernels/data.h"

/* What smooth surfaces near the focus leave open in a tile of level 0 shows their own
 * colour; once all samples up to 2 px of radius are in it. Of one view. */
void rf_close_smooth(const struct rf_composer *c, int tx, int ty,
                     const struct rf_tile_state *state);

#endif
