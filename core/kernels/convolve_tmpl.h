/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Samples of one row, side by side, that share a footprint leave a convolution of it on
 * every row that they reach; part of kernels_tmpl.c:
 *
 *   row[x] += sum over dx of  F(dx, dy) c(x - dx)
 *
 * (times a factor, of a slanted surface) with zeros for c beyond the run, summed from
 * one side to the other for every pixel: it does not matter for the bits where the run
 * is cut, as long as what reaches the tile is there. An even footprint has F(dx, dy) =
 * F(-dx, dy) = F(dx, -dy): what stands to both sides of x is added up first, and rows
 * above and below are the same.
 */
#include "base/math.h"
#include "kernels/kernels.h"
#include "kernels/vector.h"

enum {
    /* Columns before the tile, and as many after it: samples that reach it. A footprint
     * beside its sample reaches 19 px (views_lens.c: 8 px, as far beside it, the
     * cubic). */
    RUN_LEFT = 24,
    RUN_STRIDE = RUN_LEFT + RF_TILE_W + RUN_LEFT,
#if defined __AVX__ || defined RF_USE_NEON
    VECTORS = 2, /* side by side: so many sums of five planes are in registers */
#else
    VECTORS = 1,
#endif
    /* The same of one colour alone, which has sums for so many. */
    LONE_VECTORS = 2 * VECTORS,
    MOST_SUMS = RF_MAX_PLANES * VECTORS, /* of all planes */
};
_Static_assert((int)RF_LONE_PLANES *LONE_VECTORS <= MOST_SUMS, "room for sums");

/* A run of samples as planes of the tile's columns; zero beside it. */
struct run_planes {
    float at[RF_MAX_PLANES][RUN_STRIDE];
    int from, to; /* columns of the run */
};

/* Colours of n samples, `stride` floats apart, from column x on. */
static inline __attribute__((always_inline)) void load_run(struct run_planes *run,
                                                           const float *c,
                                                           size_t stride, int x, int n,
                                                           int n_colours)
{
    int i = 0;
    x += RUN_LEFT;
    for (; i + LANES <= n; i += LANES, c += LANES * stride) {
        vf v[4];
        for (size_t k = 0; k < 4; k++)
            v[k] = load_halves(c + k * stride, c + (k + 4) * stride);
        turn_halves(v);
        for (int p = 0; p < n_colours; p++)
            STORE(run->at[p] + x + i, v[p]);
    }
    for (; i < n; i++, c += stride)
        for (int p = 0; p < n_colours; p++)
            run->at[p][x + i] = c[p];
}

/* The same of one colour, that which c points to. */
static inline void load_colour(struct run_planes *run, const float *c, size_t stride,
                               int x, int n)
{
    for (int i = 0; i < n; i++, c += stride)
        run->at[0][RUN_LEFT + x + i] = *c;
}

static inline void clear_run(struct run_planes *run, int n_planes)
{
    for (int p = 0; p < n_planes; p++)
        memset(run->at[p] + RUN_LEFT + run->from, 0,
               (size_t)(run->to - run->from) * sizeof(float));
}

static inline __attribute__((always_inline)) void add_to_row(float *row, const vf *sum,
                                                             vf cover, int n_planes,
                                                             bool is_full,
                                                             int n_vectors)
{
    for (int p = 0; p < n_planes; p++)
        for (int i = 0; i < n_vectors; i++) {
            float *at = row + p * RF_ACC_STRIDE + LANES * i;
            STORE(at,
                  LOAD(at) +
                      (is_full && p == n_planes - 1 ? cover : sum[p * n_vectors + i]));
        }
}

/*
 * Columns x to x + n_vectors * LANES - 1 of all rows that a run with an even footprint
 * reaches. If `is_full` all taps there are on samples that cover their pixels, and the
 * coverage of each row is the sum of its weights.
 */
static inline __attribute__((always_inline)) void
convolve_even(const struct run_planes *run, float *origin, const struct rf_footprint *f,
              int x, int y, int n_planes, bool is_full, int n_vectors)
{
    const ptrdiff_t row_size = n_planes * RF_ACC_STRIDE;
    const int n_summed = is_full ? n_planes - 1 : n_planes;
    vf both[RF_TILE_HALO + 1][MOST_SUMS];
    for (int k = 0; k <= f->max_dx; k++)
        for (int p = 0; p < n_summed; p++)
            for (int i = 0; i < n_vectors; i++) {
                const float *c = run->at[p] + RUN_LEFT + x + LANES * i;
                both[k][p * n_vectors + i] =
                    k == 0 ? LOAD(c) : LOAD(c - k) + LOAD(c + k);
            }
    for (int r = 0; r < f->n_segments - f->n_mirrored; r++) {
        const struct rf_segment *g = &f->segments[r];
        bool has_above = (unsigned)(y + g->dy) < RF_TILE_H;
        bool has_below = g->dy != 0 && (unsigned)(y - g->dy) < RF_TILE_H;
        float *above = origin + row_size * (y + g->row) + x;
        if (!has_above && !has_below)
            continue;
        const float *weight = f->weights + g->weight - g->dx;
        vf sum[MOST_SUMS];
        for (int p = 0; p < n_summed; p++)
            for (int i = 0; i < n_vectors; i++)
                sum[p * n_vectors + i] = SPLAT(weight[0]) * both[0][p * n_vectors + i];
        for (int k = 1; k <= -g->dx; k++)
            for (int p = 0; p < n_summed; p++)
                for (int i = 0; i < n_vectors; i++)
                    sum[p * n_vectors + i] +=
                        SPLAT(weight[k]) * both[k][p * n_vectors + i];
        if (has_above)
            add_to_row(above, sum, SPLAT(g->sum), n_planes, is_full, n_vectors);
        if (has_below)
            add_to_row(above - 2 * row_size * g->dy, sum, SPLAT(g->sum), n_planes,
                       is_full, n_vectors);
    }
}

/* The same with any footprint, and the factors of a slant. */
static inline __attribute__((always_inline)) void
convolve_any(const struct run_planes *run, float *origin, const struct rf_footprint *f,
             const float *factors, int x, int y, int n_planes, bool is_full,
             int n_vectors)
{
    const ptrdiff_t row_size = n_planes * RF_ACC_STRIDE;
    const int n_summed = is_full ? n_planes - 1 : n_planes;
    for (int r = 0; r < f->n_segments; r++) {
        const struct rf_segment *g = &f->segments[r];
        if ((unsigned)(y + g->dy) >= RF_TILE_H)
            continue;
        const float *weight = f->weights + g->weight;
        const float *c = run->at[0] + RUN_LEFT + x - g->dx;
        vf sum[MOST_SUMS];
        for (int p = 0; p < n_summed; p++)
            for (int i = 0; i < n_vectors; i++)
                sum[p * n_vectors + i] =
                    SPLAT(weight[0]) * LOAD(c + RUN_STRIDE * p + LANES * i);
        for (int k = 1; k < g->n_used; k++)
            for (int p = 0; p < n_summed; p++)
                for (int i = 0; i < n_vectors; i++)
                    sum[p * n_vectors + i] +=
                        SPLAT(weight[k]) * LOAD(c + RUN_STRIDE * p + LANES * i - k);
        const vf factor = factors ? SPLAT(factors[g->cell]) : SPLAT(1);
        for (int p = 0; p < n_summed && factors; p++)
            for (int i = 0; i < n_vectors; i++)
                sum[p * n_vectors + i] *= factor;
        add_to_row(origin + row_size * (y + g->row) + x, sum, factor * SPLAT(g->sum),
                   n_planes, is_full, n_vectors);
    }
}

static inline __attribute__((always_inline)) void
convolve(const struct run_planes *run, float *origin, const struct rf_footprint *f,
         const float *factors, int x, int y, int n_planes, bool is_full, int n_vectors)
{
    if (f->is_even)
        convolve_even(run, origin, f, x, y, n_planes, is_full, n_vectors);
    else
        convolve_any(run, origin, f, factors, x, y, n_planes, is_full, n_vectors);
}

/* Spreads a run in row y; with is_surface all of it covers its pixels. */
static inline __attribute__((always_inline)) void
convolve_run(const struct run_planes *run, float *origin, const struct rf_footprint *f,
             const float *factors, int y, int n_planes, bool is_surface)
{
    int x = rf_max_int(run->from + f->min_dx, 0) / LANES * LANES;
    int end = rf_min_int(run->to + f->max_dx, RF_TILE_W);
    for (int n_vectors; x < end; x += n_vectors * LANES) {
        const int n_left = (end - x + LANES - 1) / LANES;
        const bool is_wide = n_planes == RF_LONE_PLANES && n_left >= LONE_VECTORS;
        n_vectors = is_wide ? LONE_VECTORS : n_left >= VECTORS ? VECTORS : 1;
        bool is_full = is_surface && x - f->max_dx >= run->from &&
                       x + n_vectors * LANES - f->min_dx <= run->to;
        if (is_wide && is_full)
            convolve(run, origin, f, factors, x, y, n_planes, true, LONE_VECTORS);
        else if (is_wide)
            convolve(run, origin, f, factors, x, y, n_planes, false, LONE_VECTORS);
        else if (n_vectors < VECTORS)
            convolve(run, origin, f, factors, x, y, n_planes, false, 1);
        else if (is_full)
            convolve(run, origin, f, factors, x, y, n_planes, true, VECTORS);
        else
            convolve(run, origin, f, factors, x, y, n_planes, false, VECTORS);
    }
}

static __attribute__((noinline)) void
convolve_2(const struct run_planes *run, float *origin, const struct rf_footprint *f,
           const float *factors, int y, bool is_surface)
{
    convolve_run(run, origin, f, factors, y, RF_LONE_PLANES, is_surface);
}

static __attribute__((noinline)) void
convolve_4(const struct run_planes *run, float *origin, const struct rf_footprint *f,
           const float *factors, int y, bool is_surface)
{
    convolve_run(run, origin, f, factors, y, 4, is_surface);
}

static __attribute__((noinline)) void
convolve_5(const struct run_planes *run, float *origin, const struct rf_footprint *f,
           const float *factors, int y, bool is_surface)
{
    convolve_run(run, origin, f, factors, y, RF_MAX_PLANES, is_surface);
}
