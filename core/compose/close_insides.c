/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Pixels of one surface have different radii and cover each other to 95 % only, or less
 * where their depth is rough or the levels change; what lies far behind would shine through
 * in specks and contour lines. Inside a surface (surfaces/insides.c) it is not seen.
 */
#include "compose/close_insides.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
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

/* Is anything of a pixel's T left? */
static bool is_open(const float *t, size_t plane, int n_cells)
{
    for (int cell = 0; cell < n_cells; cell++)
        if (t[plane * (size_t)cell] > 0)
            return true;
    return false;
}

static void close_pixel(float *t, size_t plane, int n_cells)
{
    for (int cell = 0; cell < n_cells; cell++)
        t[plane * (size_t)cell] = 0;
}

/* Is one of a row's pixels between two radii? */
static bool has_between(const float *radius, int n, float shift, float from, float to)
{
    int found = 0;
    for (int i = 0; i < n; i++)
        found |= (radius[i] + shift >= from) & (radius[i] + shift < to);
    return found;
}

/* Takes the T of those pixels of block (bx, by) that are inside. */
static void close_pixels(const struct rf_composer *c, int bx, int by, float from,
                         float r, const struct rf_tile_state *state,
                         struct rf_inside_hint *hint)
{
    const struct rf_insides *s = c->scene->insides;
    const float shift = c->scene->radius_shift;
    const int n_cells = c->canvas.n_cells;
    const int x1 = rf_min_int((bx + 1) * BLOCK, s->width);
    const int y1 = rf_min_int((by + 1) * BLOCK, s->height);
    const float to = rf_min_float(r, 0);
    for (int y = by * BLOCK; y < y1; y++) {
        const float *radius = s->radius + s->stride * (size_t)y;
        if (!has_between(radius + bx * BLOCK, x1 - bx * BLOCK, shift, from, to))
            continue;
        for (int x = bx * BLOCK; x < x1; x++) {
            float *t =
                state->t + state->t_row * (size_t)(y % RF_TILE_H) + x % RF_TILE_W;
            if (has_between(radius + x, 1, shift, from, to) &&
                is_open(t, state->t_plane, n_cells) &&
                rf_inside_is_met(s, shift, x, y, r, hint))
                close_pixel(t, state->t_plane, n_cells);
        }
    }
}

void rf_close_insides(const struct rf_composer *c, int tx, int ty, float from, float r,
                      const struct rf_tile_state *state)
{
    const struct rf_insides *s = c->scene->insides;
    const float shift = c->scene->radius_shift;
    if (!s)
        return;
    struct rf_inside_hint hint = {0};
    for (int y = 0; y < RF_TILE_H; y += BLOCK)
        for (int x = 0; x < RF_TILE_W; x += BLOCK) {
            int bx = (tx * RF_TILE_W + x) / BLOCK, by = (ty * RF_TILE_H + y) / BLOCK;
            if (bx >= s->n_x || by >= s->n_y)
                continue;
            const struct rf_hidden_facts *block = &s->blocks[by * s->n_x + bx];
            float highest = block->highest + shift, lowest = block->lowest + shift;
            const bool is_last = highest < r;
            const bool has_asking = s->radius && lowest < rf_min_float(r, 0);
            if (!(highest >= from && (is_last || has_asking)))
                continue;
            const float known = rf_inside_radius(s, bx, by);
            if (is_last && known + shift < r)
                close_block(c, x, y, state);
            else if (has_asking && known == INFINITY)
                close_pixels(c, bx, by, from, r, state, &hint);
        }
}
