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

enum { BLOCK = RF_HIDDEN_BLOCK, ALL_COLUMNS = 255 };

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

/* Those of some pixels of a block that are between two radii. */
static uint64_t find_between(const struct rf_insides *s, float shift, int bx, int by,
                             uint64_t bits, float from, float to)
{
    static const int bit[BLOCK] = {1, 2, 4, 8, 16, 32, 64, 128};
    const int n_rows = rf_min_int(s->height - by * BLOCK, BLOCK);
    const int n = rf_min_int(s->width - bx * BLOCK, BLOCK);
    uint64_t found = 0;
    for (int y = 0; y < n_rows; y++) {
        if (!(bits >> BLOCK * y & ALL_COLUMNS))
            continue;
        const float *radius = s->radius + s->stride * (size_t)(by * BLOCK + y);
        int columns = 0;
        for (int i = 0; i < BLOCK; i++) { /* rows have room for whole blocks */
            const float r = radius[bx * BLOCK + i] + shift;
            columns |= -((r >= from) & (r < to)) & bit[i];
        }
        found |= (uint64_t)(columns & ((1 << n) - 1)) << BLOCK * y;
    }
    return found & bits;
}

/* Takes the T of those pixels of block (bx, by) that are inside; t is that of its first
 * one. */
static void close_pixels(const struct rf_composer *c, int bx, int by, float from,
                         float r, float *t, const struct rf_tile_state *state,
                         struct rf_inside_hint *hint)
{
    const struct rf_insides *s = c->scene->insides;
    const float shift = c->scene->radius_shift;
    const int n_cells = c->canvas.n_cells;
    uint64_t open = 0, met;
    uint64_t bits = rf_inside_may_be_met(s, bx, by);
    if (bits)
        bits = find_between(s, shift, bx, by, bits, from, rf_min_float(r, 0));
    if (bits)
        bits = rf_inside_drop_hinted(s, shift, bx, by, bits, r, hint);
    for (uint64_t rest = bits; rest; rest &= rest - 1) {
        const int i = __builtin_ctzll(rest);
        if (is_open(t + state->t_row * (size_t)(i / BLOCK) + i % BLOCK, state->t_plane,
                    n_cells))
            open |= rest & -rest;
    }
    met = open ? rf_inside_find_met(s, shift, bx, by, open, r, hint) : 0;
    for (; met; met &= met - 1) {
        const int i = __builtin_ctzll(met);
        close_pixel(t + state->t_row * (size_t)(i / BLOCK) + i % BLOCK, state->t_plane,
                    n_cells);
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
                close_pixels(c, bx, by, from, r,
                             state->t + state->t_row * (size_t)y + x, state, &hint);
        }
}
