/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a denoiser makes of a lamp of a few pixels has its place and its shape, but not
 * its light: of two samples per pixel up to 20 % too much. With luminances y of the
 * samples and c of the clean picture, lamps become
 *
 *   c (1 + k (q - 1)),  q = sum of y / sum of c over 5 x 5 px, in 1 / MOST to MOST
 *
 * - k: from 0 to 1 as c goes from DIM to LAMP; 0 where the brightest of 3 x 3 px is less
 *   than CONTRAST times the mean of 9 x 9: a wide light needs no help, and the samples
 *   of bright surfaces have grain.
 *
 * What the denoiser took for a spark and removed stays so. Ours. Worth:
 * docs/notebook/rivals.md.
 */
#include "denoise/denoise_lamps.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "common/luminance.h"
#include "common/report.h"
#include "parallel.h"

/*
 * DIM, LAMP: more than a display shows as white; 8 and 16 are as good. CONTRAST: without
 * it macro loses 0.7 dB at 3 stops less, 8 gains a third less of portrait at 6. MOST:
 * what is farther off has another shape, too; 4 is as good.
 */
static const float DIM = 2, LAMP = 4, CONTRAST = 4, MOST = 2;

enum { LIGHT_PX = 2, PEAK_PX = 1, AROUND_PX = 4 };

struct lamps {
    int width, height;
    float *grainy, *clean; /* luminance */
    float *rgb;
};

/* The pixels within `reach` of one. */
struct box {
    int x0, y0, x1, y1; /* the ends are one beyond */
};

static struct box box_around(const struct lamps *l, int x, int y, int reach)
{
    return (struct box){x > reach ? x - reach : 0, y > reach ? y - reach : 0,
                        x + reach < l->width ? x + reach + 1 : l->width,
                        y + reach < l->height ? y + reach + 1 : l->height};
}

static float sum_of(const struct lamps *l, const float *plane, struct box box)
{
    float sum = 0;
    for (int y = box.y0; y < box.y1; y++)
        for (int x = box.x0; x < box.x1; x++)
            sum += plane[(size_t)y * (size_t)l->width + (size_t)x];
    return sum;
}

static bool stands_out(const struct lamps *l, int x, int y)
{
    const struct box near = box_around(l, x, y, PEAK_PX),
                     around = box_around(l, x, y, AROUND_PX);
    const int n = (around.x1 - around.x0) * (around.y1 - around.y0);
    float peak = 0;
    for (int j = near.y0; j < near.y1; j++)
        for (int i = near.x0; i < near.x1; i++)
            peak = fmaxf(peak, l->clean[(size_t)j * (size_t)l->width + (size_t)i]);
    return peak * (float)n >= CONTRAST * sum_of(l, l->clean, around);
}

static void keep_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct lamps *l = data;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < l->width; x++) {
            const size_t i = (size_t)y * (size_t)l->width + (size_t)x;
            if (l->clean[i] <= DIM || !stands_out(l, x, y))
                continue;
            const struct box box = box_around(l, x, y, LIGHT_PX);
            const float q = sum_of(l, l->grainy, box) / sum_of(l, l->clean, box);
            const float k = fminf((l->clean[i] - DIM) / (LAMP - DIM), 1);
            for (size_t c = 0; c < 3; c++)
                l->rgb[3 * i + c] *= 1 + k * (fminf(fmaxf(q, 1 / MOST), MOST) - 1);
        }
}

bool denoise_keep_lamps(const struct denoise_picture *grainy, float *clean,
                        int n_threads, struct image_error *error)
{
    const size_t n = (size_t)grainy->width * (size_t)grainy->height;
    float *room = app_memory(2 * n, sizeof *room, error);
    if (!room)
        return false;
    struct lamps l = {grainy->width, grainy->height, room, room + n, clean};
    for (size_t i = 0; i < n; i++) {
        l.grainy[i] = luminance_of(grainy->samples + i * (size_t)grainy->n_channels,
                                   grainy->n_channels) /
                      grainy->white;
        l.clean[i] = luminance_of(clean + 3 * i, 3);
    }
    os_parallel(n_threads, l.height, 16, keep_rows, &l);
    free(room);
    return true;
}
