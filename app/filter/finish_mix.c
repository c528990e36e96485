/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With x the host's own picture, y ours, g the host's denoised, and t(v) = v^(1/2.2)
 * of the display:
 *
 *   s   = t'(clip(G y, 0.02, 1))
 *   m   = G[s (x - y)]
 *   se2 = (H[s^2 (x - g)^2] - H[s (x - g)]^2) / (4 pi sigma^2), the error of that mean,
 *         or H[s^2 d^2] / (4 pi sigma^2) where x is the mean of x + d and x - d, two
 *         renders of half the samples
 *   b2  = tau^2 + max(0, m^2 - k se2), the error of y squared
 *   w   = G[b2 / (b2 + k se2)]
 *   out = y + w (g - y)
 *
 * per channel, in units of white; G and H are Gaussian means, sigma 1.4 px and 2 px: bright samples are
 * rare, and more pixels tell how rare; k = 2, tau = 0.007. Of n < 10 samples in a pixel
 * the variance in se2 is at least c(n) L[s^2 (x - g)^2], L a Gaussian mean, sigma
 * 16 / sqrt(n) px: where no bright sample fell, x looks as if it had no grain.
 * Differences are of linear light, which the grain leaves unbiased: t of a grainy pixel is too dark on
 * average, and more so the more grain it has. g is the mean of three pictures: half of
 * x denoised by its own albedo and normals, which knows what y does not, and a quarter
 * each guided by y alone and by y and the host's normals. The estimate of the error is
 *
 *   e2 = (1 - w)^2 G[b2] + w^2 se2 + tau^2 / 4
 *
 * of display values, the largest of the channels, and at most what out +- e / s differs
 * by on a display: what is left of the error of y, the grain that g may have kept, and
 * what no sample tells. Ours. What each part is worth: docs/notebook/rivals.md.
 */
#include "filter/finish_mix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "common/stop.h"
#include "denoise/denoise.h"

/* SIGMA_PX: 1 is as good on average, 2 loses 0.1 dB. GRAIN_SIGMA_PX: 1.4 loses 0.3.
 * CONTRADICTION: 3 is as good on average. LEAST_ERROR: of ours, display values; without
 * it a plane of which 32 + 32 samples know the texture loses 0.9 dB. DARK: below it the
 * display's slope would say only what black is. */
static const double SIGMA_PX = 1.4, GRAIN_SIGMA_PX = 2, CONTRADICTION = 2,
                    LEAST_ERROR = 0.007;
static const float DARK = 0.02f;

/* Samples of a pixel: up to FEW the grain is that of FEW_SIGMA_PX / sqrt(n), too, from
 * ENOUGH on that of nearby pixels alone, in between in proportion. Of 1, 2 and 4 samples
 * six scenes with a guide of one view gain 3.4, 1.8 and 0.1 dB, with one of 8 views 6.5,
 * 3.0 and 0.8; of 8 samples a third of it gains 0.65 on macro with 8
 * views (1.8 in Blender with 4), the whole loses 0.3 with one view (docs/notebook/rivals.md). */
static const double FEW = 4, ENOUGH = 10, FEW_SIGMA_PX = 16;

static size_t n_pixels(const struct finish_picture *p)
{
    return (size_t)p->width * (size_t)p->height;
}

/* ---- mixing ----------------------------------------------------------------------- */

static float display_value(float v)
{
    return powf(fminf(fmaxf(v, 0), 1), 1 / 2.2f);
}

/* What a little more light is worth on a display. */
static float display_slope(float v)
{
    return powf(fminf(fmaxf(v, DARK), 1), 1 / 2.2f - 1) / 2.2f;
}

/* How far a pixel may be off on a display: e is bounded by what it clips. */
static float display_error(float v, float e, float slope)
{
    const float shown = display_value(v), reach = e / slope;
    const float off =
        fmaxf(display_value(v + reach) - shown, shown - display_value(v - reach));
    return fminf(e, off);
}

enum { MOST_REACH = 64 };

/* Weights of a Gaussian over 4 sigma, which sum to 1; returns the reach. */
static int make_gaussian(double sigma, float weights[2 * MOST_REACH + 1])
{
    const int reach = (int)(4 * sigma);
    double sum = 0;
    for (int i = -reach; i <= reach; i++)
        sum += exp(-i * i / (2 * sigma * sigma));
    for (int i = -reach; i <= reach; i++)
        weights[i + reach] = (float)(exp(-i * i / (2 * sigma * sigma)) / sum);
    return reach;
}

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

void finish_smooth(const struct finish_picture *p, float *plane, float *room,
                   double sigma)
{
    const int width = p->width, height = p->height;
    float weights[2 * MOST_REACH + 1] = {0};
    const int reach = make_gaussian(sigma, weights);
    for (int y = 0; y < height && !is_stopped(p->stop); y++)
        for (int x = 0; x < width; x++) {
            float sum = 0;
            for (int i = -reach; i <= reach; i++)
                sum +=
                    weights[i + reach] *
                    plane[(size_t)y * (size_t)width + (size_t)clamp(x + i, width - 1)];
            room[(size_t)y * (size_t)width + (size_t)x] = sum;
        }
    for (int y = 0; y < height && !is_stopped(p->stop); y++) {
        float *row = plane + (size_t)y * (size_t)width;
        memset(row, 0, (size_t)width * sizeof(*row));
        for (int i = -reach; i <= reach; i++) {
            const float *from = room + (size_t)clamp(y + i, height - 1) * (size_t)width;
            for (int x = 0; x < width; x++)
                row[x] += weights[i + reach] * from[x];
        }
    }
}

/* The planes that one channel takes. */
struct planes {
    float *slope, *mean, *rest, *square, *wide, *room;
};

/* The square of the grain, in to->square, of more pixels where the samples are few: it is
 * no less than this. True: `to->wide` is to be looked at. */
static bool find_wide(const struct finish_picture *p, const struct planes *to)
{
    const double n_samples = (double)p->n_samples;
    if (n_samples <= 0 || n_samples >= ENOUGH)
        return false;
    const float share = (float)fmin((ENOUGH - n_samples) / (ENOUGH - FEW), 1);
    for (size_t i = 0; i < n_pixels(p); i++)
        to->wide[i] = share * to->square[i];
    finish_smooth(p, to->wide, to->room, FEW_SIGMA_PX / sqrt(n_samples));
    return true;
}

/* Means of the differences, as the top says: m in p.mean, se2 in p.square. */
static void find_means(const struct finish_picture *p, const float *denoised,
                       int channel, const struct planes *to)
{
    const size_t n = n_pixels(p);
    for (size_t i = 0; i < n; i++)
        to->slope[i] = fmaxf(p->ours[3 * i + (size_t)channel] / p->white, 0);
    finish_smooth(p, to->slope, to->room, SIGMA_PX);
    for (size_t i = 0; i < n; i++) {
        const size_t k = 3 * i + (size_t)channel;
        const float slope = display_slope(to->slope[i]) / p->white;
        to->slope[i] = slope;
        to->mean[i] = slope * (p->own[k] - p->ours[k]);
        to->rest[i] = slope * (p->apart ? p->apart[k] : p->own[k] - denoised[k]);
        to->square[i] = to->rest[i] * to->rest[i];
    }
    const bool is_wide = find_wide(p, to);
    finish_smooth(p, to->mean, to->room, SIGMA_PX);
    finish_smooth(p, to->rest, to->room, GRAIN_SIGMA_PX);
    finish_smooth(p, to->square, to->room, GRAIN_SIGMA_PX);
    const double n_averaged = 4 * 3.14159265358979 * SIGMA_PX * SIGMA_PX;
    for (size_t i = 0; i < n; i++) {
        const double rest = p->apart ? 0 : (double)to->rest[i];
        const double least = is_wide ? (double)to->wide[i] : 0;
        to->square[i] =
            (float)(fmax((double)to->square[i] - rest * rest, least) / n_averaged);
    }
}

/* Mixes one channel into p->ours. */
static void mix_channel(const struct finish_picture *p, const float *denoised,
                        int channel, const struct planes *with)
{
    const size_t n = n_pixels(p);
    float *weight = with->rest;
    find_means(p, denoised, channel, with);
    float *ours = with->mean; /* the error of y squared, in place of m */
    for (size_t i = 0; i < n; i++) {
        const double grain = CONTRADICTION * (double)with->square[i];
        const double m2 = (double)with->mean[i] * (double)with->mean[i];
        const double b2 = LEAST_ERROR * LEAST_ERROR + fmax(0, m2 - grain);
        weight[i] = (float)(b2 / (b2 + grain));
        ours[i] = (float)b2;
    }
    finish_smooth(p, weight, with->room, SIGMA_PX);
    finish_smooth(p, ours, with->room, SIGMA_PX);
    for (size_t i = 0; i < n; i++) {
        const size_t k = 3 * i + (size_t)channel;
        const float w = weight[i], left = 1 - w;
        const float e = sqrtf(left * left * ours[i] + w * w * with->square[i] +
                              (float)(LEAST_ERROR * LEAST_ERROR / 4));
        p->ours[k] += weight[i] * (denoised[k] - p->ours[k]);
        p->estimate[i] =
            fmaxf(channel == 0 ? 0 : p->estimate[i],
                  display_error(p->ours[k] / p->white, e, with->slope[i] * p->white));
    }
}

/* ---- denoising -------------------------------------------------------------------- */

/* Denoises a copy of the own picture in `rgb` by some guides. */
static bool denoise(struct denoiser *denoiser, const struct finish_picture *p,
                    float *rgb, const struct denoise_guides *guides,
                    struct image_error *error)
{
    const struct denoise_picture picture = {rgb, p->width, p->height,
                                            3,   p->name,  p->white};
    memcpy(rgb, p->own, 3 * n_pixels(p) * sizeof(*rgb));
    return denoise_picture(denoiser, &picture, guides, error);
}

/* What denoising takes; packed RGB. */
struct room {
    float *sum, *next, *limited, *albedo, *normal;
};

/* Adds the own picture denoised by some guides. */
static bool add_denoised(struct denoiser *denoiser, const struct finish_picture *p,
                         const struct denoise_guides *guides, float weight,
                         const struct room *room, struct image_error *error)
{
    if (!denoise(denoiser, p, room->next, guides, error))
        return false;
    for (size_t i = 0; i < 3 * n_pixels(p); i++)
        room->sum[i] += weight * room->next[i];
    return true;
}

/* Albedo and normals of the own render, in the room, without their grain. */
static bool clean_guides(struct denoiser *denoiser, const struct finish_picture *p,
                         const struct room *room, struct denoise_guides *guides,
                         struct image_error *error)
{
    const size_t n_bytes = 3 * n_pixels(p) * sizeof(float);
    const struct denoise_picture size = {NULL, p->width, p->height,
                                         3,    p->name,  p->white};
    *guides = (struct denoise_guides){.albedo = p->albedo ? room->albedo : NULL,
                                      .normal = p->normal ? room->normal : NULL};
    if (guides->albedo)
        memcpy(guides->albedo, p->albedo, n_bytes);
    if (guides->normal)
        memcpy(guides->normal, p->normal, n_bytes);
    return denoise_clean_guides(denoiser, &size, guides, error);
}

/* The mean g of the top, into room->sum. */
static bool denoise_own(struct denoiser *denoiser, const struct finish_picture *p,
                        const struct room *room, struct image_error *error)
{
    const size_t n = 3 * n_pixels(p);
    struct denoise_guides own;
    struct denoise_guides by = {.albedo = room->limited, .are_clean = true};
    for (size_t i = 0; i < n; i++)
        room->limited[i] = fminf(fmaxf(p->ours[i] / p->white, 0), 1);
    if (!clean_guides(denoiser, p, room, &own, error))
        return false;
    const float left = own.albedo ? 0.5f : 1;
    if (own.albedo && !add_denoised(denoiser, p, &own, 1 - left, room, error))
        return false;
    if (!add_denoised(denoiser, p, &by, own.normal ? left / 2 : left, room, error))
        return false;
    by.normal = own.normal;
    return !by.normal || add_denoised(denoiser, p, &by, left / 2, room, error);
}

bool finish_join_halves(float *own, float *half, size_t n)
{
    if (memcmp(own, half, n * sizeof(*own)) == 0)
        return false;
    for (size_t i = 0; i < n; i++) {
        const float other = half[i];
        half[i] = (own[i] - other) / 2;
        own[i] = (own[i] + other) / 2;
    }
    return true;
}

bool finish_mix(struct denoiser *denoiser, const struct finish_picture *p,
                struct image_error *error)
{
    const size_t n = n_pixels(p);
    float *all = app_memory(n, 15 * sizeof(float), error);
    if (!all)
        return false;
    float *free_planes = all + 3 * n;
    const struct room room = {all, all + 3 * n, all + 6 * n, all + 9 * n, all + 12 * n};
    const struct planes planes = {free_planes,         free_planes + n,
                                  free_planes + 2 * n, free_planes + 3 * n,
                                  free_planes + 4 * n, free_planes + 5 * n};
    const struct denoise_picture own = {(float *)p->own, p->width, p->height, 3,
                                        p->name,         p->white};
    denoise_judge_grain(denoiser, &own,
                        &(struct denoise_guides){.albedo = (float *)p->albedo,
                                                 .normal = (float *)p->normal});
    denoiser_stop_at(denoiser, p->stop);
    memset(room.sum, 0, 3 * n * sizeof(float));
    const bool is_done = denoise_own(denoiser, p, &room, error);
    for (int c = 0; c < 3 && is_done && !is_stopped(p->stop); c++)
        mix_channel(p, room.sum, c, &planes);
    free(all);
    return is_done && !is_stopped(p->stop);
}
