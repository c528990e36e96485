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

static void close_pixel(float *t, size_t plane, int n_cells)
{
    for (int cell = 0; cell < n_cells; cell++)
        t[plane * (size_t)cell] = 0;
}

/* Bits of a block's pixels on their way: those of each column, of rows 0 to 3 and 4 to 7. */
struct columns {
    uint32_t at[2][BLOCK];
};

/* That of the first column in row y. */
static uint32_t first_bit(int y)
{
    return (uint32_t)1 << BLOCK * (y % 4);
}

static uint64_t join_columns(const struct columns *columns)
{
    uint32_t half[2] = {0, 0};
    for (int i = 0; i < BLOCK; i++)
        for (int k = 0; k < 2; k++)
            half[k] |= columns->at[k][i] << i;
    return (uint64_t)half[1] << 32 | half[0];
}

/* Those of some pixels of a block that are between two radii. */
static uint64_t find_between(const struct rf_insides *s, float shift, int bx, int by,
                             uint64_t bits, float from, float to)
{
    const int n_rows = rf_min_int(s->height - by * BLOCK, BLOCK);
    const int n = rf_min_int(s->width - bx * BLOCK, BLOCK);
    const uint64_t within = (((uint64_t)1 << n) - 1) * (UINT64_MAX / ALL_COLUMNS);
    struct columns found = {{{0}}};
    for (int y = 0; y < n_rows; y++) {
        const float *radius =
            s->radius + s->stride * (size_t)(by * BLOCK + y) + bx * BLOCK;
        const uint32_t bit = first_bit(y);
        for (int i = 0; i < BLOCK; i++) { /* rows have room for whole blocks */
            const float r = radius[i] + shift;
            found.at[y / 4][i] |= (r >= from) & (r < to) ? bit : 0;
        }
    }
    return join_columns(&found) & within & bits;
}

/* Those of some pixels of a block of whose T anything is left; t is that of the first. */
static uint64_t find_open(const struct rf_tile_state *state, int n_cells,
                          const float *t, uint64_t bits)
{
    struct columns found = {{{0}}};
    for (int y = 0; y < BLOCK; y++) {
        const uint32_t bit = first_bit(y);
        if (!(bits >> BLOCK * y & ALL_COLUMNS))
            continue;
        for (int cell = 0; cell < n_cells; cell++) {
            const float *row =
                t + state->t_plane * (size_t)cell + state->t_row * (size_t)y;
            for (int i = 0; i < BLOCK; i++)
                found.at[y / 4][i] |= row[i] > 0 ? bit : 0;
        }
    }
    return join_columns(&found) & bits;
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
    uint64_t bits = rf_inside_may_be_met(s, shift, bx, by, r);
    if (bits)
        bits = find_between(s, shift, bx, by, bits, from, rf_min_float(r, 0));
    if (bits)
        bits = rf_inside_drop_hinted(s, shift, bx, by, bits, r, hint);
    if (bits)
        bits = find_open(state, n_cells, t, bits);
    uint64_t met = bits ? rf_inside_find_met(s, shift, bx, by, bits, r, hint) : 0;
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
