/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A denoiser draws the light of things a pixel wide over what lies behind them: 0.001 of
 * white beside a lit pipe on black. A lens spreads it as far as it spreads the
 * background, and on black it shows, as a halo (docs/notebook/rivals.md). What no sample
 * hit a surface in is background:
 *
 * - without alpha and light: black;
 * - without a normal: a world, or fog before it. A world has no grain, and is told from
 *   fog by its colours, which stay within FLAT of each other over 5 x 5 px, of which at
 *   least ENOUGH are background.
 *
 * Ours.
 */
#include "denoise/denoise_background.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#include "parallel.h"

/* FLAT: of the most. A quarter and four times of it change three strangers' scenes, one
 * of them fog, by 0.00 dB. ENOUGH: the pixels of a corner of the picture are 9. */
static const float FLAT = 0.02f;
enum { REACH = 2, ENOUGH = 6 };

struct background {
    const struct denoise_picture *grainy;
    const float *normal; /* NULL: not known */
    float *clean;
};

static const float *samples_at(const struct background *b, size_t i)
{
    return b->grainy->samples + (size_t)b->grainy->n_channels * i;
}

static bool is_empty(const struct background *b, size_t i)
{
    const float *samples = samples_at(b, i);
    return b->grainy->n_channels == 4 && samples[0] == 0 && samples[1] == 0 &&
           samples[2] == 0 && samples[3] == 0;
}

static bool is_beyond(const struct background *b, size_t i)
{
    const float *normal = b->normal + 3 * i;
    return normal[0] == 0 && normal[1] == 0 && normal[2] == 0;
}

/* Whether the background around a pixel of it has no grain. */
static bool is_flat(const struct background *b, int x, int y)
{
    const int width = b->grainy->width, height = b->grainy->height;
    const int n_colours = b->grainy->n_channels < 3 ? 1 : 3;
    float least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {0, 0, 0};
    int n = 0;
    for (int j = y > REACH ? y - REACH : 0; j <= y + REACH && j < height; j++)
        for (int i = x > REACH ? x - REACH : 0; i <= x + REACH && i < width; i++) {
            const size_t at = (size_t)j * (size_t)width + (size_t)i;
            const float *samples = samples_at(b, at);
            if (!is_beyond(b, at))
                continue;
            for (int c = 0; c < n_colours; c++) {
                least[c] = fminf(least[c], samples[c]);
                most[c] = fmaxf(most[c], samples[c]);
            }
            n++;
        }
    for (int c = 0; c < n_colours; c++)
        if (most[c] - least[c] > FLAT * most[c])
            return false;
    return n >= ENOUGH;
}

static void keep_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct background *b = data;
    const size_t width = (size_t)b->grainy->width;
    const size_t n_channels = (size_t)b->grainy->n_channels;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < (int)width; x++) {
            const size_t i = (size_t)y * width + (size_t)x;
            if (is_empty(b, i) || (b->normal && is_beyond(b, i) && is_flat(b, x, y)))
                memcpy(b->clean + n_channels * i, samples_at(b, i),
                       n_channels * sizeof(float));
        }
}

void denoise_keep_background(const struct denoise_picture *grainy,
                             const struct denoise_guides *guides, float *clean,
                             int n_threads)
{
    struct background b = {grainy, guides->normal, clean};
    os_parallel(n_threads, grainy->height, 16, keep_rows, &b);
}
