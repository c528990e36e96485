/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a denoiser makes of a lamp of a few pixels has its place and its shape, but not
 * its light: of two samples per pixel up to 25 % too much, and another hue. With colours
 * y of the samples and c of the clean picture, lamps become, channel by channel,
 *
 *   c (1 + k (q - 1)),  q = sum of y / sum of c over 5 x 5 px, in 1 / MOST to MOST
 *
 * - k: from 0 to 1 as the luminance of c goes from DIM to LAMP; 0 where the brightest of
 *   3 x 3 px is less than CONTRAST times the mean of 9 x 9: a wide light needs no help,
 *   and the samples of bright surfaces have grain.
 *
 * A lamp too wide for that is looked for at every 2nd pixel of 17 x 17, then every 4th of
 * 33 x 33, and its q is of 9 x 9 and 17 x 17 px: in a supersampled picture lamps are
 * twice as wide and more.
 *
 * What the denoiser took for a spark and removed stays so. Ours. Worth:
 * docs/notebook/rivals.md.
 */
#include "denoise/denoise_lamps.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "common/luminance.h"
#include "common/report.h"
#include "parallel.h"

/*
 * DIM, LAMP: more than a display shows as white; 8 and 16 are as good. CONTRAST: without
 * it macro loses 0.7 dB at 3 stops less, 8 gains a third less of portrait at 6. MOST:
 * what is farther off has another shape, too; 4 is as good.
 */
static const float DIM = 2, LAMP = 4, CONTRAST = 4, MOST = 2;

/* In steps, the widest of which is WIDEST_PX. */
enum { LIGHT = 2, PEAK = 1, AROUND = 4, WIDEST_PX = 4 };

struct lamps {
    const struct denoise_picture *grainy;
    const float *clean; /* as it was */
    float *rgb;
};

/* The pixels up to `reach` from one that are in the picture; the ends are one beyond. */
struct box {
    int x0, y0, x1, y1;
};

static struct box box_around(const struct lamps *l, int x, int y, int reach)
{
    const int width = l->grainy->width, height = l->grainy->height;
    return (struct box){x > reach ? x - reach : 0, y > reach ? y - reach : 0,
                        x + reach < width ? x + reach + 1 : width,
                        y + reach < height ? y + reach + 1 : height};
}

/* Luminances of every step-th pixel of a box. */
struct looked_at {
    float sum, most;
    int n;
};

static struct looked_at look_at(const struct lamps *l, struct box box, int step)
{
    struct looked_at seen = {0};
    for (int y = box.y0; y < box.y1; y += step)
        for (int x = box.x0; x < box.x1; x += step) {
            const size_t i = (size_t)y * (size_t)l->grainy->width + (size_t)x;
            const float at = luminance_of(l->clean + 3 * i, 3);
            seen.sum += at;
            seen.most = fmaxf(seen.most, at);
            seen.n++;
        }
    return seen;
}

static bool stands_out(const struct lamps *l, int x, int y, int step)
{
    const struct looked_at near = look_at(l, box_around(l, x, y, PEAK * step), step),
                           around =
                               look_at(l, box_around(l, x, y, AROUND * step), step);
    return near.most * (float)around.n >= CONTRAST * around.sum;
}

/* By what the channels of a pixel are to be multiplied, as far as k is 1. */
static void find_gains(const struct lamps *l, int x, int y, int step, float gains[3])
{
    const struct denoise_picture *p = l->grainy;
    const struct box box = box_around(l, x, y, LIGHT * step);
    const size_t n_channels = (size_t)p->n_channels;
    float samples[3] = {0}, clean[3] = {0};
    for (int j = box.y0; j < box.y1; j++)
        for (int i = box.x0; i < box.x1; i++) {
            const size_t at = (size_t)j * (size_t)p->width + (size_t)i;
            for (size_t c = 0; c < 3; c++) {
                samples[c] +=
                    p->samples[n_channels * at + (n_channels < 3 ? 0 : c)] / p->white;
                clean[c] += l->clean[3 * at + c];
            }
        }
    for (size_t c = 0; c < 3; c++)
        gains[c] =
            clean[c] > 0 ? fminf(fmaxf(samples[c] / clean[c], 1 / MOST), MOST) : 1;
}

static void keep_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct lamps *l = data;
    const int width = l->grainy->width;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            const float luminance = luminance_of(l->clean + 3 * i, 3);
            int step = 1;
            if (luminance <= DIM)
                continue;
            while (step <= WIDEST_PX && !stands_out(l, x, y, step))
                step *= 2;
            if (step > WIDEST_PX)
                continue;
            const float k = fminf((luminance - DIM) / (LAMP - DIM), 1);
            float gains[3];
            find_gains(l, x, y, step, gains);
            for (size_t c = 0; c < 3; c++)
                l->rgb[3 * i + c] *= 1 + k * (gains[c] - 1);
        }
}

bool denoise_keep_lamps(const struct denoise_picture *grainy, float *clean,
                        int n_threads, struct image_error *error)
{
    const size_t n = 3 * (size_t)grainy->width * (size_t)grainy->height;
    float *was = app_memory(n, sizeof *was, error);
    if (!was)
        return false;
    memcpy(was, clean, n * sizeof *was);
    struct lamps l = {grainy, was, clean};
    os_parallel(n_threads, grainy->height, 16, keep_rows, &l);
    free(was);
    return true;
}
