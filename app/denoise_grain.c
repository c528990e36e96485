/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Denoisers learn from grain that differs from pixel to pixel. Renderers that spread a
 * sample over the pixels of their filter (Mitsuba, by default) make grain that is alike
 * in pixels side by side, which OIDN leaves as it is: it takes it for texture. With t the square root of
 * light within 0 to 1, in blocks of 8 x 8 px of plain surfaces (albedo and normals tell),
 *
 *   q = mean of (t[x-1] - 2 t[x] + t[x+1])^2 / mean of (t[x-2] - 2 t[x] + t[x+2])^2
 *
 * which shading that changes steadily leaves alone. Medians: Cycles, LuxCore and Mitsuba
 * with a box filter 0.93 to 1.03, Mitsuba with its Gaussian 0.49 to 0.50. Ours.
 */
#include "denoise_grain.h"

#include <math.h>
#include <stddef.h>

/* MOST_RATIO: between both. GRAIN, of t squared: smooth pictures have texture and shading
 * alone, of 3e-5 and less. PLAIN: standard deviations. */
static const float MOST_RATIO = 0.75f, GRAIN = 1e-4f;
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
        t[x] = sqrtf(fminf(fmaxf(block->picture->samples[i], 0), 1));
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

/* q of a block; 0 where it has nothing to tell. */
static float ratio_of(const struct block *block)
{
    const size_t n_colours = block->picture->n_channels >= 3 ? 3 : 1;
    float near = 0, far = 0, t[SIDE];
    for (int y = 0; y < SIDE; y++)
        for (size_t c = 0; c < n_colours; c++) {
            if (!read_row(block, y, c, t))
                return 0;
            near += differences(t, 1);
            far += differences(t, 2);
        }
    const float n = (float)(SIDE * n_colours);
    /* Grain of variance v that is not smeared has 6 v. */
    return far > 6 * GRAIN * n ? near / far : 0;
}

bool denoise_is_smeared(const struct denoise_picture *picture,
                        const struct denoise_guides *guides)
{
    size_t n_blocks = 0, n_smeared = 0;
    if (!guides || !guides->albedo)
        return false;
    for (int y = 0; y + SIDE <= picture->height; y += SIDE)
        for (int x = 0; x + SIDE <= picture->width; x += SIDE) {
            const struct block block = {picture,
                                        (size_t)y * (size_t)picture->width + (size_t)x};
            if (!is_plain(&block, guides->albedo, PLAIN_ALBEDO) ||
                !is_plain(&block, guides->normal, PLAIN_NORMAL))
                continue;
            const float ratio = ratio_of(&block);
            n_blocks += ratio > 0;
            n_smeared += ratio > 0 && ratio < MOST_RATIO;
        }
    return n_blocks >= FEWEST_BLOCKS && 2 * n_smeared > n_blocks;
}
