/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With x the host's own picture, y ours, g the host's denoised with ours as guide, and
 * t(v) = clip(v)^(1/2.2):
 *
 *   q   = t(x) - t(y)
 *   m   = Gaussian mean of q, sigma 2 px
 *   se2 = (Gaussian mean of q^2 - m^2) / (4 pi sigma^2), the error of that mean
 *   w   = max(0, 1 - k se2 / m^2), k = 2, then Gaussian mean, sigma 1 px
 *   out = y + w (g - y)
 *
 * per channel: where the grain does not tell x from y, y is kept. g is the mean of two
 * pictures, guided by y alone and by y and the host's normals: one or the other is
 * better by up to 0.5 dB, with few samples the second. The estimate of the error is
 *
 *   e = sqrt(((1 - w) m)^2 + se2)
 *
 * of t, the largest of the channels. Ours. Worth, with passes of 64 samples in 8 views,
 * over the host's own lens denoised by albedo and normals, 64 own samples: foliage
 * + 4.6 dB, posts + 4.7; 16 own samples + 3.1 and + 4.3; one view + 3.4 and + 4.4.
 * k = 1 is 0.3 dB less, k = 3 as good. The guide alone 0.4 to 0.7 less.
 */
#include "finish_mix.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "denoise.h"
#include "report.h"

static const double SIGMA_PX = 2, BLEND_SIGMA_PX = 1, CONTRADICTION = 2;

static size_t n_pixels(const struct finish_picture *p)
{
    return (size_t)p->width * (size_t)p->height;
}

/* ---- mixing ----------------------------------------------------------------------- */

static float display_value(float v)
{
    return powf(fminf(fmaxf(v, 0), 1), 1 / 2.2f);
}

enum { MOST_REACH = 8 };

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

/* Gaussian mean of a plane in place, its edges repeated; `room` is as large. */
static void smooth(float *plane, float *room, int width, int height, double sigma)
{
    float weights[2 * MOST_REACH + 1];
    const int reach = make_gaussian(sigma, weights);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float sum = 0;
            for (int i = -reach; i <= reach; i++)
                sum +=
                    weights[i + reach] *
                    plane[(size_t)y * (size_t)width + (size_t)clamp(x + i, width - 1)];
            room[(size_t)y * (size_t)width + (size_t)x] = sum;
        }
    for (int y = 0; y < height; y++) {
        float *row = plane + (size_t)y * (size_t)width;
        memset(row, 0, (size_t)width * sizeof(*row));
        for (int i = -reach; i <= reach; i++) {
            const float *from = room + (size_t)clamp(y + i, height - 1) * (size_t)width;
            for (int x = 0; x < width; x++)
                row[x] += weights[i + reach] * from[x];
        }
    }
}

/* Mixes one channel into p->ours; `planes` are three of them. */
static void mix_channel(const struct finish_picture *p, const float *guided,
                        int channel, float *planes)
{
    const size_t n = n_pixels(p);
    float *mean = planes, *square = planes + n, *room = planes + 2 * n;
    for (size_t i = 0; i < n; i++) {
        const size_t k = 3 * i + (size_t)channel;
        mean[i] = display_value(p->own[k]) - display_value(p->ours[k]);
        square[i] = mean[i] * mean[i];
    }
    smooth(mean, room, p->width, p->height, SIGMA_PX);
    smooth(square, room, p->width, p->height, SIGMA_PX);
    const double n_averaged = 4 * 3.14159265358979 * SIGMA_PX * SIGMA_PX;
    float *weight = room;
    for (size_t i = 0; i < n; i++) {
        const double m2 = (double)mean[i] * mean[i];
        square[i] = (float)(fmax(square[i] - m2, 0) / n_averaged);
        weight[i] = (float)(m2 > 0 ? fmax(0, 1 - CONTRADICTION * square[i] / m2) : 0);
    }
    for (size_t i = 0; i < n; i++) {
        const double left = (1 - weight[i]) * mean[i];
        const float e = (float)sqrt(left * left + square[i]);
        p->estimate[i] = fmaxf(channel == 0 ? 0 : p->estimate[i], e);
    }
    smooth(weight, mean, p->width, p->height, BLEND_SIGMA_PX);
    for (size_t i = 0; i < n; i++) {
        const size_t k = 3 * i + (size_t)channel;
        p->ours[k] += weight[i] * (guided[k] - p->ours[k]);
    }
}

/* ---- denoising -------------------------------------------------------------------- */

/* Denoises a copy of the own picture in `rgb` by some guides. */
static bool denoise(struct denoiser *denoiser, const struct finish_picture *p,
                    float *rgb, const struct denoise_guides *guides,
                    struct image_error *error)
{
    const struct denoise_picture picture = {rgb, p->width, p->height, 3, p->name};
    memcpy(rgb, p->own, 3 * n_pixels(p) * sizeof(*rgb));
    return denoise_picture(denoiser, &picture, guides, error);
}

/* The mean of what our picture alone and our picture with the normals guide, into
 * `guided`; `other` has three times its size. */
static bool denoise_by_ours(struct denoiser *denoiser, const struct finish_picture *p,
                            float *guided, float *other, struct image_error *error)
{
    const size_t n = 3 * n_pixels(p);
    float *limited = other + n;
    for (size_t i = 0; i < n; i++)
        limited[i] = fminf(fmaxf(p->ours[i], 0), 1);
    struct denoise_guides by = {.albedo = limited, .are_clean = true};
    if (!denoise(denoiser, p, guided, &by, error))
        return false;
    if (!p->normal)
        return true;
    const struct denoise_picture size = {NULL, p->width, p->height, 3, p->name};
    struct denoise_guides clean = {.normal = limited + n};
    memcpy(clean.normal, p->normal, n * sizeof(float));
    if (!denoise_clean_guides(denoiser, &size, &clean, error))
        return false;
    by.normal = clean.normal;
    if (!denoise(denoiser, p, other, &by, error))
        return false;
    for (size_t i = 0; i < n; i++)
        guided[i] = (guided[i] + other[i]) / 2;
    return true;
}

bool finish_mix(struct denoiser *denoiser, const struct finish_picture *p,
                struct image_error *error)
{
    const size_t n = 3 * n_pixels(p);
    float *guided = app_memory(n, 4 * sizeof(float), error);
    if (!guided)
        return false;
    const bool is_done = denoise_by_ours(denoiser, p, guided, guided + n, error);
    for (int c = 0; c < 3 && is_done; c++)
        mix_channel(p, guided, c, guided + n);
    free(guided);
    return is_done;
}
