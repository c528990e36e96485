/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Has the guide of finish the lens of the own picture?
 *
 *   d(p) = v - G[v],  v = p / (DARK white + G2[y])
 *   b    = sum d(x) d(y) / sum d(y)^2
 *
 * over squares of SIDE px of luminance, x the own picture, y ours, G and G2 Gaussian
 * means of 3 and 2 px: how much of our detail the own picture has. The grain of x is not
 * that of y, so that b is 1 where both are blurred alike, whatever the grain; se^2 = sum
 * (d(x) - b d(y))^2 d(y)^2 / (sum d(y)^2)^2 is its error. Of squares with detail, b is off
 * in 1 to 18 % with the right lens (16 and 64 samples of posts, macro, foliage, soft,
 * plant), and in 25 to 100 % with 0.9, 1.1 and 1.25 times the focus or 0.7 and 1.4 times
 * the radius, which then come out 0.8 to 7 dB worse than without a guide; and in 85 % of a
 * room of mirrors, which comes out 1 to 5 dB worse than without one. Ours.
 */
#include "filter/finish_lens.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/luminance.h"

enum { SIDE = 24, FEWEST_SQUARES = 20 };

static const double FINE_PX = 3, BRIGHT_PX = 2;

/* Of white, as DARK in finish_light.c; fireflies of the own picture are cut at so many
 * times ours and white. */
static const float DARK = 0.02f, FIREFLY = 8;

/* Of what is seen: less detail tells nothing. */
static const double LEAST_DETAIL = 0.01;

/* The most that b may be uncertain, and the least that it is off by: a fifth of the
 * detail, beyond three times its error. */
static const double MOST_ERROR = 0.15, LEAST_OFF = 0.2, ERRORS = 3;

static const double MOST_SHARE = 0.25;

static size_t n_pixels(const struct finish_picture *p)
{
    return (size_t)p->width * (size_t)p->height;
}

/* Subtracts the Gaussian mean; `mean` and `room` are as large. */
static void take_fine(const struct finish_picture *p, float *plane, float *mean,
                      float *room)
{
    memcpy(mean, plane, n_pixels(p) * sizeof(*mean));
    finish_smooth(p, mean, room, FINE_PX);
    for (size_t i = 0; i < n_pixels(p); i++)
        plane[i] -= mean[i];
}

/* Fills d(x) and d(y); `mean` and `room` are as large. */
static void find_detail(const struct finish_picture *p, float *x, float *y, float *mean,
                        float *room)
{
    for (size_t i = 0; i < n_pixels(p); i++) {
        y[i] = luminance_of(p->ours + 3 * i, 3);
        x[i] =
            fminf(luminance_of(p->own + 3 * i, 3), FIREFLY * fmaxf(y[i], 0) + p->white);
        mean[i] = fmaxf(y[i], 0);
    }
    finish_smooth(p, mean, room, BRIGHT_PX);
    for (size_t i = 0; i < n_pixels(p); i++) {
        const float seen = DARK * p->white + mean[i];
        x[i] /= seen;
        y[i] /= seen;
    }
    take_fine(p, x, mean, room);
    take_fine(p, y, mean, room);
}

/* Looks at the square from (x0, y0). False where it tells nothing. */
static bool look_at(const struct finish_picture *p, const float *x, const float *y,
                    const int32_t from[2], bool *is_off)
{
    double both = 0, ours = 0, error = 0;
    for (int32_t k = 0; k < SIDE * SIDE; k++) {
        const size_t i = (size_t)(from[1] + k / SIDE) * (size_t)p->width +
                         (size_t)(from[0] + k % SIDE);
        both += (double)x[i] * (double)y[i];
        ours += (double)y[i] * (double)y[i];
    }
    if (ours < SIDE * SIDE * LEAST_DETAIL * LEAST_DETAIL)
        return false;
    const double b = both / ours;
    for (int32_t k = 0; k < SIDE * SIDE; k++) {
        const size_t i = (size_t)(from[1] + k / SIDE) * (size_t)p->width +
                         (size_t)(from[0] + k % SIDE);
        const double rest = ((double)x[i] - b * (double)y[i]) * (double)y[i];
        error += rest * rest;
    }
    const double deviation = sqrt(error) / ours;
    *is_off = fabs(b - 1) > fmax(LEAST_OFF, ERRORS * deviation);
    return deviation < MOST_ERROR;
}

bool finish_lens_is_other(const struct finish_picture *p, const char *guide, char *text,
                          size_t n_bytes)
{
    const size_t n = n_pixels(p);
    float *x = calloc(4 * n, sizeof(*x));
    size_t n_squares = 0, n_off = 0;
    if (!x)
        return false;
    find_detail(p, x, x + n, x + 2 * n, x + 3 * n);
    for (int32_t k = 0; k + SIDE <= p->height; k += SIDE)
        for (int32_t i = 0; i + SIDE <= p->width; i += SIDE) {
            bool is_off = false;
            if (!look_at(p, x, x + n, (const int32_t[2]){i, k}, &is_off))
                continue;
            n_squares++;
            n_off += is_off;
        }
    free(x);
    const double share = (double)n_off / (double)(n_squares > 0 ? n_squares : 1);
    snprintf(text, n_bytes,
             "is blurred in another way than %s in %.0f %% of what has detail: by "
             "another focus or aperture, or it shows mirrors, glass or motion that %s "
             "does not; give %s the lens of the render, or do without it, since it may "
             "come out worse with it",
             guide, 100 * share, guide, guide);
    return n_squares >= FEWEST_SQUARES && share > MOST_SHARE;
}
