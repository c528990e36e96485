/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What mean distances tell of mixed pixels. A pixel of which the near surface, at z_f,
 * has the share A and the far one, at z_b, the rest has the mean
 *
 *   m = A z_f + (1 - A) z_b      before nothing, which counts as 0: m = A z_f
 *
 * And where a far surface at z_t, which has the share T, stands before nothing, m and the
 * colours tell both, with e that of nothing:
 *
 *   T = (m - A z_f) / z_t
 *   c - e - m / z_t (t - e) = A (f - e - z_f / z_t (t - e))
 *
 * the last solved for A by least squares.
 */
#include "surfaces/split_means.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/math.h"
#include "input/frame.h"
#include "input/image.h"
#include "surfaces/split_around.h"
#include "surfaces/split_pixels.h"
#include "surfaces/splitter.h"
#include "surfaces/surfaces.h"

/* Ours; behind each what split.c says. */
static const float APART = 0.01f; /* distances whose mean tells shares, of the nearer */
static const float STRANGE = 0.1f; /* a share below 0 by this: a third surface */
/* A share so near 0 or 1, and a mean so near a distance. At 0.02 branches -0.1, cards
 * -0.1; at 0.1 cards +0.07, fur -0.03. */
static const float WHOLE = 0.05f;
/* Of a pixel that shows nothing: what may be taken out. None: branches -0.18; at 0.15
 * branches -0.01, at 0.4 snow -0.01. */
static const float MOST_TAKEN_OUT = 0.25f;
/* Times the near distance: so far lies what hit nothing, which is 0 in a mean. */
static const float NOTHING = 1e6f;

/* Planar distance of what has a radius; NAN: the radius is clipped and does not tell. */
static float distance_at(const struct rf_frame *f, float r)
{
    const struct rf_lens *lens = &f->lens;
    float from_bias = r - (float)(lens->bias_px + f->radius_shift);
    if (fabsf(r) >= (float)lens->max_radius_px)
        return NAN;
    if (lens->projection != RF_PROJECTION_PERSPECTIVE)
        return from_bias / (float)lens->scale;
    float z = (float)lens->scale / from_bias;
    return z >= 0 ? z : INFINITY; /* rounded */
}

/* The mean distance at a pixel; NAN: not known. */
static float mean_depth_at(const struct rf_splitter *s, int x, int y)
{
    x -= s->x0;
    y -= s->y0;
    bool is_inside = s->mean_depth && x >= 0 && y >= 0 && x < s->frame->width &&
                     y < s->frame->height;
    return is_inside ? *rf_image_at(s->mean_depth, x, y, 0) : NAN;
}

/* Where the pixel of a bit lies. */
static float mean_depth_of(const struct rf_splitter *s, int bit, int x, int y)
{
    return mean_depth_at(s, x + bit % RF_SIDES_AROUND - RF_SPLIT_WINDOW,
                         y + bit / RF_SIDES_AROUND - RF_SPLIT_WINDOW);
}

static float distance_of(const struct rf_splitter *s,
                         const struct rf_split_around *around, int bit)
{
    return distance_at(s->frame, (around->middle + around->steps[bit])->r);
}

/* The pixels of a set that are pure; those that hit nothing are left out of `bits`. */
static uint32_t find_pure(const struct rf_splitter *s,
                          const struct rf_split_around *around, uint32_t bits,
                          float nearest, int x, int y, uint32_t *nothing)
{
    uint32_t pure = 0;
    *nothing = 0;
    for (; bits; bits &= bits - 1) {
        int bit = __builtin_ctz(bits);
        float z = distance_of(s, around, bit), mean = mean_depth_of(s, bit, x, y);
        bool is_nothing = z >= NOTHING * nearest;
        bool is_pure =
            is_nothing ? mean < WHOLE * nearest : fabsf(mean - z) < WHOLE * z;
        pure |= (uint32_t)is_pure << bit;
        *nothing |= (uint32_t)is_nothing << bit;
    }
    return pure;
}

uint32_t rf_split_find_pure(const struct rf_splitter *s,
                            const struct rf_split_around *around, uint32_t bits,
                            float nearest_radius, int x, int y)
{
    uint32_t nothing;
    float nearest = s->mean_depth ? distance_at(s->frame, nearest_radius) : NAN;
    return nearest > 0 ? find_pure(s, around, bits, nearest, x, y, &nothing) : 0;
}

/* Distances of the near and the far surface; the pixel's own on its side. */
struct distances {
    float f, b;
};

static struct distances distances_of(const struct rf_splitter *s,
                                     const struct rf_meeting *m, float own_radius)
{
    return (struct distances){distance_at(s->frame, m->is_near ? own_radius : m->f.r),
                              distance_at(s->frame, m->is_near ? m->b.r : own_radius)};
}

/* Share of the near surface by a mean distance; NAN: not known, or there is a third. */
static float share_of_two(struct distances z, float mean)
{
    if (!(mean >= 0 && z.f > 0 && fabsf(z.b - z.f) > APART * z.f))
        return NAN;
    float share = mean < z.f  ? mean / z.f
                  : z.b > z.f ? 1 - (mean - z.f) / (z.b - z.f)
                              : NAN;
    return share > -STRANGE ? rf_clamp01(share) : NAN;
}

/* A surface before nothing, on the far side of an edge. */
struct before_nothing {
    struct rf_surface t; /* that surface */
    float distance;
    struct rf_surface e; /* nothing: a sky */
};

/* Share of the near surface, at distance f, of pixel c, where such a far side is its
 * rest; *mixture becomes the far side's colour there. NAN: there is another surface. */
static float share_of_three(const struct rf_surface *c, const struct rf_surface *near,
                            float f, const struct before_nothing *far, float mean,
                            struct rf_surface *mixture)
{
    const float k = f / far->distance, q = mean / far->distance;
    float dot = 0, norm = 0;
    for (int n = 0; n < 3; n++) {
        float e = far->e.c[n], d = far->t.c[n] - e;
        float unit = near->c[n] - e - k * d;
        dot += unit * (c->c[n] - e - q * d);
        norm += unit * unit;
    }
    /* So that neither T nor what is left for nothing is negative. */
    float most = rf_min_float(mean / f, (1 - q) / (1 - k));
    float a = rf_max_float(rf_min_float(dot / norm, most), 0);
    const bool is_finite = fabsf(dot) <= FLT_MAX && norm <= FLT_MAX;
    if (!(most >= 0 && norm > 0 && is_finite && a <= 1))
        return NAN;
    float t = (mean - a * f) / far->distance;
    for (int n = 0; a < 1 && n < 4; n++)
        mixture->c[n] = (t * far->t.c[n] + (1 - a - t) * far->e.c[n]) / (1 - a);
    return a;
}

/*
 * The colour of nothing where no pixel shows it alone: that of the pixel that has most of
 * it, less the part of the surface before it. False: that covers too much of all.
 */
static bool take_out_surface(const struct rf_splitter *s,
                             const struct rf_split_around *around, uint32_t nothing,
                             int x, int y, struct before_nothing *far)
{
    float least = MOST_TAKEN_OUT * far->distance;
    int found = -1;
    for (uint32_t bits = nothing; bits; bits &= bits - 1) {
        int bit = __builtin_ctz(bits);
        float mean = mean_depth_of(s, bit, x, y);
        found = mean < least ? bit : found;
        least = rf_min_float(mean, least);
    }
    if (found < 0)
        return false;
    const struct rf_surface *q = around->middle + around->steps[found];
    float t = least / far->distance;
    for (int n = 0; n < 4; n++)
        far->e.c[n] = rf_max_float((q->c[n] - t * far->t.c[n]) / (1 - t), 0);
    return true;
}

float rf_split_measured_share(const struct rf_splitter *s,
                              const struct rf_split_around *around,
                              struct rf_meeting *m, int x, int y)
{
    const float mean = mean_depth_at(s, x, y);
    const struct distances z = distances_of(s, m, around->middle->r);
    if (!(mean >= 0 && z.f > 0))
        return NAN;
    uint32_t nothing, pure = find_pure(s, around, m->far, z.f, x, y, &nothing);
    const uint32_t hit = m->far & ~nothing;
    if (!nothing)
        return share_of_two(z, mean);
    if (!hit)
        return mean < (1 + WHOLE) * z.f ? rf_min_float(mean / z.f, 1) : NAN;
    struct before_nothing far = {
        .t = rf_split_mean_of(around, hit & pure ? hit & pure : hit)};
    far.distance = distance_at(s->frame, far.t.r);
    if (nothing & pure)
        far.e = rf_split_mean_of(around, nothing & pure);
    else if (!take_out_surface(s, around, nothing, x, y, &far))
        return share_of_two(z, mean);
    return far.distance > (1 + WHOLE) * z.f
               ? share_of_three(around->middle, &m->f, z.f, &far, mean, &m->b)
               : NAN;
}

/* Do means tell of half of the pixels within both surfaces, which are whole, that they
 * are? */
static bool is_half_whole(const struct rf_splitter *s,
                          const struct rf_split_around *around,
                          const struct rf_meeting *m, int x, int y)
{
    int n = 0, n_whole = 0;
    for (uint32_t bits = m->own | m->other; bits; bits &= bits - 1, n++) {
        int bit = __builtin_ctz(bits);
        struct rf_meeting here = *m;
        if (m->other >> bit & 1)
            here.is_near = !m->is_near;
        float r = (around->middle + around->steps[bit])->r;
        float share =
            share_of_two(distances_of(s, &here, r), mean_depth_of(s, bit, x, y));
        n_whole += fabsf(share - (here.is_near ? 1 : 0)) < WHOLE;
    }
    return n_whole > 0 && 2 * n_whole >= n;
}

bool rf_split_are_told_whole(const struct rf_splitter *s,
                             const struct rf_split_around *around,
                             const struct rf_meeting *m, int x, int y)
{
    if (rf_min_float(fabsf(m->f.r), fabsf(m->b.r)) < RF_SPLIT_SHARP_PX) {
        const uint32_t others = ~(uint32_t)RF_SPLIT_MIDDLE;
        float r = m->f.r;
        if (rf_split_find_pure(s, around, m->near & others, r, x, y) &&
            rf_split_find_pure(s, around, m->far & others, r, x, y))
            return true;
    }
    return is_half_whole(s, around, m, x, y);
}
