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

/*
 * Half extent of a footprint from which the resolution falls. 9 gains 0.2 dB with
 * spherical aberration and with a picture of the aperture, whose rims have finer detail,
 * and 0.1 dB with the plain disc (tests/quality/test_looks.py), and takes twice the time
 * at the radii from 8 to 9, 16 to 18 and so on.
 */
enum { REACH_PX = 8 };

struct rf_levels rf_levels_of(const struct rf_shape *shape)
{
    struct rf_levels levels;
    double extent[2];
    /* An ellipse that is wider than its radius must not outgrow the tile's halo. */
    rf_shape_extent(shape, extent);
    double wide =
        fmax(fmax(extent[0], extent[1]), fmax(shape->size[0], shape->size[1]));
    for (int i = 0; i < 2 * (RF_MAX_LEVEL + 1); i++) {
        /* Spherical aberration takes its room; rf_footprints has the rest. */
        int is_near = i % 2, l = i / 2;
        double room = ldexp(REACH_PX, l), glow = fmin(shape->glow_px, room / 2);
        if (!rf_shape_glows(shape, is_near))
            glow = 0;
        levels.limit[is_near][l] = (float)((room - glow) / wide);
    }
    return levels;
}

double rf_levels_most(const struct rf_levels *levels)
{
    double most = 0;
    for (int i = 0; i < 2 * (RF_MAX_LEVEL + 1); i++)
        most = fmax(most, ldexp((double)levels->limit[i % 2][i / 2], -(i / 2)));
    return most;
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
    const struct rf_levels *levels = &c->levels;
    double outer_px = (double)levels->limit[is_near][level];
    if (level == 0) /* both sides */
        outer_px = (double)rf_max_float(levels->limit[0][0], levels->limit[1][0]);
    double inner_px = (double)rf_level_from(&c->levels, level, is_near);
    int outer = (int)ceil(outer_px / RF_BIN_PX),
        inner = (int)floor(inner_px / RF_BIN_PX);
    outer += RF_N_SHARP;
    inner += RF_N_SHARP;
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
