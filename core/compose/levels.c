/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Levels: the resolution at which a radius is spread, and the tiles and bins of one.
 */
#include "compose/levels.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "compose/composer.h"
#include "kernels/data.h"
#include "lens/aperture.h"

enum { REACH_PX = 8 }; /* half extent of a footprint from which the resolution falls */

float rf_level_split(const struct rf_shape *shape)
{
    double extent[2];
    /* An ellipse that is wider than its radius must not outgrow the tile's halo. */
    rf_shape_extent(shape, extent);
    double glow = fmin(shape->glow_px, REACH_PX / 2); /* rf_footprints has the rest */
    return (float)((REACH_PX - glow) / fmax(fmax(extent[0], extent[1]),
                                            fmax(shape->size[0], shape->size[1])));
}

int rf_level_of(float split, float r)
{
    int l = 0;
    for (r = fabsf(r); r >= split && l < RF_MAX_LEVEL; l++)
        split *= 2;
    return l;
}

struct rf_group rf_group_make(const struct rf_composer *c, int level, bool is_near)
{
    struct rf_group g = {.level = level, .is_near = is_near};
    int round_up = (1 << level) - 1;
    g.width = (c->scene->width + round_up) >> level;
    g.height = (c->scene->height + round_up) >> level;
    g.n_x = (g.width + RF_TILE_W - 1) / RF_TILE_W;
    g.n_y = (g.height + RF_TILE_H - 1) / RF_TILE_H;
    g.stride = (size_t)g.n_x * RF_TILE_W;
    g.plane = g.stride * (size_t)g.n_y * RF_TILE_H;
    double outer_px = ldexp(c->split, level), inner_px = level ? outer_px / 2 : 0;
    int outer = (int)ceil(outer_px / RF_BIN_PX),
        inner = (int)floor(inner_px / RF_BIN_PX);
    g.first_bin = level == 0 || is_near ? -outer : inner;
    g.n_bins = level ? outer - inner : 2 * outer;
    return g;
}

/* Is there any T left in a tile's row? What is used up is 0. */
bool rf_is_row_open(const float *t)
{
    uint32_t any = 0;
    for (int i = 0; i < RF_TILE_W; i++) {
        uint32_t bits;
        memcpy(&bits, t + i, sizeof bits);
        any |= bits;
    }
    return any != 0;
}
