/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the search for hidden background (hidden.c) knows of blocks of 8 x 8 pixels before
 * it looks at any: the radii that they show behind others, and which are rough, that is
 * hold or touch an edge or a slope that could have candidates.
 */
#include "surfaces/hidden_blocks.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/math.h"
#include "base/parallel.h"
#include "kernels/data.h"
#include "kernels/hidden_kernels.h"
#include "kernels/kernels.h"
#include "surfaces/surfaces.h"

/* Calls for the mixed pixels of a row. */
static void visit_mixed(const struct rf_hidden_search *search, int y,
                        void (*visit)(const struct rf_hidden_search *search, int x,
                                      int y, size_t i))
{
    const struct rf_surfaces *s = search->s;
    size_t row = (size_t)y * (size_t)s->width, end = row + (size_t)s->width;
    for (size_t word = row / 64; word * 64 < end; word++) {
        uint64_t bits = s->mixed[word].bits;
        if (word * 64 < row)
            bits &= UINT64_MAX << row % 64;
        for (; bits; bits &= bits - 1) {
            size_t i = word * 64 + (size_t)__builtin_ctzll(bits);
            if (i >= end)
                return;
            if (s->share[i] < 1)
                visit(search, (int)(i - row), y, i);
        }
    }
}

/* What a mixed pixel shows behind others; its near part counts for its block. */
static void show_back(const struct rf_hidden_search *search, int x, int y, size_t i)
{
    const struct rf_surfaces *s = search->s;
    struct rf_hidden_facts *b =
        &search->blocks[y / RF_HIDDEN_BLOCK * search->n_x + x / RF_HIDDEN_BLOCK];
    const struct rf_surface *q = rf_hidden_back(s, i);
    b->has_mixed = true;
    b->n_rough = 1;
    if (s->share[i] > 0)
        b->lowest = rf_min_float(s->near[i].r, b->lowest);
    rf_hidden_row(search, y)[x] = q ? q->r : -INFINITY;
}

/* Undoes it. */
static void show_near(const struct rf_hidden_search *search, int x, int y, size_t i)
{
    const struct rf_surfaces *s = search->s;
    rf_hidden_row(search, y)[x] =
        s->share[i] > RF_OCCLUDER_SHARE ? s->near[i].r : INFINITY;
}

/* The radii of a row of pixels become those of what they show behind others. */
static void load_row(const struct rf_hidden_search *search, int y, bool has_radii)
{
    const struct rf_surfaces *s = search->s;
    float *r = rf_hidden_row(search, y);
    const struct rf_surface *near = s->near + (size_t)y * (size_t)s->width;
    for (int x = 0; x < s->width && !has_radii; x++)
        r[x] = near[x].r;
    for (int x = s->width; x < s->width + RF_HIDDEN_BLOCK; x++)
        r[x] = -INFINITY;
    visit_mixed(search, y, show_back);
}

void rf_hidden_restore_row(const struct rf_hidden_search *search, int y)
{
    int width = search->s->width;
    float *r = rf_hidden_row(search, y);
    visit_mixed(search, y, show_near);
    for (int x = width; x < width + RF_HIDDEN_BLOCK; x++)
        r[x] = r[width - 1];
}

/*
 * Radii that change by less than this from pixel to pixel, along either axis and in
 * units of the aperture's extent, hold no candidates for each other: 2 x 0.7^2 < 1.
 */
static const float SMOOTH = 0.7f;

/* Sums up n_rough of all blocks, which rf_hidden_measure() filled; notes which are rough. */
static void sum_rough(struct rf_hidden_search *search)
{
    for (int by = 0; by < search->n_y; by++) {
        struct rf_hidden_facts *b = search->blocks + (size_t)by * (size_t)search->n_x;
        uint32_t *bits = search->rough + (size_t)by * (size_t)search->n_words;
        int row = 0;
        for (int bx = 0; bx < search->n_x; bx++) {
            bits[bx / 32] |= (uint32_t)b[bx].n_rough << bx % 32;
            row += b[bx].n_rough;
            b[bx].n_rough = row + (by > 0 ? b[bx - search->n_x].n_rough : 0);
        }
    }
}

static int rough_before(const struct rf_hidden_facts *blocks, int n_x, int x, int y)
{
    return x > 0 && y > 0 ? blocks[(y - 1) * n_x + x - 1].n_rough : 0;
}

bool rf_hidden_has_rough(const struct rf_hidden_facts *blocks, int n_x, int n_y, int bx,
                         int by, int reach)
{
    int x0 = rf_max_int(bx - reach, 0), x1 = rf_min_int(bx + reach + 1, n_x);
    int y0 = rf_max_int(by - reach, 0), y1 = rf_min_int(by + reach + 1, n_y);
    return rough_before(blocks, n_x, x1, y1) - rough_before(blocks, n_x, x0, y1) -
               rough_before(blocks, n_x, x1, y0) + rough_before(blocks, n_x, x0, y0) >
           0;
}

/*
 * Does the surface of pixel i end before the pixel beside it, at (x, y)? That of a mixed
 * one is an edge itself, unless it hides nothing.
 */
static bool ends_at(const struct rf_hidden_search *search, size_t i, int x, int y,
                    float most)
{
    const struct rf_surfaces *s = search->s;
    if (x < 0 || y < 0 || x >= s->width || y >= s->height)
        return false;
    const size_t other = (size_t)y * (size_t)s->width + (size_t)x;
    if (s->share[other] < 1)
        return s->share[other] <= RF_OCCLUDER_SHARE;
    return !(fabsf(s->near[other].r - s->near[i].r) <= most);
}

/* Does the surface of a pixel end here? */
static bool is_edge(const struct rf_hidden_search *search, int x, int y)
{
    const float most_x = SMOOTH / (float)search->extent[0];
    const float most_y = SMOOTH / (float)search->extent[1];
    const size_t i = (size_t)y * (size_t)search->s->width + (size_t)x;
    return search->s->share[i] < 1 || ends_at(search, i, x - 1, y, most_x) ||
           ends_at(search, i, x + 1, y, most_x) ||
           ends_at(search, i, x, y - 1, most_y) || ends_at(search, i, x, y + 1, most_y);
}

static struct rf_inside_edges find_edges(const struct rf_hidden_search *search, int bx,
                                         int by)
{
    const int x0 = bx * RF_HIDDEN_BLOCK, y0 = by * RF_HIDDEN_BLOCK;
    const struct rf_surfaces *s = search->s;
    struct rf_inside_edges edges = {0, INFINITY};
    for (int i = 0; i < RF_HIDDEN_BLOCK * RF_HIDDEN_BLOCK; i++) {
        const int x = x0 + i % RF_HIDDEN_BLOCK, y = y0 + i / RF_HIDDEN_BLOCK;
        const size_t at = (size_t)y * (size_t)s->width + (size_t)x;
        if (x >= s->width || y >= s->height || !is_edge(search, x, y))
            continue;
        edges.bits |= (uint64_t)1 << i;
        if (s->share[at] > RF_OCCLUDER_SHARE)
            edges.lowest = rf_min_float(s->near[at].r, edges.lowest);
    }
    return edges;
}

/* Radii and roughness of a block, beside what its mixed pixels have told. */
static void measure_block(struct rf_hidden_search *search, int bx, int by)
{
    struct rf_hidden_facts *b = &search->blocks[by * search->n_x + bx];
    float lowest;
    bool is_rough = search->kernels->measure_block(
        &search->backs, bx, by, SMOOTH / (float)search->extent[0],
        SMOOTH / (float)search->extent[1], &b->highest, &lowest);
    b->lowest = rf_min_float(lowest, b->lowest);
    b->n_rough |= is_rough;
    search->edges[by * search->n_x + bx] = (struct rf_inside_edges){0, INFINITY};
    if (b->n_rough)
        search->edges[by * search->n_x + bx] = find_edges(search, bx, by);
    if (b->n_rough)
        b->step = search->kernels->nearest_step(&search->backs, bx, by);
}

/* The highest radius of every area, and then of the areas around each. */
static void find_highest(struct rf_hidden_search *search)
{
    int n_x = rf_hidden_n_areas(search->n_x), n_y = rf_hidden_n_areas(search->n_y);
    float *own = search->highest + n_x * n_y;
    for (int i = 0; i < n_x * n_y; i++)
        own[i] = search->highest[i] = -INFINITY;
    for (int by = 0; by < search->n_y; by++)
        for (int bx = 0; bx < search->n_x; bx++) {
            float *area = &own[by / RF_HIDDEN_AREA * n_x + bx / RF_HIDDEN_AREA];
            *area = rf_max_float(search->blocks[by * search->n_x + bx].highest, *area);
        }
    for (int i = 0; i < 9 * n_x * n_y; i++) {
        int area = i / 9, x = area % n_x + i % 3 - 1, y = area / n_x + i % 9 / 3 - 1;
        if (x >= 0 && x < n_x && y >= 0 && y < n_y)
            search->highest[area] =
                rf_max_float(own[y * n_x + x], search->highest[area]);
    }
}

static void load_blocks(void *data, int64_t begin, int64_t end, int thread)
{
    struct rf_hidden_search *search = data;
    for (int by = (int)begin; by < (int)end; by++) {
        int y1 = rf_min_int((by + 1) * RF_HIDDEN_BLOCK, search->s->height);
        for (int bx = 0; bx < search->n_x; bx++)
            search->blocks[by * search->n_x + bx] =
                (struct rf_hidden_facts){.lowest = INFINITY, .step = -INFINITY};
        for (int y = by * RF_HIDDEN_BLOCK; y < y1; y++)
            load_row(search, y, search->has_radii);
    }
}

static void measure_blocks(void *data, int64_t begin, int64_t end, int thread)
{
    struct rf_hidden_search *search = data;
    for (int by = (int)begin; by < (int)end; by++)
        for (int bx = 0; bx < search->n_x; bx++)
            measure_block(search, bx, by);
}

void rf_hidden_measure(struct rf_hidden_search *search, bool has_radii)
{
    search->has_radii = has_radii;
    rf_parallel(search->context, search->n_y, 4, load_blocks, search);
    rf_parallel(search->context, search->n_y, 4, measure_blocks, search);
    sum_rough(search);
    find_highest(search);
}
