/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Fringes: a small bright thing bleeds into a pixel whose depth sample missed it.
 * split.c says what splitting is for.
 */
#include "surfaces/split_fringe.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/math.h"
#include "kernels/data.h"
#include "surfaces/split_pixels.h"
#include "surfaces/surfaces.h"

/* Ours. Half or twice: no scene of tests/quality changes by more than 0.02 dB. */
static const float FRINGE_RATIO = 2;       /* fringe over the surroundings */
static const float SAME_SURFACE_PX = 0.3f; /* radii of one surface */

enum { WINDOW = 2, BASE_WINDOW = RF_SPLIT_REACH };

struct highlight {
    struct rf_surface brightest;
    float peak;   /* luminance of the brightest pixel around */
    float median; /* lower third of the luminances around: the surroundings */
    float r;      /* median radius of its bright pixels */
};

/* What surroundings of luminance v count as: no darker than black, and never 0. */
static float shade_of(float v)
{
    return rf_max_float(v, 0) + 1e-4f;
}

/* Does the luminance v around a pixel of luminance l let both stand out from it? */
static bool is_surrounding(float v, float l, float peak)
{
    float shade = shade_of(v);
    return (peak > RF_HIGHLIGHT_RATIO * shade) & (l > FRINGE_RATIO * shade);
}

/* is_surrounding() of four pixels, all bits or none. */
static rf_truths are_surrounding(rf_quad v, float l, float peak)
{
    const rf_quad all_l = {l, l, l, l}, all_peak = {peak, peak, peak, peak}, none = {0};
    rf_quad shade = (rf_quad)((rf_truths)v & (v > none)) + 1e-4f;
    return (all_peak > RF_HIGHLIGHT_RATIO * shade) & (all_l > FRINGE_RATIO * shade);
}

/* Pixels of 5 x 5, none of which is outside, that are surroundings. */
static int count_surrounding(const float *const rows[2 * WINDOW + 1], int x, float l,
                             float peak)
{
    rf_truths n = {0};
    int n_last = 0;
    for (int j = 0; j <= 2 * WINDOW; j++) {
        const float *v = rows[j] + x - WINDOW;
        n -= are_surrounding(*(const rf_quad *)v, l, peak);
        n_last += is_surrounding(v[2 * WINDOW], l, peak);
    }
    return n[0] + n[1] + n[2] + n[3] + n_last;
}

bool rf_may_be_fringe(const struct rf_pixels *p, int x, int y, float peak)
{
    enum { ALL = (2 * WINDOW + 1) * (2 * WINDOW + 1) };
    struct rf_split_window w = rf_split_window_at(p, x, y, WINDOW);
    float l = rf_plane_row(p, p->luminance, y)[x];
    if (!(peak > RF_HIGHLIGHT_OVER_FRINGE * l))
        return false;
    int n = (w.x1 - w.x0 + 1) * (w.y1 - w.y0 + 1), n_dark = 0;
    if (n == ALL) {
        const float *rows[2 * WINDOW + 1];
        rf_plane_rows(p, p->luminance, y, WINDOW, rows);
        return count_surrounding(rows, x, l, peak) > n / 3;
    }
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            n_dark += is_surrounding(rf_plane_row(p, p->luminance, j)[i], l, peak);
    return n_dark > n / 3;
}

static bool find_highlight(const struct rf_pixels *p, int x, int y, struct highlight *h)
{
    float sorted[(2 * WINDOW + 1) * (2 * WINDOW + 1)] = {0};
    struct rf_split_window w = rf_split_window_at(p, x, y, WINDOW);
    h->peak = -1;
    h->brightest = *rf_split_pixel(p, x, y);
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            float l = rf_split_luminance(rf_split_pixel(p, i, j));
            if (l > h->peak) {
                h->peak = l;
                h->brightest = *rf_split_pixel(p, i, j);
            }
        }
    int n = 0;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            rf_split_insert_sorted(sorted, n++,
                                   rf_split_luminance(rf_split_pixel(p, i, j)));
    h->median = shade_of(sorted[n / 3]);
    n = 0;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++)
            if (rf_split_luminance(rf_split_pixel(p, i, j)) >= 0.6f * h->peak)
                rf_split_insert_sorted(sorted, n++, rf_split_pixel(p, i, j)->r);
    h->r = sorted[n / 2];
    return fabsf(h->r - rf_split_pixel(p, x, y)->r) > 0.08f;
}

/* What the pixel would show without the highlight. */
static void base_colour(const struct rf_pixels *p, int x, int y,
                        const struct highlight *h, float base[4])
{
    const struct rf_surface *c = rf_split_pixel(p, x, y);
    struct rf_split_window w = rf_split_window_at(p, x, y, BASE_WINDOW);
    float sum[4] = {0}, total = 0;
    for (int j = w.y0; j <= w.y1; j++)
        for (int i = w.x0; i <= w.x1; i++) {
            const struct rf_surface *q = rf_split_pixel(p, i, j);
            if (fabsf(q->r - c->r) > SAME_SURFACE_PX ||
                rf_split_luminance(q) > 1.5f * h->median)
                continue;
            float k = rf_split_distance_weight(i - x, j - y);
            for (int n = 0; n < 4; n++)
                sum[n] += k * q->c[n];
            total += k;
        }
    float l = rf_split_luminance(c);
    for (int n = 0; n < 4; n++)
        base[n] = total > 0 ? sum[n] / total : c->c[n] * (n < 3 ? h->median / l : 1);
}

bool rf_split_fringe(const struct rf_pixels *p, int x, int y, struct rf_surface *near,
                     struct rf_surface *far, float *share)
{
    struct highlight h;
    if (!find_highlight(p, x, y, &h))
        return false;
    const struct rf_surface *c = rf_split_pixel(p, x, y);
    struct rf_surface base = {.r = c->r}, light = {.r = h.r};
    base_colour(p, x, y, &h, base.c);
    float base_l = rf_split_luminance(&base);
    float a = rf_split_share_of((rf_split_luminance(c) - base_l) / (h.peak - base_l));
    for (int n = 0; n < 4; n++) {
        light.c[n] = a > 0 ? (c->c[n] - (1 - a) * base.c[n]) / a : h.brightest.c[n];
        light.c[n] = rf_max_float(light.c[n], rf_min_float(c->c[n], 0));
    }
    bool is_light_near = h.r < c->r;
    *near = is_light_near ? light : base;
    *far = is_light_near ? base : light;
    *share = is_light_near ? a : 1 - a;
    return true;
}
