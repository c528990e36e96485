/* SPDX-License-Identifier: Apache-2.0 */
/*
 * recursive-offset: four shifts in x, the result is the next input, four shifts in +,
 * and so on, n times.
 *
 *   B_0 = the picture
 *   B_k+1(p) = 1/4 sum of B_k(p + d), d in {(+-e, +-e)}       k even: x
 *                                     d in {(+-e, 0), (0, +-e)}  k odd: +
 *   e = D 2^-floor(k/2),   D^2 = (r^2 / 4) / V,   V = sum over k of 4^-floor(k/2) q_k,
 *   q_k = 1 for x and 1/2 for +
 *
 *   r   radius of the pixel, px      n   --recursions      D   the first shift, px
 *
 * The lattice of copies of an x and a + with the same shift has half the spacing of the
 * shift before; so the shift halves after each pair, and the 4^n copies lie evenly. D
 * gives their mean square distance that of a disc. A shift e between the whole numbers
 * k and k + 1 mixes the two averages, the second by (e^2 - k^2) / (2 k + 1), which
 * keeps the mean square distance as well.
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "recursive offset": x, then +, alternating; 2 or 3 recursions. The lengths of the
 * shifts are ours.
 *
 * Known artefacts: 4^n separate copies where the radius is large, a square lattice;
 * each recursion gathers by the pixel's own radius, so blurred outlines end sharply.
 *
 * Cost: eight loads per pixel and recursion, whatever the radius.
 */
#include "methods/preview/recursive_offset.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

struct recursion {
    const struct rf_blur *blur;
    const struct rf_grid *from;
    struct rf_grid *to; /* NULL: to blur->put */
    bool is_cross;      /* x, not + */
    float scale;        /* e^2 / r^2 */
};

/* Places before and after i at distances k and k + 1. */
struct around {
    int near_left, near_right, far_left, far_right;
};

static inline struct around places(int i, int k, int n)
{
    return (struct around){rf_max_int(i - k, 0), rf_min_int(i + k, n - 1),
                           rf_max_int(i - k - 1, 0), rf_min_int(i + k + 1, n - 1)};
}

/* Quarters are added, so that the sum of the largest floats stays finite: the bits of
 * smaller ones are those of a quarter of the sum. */
static inline rf_f4 mean_of(rf_f4 a, rf_f4 b, rf_f4 c, rf_f4 d)
{
    const rf_f4 quarter = rf_f4_of(0.25f);
    return (a * quarter + b * quarter) + (c * quarter + d * quarter);
}

static inline rf_f4 shift_cross(const struct rf_grid *from, int x, int y, int k,
                                float g)
{
    struct around h = places(x, k, from->width), v = places(y, k, from->height);
    const rf_f4 *top = from->at + (size_t)v.near_left * (size_t)from->width;
    const rf_f4 *low = from->at + (size_t)v.near_right * (size_t)from->width;
    const rf_f4 *above = from->at + (size_t)v.far_left * (size_t)from->width;
    const rf_f4 *below = from->at + (size_t)v.far_right * (size_t)from->width;
    rf_f4 near = mean_of(top[h.near_left], top[h.near_right], low[h.near_left],
                         low[h.near_right]);
    rf_f4 far = mean_of(above[h.far_left], above[h.far_right], below[h.far_left],
                        below[h.far_right]);
    return near + rf_f4_of(g) * (far - near);
}

static inline rf_f4 shift_plus(const struct rf_grid *from, int x, int y, int k, float g)
{
    struct around h = places(x, k, from->width), v = places(y, k, from->height);
    size_t width = (size_t)from->width;
    const rf_f4 *row = from->at + (size_t)y * width, *column = from->at + x;
    rf_f4 near = mean_of(row[h.near_left], row[h.near_right],
                         column[(size_t)v.near_left * width],
                         column[(size_t)v.near_right * width]);
    rf_f4 far =
        mean_of(row[h.far_left], row[h.far_right], column[(size_t)v.far_left * width],
                column[(size_t)v.far_right * width]);
    return near + rf_f4_of(g) * (far - near);
}

static void shift_piece(const struct recursion *s, int x, int y, int n, rf_f4 *out)
{
    float share[RF_PIECE];
    int whole[RF_PIECE];
    rf_blur_radii(s->blur, x, y, n, share);
    for (int i = 0; i < n; i++) {
        float e2 = share[i] * share[i] * s->scale;
        whole[i] = (int)sqrtf(e2);
        float k = (float)whole[i];
        share[i] = (e2 - k * k) / (2 * k + 1);
    }
    if (s->is_cross)
        for (int i = 0; i < n; i++)
            out[i] = shift_cross(s->from, x + i, y, whole[i], share[i]);
    else
        for (int i = 0; i < n; i++)
            out[i] = shift_plus(s->from, x + i, y, whole[i], share[i]);
}

static void shift_band(void *user, int from, int to, int thread)
{
    const struct recursion *s = user;
    int width = s->from->width;
    for (int y = from; y < to; y++)
        for (int x = 0; x < width; x += RF_PIECE) {
            rf_f4 out[RF_PIECE];
            int n = rf_min_int(RF_PIECE, width - x);
            if (s->to) {
                rf_f4 *row = s->to->at + (size_t)y * (size_t)width + (size_t)x;
                shift_piece(s, x, y, n, row);
                continue;
            }
            shift_piece(s, x, y, n, out);
            s->blur->put(s->blur, x, y, n, out);
        }
}

/* D^2 / r^2. */
static double first_shift(int n)
{
    double v = 0, share = 1;
    for (int k = 0; k < n; k++) {
        v += k % 2 ? share / 2 : share;
        if (k % 2)
            share /= 4;
    }
    return 0.25 / v;
}

rf_result rf_generate_recursive_offset(const struct rf_blur *blur,
                                       struct rf_error *error)
{
    const struct rf_context *context = blur->frame->context;
    int width = blur->source->width, height = blur->source->height;
    int n = blur->frame->params.recursions;
    struct rf_grid steps[2] = {{0}, {0}};
    struct recursion s = {.blur = blur, .from = blur->source};
    bool is_complete = (n < 2 || rf_grid_alloc(context, &steps[0], width, height)) &&
                       (n < 3 || rf_grid_alloc(context, &steps[1], width, height));
    double scale = first_shift(n);
    for (int k = 0; k < n && is_complete; k++) {
        s.is_cross = k % 2 == 0;
        s.scale = (float)scale;
        s.to = k + 1 < n ? &steps[k % 2] : NULL;
        rf_blur_pass(blur, k, n, height, RF_BAND_ROWS, shift_band, &s);
        s.from = s.to;
        if (k % 2)
            scale /= 4;
    }
    rf_free(context, steps[1].at);
    rf_free(context, steps[0].at);
    return is_complete ? RF_OK
                       : rf_fail_memory(error, (size_t)width * (size_t)height,
                                        2 * sizeof(rf_f4));
}
