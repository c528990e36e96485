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

/* Near pixels that ask, and what is found around them. */
struct asking {
    const struct rf_insides *s;
    float shift;        /* of all radii, px */
    int x0, y0, x1, y1; /* the first and the last pixel; in one block */
    float limit;        /* radius, at most 0, below which rays are to meet something */
    float lowest;       /* radius of what they may meet */
    struct rf_inside_hint *hint;
};

static float squared(float v)
{
    return v * v;
}

/* How far a ray is from its pixel at the depth of radius r, and half a pixel more. */
static float reach_at(const struct asking *a, float r)
{
    return fabsf(r) * a->s->reach.most + EDGE_PX;
}

/* Pixels from (x0, y0) to (x1, y1), seen from those that ask: wherever one of them may
 * see one. */
struct box {
    float x0, y0, x1, y1;
};

static struct box box_of(const struct asking *a, int x, int y, int size)
{
    return (struct box){(float)(x - a->x1), (float)(y - a->y1),
                        (float)(x + size - 1 - a->x0), (float)(y + size - 1 - a->y0)};
}

static struct box pixel_of(const struct asking *a, int x, int y)
{
    return box_of(a, x, y, 1);
}

static struct box block_of(const struct asking *a, int bx, int by)
{
    return box_of(a, bx * RF_HIDDEN_BLOCK, by * RF_HIDDEN_BLOCK, RF_HIDDEN_BLOCK);
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

/* Where rays are at a depth, along those directions. */
static struct spans rays_at(const struct rf_reach *reach, float r)
{
    struct spans rays;
    for (int k = 0; k < 4; k++) {
        rays.from[k] = -r * reach->from[k] - ALONG_PX[k];
        rays.to[k] = -r * reach->to[k] + ALONG_PX[k];
    }
    return rays;
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

/* The near surfaces of a block that do not end there. False where a ray may come to the
 * limit. */
static bool take_pixels(struct asking *a, int bx, int by)
{
    const uint64_t edges = a->s->edges[by * a->s->n_x + bx].bits;
    for (int i = 0; i < RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK; i++) {
        const int x = bx * RF_HIDDEN_BLOCK + i % RF_HIDDEN_BLOCK;
        const int y = by * RF_HIDDEN_BLOCK + i / RF_HIDDEN_BLOCK;
        if (edges >> i & 1 || x >= a->s->width || y >= a->s->height)
            continue;
        const struct box pixel = pixel_of(a, x, y);
        const float r = radius_of(a, x, y);
        if (!(r < 0) || (r < a->limit && r >= a->lowest) || !may_reach(a, &pixel, r))
            continue;
        if (r >= a->limit) {
            hint_at(a, x, y);
            return false;
        }
        a->lowest = r;
    }
    return true;
}

/* The near surfaces of a block; of one without edges as a whole. False where a ray may
 * pass an edge or come to the limit. */
static bool take_block(struct asking *a, int bx, int by)
{
    const struct rf_hidden_facts *block = &a->s->blocks[by * a->s->n_x + bx];
    const bool has_edges = a->s->edges[by * a->s->n_x + bx].bits != 0;
    const float lowest = block->lowest + a->shift;
    const bool is_met = block->highest + a->shift < a->limit;
    if (!(lowest < 0) || (!has_edges && is_met && lowest >= a->lowest))
        return true; /* nothing that is not known */
    const struct box all = block_of(a, bx, by);
    if (!may_reach(a, &all, lowest))
        return true;
    if (has_edges)
        return !has_passage(a, bx, by) && take_pixels(a, bx, by);
    a->lowest = rf_min_float(lowest, a->lowest);
    return is_met;
}

/* Pixels looked at to each side for what lies within `reach`. */
static int pixels_within(float reach)
{
    return (int)reach + 1;
}

/* So many pixels along the picture's sides see beyond what was taken. */
static int margin_of(const struct rf_insides *s, float reach)
{
    return s->border > 0 ? s->border + pixels_within(reach) : 0;
}

/* Do all rays meet something before the limit, of what lies within `reach`? */
static bool are_met(struct asking *a, float reach)
{
    const struct rf_insides *s = a->s;
    const int n = pixels_within(reach), least = margin_of(s, reach);
    if (rf_min_int(a->x0, a->y0) < least || a->x1 >= s->width - least ||
        a->y1 >= s->height - least)
        return false;
    const int bx0 = rf_max_int(a->x0 - n, 0) / RF_HIDDEN_BLOCK;
    const int by0 = rf_max_int(a->y0 - n, 0) / RF_HIDDEN_BLOCK;
    const int bx1 = rf_min_int((a->x1 + n) / RF_HIDDEN_BLOCK, s->n_x - 1);
    const int by1 = rf_min_int((a->y1 + n) / RF_HIDDEN_BLOCK, s->n_y - 1);
    a->lowest = INFINITY;
    for (int by = by0; by <= by1; by++)
        for (int bx = bx0; bx <= bx1; bx++)
            if (!take_block(a, bx, by))
                return false;
    return true;
}

/* May something of their own block be met, and nothing of it be passed? Most that ask
 * in vain learn it there. */
static bool begins_well(struct asking *a)
{
    return take_block(a, a->x0 / RF_HIDDEN_BLOCK, a->y0 / RF_HIDDEN_BLOCK);
}

/* Of one pixel: have its rays met something before the limit? */
static bool is_pixel_met(struct asking *a)
{
    float reach = MORE * reach_at(a, radius_of(a, a->x0, a->y0));
    if (!begins_well(a))
        return false;
    for (int tries = 0; tries < 3; tries++) {
        if (!(reach <= MOST_REACH * RF_HIDDEN_BLOCK) || !are_met(a, reach))
            return false;
        if (reach_at(a, a->lowest) <= reach)
            return true;
        reach = MORE * reach_at(a, a->lowest);
    }
    return false;
}

/* Of several: true only if each of them would be told so at its first try. */
static bool is_box_met(struct asking *a, float lowest, float highest)
{
    const float reach = MORE * reach_at(a, lowest);
    return reach <= MOST_REACH * RF_HIDDEN_BLOCK && begins_well(a) &&
           are_met(a, reach) && reach_at(a, a->lowest) <= MORE * reach_at(a, highest);
}

/* ---- pixels of a block ------------------------------------------------------------ */

enum { ALL_COLUMNS = 255 };

/* The columns of a row whose rays come to the hint, and whose search would look there. */
static int hinted_columns(const struct asking *a, const struct spans *rays,
                          float most_2, int x0, int y)
{
    static const int bit[RF_HIDDEN_BLOCK] = {1, 2, 4, 8, 16, 32, 64, 128};
    const float *radius = a->s->radius + a->s->stride * (size_t)y + x0;
    const int hx = a->hint->x / RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK;
    const int hy = a->hint->y / RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK;
    const float dy = (float)(a->hint->y - y);
    const int away_y = rf_max_int(y - hy - (RF_HIDDEN_BLOCK - 1), hy - y) - 1;
    int columns = 0;
    for (int i = 0; i < RF_HIDDEN_BLOCK; i++) {
        const int x = x0 + i;
        const float dx = (float)(a->hint->x - x), right = dx - dy, left = dx + dy;
        const int away_x = rf_max_int(x - hx - (RF_HIDDEN_BLOCK - 1), hx - x) - 1;
        const float away = (float)rf_max_int(away_x, away_y);
        const int comes =
            (dx * dx + dy * dy < most_2) & (dx > rays->from[0]) & (dx < rays->to[0]) &
            (right > rays->from[2]) & (right < rays->to[2]) & (left > rays->from[3]) &
            (left < rays->to[3]) & (MORE * reach_at(a, radius[i] + a->shift) >= away);
        columns |= -comes & bit[i];
    }
    return -dy > rays->from[1] && -dy < rays->to[1] ? columns : 0;
}

uint64_t rf_inside_drop_hinted(const struct rf_insides *s, float shift, int bx, int by,
                               uint64_t asking, float r, struct rf_inside_hint *hint)
{
    if (!hint->is_known)
        return asking;
    const struct asking a = {.s = s, .shift = shift, .hint = hint};
    const int hx = hint->x / RF_HIDDEN_BLOCK, hy = hint->y / RF_HIDDEN_BLOCK;
    const int i =
        hint->y % RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK + hint->x % RF_HIDDEN_BLOCK;
    const float at = radius_of(&a, hint->x, hint->y);
    if (!(at < 0) ||
        !(at >= rf_min_float(r, 0) || s->edges[hy * s->n_x + hx].bits >> i & 1))
        return asking;
    const struct spans rays = rays_at(&s->reach, at);
    const float most_2 = squared(reach_at(&a, at));
    for (int y = 0; y < RF_HIDDEN_BLOCK; y++)
        if (asking >> RF_HIDDEN_BLOCK * y & ALL_COLUMNS)
            asking &=
                ~((uint64_t)hinted_columns(&a, &rays, most_2, bx * RF_HIDDEN_BLOCK,
                                           by * RF_HIDDEN_BLOCK + y)
                  << RF_HIDDEN_BLOCK * y);
    return asking;
}

uint64_t rf_inside_may_be_met(const struct rf_insides *s, float shift, int bx, int by,
                              float r)
{
    const uint64_t edges = s->edges[by * s->n_x + bx].bits;
    for (int k = 0; k < 4; k++)
        if (!(s->reach.from[k] <= 0 && s->reach.to[k] >= 0))
            return UINT64_MAX;
    if (edges || s->blocks[by * s->n_x + bx].highest + shift < rf_min_float(r, 0))
        return ~edges;
    return 0;
}

/* The radii of pixels of a block. */
struct radii {
    float lowest, highest;
};

static struct radii radii_of(const struct asking *a, int bx, int by, uint64_t bits)
{
    const struct rf_hidden_facts *block = &a->s->blocks[by * a->s->n_x + bx];
    struct radii radii = {block->lowest + a->shift, block->highest + a->shift};
    if (!a->s->edges[by * a->s->n_x + bx].bits)
        return radii;
    radii = (struct radii){INFINITY, -INFINITY};
    for (; bits; bits &= bits - 1) {
        const int i = __builtin_ctzll(bits);
        const float r = radius_of(a, bx * RF_HIDDEN_BLOCK + i % RF_HIDDEN_BLOCK,
                                  by * RF_HIDDEN_BLOCK + i / RF_HIDDEN_BLOCK);
        radii.lowest = rf_min_float(r, radii.lowest);
        radii.highest = rf_max_float(r, radii.highest);
    }
    return radii;
}

/* Around the pixels of some bits. */
static void set_box(struct asking *a, int bx, int by, uint64_t bits)
{
    uint64_t columns = bits | bits >> 32;
    columns |= columns >> 16;
    columns = (columns | columns >> 8) & ALL_COLUMNS;
    a->x0 = bx * RF_HIDDEN_BLOCK + __builtin_ctzll(columns);
    a->x1 = bx * RF_HIDDEN_BLOCK + 63 - __builtin_clzll(columns);
    a->y0 = by * RF_HIDDEN_BLOCK + __builtin_ctzll(bits) / RF_HIDDEN_BLOCK;
    a->y1 = by * RF_HIDDEN_BLOCK + (63 - __builtin_clzll(bits)) / RF_HIDDEN_BLOCK;
}

/* The half of a block that a box is cut by, across its longer side. */
static uint64_t half_of(const struct asking *a)
{
    if (a->y1 - a->y0 >= a->x1 - a->x0) {
        const int rows = (a->y0 + a->y1) / 2 % RF_HIDDEN_BLOCK + 1;
        return ((uint64_t)1 << RF_HIDDEN_BLOCK * rows) - 1;
    }
    const int columns = (a->x0 + a->x1) / 2 % RF_HIDDEN_BLOCK + 1;
    return (((uint64_t)1 << columns) - 1) * (UINT64_MAX / ALL_COLUMNS);
}

/* Those of n pixels that a new hint leaves; `known` is the one that they know. */
static uint64_t drop_if_new(const struct asking *a, int bx, int by, uint64_t asking,
                            struct rf_inside_hint *known)
{
    const struct rf_inside_hint *hint = a->hint;
    if (!asking || (hint->x == known->x && hint->y == known->y &&
                    hint->is_known == known->is_known))
        return asking;
    *known = *hint;
    return rf_inside_drop_hinted(a->s, a->shift, bx, by, asking, a->limit, a->hint);
}

/* The pixels of a block but for a margin along the picture's sides. */
static uint64_t inner_pixels(const struct rf_insides *s, int bx, int by, int margin)
{
    const int x0 = margin - bx * RF_HIDDEN_BLOCK, y0 = margin - by * RF_HIDDEN_BLOCK;
    const int x1 = s->width - x0 - 2 * bx * RF_HIDDEN_BLOCK;
    const int y1 = s->height - y0 - 2 * by * RF_HIDDEN_BLOCK;
    uint64_t inner = 0;
    int columns = 0;
    for (int i = 0; i < RF_HIDDEN_BLOCK; i++)
        columns |= (i >= x0 && i < x1) << i;
    for (int i = 0; i < RF_HIDDEN_BLOCK; i++)
        if (i >= y0 && i < y1)
            inner |= (uint64_t)columns << RF_HIDDEN_BLOCK * i;
    return inner;
}

static uint64_t find_met(struct asking *a, int bx, int by, uint64_t asking)
{
    struct rf_inside_hint known = *a->hint;
    if (!asking)
        return 0;
    set_box(a, bx, by, asking);
    a->lowest = INFINITY;
    if (!(asking & (asking - 1)))
        return is_pixel_met(a) ? asking : 0;
    const struct radii radii = radii_of(a, bx, by, asking);
    if (is_box_met(a, radii.lowest, radii.highest))
        return asking;
    const uint64_t half = half_of(a);
    asking = drop_if_new(a, bx, by, asking, &known);
    const uint64_t met = find_met(a, bx, by, asking & half);
    const uint64_t rest = drop_if_new(a, bx, by, asking & ~half, &known);
    return met | find_met(a, bx, by, rest);
}

uint64_t rf_inside_find_met(const struct rf_insides *s, float shift, int bx, int by,
                            uint64_t asking, float r, struct rf_inside_hint *hint)
{
    struct asking a = {
        .s = s, .shift = shift, .limit = rf_min_float(r, 0), .hint = hint};
    const struct radii radii = radii_of(&a, bx, by, asking);
    const float reach = MORE * reach_at(&a, rf_min_float(radii.highest, 0));
    if (s->border > 0 && reach <= MOST_REACH * RF_HIDDEN_BLOCK)
        asking &= inner_pixels(s, bx, by, margin_of(s, reach));
    return find_met(&a, bx, by, asking);
}
