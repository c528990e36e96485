/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which of several views sees what. Blocks of 8 x 8 pixels know the range of their
 * radii, so most of a picture is known to be seen by all views without a look at its
 * pixels; where they slant, the planes that they fit tell.
 */
#include "methods/views/views_sight.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/emit.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "kernels/sight_kernels.h"
#include "methods/views/merge.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

enum { BLOCK = RF_SIGHT_BLOCK };

/* ---- blocks -------------------------------------------------------------------- */

/* Which other views may see a part of a block only, and which see nothing of it. */
struct doubt {
    uint64_t partly, blind; /* bit j: view j */
};

/*
 * In which cells a view is listed for what another one does not see, and in which order
 * to ask: first those that rule out most.
 */
struct say {
    uint32_t cells[RF_MAX_VIEWS]; /* per view: not in these where it sees the place */
    int order[RF_MAX_VIEWS];      /* all other views */
};

/* Blocks of a picture, to the right and down. */
struct box {
    int first[2], end[2];
};

/* The blocks of all views. */
struct blocks {
    struct rf_views *v;
    const struct rf_kernels *kernels;
    int n_x, n_y, n_failed;
    struct box shown, rendered; /* of each view: in part, whole */
    /* Of its radii: the plane that they lie on, and how far they lie off it. */
    struct rf_sight_plane *at;
    struct doubt *doubts;
    struct say *says; /* per view */
};

static size_t block_index(const struct blocks *b, int view, int x, int y)
{
    return ((size_t)view * (size_t)b->n_y + (size_t)y) * (size_t)b->n_x + (size_t)x;
}

/* A bit for each of eight pixels from i on that is mixed. */
static unsigned mixed_bits(const struct rf_surfaces *s, size_t i)
{
    uint64_t bits = s->mixed[i / 64].bits >> i % 64;
    if (i % 64 > 64 - BLOCK)
        bits |= s->mixed[i / 64 + 1].bits << (64 - i % 64);
    return (unsigned)bits & ((1u << BLOCK) - 1);
}

static bool is_inside(const struct rf_surfaces *s, int bx, int by)
{
    return (bx + 1) * BLOCK <= s->width && (by + 1) * BLOCK <= s->height;
}

/* Are all pixels of a block within the picture of one surface each? */
static bool is_pure_block(const struct rf_surfaces *s, int bx, int by)
{
    unsigned mixed = 0;
    for (int y = by * BLOCK; y < (by + 1) * BLOCK; y++)
        mixed |= mixed_bits(s, (size_t)y * (size_t)s->width + (size_t)bx * BLOCK);
    return !mixed;
}

/* Least and greatest radius of the parts of pixel i. */
static void load_pixel(const struct rf_surfaces *s, size_t i, float *low, float *high)
{
    const struct rf_surface *back = s->share[i] < 1 ? rf_far_at(s, i) : &s->near[i];
    float far = back->r, near = s->share[i] > 0 ? s->near[i].r : far;
    *low = rf_min_float(near, far);
    *high = rf_max_float(near, far);
}

/* The radii of a block's pixels; what lies outside repeats the edge. */
static void load_edge(const struct rf_surfaces *s, int bx, int by, float *low,
                      float *high)
{
    for (int y = 0; y < BLOCK; y++)
        for (int x = 0; x < BLOCK; x++) {
            size_t row = (size_t)rf_min_int(by * BLOCK + y, s->height - 1);
            size_t i = row * (size_t)s->width +
                       (size_t)rf_min_int(bx * BLOCK + x, s->width - 1);
            load_pixel(s, i, &low[y * BLOCK + x], &high[y * BLOCK + x]);
        }
}

/* The same within the picture, from rows of the plane of near radii. */
static void load_mixed(const struct rf_surfaces *s, const float *radius, size_t stride,
                       int bx, int by, float *low, float *high)
{
    for (int y = 0; y < BLOCK; y++, low += BLOCK, high += BLOCK, radius += stride) {
        size_t i = (size_t)(by * BLOCK + y) * (size_t)s->width + (size_t)bx * BLOCK;
        memcpy(low, radius, BLOCK * sizeof *low);
        memcpy(high, radius, BLOCK * sizeof *high);
        for (unsigned mixed = mixed_bits(s, i); mixed; mixed &= mixed - 1) {
            int x = __builtin_ctz(mixed);
            load_pixel(s, i + (size_t)x, &low[x], &high[x]);
        }
    }
}

static void measure_block(const struct blocks *b, int view, int bx, int by)
{
    static const float LEVEL_PX = 0.05f; /* the steps of the radius need no more */
    const struct rf_picture *picture = &b->v->pictures[view];
    const struct rf_sight *sight = &b->v->sights[view];
    struct rf_sight_plane *plane = &b->at[block_index(b, view, bx, by)];
    const struct rf_surfaces *s = &picture->surfaces;
    const float *r =
        sight->radius + sight->stride * (size_t)by * BLOCK + (size_t)bx * BLOCK;
    float low[BLOCK * BLOCK], high[BLOCK * BLOCK];
    if (!is_inside(s, bx, by)) {
        load_edge(s, bx, by, low, high);
    } else if (is_pure_block(s, bx, by)) {
        b->kernels->fit_plane(r, r, sight->stride, LEVEL_PX, plane);
        return;
    } else {
        load_mixed(s, r, sight->stride, bx, by, low, high);
    }
    b->kernels->fit_plane(low, high, BLOCK, LEVEL_PX, plane);
}

static void measure_blocks(const struct blocks *b, int view, int by)
{
    for (int bx = 0; bx < b->n_x; bx++)
        measure_block(b, view, bx, by);
}

/* How view j shifts what view `view` shows: px per px of radius, and px. */
struct parallax {
    float slope[2], base[2];
};

static struct parallax parallax_of(const struct rf_views *v, int view, int j)
{
    const struct rf_work_view *from = &v->work->views[view], *to = &v->work->views[j];
    struct parallax p;
    for (int k = 0; k < 2; k++) {
        float sign = k ? -1 : 1;
        p.slope[k] =
            sign * (to->lens[k] * to->shift_scale - from->lens[k] * from->shift_scale);
        p.base[k] =
            sign * (to->lens[k] * to->shift_bias - from->lens[k] * from->shift_bias);
    }
    return p;
}

/*
 * Does nothing in block (x, y) of another view hide a block, as the planes of both
 * tell? `block` is block (bx, by) of its own view. Where the one is at x, of radius r,
 * the other one is looked at within a pixel of x + slope r + base.
 */
static bool is_behind(const struct rf_sight_plane *other, int x, int y,
                      const struct rf_sight_plane *block, int bx, int by,
                      const struct parallax *p)
{
    static const float ROUNDED_PX = 0.54f; /* the pixel, and snapping */
    const float *g = other->slope;
    float to_x = (float)((bx - x) * BLOCK) + p->base[0];
    float to_y = (float)((by - y) * BLOCK) + p->base[1];
    /* Of what lies before the block, per px of the block's radius and per px. */
    float per_r = g[0] * p->slope[0] + g[1] * p->slope[1] - 1;
    float middle = other->level + g[0] * to_x + g[1] * to_y + per_r * block->level;
    float along_x = fabsf(g[0] + per_r * block->slope[0]);
    float along_y = fabsf(g[1] + per_r * block->slope[1]);
    float least = middle - 0.5f * (BLOCK - 1) * (along_x + along_y) -
                  ROUNDED_PX * (fabsf(g[0]) + fabsf(g[1])) - other->rough -
                  fabsf(per_r) * block->rough;
    return least > -0.95f * RF_OCCLUDED_PX;
}

/* The blocks of which some or all pixels were rendered, in any view. */
static void find_boxes(struct blocks *b)
{
    const struct rf_picture *picture = &b->v->pictures[0];
    const int x0[2] = {picture->x0, picture->y0},
              size[2] = {picture->width, picture->height};
    const int rendered[2] = {picture->frame->width, picture->frame->height};
    for (int k = 0; k < 2; k++) {
        int x1 = x0[k] + rendered[k], n = (size[k] + BLOCK - 1) / BLOCK;
        b->shown.first[k] = x0[k] / BLOCK;
        b->shown.end[k] = (x1 + BLOCK - 1) / BLOCK;
        b->rendered.first[k] = (x0[k] + BLOCK - 1) / BLOCK;
        b->rendered.end[k] = x1 == size[k] ? n : x1 / BLOCK;
    }
}

static bool is_shown(const struct blocks *b, int bx, int by)
{
    const struct box *shown = &b->shown;
    return bx >= shown->first[0] && bx < shown->end[0] && by >= shown->first[1] &&
           by < shown->end[1];
}

enum sight { SEES_NOTHING, SEES_A_PART, SEES_ALL };

/* What a view surely sees of what lies in a box, if nothing in there hides it. */
static enum sight sight_in(const struct blocks *b, const struct box *box)
{
    bool is_rendered = true;
    for (int k = 0; k < 2; k++) {
        if (box->first[k] >= b->shown.end[k] || box->end[k] <= b->shown.first[k])
            return SEES_NOTHING;
        is_rendered &=
            box->first[k] >= b->rendered.first[k] && box->end[k] <= b->rendered.end[k];
    }
    return is_rendered ? SEES_ALL : SEES_A_PART;
}

/* What view j surely sees of all that a block of another view shows. */
static enum sight sight_of(const struct blocks *b, int view, int bx, int by, int j,
                           const struct parallax *parallax)
{
    static const float SNAPPED_PX = 0.04f;
    const struct rf_picture *picture = &b->v->pictures[j];
    const struct rf_sight_plane *block = &b->at[block_index(b, view, bx, by)];
    const int at[2] = {bx * BLOCK, by * BLOCK},
              size[2] = {picture->width, picture->height};
    struct box box; /* of view j, that it may lie in */
    for (int k = 0; k < 2; k++) {
        float a = parallax->slope[k] * block->lowest;
        float z = parallax->slope[k] * block->highest;
        float from = (float)at[k] + parallax->base[k] - SNAPPED_PX;
        float to = (float)at[k] + parallax->base[k] + BLOCK + SNAPPED_PX;
        from += rf_min_float(a, z);
        to += rf_max_float(a, z);
        if (!(from >= 0 && to < (float)size[k]))
            return SEES_A_PART;
        box.first[k] = (int)from / BLOCK;
        box.end[k] = (int)to / BLOCK + 1;
    }
    enum sight sight = sight_in(b, &box);
    if (sight != SEES_ALL)
        return sight;
    float least = block->highest - RF_OCCLUDED_PX;
    for (int y = box.first[1]; y < box.end[1]; y++) {
        const struct rf_sight_plane *row = &b->at[block_index(b, j, 0, y)];
        for (int x = box.first[0]; x < box.end[0]; x++)
            if (row[x].lowest < least &&
                !is_behind(&row[x], x, y, block, bx, by, parallax))
                return SEES_A_PART;
    }
    return SEES_ALL;
}

/*
 * Which views have a say: a view stands for what a cell's own views do not see, but not
 * where one that is nearer shows it. The mean of two is better by 0.02 dB at the most,
 * that of all by less than that again, and they are as many samples more.
 */
static struct say say_of(const struct rf_views *v, int view)
{
    struct say say;
    int n_cells[RF_MAX_VIEWS], n = 0;
    for (int j = 0; j < v->work->n_views; j++) {
        say.cells[j] = 0;
        for (int i = 0; i < v->n_cells; i++) {
            const struct rf_cell_views *cell = &v->cells[i];
            say.cells[j] |= (uint32_t)((cell->own | cell->nearer[view]) >> j & 1) << i;
        }
        if (j == view)
            continue;
        int rules_out = __builtin_popcount(say.cells[j]), k = n++;
        for (; k > 0 && n_cells[k - 1] < rules_out; k--) {
            n_cells[k] = n_cells[k - 1];
            say.order[k] = say.order[k - 1];
        }
        n_cells[k] = rules_out;
        say.order[k] = j;
    }
    return say;
}

/* The cells that the view itself leaves. */
static uint32_t cells_beside(const struct rf_views *v, const struct say *say, int view)
{
    return (((uint32_t)1 << v->n_cells) - 1) & ~say->cells[view];
}

/* What may be listed of a block: none where the views that surely see it leave no
 * cell. */
static struct doubt doubt_of(const struct blocks *b, int view, int bx, int by,
                             const struct parallax *parallax)
{
    const struct say *say = &b->says[view];
    uint32_t cells = cells_beside(b->v, say, view);
    struct doubt doubt = {0, 0};
    for (int i = 0; i < b->v->work->n_views - 1; i++) {
        int j = say->order[i];
        enum sight sight = sight_of(b, view, bx, by, j, &parallax[j]);
        doubt.partly |= (uint64_t)(sight == SEES_A_PART) << j;
        doubt.blind |= (uint64_t)(sight == SEES_NOTHING) << j;
        if (sight == SEES_ALL)
            cells &= ~say->cells[j];
        if (!cells)
            return (struct doubt){0, 0};
    }
    return doubt;
}

/* What continues a picture has no doubts, as it is not listed. */
static void find_doubts(const struct blocks *b, int view, int by)
{
    struct doubt *row = &b->doubts[block_index(b, view, 0, by)];
    struct parallax parallax[RF_MAX_VIEWS];
    memset(row, 0, (size_t)b->n_x * sizeof *row);
    for (int j = 0; j < b->v->work->n_views; j++)
        parallax[j] = parallax_of(b->v, view, j);
    for (int bx = 0; bx < b->n_x; bx++)
        if (is_shown(b, bx, by))
            row[bx] = doubt_of(b, view, bx, by, parallax);
}

/* ---- rows ---------------------------------------------------------------------- */

/*
 * The parts of a row of a block: of each pixel the near one, the far one, or both.
 * Pixels of one surface each are parts from x[0] on, of which no more is noted.
 */
struct parts {
    int n;
    bool are_pure;
    int x[RF_SIGHT_PARTS];
    bool is_far[RF_SIGHT_PARTS];
    float share[RF_SIGHT_PARTS];
    struct rf_sight_places places;
    unsigned listed[RF_MOST_CELLS]; /* per cell: bit i, part i */
};

/* The parts of pixels x0 to x1 - 1 of a row that has mixed ones. */
static void add_parts(const struct rf_surfaces *s, int x0, int x1, int y,
                      struct parts *parts)
{
    memset(&parts->places, 0, sizeof parts->places);
    for (int x = x0; x < x1; x++) {
        size_t i = (size_t)y * (size_t)s->width + (size_t)x;
        const float shares[2] = {s->share[i], 1 - s->share[i]};
        for (int k = 0; k < 2; k++)
            if (shares[k] > 0) {
                int n = parts->n++;
                parts->x[n] = x;
                parts->is_far[n] = k;
                parts->share[n] = shares[k];
                parts->places.x[n] = (float)x + 0.5f;
                parts->places.y[n] = (float)y + 0.5f;
                parts->places.r[n] = k ? rf_far_at(s, i)->r : s->near[i].r;
            }
    }
}

/* The rendered pixels of row y of a block. */
static void find_parts(const struct blocks *b, int view, int bx, int y,
                       struct parts *parts)
{
    const struct rf_picture *picture = &b->v->pictures[view];
    const struct rf_sight *sight = &b->v->sights[view];
    int x0 = rf_max_int(bx * BLOCK, sight->x0);
    int x1 = rf_min_int((bx + 1) * BLOCK, sight->x1);
    size_t i = (size_t)y * (size_t)picture->width + (size_t)x0;
    parts->are_pure = x1 - x0 == BLOCK && !mixed_bits(&picture->surfaces, i);
    if (parts->are_pure) {
        parts->n = BLOCK;
        parts->x[0] = x0;
        b->kernels->place_row(sight, x0, y, &parts->places);
        return;
    }
    parts->n = 0;
    add_parts(&picture->surfaces, x0, x1, y, parts);
    b->kernels->place_parts(sight, parts->n, &parts->places);
}

/* Does a view that shows so much of a place not see it? */
static bool is_blind(float seen)
{
    return seen < 0.5f;
}

/* Which parts view j sees: bit i, part i. */
static unsigned look_at_parts(const struct blocks *b, int j, const struct parts *parts)
{
    const struct rf_picture *picture = &b->v->pictures[j];
    const struct rf_surfaces *s = &picture->surfaces;
    struct rf_sight_found found;
    b->kernels->look_for_parts(&b->v->sights[j], &parts->places, parts->n,
                               RF_OCCLUDED_PX, &found);
    unsigned seen = found.clear;
    for (unsigned left = found.rendered & ~seen; left; left &= left - 1) {
        int k = __builtin_ctz(left), x = found.x[k], y = found.y[k];
        size_t i = (size_t)y * (size_t)s->width + (size_t)x;
        if (rf_is_mixed(s, i) &&
            !is_blind(rf_view_pixel_sees(picture, x, y, parts->places.r[k])))
            seen |= 1u << k;
    }
    return seen;
}

/* Of some cells, those in which a part is listed. */
static uint32_t cells_in_use(const struct parts *parts, uint32_t cells)
{
    uint32_t used = 0;
    for (; cells; cells &= cells - 1) {
        int i = __builtin_ctz(cells);
        used |= (uint32_t)(parts->listed[i] != 0) << i;
    }
    return used;
}

/* Finds in which cells the parts are listed; returns those cells. */
static uint32_t find_cells(const struct blocks *b, int view, const struct doubt *doubt,
                           struct parts *parts)
{
    const struct rf_views *v = b->v;
    const struct say *say = &b->says[view];
    uint32_t all = cells_beside(v, say, view);
    for (int i = 0; i < v->work->n_views - 1; i++)
        if (!((doubt->partly | doubt->blind) >> say->order[i] & 1))
            all &= ~say->cells[say->order[i]];
    for (int i = 0; i < v->n_cells; i++)
        parts->listed[i] = all >> i & 1 ? (1u << parts->n) - 1 : 0;
    all = cells_in_use(parts, all);
    for (int k = 0; k < v->work->n_views - 1 && all; k++) {
        int j = say->order[k];
        uint32_t cells = say->cells[j] & all;
        if (!(doubt->partly >> j & 1) || !cells)
            continue;
        unsigned seen = look_at_parts(b, j, parts);
        for (uint32_t left = cells; left; left &= left - 1)
            parts->listed[__builtin_ctz(left)] &= ~seen;
        all = (all & ~cells) | cells_in_use(parts, cells);
    }
    return all;
}

/* What is listed of a row so far, for each cell. */
struct row_lists {
    struct rf_unseen *at[RF_MOST_CELLS];
    int n[RF_MOST_CELLS], n_bright[RF_MOST_CELLS];
};

static struct rf_unseen unseen_of(const struct rf_picture *picture, int y,
                                  const struct parts *parts, int i)
{
    const struct rf_surfaces *s = &picture->surfaces;
    if (parts->are_pure) {
        int x = parts->x[0] + i;
        const struct rf_surface *near =
            &s->near[(size_t)y * (size_t)picture->width + (size_t)x];
        /* Most need no look at their colour. */
        bool is_bright = rf_picture_may_be_bright(picture, x, y) &&
                         rf_picture_is_bright(picture, near, x, y);
        return (struct rf_unseen){.part = 4 * x + 2 * is_bright, .weight = 1};
    }
    int x = parts->x[i], is_far = parts->is_far[i];
    size_t pixel = (size_t)y * (size_t)picture->width + (size_t)x;
    const struct rf_surface *surface = is_far ? rf_far_at(s, pixel) : &s->near[pixel];
    return (struct rf_unseen){
        .part = 4 * x + 2 * rf_picture_is_bright(picture, surface, x, y) + is_far,
        .weight = is_far ? rf_min_float(1, 2 * parts->share[i]) : parts->share[i]};
}

/*
 * Lists what some views do not see of a row of a block. Those that surely see it have
 * no say in how sums are rounded.
 */
static void list_block(const struct blocks *b, int view, int bx, int y,
                       const struct doubt *doubt, struct row_lists *lists)
{
    const struct rf_views *v = b->v;
    struct parts parts;
    struct rf_unseen unseen[RF_SIGHT_PARTS];
    find_parts(b, view, bx, y, &parts);
    uint32_t all = find_cells(b, view, doubt, &parts);
    unsigned any = 0, bright = 0;
    for (uint32_t left = all; left; left &= left - 1)
        any |= parts.listed[__builtin_ctz(left)];
    for (; any; any &= any - 1) {
        int i = __builtin_ctz(any);
        unseen[i] = unseen_of(&v->pictures[view], y, &parts, i);
        bright |= (unsigned)(unseen[i].part >> 1 & 1) << i;
    }
    for (uint32_t left = all; left; left &= left - 1) {
        int cell = __builtin_ctz(left), n = lists->n[cell];
        unsigned listed = parts.listed[cell];
        lists->n_bright[cell] += __builtin_popcount(listed & bright);
        for (; listed; listed &= listed - 1)
            lists->at[cell][n++] = unseen[__builtin_ctz(listed)];
        lists->n[cell] = n;
    }
}

/* The lists of a row, one after the other; false: out of memory. */
static bool keep_lists(const struct rf_views *v, const struct row_lists *lists,
                       struct rf_unseen_row *row)
{
    int n = 0;
    for (int i = 0; i < RF_MOST_CELLS; i++) {
        row->first[i] = n;
        row->n_bright[i] = lists->n_bright[i];
        n += lists->n[i];
    }
    row->first[RF_MOST_CELLS] = n;
    if (n == 0)
        return true;
    row->at = rf_alloc(v->work->frame->context, (size_t)n, sizeof *row->at);
    for (int i = 0; i < RF_MOST_CELLS && row->at; i++)
        memcpy(row->at + row->first[i], lists->at[i],
               (size_t)lists->n[i] * sizeof *row->at);
    return row->at != NULL;
}

/* `room` holds all parts of a row for each cell. */
static void list_row(struct blocks *b, int view, int y, struct rf_unseen *room)
{
    struct rf_views *v = b->v;
    const struct rf_picture *picture = &v->pictures[view];
    struct rf_unseen_row *row =
        &v->unseen[(size_t)view * (size_t)picture->height + (size_t)y];
    const struct doubt *doubts = &b->doubts[block_index(b, view, 0, y / BLOCK)];
    struct row_lists lists = {.n = {0}};
    if (y < picture->y0 || y >= picture->y0 + picture->frame->height)
        return;
    for (int i = 0; i < RF_MOST_CELLS; i++)
        lists.at[i] = room + 2 * (size_t)picture->width * (size_t)i;
    for (int bx = 0; bx < b->n_x; bx++)
        if (doubts[bx].partly | doubts[bx].blind)
            list_block(b, view, bx, y, &doubts[bx], &lists);
    if (keep_lists(v, &lists, row))
        return;
    __atomic_fetch_add(&b->n_failed, 1, __ATOMIC_RELAXED);
}

static void measure_some(void *data, int64_t begin, int64_t end, int thread)
{
    struct blocks *b = data;
    for (int i = (int)begin; i < (int)end; i++)
        measure_blocks(b, i / b->n_y, i % b->n_y);
}

/* Rows of blocks of all views, one after the other: they look at each other. */
static void find_some_doubts(void *data, int64_t begin, int64_t end, int thread)
{
    struct blocks *b = data;
    int n_views = b->v->work->n_views;
    for (int i = (int)begin; i < (int)end; i++)
        find_doubts(b, i % n_views, i / n_views);
}

/* What the threads share that list what views do not see. */
struct listing {
    struct blocks *blocks;
    struct rf_unseen *room; /* n_room for each thread */
    size_t n_room;
};

static void list_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct listing *l = data;
    struct blocks *b = l->blocks;
    int n_views = b->v->work->n_views, height = b->v->pictures[0].height;
    for (int i = (int)begin; i < (int)end; i++) {
        int by = i / n_views;
        for (int y = by * BLOCK; y < rf_min_int((by + 1) * BLOCK, height); y++)
            if (!rf_task_is_cancelled(b->v->work->task))
                list_row(b, i % n_views, y, l->room + l->n_room * (size_t)thread);
    }
}

static void list_all(struct blocks *b, struct rf_unseen *room)
{
    const struct rf_picture *picture = &b->v->pictures[0];
    const struct rf_context *context = picture->frame->context;
    const int64_t n = (int64_t)b->v->work->n_views * b->n_y;
    struct listing listing = {b, room, RF_MOST_CELLS * 2 * (size_t)picture->width};
    rf_parallel(context, n, 4, measure_some, b);
    rf_parallel(context, n, 4, find_some_doubts, b);
    rf_parallel(context, n, 1, list_rows, &listing);
    rf_task_poll(b->v->work->task);
}

rf_result rf_views_find_unseen(struct rf_views *v, struct rf_error *error)
{
    const struct rf_picture *picture = &v->pictures[0];
    const struct rf_context *context = v->work->frame->context;
    struct blocks b = {.v = v,
                       .kernels = context->kernels,
                       .n_x = (picture->width + BLOCK - 1) / BLOCK,
                       .n_y = (picture->height + BLOCK - 1) / BLOCK};
    size_t n_blocks = (size_t)b.n_x * (size_t)b.n_y * (size_t)v->work->n_views;
    size_t n_rows = (size_t)picture->height * (size_t)v->work->n_views;
    size_t n_room =
        RF_MOST_CELLS * 2 * (size_t)picture->width * (size_t)context->n_threads;
    b.at = rf_alloc(context, n_blocks, sizeof *b.at);
    b.doubts = rf_alloc(context, n_blocks, sizeof *b.doubts);
    b.says = rf_alloc(context, (size_t)v->work->n_views, sizeof *b.says);
    struct rf_unseen *room = rf_alloc(context, n_room, sizeof *room);
    v->unseen = rf_calloc(context, n_rows, sizeof *v->unseen);
    bool is_complete = b.at && b.doubts && b.says && room && v->unseen;
    find_boxes(&b);
    for (int j = 0; j < v->work->n_views && b.says; j++)
        b.says[j] = say_of(v, j);
    if (is_complete)
        list_all(&b, room);
    rf_free(context, room);
    rf_free(context, b.says);
    rf_free(context, b.doubts);
    rf_free(context, b.at);
    return is_complete && !b.n_failed ? RF_OK
                                      : rf_fail_memory(error, n_room, sizeof *room);
}

void rf_views_free_unseen(struct rf_views *v)
{
    const struct rf_context *context = v->work->frame->context;
    if (!v->unseen)
        return;
    for (int i = 0; i < v->work->n_views * v->pictures[0].height; i++)
        rf_free(context, v->unseen[i].at);
    rf_free(context, v->unseen);
    v->unseen = NULL;
}
