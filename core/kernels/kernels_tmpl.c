/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compiled once per instruction set with RF_LEVEL set to its name.
 *
 *   spread   acc[p][x] += s w c_p F[x]     F the footprint's weights, p the planes, s
 *                                          what the slant makes of a cell's light
 *   flush    w = T f(acc_w / T),  sum_p += acc_p w / acc_w,  T -= w
 *
 * with f(x) = min(x, 1), but out of focus for a ramp from 0.9 at x = 0.9 to 1 at x = 0.95:
 * a curved surface covers pixels to 95 % only, and the rest must not be let through to
 * what lies behind (worth 0.5 dB on a house before a sky, 1.2 on columns, -0.1 on plane;
 * a wider ramp moves the edges of mattes by 0.1 and costs plane 0.3).
 *
 * Preconditions: segments are padded with zero weights to eight lanes; a footprint
 * reaches at most RF_TILE_HALO px from its middle, which lies at most 9 px beside its
 * pixel.
 */
#include "kernels/frame_tmpl.h"
#include "kernels/hidden_tmpl.h"
#include "kernels/kernels.h"
#include "kernels/levels_tmpl.h"
#include "kernels/shadows_tmpl.h"
#include "kernels/sight_tmpl.h"
#include "kernels/slants_tmpl.h"
#include "kernels/split_tmpl.h"
#include "kernels/spread_tmpl.h"
#include "kernels/vector.h"

#define RF_CONCAT2(a, b) a##b
#define RF_CONCAT(a, b) RF_CONCAT2(a, b)
#define RF_TEXT2(a) #a
#define RF_TEXT(a) RF_TEXT2(a)

_Static_assert(LANES == RF_FOOTPRINT_LANES, "segments are padded to whole vectors");

/* A bit for each of eight pixels that find_others() finds. */
static inline __attribute__((always_inline)) unsigned
others_of(vf share, vf luminance, vf r, vf darkest, vf bright, vf most_r2)
{
    vf limit = bright + bright * vmin(r * r, most_r2);
    return lane_bits((share < SPLAT(1)) | (luminance > limit * darkest));
}

static void find_others(const float *share, const float *luminance, const float *radius,
                        const float *darkest, float bright, float most_r2, int n,
                        uint64_t *bits)
{
    const vf k = SPLAT(bright), most = SPLAT(most_r2);
    for (int x = 0; x < n; x += 64) {
        uint64_t found = 0;
        int end = n - x < 64 ? n - x : 64, i = 0;
        for (; i + LANES <= end; i += LANES)
            found |= (uint64_t)others_of(LOAD(share + x + i), LOAD(luminance + x + i),
                                         LOAD(radius + x + i), LOAD(darkest + x + i), k,
                                         most)
                     << i;
        if (i < end) {
            int m = end - i, at = x + i;
            unsigned last = others_of(
                load_part(share + at, m), load_part(luminance + at, m),
                load_part(radius + at, m), load_part(darkest + at, m), k, most);
            found |= (uint64_t)(last & ((1u << m) - 1)) << i;
        }
        bits[x / 64] = found;
    }
}

static void find_above(const float *v, float limit, int n, uint64_t *bits)
{
    const vf most = SPLAT(limit);
    for (int x = 0; x < n; x += 64) {
        uint64_t found = 0;
        int end = n - x < 64 ? n - x : 64, i = 0;
        for (; i + LANES <= end; i += LANES)
            found |= (uint64_t)lane_bits(LOAD(v + x + i) > most) << i;
        if (i < end)
            found |= (uint64_t)lane_bits(load_part(v + x + i, end - i) > most) << i;
        bits[x / 64] = found;
    }
}

/*
 * Coverage below this must not be divided by. Light is there all the same at the rim of
 * a footprint, where the cubic's weights are negative and those of light are not.
 */
static const float DUST = 1e-12f;

/* f(x) of the head of this file; x >= 0 where it counts. */
static inline vf saturate(vf x, float from)
{
    vf ramp = SPLAT(0.9f) + (x - SPLAT(0.9f)) * SPLAT(2);
    return vmin(SPLAT(1), choose(x > SPLAT(from), ramp, x));
}

/* A cell's sums, with its share of what all cells have in common. */
static inline __attribute__((always_inline)) vf
gathered(const float *acc, const float *common, float share)
{
    vf v = LOAD(acc);
    return common ? v + SPLAT(share) * LOAD(common) : v;
}

static inline __attribute__((always_inline)) void
flush_row(float *acc, const float *common, float share, float *t, float *sum,
          size_t plane, int n_planes, const float *least, float ramp)
{
    for (int x = 0; x < RF_TILE_W; x += LANES) {
        float *a = acc + RF_ACC_LEFT + x;
        const float *b = common ? common + RF_ACC_LEFT + x : NULL;
        const int last = (n_planes - 1) * RF_ACC_STRIDE;
        vf w = gathered(a + last, common ? b + last : NULL, share);
        vf left = vmax(LOAD(t + x), SPLAT(0));
        vf m = left * saturate(w / vmax(left, SPLAT(DUST)), ramp);
        vi has_surface = w > SPLAT(DUST);
        vf q = choose(has_surface, m / vmax(w, SPLAT(DUST)),
                      choose(left > SPLAT(0), SPLAT(1), SPLAT(0)));
        m = choose(has_surface, m, SPLAT(0));
        for (int p = 0; p < n_planes - 1; p++) {
            float *s = sum + plane * (size_t)p + x;
            vf c = gathered(a + p * RF_ACC_STRIDE,
                            common ? b + p * RF_ACC_STRIDE : NULL, share);
            STORE(s, LOAD(s) + q * choose(has_surface, c, vmax(c, SPLAT(least[p]))));
            STORE(a + p * RF_ACC_STRIDE, SPLAT(0));
        }
        STORE(a + last, SPLAT(0));
        float *covered = sum + plane * (size_t)(n_planes - 1) + x;
        STORE(covered, LOAD(covered) + m);
        STORE(t + x, still_open(left - m));
    }
    for (int p = 0; p < n_planes; p++) {
        float *margin = acc + p * RF_ACC_STRIDE;
        for (int x = 0; x < RF_ACC_LEFT; x += LANES)
            STORE(margin + x, SPLAT(0));
        for (int x = RF_ACC_LEFT + RF_TILE_W; x < RF_ACC_STRIDE; x += LANES)
            STORE(margin + x, SPLAT(0));
    }
}

static inline __attribute__((always_inline)) void
flush_all(struct rf_spread_sums *acc, const struct rf_tile_state *state, int n_planes)
{
    const size_t row_size = (size_t)n_planes * RF_ACC_STRIDE;
    float *const common = acc->at + row_size * RF_TILE_H * (size_t)acc->n_cells;
    for (int c = 0; c < acc->n_cells; c++)
        for (int y = acc->first_row; y <= acc->last_row; y++) {
            float *row = acc->at + ((size_t)c * RF_TILE_H + (size_t)y) * row_size;
            float *t = state->t + state->t_plane * (size_t)c + state->t_row * (size_t)y;
            float *sum = state->sum + state->cell * (size_t)c + state->row * (size_t)y;
            if (acc->common_rows >> y & 1)
                flush_row(row, common + row_size * (size_t)y, acc->share[c], t, sum,
                          state->plane, n_planes, acc->least, acc->ramp);
            else
                flush_row(row, NULL, 0, t, sum, state->plane, n_planes, acc->least,
                          acc->ramp);
        }
    for (int y = acc->first_row; y <= acc->last_row; y++)
        if (acc->common_rows >> y & 1)
            memset(common + row_size * (size_t)y, 0, row_size * sizeof *common);
    acc->common_rows = 0;
    acc->first_row = RF_TILE_H;
    acc->last_row = -1;
}

static void flush(struct rf_spread_sums *acc, const struct rf_tile_state *state)
{
    if (acc->n_planes == RF_LONE_PLANES)
        flush_all(acc, state, RF_LONE_PLANES);
    else if (acc->n_planes == 4)
        flush_all(acc, state, 4);
    else
        flush_all(acc, state, RF_MAX_PLANES);
}

/* row[X] and row[X + 1] at the fractions (i + 1/2) / 2^level between them. */
static void magnify_row(const float *row, int n_level, int level, float *out, int n)
{
    const int size = 1 << level, half = size / 2;
    const vf step = SPLAT(1.0f / (float)size);
    for (int x = 0; x < half && x < n; x++)
        out[x] = row[0];
    int i = 0;
    if (level == 1)
        for (; i + LANES < n_level && half + 2 * (i + LANES) <= n; i += LANES) {
            vf a = LOAD(row + i), d = LOAD(row + i + 1) - a;
            vf low = a + SPLAT(0.25f) * d, high = a + SPLAT(0.75f) * d;
            STORE(out + half + 2 * i, INTERLEAVE(low, high, 0));
            STORE(out + half + 2 * i + LANES, INTERLEAVE(low, high, 4));
        }
    if (level == 2)
        for (; i + LANES < n_level && half + 4 * (i + LANES) <= n; i += LANES) {
            vf a = LOAD(row + i), d = LOAD(row + i + 1) - a;
            vf v0 = a + SPLAT(0.125f) * d, v1 = a + SPLAT(0.375f) * d;
            vf v2 = a + SPLAT(0.625f) * d, v3 = a + SPLAT(0.875f) * d;
            float *to = out + half + 4 * i;
            vf even = INTERLEAVE(v0, v2, 0), odd = INTERLEAVE(v1, v3, 0);
            STORE(to, INTERLEAVE(even, odd, 0));
            STORE(to + LANES, INTERLEAVE(even, odd, 4));
            even = INTERLEAVE(v0, v2, 4);
            odd = INTERLEAVE(v1, v3, 4);
            STORE(to + 2 * LANES, INTERLEAVE(even, odd, 0));
            STORE(to + 3 * LANES, INTERLEAVE(even, odd, 4));
        }
    for (; i + 1 < n_level && half + size * i < n; i++) {
        float a = row[i], d = row[i + 1] - a;
        float *to = out + half + size * i;
        int m = n - (half + size * i) < size ? n - (half + size * i) : size;
        if (m >= LANES && size >= LANES) {
            vf k = (to_float(lane_numbers()) + SPLAT(0.5f)) * step;
            for (int x = 0; x + LANES <= m; x += LANES, k += SPLAT(LANES) * step)
                STORE(to + x, SPLAT(a) + k * SPLAT(d));
            m = m / LANES * LANES == m ? 0 : m;
        }
        for (int x = 0; x < m; x++)
            to[x] = a + ((float)x + 0.5f) * step[0] * d;
    }
    for (int x = half + size * (n_level - 1); x < n; x++)
        out[x] = row[n_level - 1];
}

static void magnify(const float *a, const float *b, float k, int n_level, int level,
                    float *row, float *out, int n)
{
    int x = 0;
    for (; x + LANES <= n_level; x += LANES) {
        vf low = LOAD(a + x);
        STORE(row + x, low + SPLAT(k) * (LOAD(b + x) - low));
    }
    for (; x < n_level; x++)
        row[x] = a[x] + k * (b[x] - a[x]);
    magnify_row(row, n_level, level, out, n);
}

static inline vd radii_of(const struct rf_plain_depth *d, vd value, vl *n_good,
                          vl *n_known)
{
    vd v = value * SPLAT_D(d->factor) + SPLAT_D(d->offset);
    *n_good -= v >= SPLAT_D(0); /* true is -1 */
    *n_known -= v != SPLAT_D(0);
    vl is_nothing = (v == SPLAT_D(0)) | (v >= SPLAT_D(d->infinity));
    vd z = choose_d(is_nothing, SPLAT_D(INFINITY), v);
    vd r = SPLAT_D(d->bias) + SPLAT_D(d->scale) / z, most = SPLAT_D(d->most);
    r = choose_d(r > -most, r, -most);
    return choose_d(r < most, r, most);
}

/* The greatest magnitude of n values. */
static float largest_of(const float *v, int n)
{
    vf most = {0};
    for (int x = 0; x < n; x += LANES) {
        vf r = load_part(v + x, n - x);
        most = vmax((vf)((vi)r & ~(vi)SPLAT(-0.0f)), most);
    }
    return greatest_of(most);
}

static bool radii(const struct rf_plain_depth *depth, const float *value, int n,
                  float *radius, int64_t *n_known, float *largest)
{
    const struct rf_plain_depth d = *depth;
    vl n_good = {0}, n_some = {0};
    int x = 0;
    for (; x + LANES_D <= n; x += LANES_D)
        STORE_D(radius + x, radii_of(&d, LOAD_D(value + x), &n_good, &n_some));
    if (x < n) {
        float last[LANES_D] = {0};
        vl is_good = {0}, is_known = {0};
        memcpy(last, value + x, (size_t)(n - x) * sizeof *last);
        STORE_D(last, radii_of(&d, LOAD_D(last), &is_good, &is_known));
        memcpy(radius + x, last, (size_t)(n - x) * sizeof *last);
        for (int i = 0; i < n - x; i++) {
            n_good[i] += is_good[i];
            n_some[i] += is_known[i];
        }
    }
    *largest = largest_of(radius, n);
    int64_t good = 0;
    for (int i = 0; i < LANES_D; i++) {
        good += n_good[i];
        *n_known += n_some[i];
    }
    return good == n;
}

const struct rf_kernels RF_CONCAT(rf_kernels_, RF_LEVEL) = {
    .name = RF_TEXT(RF_LEVEL),
    .radii = radii,
    .spread = spread,
    .spread_places = spread_places,
    .find_others = find_others,
    .find_above = find_above,
    .find_slants = find_slants,
    .flush = flush,
    .average = average,
    .find_some = find_some,
    .find_open = find_open,
    .stretch = stretch,
    .merge = merge,
    .magnify = magnify,
    .extremes = extremes,
    .load_row = load_row,
    .load_rgba = load_rgba,
    .keep_edges = keep_edges,
    .find_mixed = find_mixed,
    .find_gaps = find_gaps,
    .find_sides = find_sides,
    .cast_shadows = cast_shadows,
    .unpack = unpack,
    .pack = pack,
    .shrink = shrink,
    .detail = detail,
    .join = join,
    .divide = divide,
    .divide_add = divide_add,
    .divide_rgba = divide_rgba,
    .measure_block = measure_block,
    .nearest_step = nearest_step,
    .log_row = log_row,
    .has_candidate = has_candidate,
    .quad_has_candidate = quad_has_candidate,
    .vote_blocks = vote_blocks,
    .gather_window = gather_window,
    .average_window = average_window,
    .place_parts = place_parts,
    .place_row = place_row,
    .look_for_parts = look_for_parts,
    .find_pixels = find_pixels,
    .find_finite_from = find_finite_from,
    .fit_plane = fit_plane,
};
