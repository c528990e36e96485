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

/*
 * Bins, numbered from before the focus to behind it, 0 the first one behind it. A tile adds up
 * what lies in one bin, be it near or far. What is in focus has sharp edges, and a soft ground
 * behind it would be seen through them: it has bins of its own, up to RF_SHARP_PX of radius.
 * 0, none: errors of 0.06 of an edge's contrast (tests/physics/test_edges.c). plane -0.02 dB;
 * with 1 px -0.03, of normal quality -0.12 (docs/notebook/thresholds.md).
 */
static const float RF_SHARP_PX = 0.5f;
enum { RF_N_SHARP = 1 }; /* more bins on either side */

static inline int rf_floor_int(float v)
{
    int i = (int)v;
    return i - (v < (float)i);
}

static inline int rf_bin_at(float r)
{
    return rf_floor_int(r / RF_BIN_PX) + (r >= RF_SHARP_PX) - (r < -RF_SHARP_PX);
}

/* The least radius of a bin, which is the end of the one before it. */
static inline float rf_bin_from(int bin)
{
    if (bin == 1 || bin == -1)
        return (float)bin * RF_SHARP_PX;
    return (float)(RF_BIN_PX * (bin > 0   ? bin - RF_N_SHARP
                                : bin < 0 ? bin + RF_N_SHARP
                                          : 0));
}

/* The tiles of a level and side of the focus, without lists. */
struct rf_group rf_group_make(const struct rf_composer *c, int level, bool is_near);

/* Is there any T left in a tile's row? */
bool rf_is_row_open(const float *t);

#endif
