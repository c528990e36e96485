/* SPDX-License-Identifier: Apache-2.0 */
/* The resolution at which a radius is spread, and its tiles. */
#ifndef RF_COMPOSE_LEVELS_H
#define RF_COMPOSE_LEVELS_H

#include <stdbool.h>

#include "compose/composer.h"
#include "lens/aperture.h"

/* Radius of level 0 up to which footprints of a shape are spread in full, px. */
float rf_level_split(const struct rf_shape *shape);

/* The level that spreads samples of radius r. */
int rf_level_of(float split, float r);

/* The tiles of a level and side of the focus, without lists. */
struct rf_group rf_group_make(const struct rf_composer *c, int level, bool is_near);

/* Is there any T left in a tile's row? */
bool rf_is_row_open(const float *t);

#endif
