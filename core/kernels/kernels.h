/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops, compiled once per instruction set from kernels_tmpl.c and chosen at
 * run time. Every level gives the same bits: vectors of eight floats everywhere, no
 * contraction, fixed order of sums.
 */
#ifndef RF_KERNELS_KERNELS_H
#define RF_KERNELS_KERNELS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "kernels/data.h"
#include "kernels/hidden_kernels.h"
#include "kernels/sight_kernels.h"

struct rf_kernels {
    const char *name;
    /*
     * Radii of n planar depths, as planar_distance() and rf_lens_radius_px() give them;
     * returns whether none is bad, and adds those that are not 0 to `n_known`;
     * `largest` receives the greatest magnitude of a radius.
     */
    bool (*radii)(const struct rf_plain_depth *depth, const float *value, int n,
                  float *radius, int64_t *n_known, float *largest);
    /*
     * Spreads n splats over a tile whose top left pixel is (x0, y0). Those that do not
     * reach the tile are passed over.
     */
    void (*spread)(struct rf_spread_sums *acc, const struct rf_splat *splats, int n,
                   struct rf_footprint *const *footprints, int x0, int y0);
    /* The same for n places of a tile. */
    void (*spread_places)(struct rf_spread_sums *acc, const rf_packed *places, int n,
                          const struct rf_tile_surfaces *surfaces,
                          struct rf_footprint *const *footprints, int x0, int y0);
    /*
     * A bit for each of n pixels, in whole words, that is mixed, share < 1, or has a
     * luminance above bright (1 + min(radius^2, most_r2)) darkest.
     */
    void (*find_others)(const float *share, const float *luminance, const float *radius,
                        const float *darkest, float bright, float most_r2, int n,
                        uint64_t *bits);
    /* A bit for each of n values, in whole words, that is above a limit of 0 or more.
     */
    void (*find_above)(const float *v, float limit, int n, uint64_t *bits);
    /*
     * The slants of n pixels, rounded up to eight in `out`, from radii in the rows two
     * above them to two below; two values before and after are read. 0 of slopes up to
     * `least`, px per px. Is any not 0?
     */
    bool (*find_slants)(const float *const rows[5], float least, int n, int16_t *out);
    /*
     * Saturating sum: w = min(coverage, t); sum += colour w / coverage; t -= w. Clears
     * the accumulator.
     */
    void (*flush)(struct rf_spread_sums *acc, const struct rf_tile_state *state);

    /*
     * One row of a coarse level from n_rows rows of transmittance, each `stride` after
     * the last: means of 2^level columns, what is below 0 counting as 0, for n_level
     * pixels. `row` holds 2^level n_level floats, rounded up to eight.
     */
    void (*average)(const float *t, size_t stride, int n_rows, int level, int n_level,
                    float *row, float *out);
    /*
     * A bit for each pixel of a tile's row that has a sum that is not 0; the planes are
     * `plane` floats apart.
     */
    uint64_t (*find_some)(const float *sum, size_t plane, int n_planes);
    /* A bit for each eight pixels of a tile's row of T where any is above 0. */
    unsigned (*find_open)(const float *t);
    /*
     * A row of a coarse level, magnified horizontally by 2^level to a tile's row, whose
     * first pixel lies `first` px after the beginning of in[1]; in[0] to in[n + 1] are
     * read where n pixels of the level lie in the tile.
     */
    void (*stretch)(const float *in, int level, int first, float *out);
    /*
     * Adds a level to those eights of a tile's row whose bits are set in `parts`. With
     * c_p, W and T_l its colours, coverage and transmittance before, magnified between
     * the rows `low` and `high` (its share), one tile's row after the other, and T = t,
     * w = T min(1, W / T_l), sum_p += c_p w / W, sum_last += w, T -= w. There are
     * n_planes - 1 colours; sums are `plane` floats apart.
     */
    void (*merge)(float *t, float *sum, size_t plane, const float *low,
                  const float *high, float share, unsigned parts, int n_planes);
    /*
     * A row of a reduced picture, magnified: vertically between rows a and b (the share
     * k of b), horizontally by 2^level with the edges repeated. `rows` holds n_level
     * floats; n floats are written, rounded up to eight.
     */
    void (*magnify)(const float *a, const float *b, float k, int n_level, int level,
                    float *row, float *out, int n);
    /*
     * Least and greatest value of (2 reach + 1) columns of n_rows rows around each of n
     * pixels. Rows may be read RF_ROW_MARGIN floats before and, n rounded up to eight,
     * after; `scratch` has room for that for each result. One of them may be NULL.
     */
    void (*extremes)(const float *const *rows, int n_rows, int reach, int n,
                     float *scratch, float *lowest, float *highest);
    /*
     * Surfaces of n pixels and their luminance from planes of colour, alpha (NULL: 1)
     * and radius; returns enum rf_row_kind, but for RF_ROW_INFINITE.
     */
    unsigned (*load_row)(const float *const planes[4], const float *radius, int n,
                         struct rf_surface *at, float *luminance);
    /*
     * The same from RGBA quadruples; returns enum rf_row_kind. What is not finite has
     * no defined surface.
     */
    unsigned (*load_rgba)(const float *rgba, const float *radius, int n,
                          struct rf_surface *at, float *luminance);
    /*
     * Takes `bit` from those of n pixels whose 3 x 3 values, in the middle of three
     * rows, lie on one slanted plane: within `tolerance` of the range (highest -
     * lowest). Reads and writes n rounded up to eight.
     */
    void (*keep_edges)(const float *const rows[3], const float *lowest,
                       const float *highest, float tolerance, int n, unsigned char bit,
                       unsigned char *flags);
    /*
     * The largest gap between the sorted 3 x 3 values around each of n pixels that has
     * `bit`, and its middle; takes the bit where the gap is less than `least`. Reads
     * and writes n rounded up to eight; without the bit the results are undefined.
     */
    void (*find_gaps)(const float *const rows[3], float least, int n, unsigned char bit,
                      unsigned char *flags, float *gap, float *middle);
    /*
     * Bits for each of n pixels, n rounded up to eight: `fringe` where the brightest
     * value around is more than dark_ratio (darkest + 1/10000) and more than
     * bright_ratio its own; `edge` where the greatest radius around is `gap` or more
     * above the least. 0 beyond n.
     */
    void (*find_mixed)(const struct rf_around *around, float dark_ratio,
                       float bright_ratio, float gap, int n, unsigned char fringe,
                       unsigned char edge, unsigned char *flags);
    /* What is around pixel x of the middle of seven rows. */
    void (*find_sides)(const float *const rows[7], int x, float threshold, float lowest,
                       float highest, struct rf_sides *sides);
    /*
     * Draws the shadows of pixels x0 to x1 - 1 of row y of a view: radius[x] of their
     * surfaces, INFINITY where there is none, and share[x]; returns whether there is
     * one. Without a mask stops at the first. Reads n rounded up to eight radii.
     */
    bool (*cast_shadows)(const struct rf_shadows *s, const float *radius,
                         const float *share, int y, int x0, int x1);
    /*
     * Unpacks n pixels of RGBA into planes, or packs them; unpack() returns whether all
     * values are finite.
     */
    bool (*unpack)(const float *rgba, int n, float *const planes[4]);
    void (*pack)(const float *const planes[4], int n, float *rgba);
    /*
     * Means of 2^level columns of n_rows rows, each `stride` after the last, for
     * n_level pixels; `row` holds 2^level n_level floats.
     */
    void (*shrink)(const float *from, size_t stride, int n_rows, int level, int n_level,
                   float *row, float *out);
    /*
     * k = max(1 - scale |radius|, 0) (1 - covered) for n pixels; returns whether one is
     * above 0.
     */
    bool (*detail)(const float *radius, const float *covered, float scale, int n,
                   float *k);
    /*
     * out = blurred + k (at - low), limited to 0 .. most, or to `blurred` or `at` where
     * that is below 0, for n pixels; with k NULL that of k = 0.
     */
    void (*join)(const float *blurred, const float *low, const float *at,
                 const float *k, float most, int n, float *out);
    /*
     * out = sum / coverage for n pixels, limited to least .. most; 0 where the coverage
     * is as good as none.
     */
    void (*divide)(const float *sum, const float *coverage, float least, float most,
                   int n, float *out);
    /* The same of three or four sums, times `weight`, added to planes; NULL: not
     * wanted. With sum[3] NULL the last is as for divide_rgba(). */
    void (*divide_add)(const float *const sum[4], const float *coverage,
                       const float least[3], float weight, int n, float *const out[4]);
    /*
     * The same to RGBA quadruples, of which the last is at most 1, or with sum[3] NULL
     * 1 and, where the coverage is as good as none, 0. They may be stored past the
     * caches: before another thread reads them, a fence is needed.
     */
    void (*divide_rgba)(const float *const sum[4], const float *coverage,
                        const float least[3], int n, float *rgba);
    /*
     * The highest and the lowest radius of a block; does it change by more than most_x
     * or most_y between one of its pixels and a neighbour in its row or column?
     */
    bool (*measure_block)(const struct rf_backs *backs, int block_x, int block_y,
                          float most_x, float most_y, float *highest, float *lowest);
    /*
     * Of all steps by more than 2 px of radius between pixels of a block and the second
     * from them in their row or column: the greatest radius of a near side; -INFINITY.
     */
    float (*nearest_step)(const struct rf_backs *backs, int block_x, int block_y);
    /* v = log(max(v, 0) + 1/1000) for n floats, n a multiple of eight. */
    void (*log_row)(float *v, int n);
    /*
     * May any pixel of a group have a candidate that vote_blocks() finds? None is one
     * for itself.
     */
    bool (*has_candidate)(const struct rf_backs *backs, struct rf_hidden_group *group);
    /* The same for 2 x 2 pixels of a group, of which the query is the first and has
     * the least radius of all. */
    bool (*quad_has_candidate)(const struct rf_backs *backs,
                               struct rf_hidden_group *group,
                               const struct rf_hidden_query *query);
    /*
     * Lets the candidates of a pixel of a group vote; false: there is none. Receive the
     * radius that wins and the squared distance to the nearest of about that radius.
     */
    bool (*vote_blocks)(const struct rf_backs *backs, struct rf_hidden_group *group,
                        const struct rf_hidden_query *query,
                        struct rf_hidden_vote *vote, float *r, int *d2);
    /*
     * The pixels around a query that show the surface of radius about r. Asks for their
     * near surfaces, which average_window() reads, but does not look at them.
     */
    void (*gather_window)(const struct rf_backs *backs,
                          const struct rf_hidden_query *query, float r, float reach,
                          const struct rf_surface *near, struct rf_hidden_window *out);
    /*
     * The weighted mean of what the pixels of a window that is not empty show, none of
     * it of more luminance than `brightest` times the weighted geometric mean.
     * Completes w->index.
     */
    void (*average_window)(const struct rf_surfaces *s, struct rf_hidden_window *w,
                           float brightest, float c[4]);
    /*
     * Places of the centre's view for n points of one view, whose places there and
     * radii are given. n is rounded up to eight.
     */
    void (*place_parts)(const struct rf_sight *own, int n, struct rf_sight_places *p);
    /* The same for eight pixels from (x, y) on, of their near parts. */
    void (*place_row)(const struct rf_sight *own, int x, int y,
                      struct rf_sight_places *p);
    /*
     * Looks for n <= 16 places in a view; what is nearer by less than `nearer` does not
     * hide. Reads n rounded up to eight.
     */
    void (*look_for_parts)(const struct rf_sight *view, const struct rf_sight_places *p,
                           int n, float nearer, struct rf_sight_found *found);
    /* The same, but only finds the pixels, and which were rendered. */
    void (*find_pixels)(const struct rf_sight *view, const struct rf_sight_places *p,
                        int n, struct rf_sight_found *found);
    /* A bit for each of n <= 64 values, n > 0, that is finite and `least` or more. */
    uint64_t (*find_finite_from)(const float *v, float least, int n);
    /*
     * Fits a plane to 8 x 8 radii, rows of `stride`, by least squares, and measures how
     * far from it `low` and `high` lie. What differs by less than level_px is level.
     */
    void (*fit_plane)(const float *low, const float *high, size_t stride,
                      float level_px, struct rf_sight_plane *out);
};

/*
 * The level of that name, NULL where the machine does not have it; without a name the
 * best of the machine but for AVX-512, which lowers the clock of older processors.
 */
const struct rf_kernels *rf_kernels_find(const char *name);

/* The levels of this machine from the plainest on: i = 0, 1, .. until NULL. */
const struct rf_kernels *rf_kernels_at(int i);

#endif
