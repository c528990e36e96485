/* SPDX-License-Identifier: Apache-2.0 */
/* Inner loops over rows of pixels: in and out, and the previews; part of
 * kernels_tmpl.c. */
#include <math.h>
#include <stdbool.h>

#include "base/math.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "kernels/vector.h"

/* Pixels of rgba as they are, and which of their floats are not finite, too. */
static inline void load_pixels(const float *rgba, vf v[4], vi *is_bad)
{
    const vi infinite = (vi)SPLAT(INFINITY), magnitude = ~(vi)SPLAT(-0.0f);
    for (int i = 0; i < 4; i++) {
        v[i] = LOAD(rgba + LANES * i);
        *is_bad |= ((vi)v[i] & magnitude) >= infinite;
    }
}

static bool unpack(const float *rgba, int n, float *const planes[4])
{
    vi is_bad = {0};
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        vf v[4];
        load_pixels(rgba + 4 * x, v, &is_bad);
        turn(v);
        turn(v);
        turn(v);
        for (int i = 0; i < 4; i++)
            STORE(planes[i] + x, v[i]);
    }
    bool is_good = !lane_bits(is_bad);
    for (; x < n; x++)
        for (int i = 0; i < 4; i++) {
            float v = rgba[4 * x + i];
            planes[i][x] = v;
            is_good &= v - v == 0;
        }
    return is_good;
}

static void pack(const float *const planes[4], int n, float *rgba)
{
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        vf v[4];
        for (int i = 0; i < 4; i++)
            v[i] = LOAD(planes[i] + x);
        turn(v);
        turn(v);
        for (int i = 0; i < 4; i++)
            STORE(rgba + 4 * x + LANES * i, v[i]);
    }
    for (; x < n; x++)
        for (int i = 0; i < 4; i++)
            rgba[4 * x + i] = planes[i][x];
}

static unsigned load_row(const float *const planes[4], const float *radius, int n,
                         struct rf_surface *at, float *luminance)
{
    vi has_alpha = {0}, is_negative = {0};
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        vf v[4];
        for (int i = 0; i < 3; i++) {
            v[i] = LOAD(planes[i] + x);
            is_negative |= v[i] < SPLAT(0);
        }
        v[3] = planes[3] ? LOAD(planes[3] + x) : SPLAT(1);
        has_alpha |= v[3] != SPLAT(1);
        STORE(luminance + x, luminance_of(v));
        turn(v);
        turn(v);
        for (int i = 0; i < LANES; i++) {
            memcpy(at[x + i].c, (const float *)&v[i / 2] + i % 2 * 4,
                   sizeof at[x + i].c);
            at[x + i].r = radius[x + i];
        }
    }
    unsigned kind = (lane_bits(has_alpha) ? RF_ROW_FILM : 0) |
                    (lane_bits(is_negative) ? RF_ROW_NEGATIVE : 0);
    for (; x < n; x++) {
        for (int i = 0; i < 4; i++) {
            at[x].c[i] = planes[i] ? planes[i][x] : 1;
            kind |= i < 3 && at[x].c[i] < 0 ? RF_ROW_NEGATIVE : 0;
        }
        at[x].r = radius[x];
        luminance[x] = rf_luminance(at[x].c[0], at[x].c[1], at[x].c[2]);
        kind |= at[x].c[3] != 1 ? RF_ROW_FILM : 0;
    }
    return kind;
}

static unsigned load_rgba(const float *rgba, const float *radius, int n,
                          struct rf_surface *at, float *luminance)
{
    vi bad = {0}, is_film = {0}, is_negative = {0};
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        vf v[4];
        for (int i = 0; i < 4; i++) {
            v[i] = load_halves(rgba + 4 * (x + i), rgba + 4 * (x + i + 4));
            store_halves(at[x + i].c, at[x + i + 4].c, v[i], false);
            bad |= (vi)(v[i] * SPLAT(0)); /* 0 or -0 where it is finite, else NaN */
        }
        for (int i = 0; i < LANES; i++)
            at[x + i].r = radius[x + i];
        turn_halves(v);
        is_film |= v[3] != SPLAT(1);
        for (int i = 0; i < 3; i++)
            is_negative |= v[i] < SPLAT(0);
        STORE(luminance + x, luminance_of(v));
    }
    unsigned kind = (lane_bits(is_film) ? RF_ROW_FILM : 0) |
                    (lane_bits(bad << 1 != 0) ? RF_ROW_INFINITE : 0) |
                    (lane_bits(is_negative) ? RF_ROW_NEGATIVE : 0);
    for (; x < n; x++) {
        const float *c = rgba + 4 * x;
        memcpy(at[x].c, c, sizeof at[x].c);
        at[x].r = radius[x];
        luminance[x] = rf_luminance(c[0], c[1], c[2]);
        kind |= c[3] != 1 ? RF_ROW_FILM : 0;
        for (int i = 0; i < 4; i++)
            kind |= (c[i] - c[i] == 0 ? 0 : RF_ROW_INFINITE) |
                    (i < 3 && c[i] < 0 ? RF_ROW_NEGATIVE : 0);
    }
    return kind;
}

/* Adds four columns, one after the other, of each of eight pixels of `size` columns. */
static inline vf add_four(vf sum, const float *row, int size)
{
    vf v[4];
    for (int i = 0; i < 4; i++)
        v[i] = load_halves(row + size * i, row + size * (i + 4));
    turn_halves(v);
    return sum + v[0] + v[1] + v[2] + v[3];
}

/* Sums of 2^level columns for n_level pixels, from the left; out may not be row. */
static void sum_columns(const float *row, int level, int n_level, float *out)
{
    int size = 1 << level, x = 0;
    for (; level == 1 && x + LANES <= n_level; x += LANES) {
        vf a = LOAD(row + 2 * x), b = LOAD(row + 2 * x + LANES);
        STORE(out + x, SHUFFLE(a, b, 0, 2, 4, 6, 8, 10, 12, 14) +
                           SHUFFLE(a, b, 1, 3, 5, 7, 9, 11, 13, 15));
    }
    for (; level >= 2 && x + LANES <= n_level; x += LANES) {
        vf sum = {0};
        for (int i = 0; i < size; i += 4)
            sum = add_four(sum, row + (x << level) + i, size);
        STORE(out + x, sum);
    }
    for (; x < n_level; x++) {
        float sum = row[x << level];
        for (int i = 1; i < size; i++)
            sum += row[(x << level) + i];
        out[x] = sum;
    }
}

static void shrink(const float *from, size_t stride, int n_rows, int level, int n_level,
                   float *row, float *out)
{
    int x0 = 0;
    for (; x0 + LANES <= n_level << level; x0 += LANES) {
        vf sum = LOAD(from + x0);
        for (int y = 1; y < n_rows; y++)
            sum += LOAD(from + (size_t)y * stride + x0);
        STORE(row + x0, sum);
    }
    for (; x0 < n_level << level; x0++) {
        row[x0] = from[x0];
        for (int y = 1; y < n_rows; y++)
            row[x0] += from[(size_t)y * stride + x0];
    }
    float scale = 1.0f / (float)(n_rows << level);
    sum_columns(row, level, n_level, out);
    for (int x = 0; x < n_level; x++)
        out[x] *= scale;
}

/* Eight values of a row, of the last ones those that there are. */
static inline vf load_part(const float *p, int n)
{
    float v[LANES] = {0};
    if (n >= LANES)
        return LOAD(p);
    memcpy(v, p, (size_t)n * sizeof *v);
    return LOAD(v);
}

static inline void store_part(float *p, int n, vf v)
{
    if (n >= LANES)
        STORE(p, v);
    else
        memcpy(p, &v, (size_t)n * sizeof *p);
}

static bool detail(const float *radius, const float *covered, float scale, int n,
                   float *out)
{
    vi is_any = {0};
    for (int x = 0; x < n; x += LANES) {
        vf r = load_part(radius + x, n - x);
        r = choose(r < SPLAT(0), -r, r);
        vf k = vmax(SPLAT(1) - r * SPLAT(scale), SPLAT(0));
        k *= SPLAT(1) - load_part(covered + x, n - x);
        is_any |= k > SPLAT(0);
        store_part(out + x, n - x, k);
    }
    return lane_bits(is_any);
}

static void join(const float *blurred, const float *low, const float *at,
                 const float *k, float most, int n, float *out)
{
    for (int x = 0; x < n; x += LANES) {
        vf v = load_part(blurred + x, n - x), least = vmin(v, SPLAT(0));
        if (k) {
            vf here = load_part(at + x, n - x);
            v += load_part(k + x, n - x) * (here - load_part(low + x, n - x));
            least = vmin(least, here);
        }
        store_part(out + x, n - x, vmin(vmax(v, least), SPLAT(most)));
    }
}

static const float NO_COVERAGE = 1e-6f; /* or less */

/* sum / w, limited to least .. most; 0 where w is no coverage. */
static inline vf quotient(vf sum, vf w, vf least, vf most)
{
    const vf least_w = SPLAT(NO_COVERAGE);
    vf v = vmax(sum / vmax(w, least_w), least);
    return vmin(choose(w > least_w, v, SPLAT(0)), most);
}

static void divide(const float *sum, const float *coverage, float least, float most,
                   int n, float *out)
{
    for (int x = 0; x < n; x += LANES) {
        vf v = load_part(sum + x, n - x), w = load_part(coverage + x, n - x);
        store_part(out + x, n - x, quotient(v, w, SPLAT(least), SPLAT(most)));
    }
}

/* Quotients of up to eight pixels; most of a picture is covered exactly. */
static inline __attribute__((always_inline)) void
divide_pixels(const float *const sum[4], const float *coverage, const float least[3],
              int x, int n, vf v[4])
{
    vf w = load_part(coverage + x, n);
    bool is_full = lane_bits(w == SPLAT(1)) == (1u << LANES) - 1;
    for (int i = 0; i < 3; i++) {
        v[i] = load_part(sum[i] + x, n);
        vf low = SPLAT(least[i]);
        v[i] = is_full ? vmax(v[i], low) : quotient(v[i], w, low, SPLAT(INFINITY));
    }
    if (sum[3])
        v[3] = quotient(load_part(sum[3] + x, n), w, SPLAT(0), SPLAT(1));
    else
        v[3] = choose(w > SPLAT(NO_COVERAGE), SPLAT(1), SPLAT(0));
}

static void divide_add(const float *const sum[4], const float *coverage,
                       const float least[3], float weight, int n, float *const out[4])
{
    vf v[4];
    for (int x = 0; x < n; x += LANES) {
        divide_pixels(sum, coverage, least, x, n - x, v);
        for (int p = 0; p < 4; p++)
            if (out[p])
                store_part(out[p] + x, n - x,
                           load_part(out[p] + x, n - x) + SPLAT(weight) * v[p]);
    }
}

static void divide_rgba(const float *const sum[4], const float *coverage,
                        const float least[3], int n, float *rgba)
{
    /* A picture is larger than the caches: lines of it would be fetched for nothing. */
    const bool is_streamed = (uintptr_t)rgba % 16 == 0;
    vf v[4];
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        divide_pixels(sum, coverage, least, x, LANES, v);
        turn_halves(v);
        for (int i = 0; i < 4; i++) {
            float *low = rgba + 4 * (x + i), *high = low + 4 * 4;
            store_halves(low, high, v[i], is_streamed);
        }
    }
    if (x == n)
        return;
    divide_pixels(sum, coverage, least, x, n - x, v);
    for (int i = 0; i < n - x; i++)
        for (int p = 0; p < 4; p++)
            rgba[4 * (x + i) + p] = v[p][i];
}
