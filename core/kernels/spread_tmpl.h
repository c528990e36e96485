/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Inner loops that spread samples over an accumulator; part of kernels_tmpl.c, which
 * says what they compute. Runs of many with one footprint: convolve_tmpl.h.
 */
#include "base/math.h"
#include "kernels/convolve_tmpl.h"
#include "kernels/kernels.h"
#include "kernels/vector.h"

/*
 * Adds a segment of n weights times a factor, n > 0 and a multiple of eight, to the row at
 * a, and to that at b where there is one: as many splats side by side as there are values, each
 * with the weights one place further on. If `is_summed` what they add is summed up
 * first; a splat that is missing counts as one without weight, so that it does not
 * matter for the bits whether those that do not reach a pixel are there. Otherwise
 * they are added one by one, and it does not matter which ones are together.
 */
static inline __attribute__((always_inline)) void
spread_segment(float *a, float *b, const float *weight, int n, vf factor,
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
                    sum_a += factor * sum;
                    sum_b += factor * sum;
                }
                sum = is_summed ? sum + next : next;
            }
            STORE(to_a, sum_a + factor * sum);
            if (b)
                STORE(to_b, sum_b + factor * sum);
        }
        a += LANES;
        b = b ? b + LANES : NULL;
        weight += LANES;
        n -= LANES;
    } while (n > 0);
}

/* Segments of a footprint whose rows are in the tile, each from one up to another. */
struct rows {
    const struct rf_segment *first, *last;    /* all of them */
    const struct rf_segment *pair, *middle;   /* those that others mirror there */
    const struct rf_segment *from[2], *to[2]; /* all but these and what mirrors them */
};

/* Of a sample in row y of the tile. */
static inline struct rows rows_in_tile(const struct rf_footprint *f, int y)
{
    const struct rf_segment *all = f->segments, *end = all + f->n_segments;
    struct rows r = {.first = all, .last = end, .middle = all + f->n_mirrored};
    if (y + f->min_dy < 0)
        while (r.first < r.last && y + r.first->dy < 0)
            r.first++;
    if (y + f->max_dy >= RF_TILE_H)
        while (r.last > r.first && y + r.last[-1].dy >= RF_TILE_H)
            r.last--;
    ptrdiff_t above = r.first - all, below = end - r.last;
    ptrdiff_t out = above > below ? above : below;
    r.from[0] = r.first;
    r.to[0] = r.last;
    if (out >= f->n_mirrored) { /* no row is there with its mirror */
        r.pair = r.middle;
        r.from[1] = r.to[1] = end;
        return r;
    }
    r.pair = all + out;
    if (above > below)
        r.from[0] = end - out;
    else
        r.to[0] = r.pair;
    r.from[1] = r.middle;
    r.to[1] = end - f->n_mirrored;
    return r;
}

/*
 * Spreads n_splats neighbours with one footprint and the factors of one slant, the first
 * at (x, y) of the tile. Each call of spread_segment() becomes code for every number of
 * planes and of splats: more than three would cost compilers half of their time.
 */
static inline __attribute__((always_inline)) void
spread_values(float *origin, vf value[][RF_MAX_PLANES], int n_splats,
              const struct rf_footprint *f, const float *factors, int x, int y,
              int n_planes, bool is_summed)
{
    const ptrdiff_t row_size = n_planes * RF_ACC_STRIDE;
    float *base = origin + row_size * y + x;
    const struct rows r = rows_in_tile(f, y);
    if (factors && !f->is_common) { /* of what is common they are 1 */
        for (const struct rf_segment *g = r.first; g < r.last; g++)
            spread_segment(base + row_size * g->row + g->dx, NULL,
                           f->weights + g->weight, g->n, SPLAT(factors[g->cell]), value,
                           n_splats, n_planes, is_summed);
        return;
    }
    for (const struct rf_segment *g = r.pair; g < r.middle; g++) {
        float *a = base + row_size * g->row + g->dx;
        spread_segment(a, a - 2 * row_size * g->dy, f->weights + g->weight, g->n,
                       SPLAT(1), value, n_splats, n_planes, is_summed);
    }
    for (int i = 0; i < 2; i++)
        for (const struct rf_segment *g = r.from[i]; g < r.to[i]; g++)
            spread_segment(base + row_size * g->row + g->dx, NULL,
                           f->weights + g->weight, g->n, SPLAT(1), value, n_splats,
                           n_planes, is_summed);
}

/* Samples side by side with one footprint. */
struct strip {
    const float *c; /* colour of the first, `stride` floats before that of the next */
    size_t stride;
    bool is_surface; /* all cover their pixels; else cover stands before each colour */
    int x, y, n;     /* pixel of the tile of the first */
    int colour;      /* of each that goes to the first plane */
    const float *factors; /* of their slant */
};

static inline __attribute__((always_inline)) void
load_value(vf value[], const float *c, bool is_surface, int colour, int n_planes)
{
    for (int p = 0; p < n_planes - 1; p++)
        value[p] = SPLAT(c[colour + p]);
    value[n_planes - 1] = SPLAT(is_surface ? 1 : c[-1]);
}

/* Spreads n_splats of a strip from the first on. */
static inline __attribute__((always_inline)) void
spread_some(const struct strip *s, int first, int n_splats, float *origin,
            const struct rf_footprint *f, int n_planes, bool is_summed)
{
    vf value[RF_MAX_SIDE_BY_SIDE][RF_MAX_PLANES];
    const float *c = s->c + s->stride * (size_t)first;
    for (int i = 0; i < n_splats; i++, c += s->stride)
        load_value(value[i], c, s->is_surface, s->colour, n_planes);
    spread_values(origin, value, n_splats, f, s->factors, s->x + first, s->y, n_planes,
                  is_summed);
}

static inline __attribute__((always_inline)) void
spread_short(const struct strip *s, float *origin, const struct rf_footprint *f,
             int n_planes, bool is_summed)
{
    for (int i = 0, n_splats; i < s->n; i += n_splats) {
        n_splats = rf_min_int(s->n - i, f->n_side_by_side);
        if (n_splats == 4)
            spread_some(s, i, 4, origin, f, n_planes, is_summed);
        else if (n_splats == 3)
            spread_some(s, i, 3, origin, f, n_planes, is_summed);
        else if (n_splats == 2)
            spread_some(s, i, 2, origin, f, n_planes, is_summed);
        else
            spread_some(s, i, 1, origin, f, n_planes, is_summed);
    }
}

static inline __attribute__((always_inline)) void
spread_long(const struct strip *s, struct run_planes *run, float *origin,
            const struct rf_footprint *f, int n_planes)
{
    float *cover = run->at[n_planes - 1] + RUN_LEFT + s->x;
    run->from = s->x;
    run->to = s->x + s->n;
    if (n_planes == RF_LONE_PLANES)
        load_colour(run, s->c + s->colour, s->stride, s->x, s->n);
    else
        load_run(run, s->c, s->stride, s->x, s->n, n_planes - 1);
    for (int i = 0; i < s->n; i++)
        cover[i] = s->is_surface ? 1 : (s->c + s->stride * (size_t)i)[-1];
    (n_planes == RF_LONE_PLANES ? convolve_2
     : n_planes == 4            ? convolve_4
                     : convolve_5)(run, origin, f, s->factors, s->y, s->is_surface);
    clear_run(run, n_planes);
}

/* Samples in a strip from which on a convolution takes less time. */
enum { LEAST_RUN = 8 };

/* Can a row y of samples reach the tile? */
static inline bool reaches_rows(const struct rf_footprint *f, int y)
{
    return y + f->max_dy >= 0 && y + f->min_dy < RF_TILE_H;
}

/* Notes the rows that samples of row y reach. */
static inline void note_rows(struct rf_spread_sums *acc, const struct rf_footprint *f,
                             int y)
{
    int top = rf_max_int(y + f->min_dy, 0);
    int bottom = rf_min_int(y + f->max_dy, RF_TILE_H - 1);
    acc->first_row = rf_min_int(acc->first_row, top);
    acc->last_row = rf_max_int(acc->last_row, bottom);
    if (f->is_common)
        acc->common_rows |= (2u << bottom) - (1u << top);
}

/* Spreads what can reach the tile of a strip in a row that does. */
static inline __attribute__((always_inline)) void
spread_strip(struct rf_spread_sums *acc, struct strip s, struct run_planes *run,
             const struct rf_footprint *f, int n_planes, bool is_summed)
{
    float *const origin = acc->at + RF_ACC_LEFT;
    int cut = rf_max_int(-f->max_dx - s.x, 0);
    s.x += cut;
    s.c += s.stride * (size_t)cut;
    s.n = rf_min_int(s.n - cut, RF_TILE_W - f->min_dx - s.x);
    if (s.n <= 0)
        return;
    note_rows(acc, f, s.y);
    if (s.n >= LEAST_RUN)
        spread_long(&s, run, origin, f, n_planes);
    else
        spread_short(&s, origin, f, n_planes, is_summed);
}

/* How many of n splats from the first one on lie side by side and have its footprint and
 * slant. */
static inline int count_neighbours(const struct rf_splat *s, int n)
{
    int i = 1;
    while (i < n && s[i].slot == s->slot && s[i].x == s->x + i && s[i].y == s->y &&
           s[i].slant == s->slant)
        i++;
    return i;
}

/* The first splat from s on that may reach columns and rows from (x, y) on. */
static inline const struct rf_splat *find_near(const struct rf_splat *s,
                                               const struct rf_splat *end, int x, int y,
                                               unsigned width, unsigned height)
{
    while (s < end && ((unsigned)(s->x - x) >= width || (unsigned)(s->y - y) >= height))
        s++;
    return s;
}

static inline __attribute__((always_inline)) void
spread_splats(struct rf_spread_sums *acc, const struct rf_splat *splats, int n,
              struct rf_footprint *const *footprints, int x0, int y0, int n_planes)
{
    const int left = x0 - acc->reach, top = y0 - acc->reach;
    const unsigned width = RF_TILE_W + 2 * (unsigned)acc->reach;
    const unsigned height = RF_TILE_H + 2 * (unsigned)acc->reach;
    const struct rf_splat *s = splats, *end = splats + n;
    const int colour = n_planes == RF_LONE_PLANES ? acc->first_colour : 0;
    struct run_planes run = {.from = 0};
    for (int n_strip; (s = find_near(s, end, left, top, width, height)) < end;
         s += n_strip) {
        int x = s->x - x0, y = s->y - y0;
        const struct rf_footprint *f = rf_footprint_at(footprints, (size_t)s->slot);
        n_strip = 1;
        if (!reaches_rows(f, y))
            continue;
        n_strip = count_neighbours(s, (int)(end - s));
        spread_strip(acc,
                     (struct strip){s->c, sizeof *s / sizeof *s->c, false, x, y,
                                    n_strip, colour, rf_slant_factors(acc, s->slant)},
                     &run, f, n_planes, false);
    }
}

/* The next of n places after i that may reach column x of row y of their tile. */
static inline int skip_places(const rf_packed *p, int i, int n, int x, int y)
{
    const rf_packed least = rf_packed_make(0, x, y, 0);
    int from = ++i, step = 4, end;
    while (i + step < n && p[i + step] < least) {
        i += step;
        step *= 2;
    }
    for (end = rf_min_int(i + step, n); i < end;) {
        int middle = (i + end) / 2;
        if (p[middle] < least)
            i = middle + 1;
        else
            end = middle;
    }
    bool is_reached = i > from && rf_packed_y(p[i - 1]) == y &&
                      rf_packed_x(p[i - 1]) + rf_packed_n(p[i - 1]) > x;
    return i - is_reached;
}

/* Asks for the surfaces two rows below those of a place. */
static inline void fetch_surfaces(const struct rf_surface *at, size_t width, int n)
{
    const char *next = (const char *)(at + 2 * width);
    for (size_t i = 0; i < (size_t)n * sizeof *at; i += 64)
        __builtin_prefetch(next + i);
}

/* What a place stands for; x and y are the tile's. */
static inline struct strip strip_of(const struct rf_spread_sums *acc,
                                    const struct rf_tile_surfaces *t, rf_packed place,
                                    int x, int y, int colour)
{
    int n = rf_packed_n(place);
    if (n == 0) {
        const struct rf_splat *other = &t->others[rf_packed_other(place) - 1];
        return (struct strip){other->c, 0, false,  x,
                              y,        1, colour, rf_slant_factors(acc, other->slant)};
    }
    const struct rf_surface *at =
        rf_tile_surface(t, rf_packed_x(place), rf_packed_y(place));
    fetch_surfaces(at, t->width, n);
    return (struct strip){at->c,  sizeof *at / sizeof *at->c,
                          true,   x,
                          y,      n,
                          colour, rf_slant_factors(acc, rf_packed_slant(place))};
}

/* Is one splat of any kind to the right of another, with the same footprint? */
static inline bool is_next(rf_packed left, rf_packed right)
{
    return right >> 16 == (left + rf_packed_make(0, 1, 0, 0)) >> 16 &&
           rf_packed_n(right) <= 1;
}

/* Spreads two splats of any kind side by side, of which both can reach the tile. */
static inline __attribute__((always_inline)) void
spread_pair(struct rf_spread_sums *acc, const struct strip *left,
            const struct strip *right, const struct rf_footprint *f, int n_planes)
{
    vf value[2][RF_MAX_PLANES];
    note_rows(acc, f, left->y);
    load_value(value[0], left->c, left->is_surface, left->colour, n_planes);
    load_value(value[1], right->c, right->is_surface, right->colour, n_planes);
    spread_values(acc->at + RF_ACC_LEFT, value, 2, f, left->factors, left->x, left->y,
                  n_planes, true);
}

static inline __attribute__((always_inline)) void
spread_all(struct rf_spread_sums *acc, const rf_packed *places, int n,
           const struct rf_tile_surfaces *surfaces,
           struct rf_footprint *const *footprints, int x0, int y0, int n_planes)
{
    const int reach = acc->reach;
    const int colour = n_planes == RF_LONE_PLANES ? acc->first_colour : 0;
    struct run_planes run = {.from = 0};
    x0 -= surfaces->x;
    y0 -= surfaces->y;
    for (int i = 0; i < n;) {
        rf_packed place = places[i];
        int x = rf_packed_x(place) - x0, y = rf_packed_y(place) - y0;
        int n_strip = rf_packed_n(place);
        bool is_beyond = x >= RF_TILE_W + reach;
        if (is_beyond || x + rf_max_int(n_strip, 1) + reach <= 0) {
            i = skip_places(places, i, n, rf_max_int(x0 - reach, 0),
                            rf_packed_y(place) + is_beyond);
            continue;
        }
        i++;
        if ((unsigned)(y + reach) >= RF_TILE_H + 2 * (unsigned)reach)
            continue;
        const struct rf_footprint *f =
            rf_footprint_at(footprints, (size_t)rf_packed_slot(place));
        if (!reaches_rows(f, y))
            continue;
        struct strip strip = strip_of(acc, surfaces, place, x, y, colour);
        bool may_pair = i < n && n_strip <= 1 && is_next(place, places[i]) &&
                        f->n_side_by_side > 1 && x + f->max_dx >= 0 &&
                        x + 1 + f->min_dx < RF_TILE_W;
        struct strip next;
        if (may_pair)
            next = strip_of(acc, surfaces, places[i], x + 1, y, colour);
        if (may_pair && next.factors == strip.factors) {
            spread_pair(acc, &strip, &next, f, n_planes);
            i++;
        } else {
            spread_strip(acc, strip, &run, f, n_planes, true);
        }
    }
}

static void spread(struct rf_spread_sums *acc, const struct rf_splat *splats, int n,
                   struct rf_footprint *const *footprints, int x0, int y0)
{
    if (acc->n_planes == RF_LONE_PLANES)
        spread_splats(acc, splats, n, footprints, x0, y0, RF_LONE_PLANES);
    else if (acc->n_planes == 4)
        spread_splats(acc, splats, n, footprints, x0, y0, 4);
    else
        spread_splats(acc, splats, n, footprints, x0, y0, RF_MAX_PLANES);
}

static void spread_places(struct rf_spread_sums *acc, const rf_packed *places, int n,
                          const struct rf_tile_surfaces *surfaces,
                          struct rf_footprint *const *footprints, int x0, int y0)
{
    if (acc->n_planes == RF_LONE_PLANES)
        spread_all(acc, places, n, surfaces, footprints, x0, y0, RF_LONE_PLANES);
    else if (acc->n_planes == 4)
        spread_all(acc, places, n, surfaces, footprints, x0, y0, 4);
    else
        spread_all(acc, places, n, surfaces, footprints, x0, y0, RF_MAX_PLANES);
}
