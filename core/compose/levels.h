/* SPDX-License-Identifier: Apache-2.0 */
/* The resolution at which a radius is spread, and its tiles. */
#ifndef RF_COMPOSE_LEVELS_H
#define RF_COMPOSE_LEVELS_H

#include <stdbool.h>

#include "base/math.h"
#include "compose/composer.h"
#include "lens/aperture.h"

/* Of the footprints of a shape. */
struct rf_levels rf_levels_of(const struct rf_shape *shape);

/* The largest radius of them all, px of its level. */
double rf_levels_most(const struct rf_levels *levels);

/* The level that spreads samples of radius r. */
static inline int rf_level_of(const struct rf_levels *levels, float r)
{
    const float *limit = levels->limit[r < 0];
    int l = 0;
    for (r = r < 0 ? -r : r; l < RF_MAX_LEVEL && r >= limit[l]; l++)
        ;
    return l;
}

/* The highest level of radii up to r before and behind the focus. */
static inline int rf_level_up_to(const struct rf_levels *levels, float r)
{
    return rf_max_int(rf_level_of(levels, r), rf_level_of(levels, -r));
}

/* The smallest radius of a level, without its sign; 0 of the first. */
static inline float rf_level_from(const struct rf_levels *levels, int level,
                                  bool is_near)
{
    return level > 0 ? levels->limit[is_near][level - 1] : 0;
}

/* The tiles of a level and side of the focus, without lists. */
struct rf_group rf_group_make(const struct rf_composer *c, int level, bool is_near);

/* Is there any T left in a tile's row? */
bool rf_is_row_open(const float *t);

#endif
