/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Inner loops that spread samples over an accumulator; part of kernels_tmpl.c, which
 * says what they compute. Runs of many with one footprint: convolve_tmpl.h.
 */
#include "convolve_tmpl.h"
#include "kernels.h"
#include "vector.h"

/*
 * Adds a segment of n weights, n > 0 and a multiple of eight, to the row at a, and to
 * that at b where there is one: as many splats side by side as there are values, each
 * with the weights one place further on. If `is_summed` what they add is summed up
 * first; a splat that is missing counts as one without weight, so that it does not
 * matter for the bits whether those that do not reach a pixel are there. Otherwise
 * they are added one by one, and it does not matter which ones are together.
 */
static inline __attribute__((always_inline)) void
spread_segment(float *a, float *b, const float *weight, int n,
               vf value[][RF_MAX_PLANES], int n_splats, int n_planes, bool is_summed)
{
    do {
        vf k[RF_MAX_SIDE_BY_SIDE];
        for (int i = 0; i < n_splats; i++)
            k[i] = LOAD(weight - i);
        for (int p = 0; p < n_planes; p++) {
            float *to_a = a + p * RF_ACC_STRIDE, *to_b = b ? b + p * RF_ACC_STRIDE : b;
            vf sum = value[0][p] * k[0];
            vf sum_a = LOAD(to_a), sum_b = b ? LOAD(to_b) : sum;
            for (int i = 1; i < n_splats; i++) {
                vf next = value[i][p] * k[i];
                if (!is_summed) {
                    sum_a += sum;
                    sum_b += sum;
                }
                sum = is_summed ? sum + next : next;
            }
            STORE(to_a, sum_a + sum);
            if (b)
                STORE(to_b, sum_b + sum);
        }
        a += LANES;
        b = b ? b + LANES : NULL;
        weight += LANES;
        n -= LANES;
    } while (n > 0);
}

/* Spreads n_splats neighbours with one footprint, the first at (x, y) of the tile; with
 * is_inside all of its rows are. */
static inline __attribute__((always_inline)) void
spread_rows(float *base, vf value[][RF_MAX_PLANES], int n_splats,
            const struct rf_footprint *f, int y, int n_planes, bool is_summed,
            bool is_inside)
{
    const ptrdiff_t row_size = n_planes * RF_ACC_STRIDE;
    const float *weights = f->weights;
    const struct rf_segment *g = f->segments, *end = g + f->n_segments;
    for (const struct rf_segment *middle = g + f->n_mirrored; g < middle; g++) {
        ptrdiff_t down = row_size * g->dy;
        float *a = base + row_size * g->row + g->dx, *b = a - 2 * down;
        bool has_a = is_inside || (unsigned)(y + g->dy) < RF_TILE_H;
        bool has_b = is_inside || (unsigned)(y - g->dy) < RF_TILE_H;
        if (has_a && has_b)
            spread_segment(a, b, weights + g->weight, g->n, value, n_splats, n_planes,
                           is_summed);
        else if (has_a || has_b)
            spread_segment(has_a ? a : b, NULL, weights + g->weight, g->n, value,
                           n_splats, n_planes, is_summed);
    }
    for (end -= f->n_mirrored; g < end; g++)
        if (is_inside || (unsigned)(y + g->dy) < RF_TILE_H)
            spread_segment(base + row_size * g->row + g->dx, NULL, weights + g->weight,
                           g->n, value, n_splats, n_planes, is_summed);
}

static inline __attribute__((always_inline)) void
spread_values(float *origin, vf value[][RF_MAX_PLANES], int n_splats,
              const struct rf_footprint *f, int x, int y, int n_planes, bool is_summed)
{
    float *base = origin + n_planes * RF_ACC_STRIDE * (ptrdiff_t)y + x;
    if (y + f->min_dy >= 0 && y + f->max_dy < RF_TILE_H)
        spread_rows(base, value, n_splats, f, y, n_planes, is_summed, true);
    else
        spread_rows(base, value, n_splats, f, y, n_planes, is_summed, false);
}

/* What is spread: splats, or places and what they stand for. */
struct spread_list {
    const struct rf_splat *splats;
    const rf_place *places;
    const struct rf_tile_surfaces *surfaces;
};

/* How many of n splats from the first one on lie side by side and have its footprint,
 * but no more than `most`. */
static inline int count_neighbours(const struct rf_splat *s, int n, int most)
{
    int i = 1;
    most = n < most ? n : most;
    while (i < most && s[i].slot == s->slot && s[i].x == s->x + i && s[i].y == s->y)
        i++;
    return i;
}

/* The same for places: any number where all are surfaces, else 1 or 2. */
static inline int count_places(const rf_place *p, int n, int most)
{
    const rf_place right = rf_place_make(0, 1, 0, 0);
    int i = 1;
    most = n < most ? n : most;
    if (!rf_place_other(p[0])) {
        vu next = p[0] + (vu){right, 2 * right, 3 * right, 4 * right};
        for (; i + 4 <= most; i += 4, next += 4 * right)
            if (!is_same(LOAD_U(p + i), next))
                break;
        for (rf_place q = p[0] + right * (uint64_t)i; i < most && p[i] == q; q += right)
            i++;
    }
    return i == 1 && most >= 2 && p[1] >> 16 == (p[0] + right) >> 16 ? 2 : i;
}

/* The first of n places after i that is not before pixel (x, y) of their tile. */
static inline int skip_places(const rf_place *p, int i, int n, int x, int y)
{
    const rf_place least = rf_place_make(0, x, y, 0);
    int step = 4, end;
    /* Where the tile has each pixel once it lies as far on as the pixel does. */
    int guess = i + (y - rf_place_y(p[i])) * RF_TILE_W + x - rf_place_x(p[i]);
    if (guess > i && guess < n && p[guess - 1] < least && p[guess] >= least)
        return guess;
    while (i + step < n && p[i + step] < least) {
        i += step;
        step *= 2;
    }
    for (end = rf_min_int(i + step, n), i++; i < end;) {
        int middle = (i + end) / 2;
        if (p[middle] < least)
            i = middle + 1;
        else
            end = middle;
    }
    return i;
}

/* Spreads n_splats splats or places from the first on. */
static inline __attribute__((always_inline)) void
spread_some(const struct spread_list *list, int first, int n_splats, float *origin,
            const struct rf_footprint *f, int x, int y, int n_planes, bool has_places)
{
    vf value[RF_MAX_SIDE_BY_SIDE][RF_MAX_PLANES];
    if (has_places)
        __builtin_prefetch(rf_tile_surface(list->surfaces,
                                           rf_place_x(list->places[first]),
                                           rf_place_y(list->places[first]) + 2));
    for (int i = 0; i < n_splats; i++) {
        const float *c;
        float cover = 1;
        if (has_places) {
            const struct rf_tile_surfaces *t = list->surfaces;
            const rf_place *at = list->places + first;
            int other = n_splats > 2 ? 0 : rf_place_other(at[i]);
            c = rf_tile_surface(t, rf_place_x(at[0]), rf_place_y(at[0]))[i].c;
            if (other) {
                c = t->others[other - 1].c;
                cover = t->others[other - 1].cover;
            }
        } else {
            c = list->splats[first + i].c;
            cover = list->splats[first + i].cover;
        }
        for (int p = 0; p < n_planes - 1; p++)
            value[i][p] = SPLAT(c[p]);
        value[i][n_planes - 1] = SPLAT(cover);
    }
    spread_values(origin, value, n_splats, f, x, y, n_planes, has_places);
}

/* Spreads n splats or places side by side with one footprint. */
static inline __attribute__((always_inline)) void
spread_run(const struct spread_list *list, int first, int n, float *origin,
           const struct rf_footprint *f, int x, int y, int n_planes, bool has_places)
{
    int most = f->n_side_by_side;
    for (int n_splats; n > 0; n -= n_splats, first += n_splats, x += n_splats) {
        n_splats = rf_min_int(n, most);
        if (n_splats == 4)
            spread_some(list, first, 4, origin, f, x, y, n_planes, has_places);
        else if (n_splats == 3)
            spread_some(list, first, 3, origin, f, x, y, n_planes, has_places);
        else if (n_splats == 2)
            spread_some(list, first, 2, origin, f, x, y, n_planes, has_places);
        else
            spread_some(list, first, 1, origin, f, x, y, n_planes, has_places);
    }
}

/* Samples of one footprint side by side from which on a convolution takes less time. */
enum { LEAST_RUN = 8 };

/* Asks for n bytes of memory. */
static inline void fetch(const void *at, size_t n)
{
    for (size_t i = 0; i < n; i += 64)
        __builtin_prefetch((const char *)at + i);
}

/* The same for many of them. */
static inline __attribute__((always_inline)) void
spread_long(const struct spread_list *list, int first, int n, struct run_planes *run,
            float *origin, const struct rf_footprint *f, int x, int y, int n_planes,
            bool has_places)
{
    const struct rf_splat *splats = has_places ? NULL : list->splats + first;
    float *cover = run->at[n_planes - 1] + RUN_LEFT + x;
    run->from = x;
    run->to = x + n;
    if (has_places) {
        rf_place at = list->places[first];
        const struct rf_surface *surface =
            rf_tile_surface(list->surfaces, rf_place_x(at), rf_place_y(at));
        fetch(surface + 2 * list->surfaces->width, n * sizeof *surface);
        load_run(run, surface->c, sizeof *surface / sizeof(float), x, n, n_planes - 1);
    } else {
        load_run(run, splats->c, sizeof *splats / sizeof(float), x, n, n_planes - 1);
    }
    for (int i = 0; i < n; i++)
        cover[i] = has_places ? 1 : splats[i].cover;
    (n_planes == 4 ? convolve_4 : convolve_5)(run, origin, f, y, has_places);
    clear_run(run, n_planes);
}

static inline __attribute__((always_inline)) void
spread_all(struct rf_accumulator *acc, const struct spread_list *list, int n,
           struct rf_footprint *const *footprints, int x0, int y0, int n_planes,
           bool has_places)
{
    const int reach = acc->reach;
    int first = acc->first_row, last = acc->last_row;
    float *const origin = acc->at + RF_ACC_LEFT;
    struct run_planes run = {.from = 0};
    if (has_places) {
        x0 -= list->surfaces->x;
        y0 -= list->surfaces->y;
    }
    for (int i = 0, n_splats; i < n; i += n_splats) {
        const struct rf_splat *s = has_places ? NULL : list->splats + i;
        if (has_places)
            __builtin_prefetch(list->places + i + 2 * RF_TILE_W);
        rf_place place = has_places ? list->places[i] : 0;
        int x = (has_places ? rf_place_x(place) : s->x) - x0;
        int y = (has_places ? rf_place_y(place) : s->y) - y0;
        n_splats = 1;
        if (has_places && (unsigned)(x + reach) >= RF_TILE_W + 2 * (unsigned)reach) {
            int row = rf_place_y(place) + (x >= 0);
            int column = rf_max_int(x0 - reach, 0);
            n_splats = skip_places(list->places, i, n, column, row) - i;
            continue;
        }
        if ((unsigned)(x + reach) >= RF_TILE_W + 2 * (unsigned)reach ||
            (unsigned)(y + reach) >= RF_TILE_H + 2 * (unsigned)reach)
            continue;
        const struct rf_footprint *f = rf_footprint_at(
            footprints, (size_t)(has_places ? rf_place_slot(place) : s->slot));
        if (y + f->max_dy < 0 || y + f->min_dy >= RF_TILE_H) {
            n_splats = has_places ? count_places(list->places + i, n - i, n) : 1;
            continue;
        }
        if (x + f->max_dx < 0 || x + f->min_dx >= RF_TILE_W)
            continue;
        int top = rf_max_int(y + f->min_dy, 0);
        int bottom = rf_min_int(y + f->max_dy, RF_TILE_H - 1);
        first = rf_min_int(first, top);
        last = rf_max_int(last, bottom);
        if (f->is_common)
            acc->common_rows |= (2u << bottom) - (1u << top);
        int most = RF_TILE_W - f->min_dx - x;
        n_splats = has_places ? count_places(list->places + i, n - i, most)
                              : count_neighbours(s, n - i, most);
        if (n_splats >= LEAST_RUN) {
            spread_long(list, i, n_splats, &run, origin, f, x, y, n_planes, has_places);
        } else {
            n_splats = f->n_side_by_side > 1 ? n_splats : 1;
            spread_run(list, i, n_splats, origin, f, x, y, n_planes, has_places);
        }
    }
    acc->first_row = first;
    acc->last_row = last;
}

static void spread(struct rf_accumulator *acc, const struct rf_splat *splats, int n,
                   struct rf_footprint *const *footprints, int x0, int y0)
{
    const struct spread_list list = {.splats = splats};
    if (acc->n_planes == 4)
        spread_all(acc, &list, n, footprints, x0, y0, 4, false);
    else
        spread_all(acc, &list, n, footprints, x0, y0, RF_MAX_PLANES, false);
}

static void spread_places(struct rf_accumulator *acc, const rf_place *places, int n,
                          const struct rf_tile_surfaces *surfaces,
                          struct rf_footprint *const *footprints, int x0, int y0)
{
    const struct spread_list list = {.places = places, .surfaces = surfaces};
    if (acc->n_planes == 4)
        spread_all(acc, &list, n, footprints, x0, y0, 4, true);
    else
        spread_all(acc, &list, n, footprints, x0, y0, RF_MAX_PLANES, true);
}
