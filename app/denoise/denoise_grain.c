/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Denoisers learn from grain that differs from pixel to pixel. Renderers that spread a
 * sample over the pixels of their filter (Mitsuba, by default) make grain that is alike
 * in pixels side by side, which OIDN takes for texture and leaves. With t the square root
 * of light within 0 to 1, in blocks of 8 x 8 px of plain surfaces (by albedo and normals),
 *
 *   s_k = mean of (t[x-k] - 2 t[x] + t[x+k])^2
 *
 * is of grain alone where shading changes steadily, and the same for all k where that is
 * of single pixels. Grain that neighbours share has a small s_1 / s_2, but an s_3 / s_2
 * near 1, which light that has a pattern seldom has. Medians of s_1 / s_2 over blocks:
 * Cycles, LuxCore and Mitsuba with a box filter 0.93 to 1.03, Mitsuba with its Gaussian
 * 0.49 to 0.50. Ours.
 */
#include "denoise/denoise_grain.h"

#include <math.h>
#include <stddef.h>

/* Means of s_1 / s_2 and s_3 / s_2 over the blocks: 1/3 is grain of 2 x 2 px. GRAIN, of t
 * squared: smooth pictures have texture and shading alone, of 3e-5 and less. */
static const double BESIDE[2] = {0.3, 0.75}, BEYOND[2] = {0.75, 1.33};
static const float GRAIN = 1e-4f;
/* Standard deviations of plain surfaces. */
static const float PLAIN_ALBEDO = 0.01f, PLAIN_NORMAL = 0.02f;

/* Of t: darker and brighter blocks have clipped grain. */
static const float DARKEST = 0.02f, BRIGHTEST = 0.98f;

/* Fewer blocks may be chance. */
enum { SIDE = 8, FEWEST_BLOCKS = 20 };

/* A block of a picture: its first pixel, and floats from row to row. */
struct block {
    const struct denoise_picture *picture;
    size_t first;
};

static size_t pixel_of(const struct block *block, int x, int y)
{
    return block->first + (size_t)y * (size_t)block->picture->width + (size_t)x;
}

/* Do three channels of packed samples differ by no more than a standard deviation? */
static bool is_plain(const struct block *block, const float *guide, float deviation)
{
    for (size_t c = 0; guide && c < 3; c++) {
        float sum = 0, squares = 0;
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) {
                const float v = guide[3 * pixel_of(block, x, y) + c];
                sum += v;
                squares += v * v;
            }
        const float n = SIDE * SIDE, mean = sum / n;
        if (!(squares / n - mean * mean <= deviation * deviation))
            return false;
    }
    return true;
}

/* t of one channel of a row; false where it is too dark or too bright. */
static bool read_row(const struct block *block, int y, size_t channel, float t[SIDE])
{
    const size_t n_channels = (size_t)block->picture->n_channels;
    bool is_told = true;
    for (int x = 0; x < SIDE; x++) {
        const size_t i = pixel_of(block, x, y) * n_channels + channel;
        const float v = block->picture->samples[i] / block->picture->white;
        t[x] = sqrtf(fminf(fmaxf(v, 0), 1));
        is_told &= t[x] > DARKEST && t[x] < BRIGHTEST;
    }
    return is_told;
}

/* Mean squares of second differences of neighbours `step` px apart. */
static float differences(const float t[SIDE], int step)
{
    float sum = 0;
    for (int x = step; x + step < SIDE; x++) {
        const float d = t[x - step] - 2 * t[x] + t[x + step];
        sum += d * d;
    }
    return sum / (float)(SIDE - 2 * step);
}

/* Blocks, and sums of their s_1 / s_2 and s_3 / s_2. */
struct tally {
    size_t n;
    double near, far;
};

/* Counts a block, unless it has nothing to tell. */
static void count_block(const struct block *block, struct tally *tally)
{
    const size_t n_colours = block->picture->n_channels >= 3 ? 3 : 1;
    float s[4] = {0}, t[SIDE];
    for (int y = 0; y < SIDE; y++)
        for (size_t c = 0; c < n_colours; c++) {
            if (!read_row(block, y, c, t))
                return;
            for (int k = 1; k <= 3; k++)
                s[k] += differences(t, k);
        }
    /* Grain of variance v that is not smeared has 6 v. */
    if (!(s[2] > 6 * GRAIN * (float)(SIDE * n_colours)))
        return;
    tally->n++;
    tally->near += (double)(s[1] / s[2]);
    tally->far += (double)(s[3] / s[2]);
}

bool denoise_is_smeared(const struct denoise_picture *picture,
                        const struct denoise_guides *guides)
{
    struct tally tally = {0};
    if (!guides || !guides->albedo)
        return false;
    for (int y = 0; y + SIDE <= picture->height; y += SIDE)
        for (int x = 0; x + SIDE <= picture->width; x += SIDE) {
            const struct block block = {picture,
                                        (size_t)y * (size_t)picture->width + (size_t)x};
            if (is_plain(&block, guides->albedo, PLAIN_ALBEDO) &&
                is_plain(&block, guides->normal, PLAIN_NORMAL))
                count_block(&block, &tally);
        }
    const double near = tally.near / (double)tally.n, far = tally.far / (double)tally.n;
    return tally.n >= FEWEST_BLOCKS && near > BESIDE[0] && near < BESIDE[1] &&
           far > BEYOND[0] && far < BEYOND[1];
}
