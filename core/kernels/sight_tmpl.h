/* SPDX-License-Identifier: Apache-2.0 */
/* Which view sees what: views_sight.c says why; part of kernels_tmpl.c. */
#include "base/math.h"
#include "kernels/sight_kernels.h"
#include "kernels/vector.h"

static inline vf vsnap(vf v)
{
    static const float ROUND = 98304; /* as rf_snap_px() has it */
    return (v + SPLAT(ROUND)) - SPLAT(ROUND);
}

/* Of any number: beyond 1e9 it is that. */
static inline vi bounded_floor(vf v)
{
    v = choose(v > SPLAT(-1e9f), v, SPLAT(-1e9f));
    v = choose(v < SPLAT(1e9f), v, SPLAT(1e9f));
    vi i = to_int(v);
    return i + (v < to_float(i)); /* true is -1 */
}

static inline vf shift_of(const struct rf_sight *s, vf r)
{
    return SPLAT(s->shift_scale) * r + SPLAT(s->shift_bias);
}

static void place_row(const struct rf_sight *own, int x, int y,
                      struct rf_sight_places *p)
{
    vf r = LOAD(own->radius + own->stride * (size_t)y + x), shift = shift_of(own, r);
    vf at = to_float(lane_numbers() + x) + SPLAT(0.5f);
    STORE(p->x, at - vsnap(SPLAT(own->lens[0]) * shift));
    STORE(p->y, SPLAT((float)y + 0.5f) + vsnap(SPLAT(own->lens[1]) * shift));
    STORE(p->r, r);
}

static void place_parts(const struct rf_sight *own, int n, struct rf_sight_places *p)
{
    for (int i = 0; i < n; i += LANES) {
        vf shift = shift_of(own, LOAD(p->r + i));
        STORE(p->x + i, LOAD(p->x + i) - vsnap(SPLAT(own->lens[0]) * shift));
        STORE(p->y + i, LOAD(p->y + i) + vsnap(SPLAT(own->lens[1]) * shift));
    }
}

/* What a view has at eight pixels, where `is_rendered`: mostly side by side. */
static inline vf look_at(const struct rf_sight *s, vi x, vi y, unsigned is_rendered)
{
    vi x0 = {x[0], x[0], x[0], x[0], x[0], x[0], x[0], x[0]};
    vi y0 = {y[0], y[0], y[0], y[0], y[0], y[0], y[0], y[0]};
    vi is_beside = (x == x0 + lane_numbers()) & (y == y0);
    if (is_rendered == 0xff && lane_bits(is_beside) == 0xff)
        return LOAD(s->radius + s->stride * (size_t)y[0] + x[0]);
    float r[LANES] = {0};
    for (; is_rendered; is_rendered &= is_rendered - 1) {
        int l = __builtin_ctz(is_rendered);
        r[l] = s->radius[s->stride * (size_t)y[l] + (size_t)x[l]];
    }
    return LOAD(r);
}

static inline vi splat_int(int32_t i)
{
    return (vi){i, i, i, i, i, i, i, i};
}

/* The pixels of a view at eight places; returns which of them were rendered. */
static inline unsigned pixels_at(const struct rf_sight *s,
                                 const struct rf_sight_places *p, int i, vi *x, vi *y)
{
    vf shift = shift_of(s, LOAD(p->r + i));
    *x = bounded_floor(LOAD(p->x + i) + vsnap(SPLAT(s->lens[0]) * shift));
    *y = bounded_floor(LOAD(p->y + i) - vsnap(SPLAT(s->lens[1]) * shift));
    return lane_bits((*x >= splat_int(s->x0)) & (*x < splat_int(s->x1)) &
                     (*y >= splat_int(s->y0)) & (*y < splat_int(s->y1)));
}

static void find_pixels(const struct rf_sight *s, const struct rf_sight_places *p,
                        int n, struct rf_sight_found *found)
{
    found->rendered = found->clear = 0;
    for (int i = 0; i < n; i += LANES) {
        vi x, y;
        found->rendered |= pixels_at(s, p, i, &x, &y) << i;
        memcpy(found->x + i, &x, sizeof x);
        memcpy(found->y + i, &y, sizeof y);
    }
    found->rendered &= (1u << n) - 1;
}

static void look_for_parts(const struct rf_sight *s, const struct rf_sight_places *p,
                           int n, float nearer, struct rf_sight_found *found)
{
    found->rendered = found->clear = 0;
    for (int i = 0; i < n; i += LANES) {
        vi x, y;
        unsigned is_rendered = pixels_at(s, p, i, &x, &y);
        vf r = LOAD(p->r + i), near = look_at(s, x, y, is_rendered);
        vi is_clear = (near >= r - SPLAT(nearer)) & (near < SPLAT(INFINITY));
        memcpy(found->x + i, &x, sizeof x);
        memcpy(found->y + i, &y, sizeof y);
        found->rendered |= is_rendered << i;
        found->clear |= (lane_bits(is_clear) & is_rendered) << i;
    }
    found->rendered &= (1u << n) - 1;
    found->clear &= (1u << n) - 1;
}

static uint64_t find_finite_from(const float *v, float least, int n)
{
    uint64_t found = 0;
    for (int x = 0; x < n; x += LANES) {
        vf at = load_part(v + x, n - x);
        vi is_found = (at >= SPLAT(least)) & (at < SPLAT(INFINITY));
        found |= (uint64_t)lane_bits(is_found) << x;
    }
    return found & UINT64_MAX >> (64 - n);
}

/* Eight places in a block, from its middle. */
static inline vf from_middle(void)
{
    return to_float(lane_numbers()) - SPLAT(0.5f * (LANES - 1));
}

static inline float sum_of(vf v)
{
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

static void fit_plane(const float *low, const float *high, size_t stride,
                      float level_px, struct rf_sight_plane *out)
{
    static const float SQUARES = LANES * LANES * (LANES * LANES - 1) / 12.0f;
    vf lowest = LOAD(low), highest = LOAD(high), sum = {0}, down = {0}, rough = {0};
    for (int y = 0; y < LANES; y++) {
        vf r = LOAD(low + stride * (size_t)y);
        lowest = vmin(r, lowest);
        highest = vmax(LOAD(high + stride * (size_t)y), highest);
        sum += r;
        down += SPLAT((float)y - 0.5f * (LANES - 1)) * r;
    }
    *out = (struct rf_sight_plane){lowest[0], highest[0], 0, {0, 0}, 0};
    for (int l = 1; l < LANES; l++) {
        out->lowest = rf_min_float(lowest[l], out->lowest);
        out->highest = rf_max_float(highest[l], out->highest);
    }
    if (out->highest - out->lowest < level_px) {
        out->level = 0.5f * (out->lowest + out->highest);
        out->rough = out->highest - out->lowest;
        return;
    }
    out->level = sum_of(sum) / (LANES * LANES);
    out->slope[0] = sum_of(from_middle() * sum) / SQUARES;
    out->slope[1] = sum_of(down) / SQUARES;
    vf row = SPLAT(out->level) + SPLAT(out->slope[0]) * from_middle();
    for (int y = 0; y < LANES; y++) {
        vf plane = row + SPLAT(out->slope[1] * ((float)y - 0.5f * (LANES - 1)));
        rough = vmax(plane - LOAD(low + stride * (size_t)y), rough);
        rough = vmax(LOAD(high + stride * (size_t)y) - plane, rough);
    }
    for (int l = 0; l < LANES; l++)
        out->rough = rf_max_float(rough[l], out->rough);
}
