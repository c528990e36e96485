/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A ray that comes to a pixel through the lens passes the depth of radius r at most |r|
 * away from it. Where all surfaces as far around are without edges, and none is farther
 * than of radius r, the ray has met one before it comes to that depth: what lies behind
 * does not show, however the pixels' footprints cover each other.
 *
 * Of blocks of pixels that is asked with a margin of up to two blocks. Single pixels
 * before the focus ask what their rays reach: an edge of radius r_e lets one pass only if
 * it is nearer than |r_e|, and what is farther away than its own |r| meets none.
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

/* ---- one pixel ------------------------------------------------------------------- */

/*
 * The edge of a pixel is half a pixel from its middle. With 1 px a sphere of 54 px of
 * radius, 14 px of blur, lets through 0.7 % 2 px inside what its blur reaches, with 0.5
 * nothing.
 */
static const float EDGE_PX = 0.5f;
/* The same along the directions of struct rf_reach. */
static const float ALONG_PX[4] = {EDGE_PX, EDGE_PX, 2 * EDGE_PX, 2 * EDGE_PX};

/* Beyond what rays reach at the pixel's own depth nearer surfaces may lie. */
static const float MORE = 1.1f;

/* A near pixel that asks, and what is found around it. */
struct asking {
    const struct rf_insides *s;
    float shift; /* of all radii, px */
    int x, y;
    float limit;  /* radius, at most 0, below which rays are to meet something */
    float lowest; /* radius of what they may meet */
    struct rf_inside_hint *hint;
};

static float squared(float v)
{
    return v * v;
}

/* How far a ray is from the pixel at the depth of radius r, and half a pixel more. */
static float reach_at(const struct asking *a, float r)
{
    return fabsf(r) * a->s->reach.most + EDGE_PX;
}

/* Pixels from (x0, y0) to (x1, y1), seen from the one that asks. */
struct box {
    float x0, y0, x1, y1;
};

static struct box pixel_of(const struct asking *a, int x, int y)
{
    const float dx = (float)(x - a->x), dy = (float)(y - a->y);
    return (struct box){dx, dy, dx, dy};
}

static struct box block_of(const struct asking *a, int bx, int by)
{
    const float x = (float)(bx * RF_HIDDEN_BLOCK - a->x);
    const float y = (float)(by * RF_HIDDEN_BLOCK - a->y);
    return (struct box){x, y, x + RF_HIDDEN_BLOCK - 1, y + RF_HIDDEN_BLOCK - 1};
}

/* Where the pixels lie along the directions of struct rf_reach; rows go down. */
struct spans {
    float from[4], to[4];
};

static struct spans spans_of(const struct box *b)
{
    return (struct spans){{b->x0, -b->y1, b->x0 - b->y1, b->x0 + b->y0},
                          {b->x1, -b->y0, b->x1 - b->y0, b->x1 + b->y1}};
}

/* May a ray reach one of the pixels, at the depth of radius r < 0? */
static inline bool may_reach(const struct asking *a, const struct box *b, float r)
{
    const struct rf_reach *reach = &a->s->reach;
    const float dx = rf_max_float(rf_max_float(b->x0, -b->x1), 0);
    const float dy = rf_max_float(rf_max_float(b->y0, -b->y1), 0);
    if (!(squared(dx) + squared(dy) < squared(reach_at(a, r))))
        return false;
    const struct spans spans = spans_of(b);
    for (int k = 0; k < 4; k++)
        if (spans.to[k] <= -r * reach->from[k] - ALONG_PX[k] ||
            spans.from[k] >= -r * reach->to[k] + ALONG_PX[k])
            return false;
    return true;
}

static float radius_of(const struct asking *a, int x, int y)
{
    return a->s->radius[a->s->stride * (size_t)y + x] + a->shift;
}

static void hint_at(const struct asking *a, int x, int y)
{
    *a->hint = (struct rf_inside_hint){x, y, true};
}

/* May a ray pass an edge of the block, before it comes to the focus? */
static bool has_passage(const struct asking *a, int bx, int by)
{
    const struct rf_inside_edges *edges = &a->s->edges[by * a->s->n_x + bx];
    const struct box block = block_of(a, bx, by);
    const float lowest = edges->lowest + a->shift;
    if (!(lowest < 0) || !may_reach(a, &block, lowest))
        return false;
    for (uint64_t bits = edges->bits; bits; bits &= bits - 1) {
        const int i = __builtin_ctzll(bits);
        const int x = bx * RF_HIDDEN_BLOCK + i % RF_HIDDEN_BLOCK;
        const int y = by * RF_HIDDEN_BLOCK + i / RF_HIDDEN_BLOCK;
        const struct box pixel = pixel_of(a, x, y);
        const float r = radius_of(a, x, y);
        if (r < 0 && may_reach(a, &pixel, r)) {
            hint_at(a, x, y);
            return true;
        }
    }
    return false;
}

/* The near surfaces of a block; of one without edges as a whole. False where a ray may
 * come to the limit. */
static bool take_block(struct asking *a, int bx, int by)
{
    const struct rf_hidden_facts *block = &a->s->blocks[by * a->s->n_x + bx];
    const struct box all = block_of(a, bx, by);
    const float lowest = block->lowest + a->shift;
    if (!(lowest < 0) || !may_reach(a, &all, lowest))
        return true;
    if (!a->s->edges[by * a->s->n_x + bx].bits) {
        a->lowest = rf_min_float(lowest, a->lowest);
        return block->highest + a->shift < a->limit;
    }
    for (int i = 0; i < RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK; i++) {
        const int x = bx * RF_HIDDEN_BLOCK + i % RF_HIDDEN_BLOCK;
        const int y = by * RF_HIDDEN_BLOCK + i / RF_HIDDEN_BLOCK;
        if (x >= a->s->width || y >= a->s->height)
            continue;
        const struct box pixel = pixel_of(a, x, y);
        const float r = radius_of(a, x, y);
        if (!(r < 0) || !may_reach(a, &pixel, r))
            continue;
        if (r >= a->limit) {
            hint_at(a, x, y);
            return false;
        }
        a->lowest = rf_min_float(r, a->lowest);
    }
    return true;
}

/* Blocks from (x0, y0) to (x1, y1). */
struct blocks {
    int x0, y0, x1, y1;
};

static struct blocks blocks_within(const struct asking *a, int n)
{
    const struct rf_insides *s = a->s;
    return (struct blocks){rf_max_int(a->x - n, 0) / RF_HIDDEN_BLOCK,
                           rf_max_int(a->y - n, 0) / RF_HIDDEN_BLOCK,
                           rf_min_int((a->x + n) / RF_HIDDEN_BLOCK, s->n_x - 1),
                           rf_min_int((a->y + n) / RF_HIDDEN_BLOCK, s->n_y - 1)};
}

/* Do the rays come to the limit at the hint? As the search within `reach` would find. */
static bool is_hint_right(const struct asking *a, float reach)
{
    const struct rf_inside_hint *hint = a->hint;
    const struct blocks near = blocks_within(a, (int)reach + 1);
    const int bx = hint->x / RF_HIDDEN_BLOCK, by = hint->y / RF_HIDDEN_BLOCK;
    if (!hint->is_known || bx < near.x0 || bx > near.x1 || by < near.y0 || by > near.y1)
        return false;
    const int i =
        hint->y % RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK + hint->x % RF_HIDDEN_BLOCK;
    const struct box pixel = pixel_of(a, hint->x, hint->y);
    const float r = radius_of(a, hint->x, hint->y);
    return r < 0 && may_reach(a, &pixel, r) &&
           (r >= a->limit || a->s->edges[by * a->s->n_x + bx].bits >> i & 1);
}

/* Do all rays meet something before the limit, of what lies within `reach`? */
static bool are_met(struct asking *a, float reach)
{
    const struct rf_insides *s = a->s;
    const int n = (int)reach + 1;
    const int least = s->border > 0 ? s->border + n : 0;
    if (rf_min_int(a->x, a->y) < least || a->x >= s->width - least ||
        a->y >= s->height - least)
        return false;
    const struct blocks near = blocks_within(a, n);
    a->lowest = INFINITY;
    for (int by = near.y0; by <= near.y1; by++)
        for (int bx = near.x0; bx <= near.x1; bx++)
            if (has_passage(a, bx, by) || !take_block(a, bx, by))
                return false;
    return true;
}

bool rf_inside_is_met(const struct rf_insides *s, float shift, int x, int y, float r,
                      struct rf_inside_hint *hint)
{
    struct asking a = {s, shift, x, y, rf_min_float(r, 0), INFINITY, hint};
    const int bx = x / RF_HIDDEN_BLOCK, by = y / RF_HIDDEN_BLOCK;
    float reach = MORE * reach_at(&a, radius_of(&a, x, y));
    if (is_hint_right(&a, reach) || has_passage(&a, bx, by) || !take_block(&a, bx, by))
        return false;
    for (int tries = 0; tries < 3; tries++) {
        if (!(reach <= MOST_REACH * RF_HIDDEN_BLOCK) || !are_met(&a, reach))
            return false;
        if (reach_at(&a, a.lowest) <= reach)
            return true;
        reach = MORE * reach_at(&a, a.lowest);
    }
    return false;
}
