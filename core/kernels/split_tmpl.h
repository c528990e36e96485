/* SPDX-License-Identifier: Apache-2.0 */
/* Which pixels are mixed: split.c says why; part of kernels_tmpl.c. */
#include <string.h>

#include "kernels/kernels.h"
#include "kernels/vector.h"

static inline __attribute__((always_inline)) void
extremes_of(const float *const *rows, int n_rows, int reach, int n, float *scratch,
            float *out, bool is_highest)
{
    scratch += RF_ROW_MARGIN;
    for (int x = -RF_ROW_MARGIN; x < n + RF_ROW_MARGIN; x += LANES) {
        vf v = LOAD(rows[0] + x);
        for (int k = 1; k < n_rows; k++)
            v = is_highest ? vmax(LOAD(rows[k] + x), v) : vmin(LOAD(rows[k] + x), v);
        STORE(scratch + x, v);
    }
    for (int x = 0; x < n; x += LANES) {
        vf v = LOAD(scratch + x);
        for (int k = 1; k <= reach; k++) {
            vf a = LOAD(scratch + x - k), b = LOAD(scratch + x + k);
            v = is_highest ? vmax(vmax(a, b), v) : vmin(vmin(a, b), v);
        }
        STORE(out + x, v);
    }
}

/* The same for both, with each row loaded once. */
static inline __attribute__((always_inline)) void
both_extremes(const float *const *rows, int n_rows, int reach, int n, float *scratch,
              float *lowest, float *highest)
{
    float *low = scratch + RF_ROW_MARGIN;
    float *high = low + (n + LANES - 1) / LANES * LANES + 2 * RF_ROW_MARGIN;
    for (int x = -RF_ROW_MARGIN; x < n + RF_ROW_MARGIN; x += LANES) {
        vf a = LOAD(rows[0] + x), b = a;
        for (int k = 1; k < n_rows; k++) {
            vf v = LOAD(rows[k] + x);
            a = vmin(v, a);
            b = vmax(v, b);
        }
        STORE(low + x, a);
        STORE(high + x, b);
    }
    for (int x = 0; x < n; x += LANES) {
        vf a = LOAD(low + x), b = LOAD(high + x);
        for (int k = 1; k <= reach; k++) {
            a = vmin(vmin(LOAD(low + x - k), LOAD(low + x + k)), a);
            b = vmax(vmax(LOAD(high + x - k), LOAD(high + x + k)), b);
        }
        STORE(lowest + x, a);
        STORE(highest + x, b);
    }
}

static inline __attribute__((always_inline)) void
any_extremes(const float *const *rows, int n_rows, int reach, int n, float *scratch,
             float *lowest, float *highest)
{
    if (lowest && highest)
        both_extremes(rows, n_rows, reach, n, scratch, lowest, highest);
    else if (lowest)
        extremes_of(rows, n_rows, reach, n, scratch, lowest, false);
    else
        extremes_of(rows, n_rows, reach, n, scratch, highest, true);
}

/* The two sizes that are in use are unrolled. */
static void extremes(const float *const *rows, int n_rows, int reach, int n,
                     float *scratch, float *lowest, float *highest)
{
    if (n_rows == 5 && reach == 2)
        any_extremes(rows, 5, 2, n, scratch, lowest, highest);
    else if (n_rows == 3 && reach == 1)
        any_extremes(rows, 3, 1, n, scratch, lowest, highest);
    else
        any_extremes(rows, n_rows, reach, n, scratch, lowest, highest);
}

/* Eight bytes of 0 or `value`, by the lowest eight bits. */
static inline uint64_t bytes_of(unsigned bits, unsigned char value)
{
    const uint64_t each = 0x0101010101010101u, own = 0x8040201008040201u;
    uint64_t one = ((bits * each & own) + 0x7f * each) >> 7 & each;
    return one * value;
}

static void find_mixed(const struct rf_around *a, float dark_ratio, float bright_ratio,
                       float gap, int n, unsigned char fringe, unsigned char edge,
                       unsigned char *flags)
{
    for (int x = 0; x < n; x += LANES) {
        vf peak = LOAD(a->brightest + x), dark = LOAD(a->darkest + x) + SPLAT(1e-4f);
        vi is_fringe = (peak > SPLAT(dark_ratio) * dark) &
                       (peak > SPLAT(bright_ratio) * LOAD(a->luminance + x));
        vi is_edge = (LOAD(a->farthest + x) - LOAD(a->nearest + x)) >= SPLAT(gap);
        unsigned all = n - x < LANES ? (1u << (n - x)) - 1 : 0xff;
        uint64_t bytes = 0;
        if (lane_bits(is_fringe | is_edge))
            bytes = bytes_of(lane_bits(is_fringe) & all, fringe) +
                    bytes_of(lane_bits(is_edge) & all, edge);
        memcpy(flags + x, &bytes, sizeof bytes);
    }
}

/* All bits where the least-squares plane of 3 x 3 fits; a step leaves a third of it. */
static inline vi is_planar(const float *const rows[3], int x, vf most)
{
    vf v[9], mean = {0}, slope_x = {0}, slope_y = {0};
    for (int k = 0; k < 9; k++) {
        v[k] = LOAD(rows[k / 3] + x + k % 3 - 1);
        mean += v[k] / SPLAT(9);
        slope_x += v[k] * SPLAT(k % 3 - 1) / SPLAT(6);
        slope_y += v[k] * SPLAT(k / 3 - 1) / SPLAT(6);
    }
    vi fits = {-1, -1, -1, -1, -1, -1, -1, -1};
    for (int k = 0; k < 9; k++) {
        vf d = v[k] - (mean + slope_x * SPLAT(k % 3 - 1) + slope_y * SPLAT(k / 3 - 1));
        fits &= (d <= most) & (-d <= most);
    }
    return fits;
}

static void keep_edges(const float *const rows[3], const float *lowest,
                       const float *highest, float tolerance, int n, unsigned char bit,
                       unsigned char *flags)
{
    uint64_t bits = bit * 0x0101010101010101u, eight;
    for (int x = 0; x < n; x += LANES) {
        memcpy(&eight, flags + x, sizeof eight);
        if (!(eight & bits))
            continue;
        vf range = LOAD(highest + x) - LOAD(lowest + x);
        unsigned planar = lane_bits(is_planar(rows, x, SPLAT(tolerance) * range));
        for (int l = 0; l < LANES; l++)
            if (planar >> l & 1)
                flags[x + l] &= (unsigned char)~bit;
    }
}

/* Sorts nine values: the 25 exchanges of the smallest network. */
static inline void sort_nine(vf v[9])
{
    static const unsigned char EXCHANGES[][2] = {
        {0, 3}, {1, 7}, {2, 5}, {4, 8}, {0, 7}, {2, 4}, {3, 8}, {5, 6}, {0, 2},
        {1, 3}, {4, 5}, {7, 8}, {1, 4}, {3, 6}, {5, 7}, {0, 1}, {2, 4}, {3, 5},
        {6, 8}, {2, 3}, {4, 5}, {6, 7}, {1, 2}, {3, 4}, {5, 6}};
#pragma GCC unroll 25
    for (int i = 0; i < 25; i++) {
        vf a = v[EXCHANGES[i][0]], b = v[EXCHANGES[i][1]];
        v[EXCHANGES[i][0]] = vmin(a, b);
        v[EXCHANGES[i][1]] = vmax(b, a);
    }
}

static void find_gaps(const float *const rows[3], float least, int n, unsigned char bit,
                      unsigned char *flags, float *gap, float *middle)
{
    uint64_t bits = bit * 0x0101010101010101u, eight;
    for (int x = 0; x < n; x += LANES) {
        memcpy(&eight, flags + x, sizeof eight);
        if (!(eight & bits))
            continue;
        vf v[9], widest = {0}, at = {0};
        for (int k = 0; k < 9; k++)
            v[k] = LOAD(rows[k / 3] + x + k % 3 - 1);
        sort_nine(v);
        for (int k = 1; k < 9; k++) {
            vf d = v[k] - v[k - 1];
            vi is_wider = d > widest;
            widest = choose(is_wider, d, widest);
            at = choose(is_wider, SPLAT(0.5f) * (v[k] + v[k - 1]), at);
        }
        STORE(gap + x, widest);
        STORE(middle + x, at);
        unsigned narrow = ~lane_bits(widest >= SPLAT(least));
        for (int l = 0; l < LANES; l++)
            if (narrow >> l & 1)
                flags[x + l] &= (unsigned char)~bit;
    }
}

static void find_sides(const float *const rows[7], int x, float threshold, float lowest,
                       float highest, struct rf_sides *sides)
{
    enum { ROW = RF_SIDES_AROUND, MASK = (1 << ROW) - 1 };
    unsigned far[7], all_far[7], all_near[7];
    *sides = (struct rf_sides){0, 0, 0};
    for (int j = 0; j < 7; j++) {
        vf r = LOAD(rows[j] + x - 3);
        far[j] = lane_bits(r > SPLAT(threshold));
        all_far[j] = far[j] & far[j] >> 1 & far[j] >> 2;
        all_near[j] = ~(far[j] | far[j] >> 1 | far[j] >> 2);
        if (j == 0 || j == 6)
            continue;
        unsigned usual = ~lane_bits((r > SPLAT(highest)) | (r < SPLAT(lowest)));
        sides->far |= (far[j] >> 1 & MASK) << ROW * (j - 1);
        sides->usual |= (usual >> 1 & MASK) << ROW * (j - 1);
    }
    for (int j = 0; j < ROW; j++) {
        unsigned is_interior = (all_far[j] & all_far[j + 1] & all_far[j + 2]) |
                               (all_near[j] & all_near[j + 1] & all_near[j + 2]);
        sides->interior |= (is_interior & MASK) << ROW * j;
    }
}
