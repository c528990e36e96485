/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray that comes to a pixel through the lens passes the depth of radius r at most |r|
 * away from it. Where all surfaces as far around are without edges, and none is farther
 * than of radius r, the ray has met one before it comes to that depth: what lies behind
 * does not show, however the pixels' footprints cover each other.
 */
#include "surfaces/insides.h"

#include <math.h>
#include <stdbool.h>

#include "base/math.h"
#include "kernels/hidden_kernels.h"
#include "surfaces/hidden_blocks.h"

/* Blocks that are looked at to each side at the most: radii of 32 px. */
enum { MOST_REACH = 5 };

/* How many blocks away a surface of radius r may be met. */
static int reach_of(const struct rf_insides *s, float r)
{
    float blocks = (fabsf(r) * s->extent + 1) / RF_HIDDEN_BLOCK;
    return blocks < MOST_REACH ? (int)blocks + 1 : MOST_REACH + 1;
}

/* The highest radius of the blocks within `reach`. */
static float highest_within(const struct rf_insides *s, int bx, int by, int reach)
{
    int x0 = rf_max_int(bx - reach, 0), x1 = rf_min_int(bx + reach, s->n_x - 1);
    int y0 = rf_max_int(by - reach, 0), y1 = rf_min_int(by + reach, s->n_y - 1);
    float highest = -INFINITY;
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++)
            highest = rf_max_float(s->blocks[y * s->n_x + x].highest, highest);
    return highest;
}

float rf_inside_radius(const struct rf_insides *s, int bx, int by)
{
    float highest = s->blocks[by * s->n_x + bx].highest;
    int reach = reach_of(s, highest);
    for (int tries = 0; tries < 2; tries++) {
        if (reach > MOST_REACH ||
            rf_hidden_has_rough(s->blocks, s->n_x, s->n_y, bx, by, reach))
            return INFINITY;
        highest = highest_within(s, bx, by, reach);
        int needed = reach_of(s, highest);
        if (needed <= reach)
            return highest;
        reach = needed;
    }
    return INFINITY;
}
