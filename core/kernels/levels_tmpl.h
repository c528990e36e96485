/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Coarse levels: T averaged down, and their sums magnified and added to the canvas;
 * composite.c says what is computed. Part of kernels_tmpl.c.
 */
#include "kernels/kernels.h"
#include "kernels/vector.h"

/*
 * What is left of T: so little that it does not show counts as nothing, for every pixel
 * on its own, so that tiles may end early where all of theirs is used up.
 */
static inline vf still_open(vf t)
{
    return choose(t > SPLAT(RF_USED_UP), t, SPLAT(0));
}

static void average(const float *t, size_t stride, int n_rows, int level, int n_level,
                    float *row, float *out)
{
    int size = 1 << level, n = n_level << level;
    for (int x = 0; x < n; x += LANES) {
        vf sum = vmax(LOAD(t + x), SPLAT(0));
        for (int y = 1; y < n_rows; y++)
            sum += vmax(LOAD(t + (size_t)y * stride + x), SPLAT(0));
        STORE(row + x, sum);
    }
    float scale = 1.0f / (float)(size * n_rows);
    sum_columns(row, level, n_level, out);
    for (int x = 0; x < n_level; x++) {
        float mean = out[x] * scale;
        out[x] = mean > RF_USED_UP ? mean : 0;
    }
}

static uint64_t find_some(const float *sum, size_t plane, int n_planes)
{
    uint64_t some = 0;
    for (int x = 0; x < RF_TILE_W; x += LANES) {
        vi any = (vi)LOAD(sum + x);
        for (int p = 1; p < n_planes; p++)
            any |= (vi)LOAD(sum + plane * (size_t)p + x);
        some |= (uint64_t)lane_bits(any << 1 != 0) << x; /* -0 is nothing, too */
    }
    return some;
}

static unsigned find_open(const float *t)
{
    unsigned open = 0;
    for (int i = 0; i < RF_TILE_W / LANES; i++)
        open |= (unsigned)(lane_bits(LOAD(t + LANES * i) > SPLAT(0)) != 0) << i;
    return open;
}

/* Pixels 2 i and 2 i + 1 lie 3/4 px after in[i] and 1/4 after in[i + 1]. */
static inline void stretch_twice(const float *in, float *out)
{
    for (int i = 0; i < RF_TILE_W / 2; i += LANES) {
        vf a = LOAD(in + i), b = LOAD(in + i + 1), c = LOAD(in + i + 2);
        vf even = a + SPLAT(0.75f) * (b - a), odd = b + SPLAT(0.25f) * (c - b);
        STORE(out + 2 * i, INTERLEAVE(even, odd, 0));
        STORE(out + 2 * i + LANES, INTERLEAVE(even, odd, 4));
    }
}

static inline void stretch_four_times(const float *in, float *out)
{
    for (int i = 0; i < RF_TILE_W / 4; i += LANES) {
        vf a = LOAD(in + i), b = LOAD(in + i + 1), c = LOAD(in + i + 2);
        vf v0 = a + SPLAT(0.625f) * (b - a), v1 = a + SPLAT(0.875f) * (b - a);
        vf v2 = b + SPLAT(0.125f) * (c - b), v3 = b + SPLAT(0.375f) * (c - b);
        vf even = INTERLEAVE(v0, v2, 0), odd = INTERLEAVE(v1, v3, 0);
        STORE(out + 4 * i, INTERLEAVE(even, odd, 0));
        STORE(out + 4 * i + LANES, INTERLEAVE(even, odd, 4));
        even = INTERLEAVE(v0, v2, 4);
        odd = INTERLEAVE(v1, v3, 4);
        STORE(out + 4 * i + 2 * LANES, INTERLEAVE(even, odd, 0));
        STORE(out + 4 * i + 3 * LANES, INTERLEAVE(even, odd, 4));
    }
}

static inline void stretch_eight_times(const float *in, float *out)
{
    const vi is_first = lane_numbers() < 4;
    const vf half = choose(is_first, SPLAT(4.5f), SPLAT(-3.5f));
    const vf k = (to_float(lane_numbers()) + half) * SPLAT(0.125f);
    for (int i = 0; i < RF_TILE_W / LANES; i++) {
        vf a = choose(is_first, SPLAT(in[i]), SPLAT(in[i + 1]));
        vf b = choose(is_first, SPLAT(in[i + 1]), SPLAT(in[i + 2]));
        STORE(out + LANES * i, a + k * (b - a));
    }
}

static void stretch(const float *in, int level, int first, float *out)
{
    const int size = 1 << level;
    if (level == 1)
        stretch_twice(in, out);
    else if (level == 2)
        stretch_four_times(in, out);
    else if (level == 3)
        stretch_eight_times(in, out);
    else
        for (int x = 0; x < RF_TILE_W; x += LANES) {
            int at = first + x + size / 2, i = at >> level;
            vf k = to_float(lane_numbers() + (at - (i << level))) + SPLAT(0.5f);
            vf a = SPLAT(in[i]);
            k *= SPLAT(1.0f / (float)size);
            STORE(out + x, a + k * (SPLAT(in[i + 1]) - a));
        }
}

static inline __attribute__((always_inline)) void
merge_all(float *t, float *sum, size_t plane, const float *low, const float *high,
          float share, unsigned parts, int n_planes)
{
    const vf dust = SPLAT(1e-12f), k = SPLAT(share);
    for (; parts; parts &= parts - 1) {
        int x = LANES * __builtin_ctz(parts);
        vf v[RF_MAX_PLANES + 1], left = LOAD(t + x);
        vi is_open = left > SPLAT(0);
        for (int p = 0; p <= n_planes; p++) {
            vf a = LOAD(low + RF_TILE_W * p + x);
            v[p] = a + k * (LOAD(high + RF_TILE_W * p + x) - a);
        }
        vf w = v[n_planes - 1], b = v[n_planes];
        vf m = choose(w < b, left * (w / vmax(b, dust)), left);
        /* Light may reach a little farther than the coverage of its surface. */
        vf q = choose(w > dust, m / vmax(w, dust), left / vmax(b, dust));
        q = choose(is_open, q, SPLAT(0));
        /* Outside the level's active tiles there is neither coverage nor T. */
        m = choose(is_open & (w > dust), m, SPLAT(0));
        for (int p = 0; p < n_planes; p++) {
            float *s = sum + plane * (size_t)p + x;
            STORE(s, LOAD(s) + (p < n_planes - 1 ? q * v[p] : m));
        }
        STORE(t + x, still_open(left - m));
    }
}

static void merge(float *t, float *sum, size_t plane, const float *low,
                  const float *high, float share, unsigned parts, int n_planes)
{
    if (n_planes == RF_LONE_PLANES)
        merge_all(t, sum, plane, low, high, share, parts, RF_LONE_PLANES);
    else if (n_planes == 4)
        merge_all(t, sum, plane, low, high, share, parts, 4);
    else
        merge_all(t, sum, plane, low, high, share, parts, RF_MAX_PLANES);
}
