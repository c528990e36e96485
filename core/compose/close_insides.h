/* SPDX-License-Identifier: Apache-2.0 */
/* The inside of surfaces is closed once they are composited. */
#ifndef RF_COMPOSE_CLOSE_INSIDES_H
#define RF_COMPOSE_CLOSE_INSIDES_H

#include "compose/composer.h"
#include "kernels/data.h"

/*
 * In tile (tx, ty) of level 0, once all samples below radius r are in it: blocks of pixels
 * of radii from `from` on through which nothing farther is seen have no T any more. Of one
 * view.
 */
void rf_close_insides(const struct rf_composer *c, int tx, int ty, float from, float r,
                      const struct rf_tile_state *state);

#endif
