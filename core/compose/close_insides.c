/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pixels of one surface have different radii and cover each other to 95 % only, or less
 * where their depth is rough or the levels change; what lies far behind would shine through
 * in specks and contour lines. Inside a surface (surfaces/insides.c) it is not seen.
 */
#include "compose/close_insides.h"

#include <stddef.h>

#include "compose/composer.h"
#include "compose/scene.h"
#include "kernels/data.h"
#include "kernels/hidden_kernels.h"
#include "surfaces/hidden_blocks.h"
#include "surfaces/insides.h"

enum { BLOCK = RF_HIDDEN_BLOCK };

/* Takes the T of a block of pixels of a tile, from (x, y) of it on. */
static void close_block(const struct rf_composer *c, int x, int y,
                        const struct rf_tile_state *state)
{
    for (int cell = 0; cell < c->canvas.n_cells; cell++)
        for (int k = 0; k < BLOCK; k++) {
            float *t = state->t + state->t_plane * (size_t)cell +
                       state->t_row * (size_t)(y + k) + x;
            for (int i = 0; i < BLOCK; i++)
                t[i] = 0;
        }
}

void rf_close_insides(const struct rf_composer *c, int tx, int ty, float from, float r,
                      const struct rf_tile_state *state)
{
    const struct rf_insides *s = c->scene->insides;
    const float shift = c->scene->radius_shift;
    if (!s)
        return;
    for (int y = 0; y < RF_TILE_H; y += BLOCK)
        for (int x = 0; x < RF_TILE_W; x += BLOCK) {
            int bx = (tx * RF_TILE_W + x) / BLOCK, by = (ty * RF_TILE_H + y) / BLOCK;
            if (bx >= s->n_x || by >= s->n_y)
                continue;
            float highest = s->blocks[by * s->n_x + bx].highest + shift;
            if (highest >= from && highest < r &&
                rf_inside_radius(s, bx, by) + shift < r)
                close_block(c, x, y, state);
        }
}
