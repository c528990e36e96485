/* SPDX-License-Identifier: Apache-2.0 */
/*
 * POV-Ray's anti-aliasing sends more rays where neighbours differ, and nowhere else: a
 * star that the first ray of its pixel hits is averaged with the dark around it, one
 * that is missed is never found. A sky of stars so loses light, a quarter of that of
 * textures.inc's Starfield, whatever the threshold and the size; with one ray in each
 * sample, as the renders for the depth have, the mean is right. Rays are averaged in the
 * space that POV-Ray computes in, so light is weighed there: any edge before black loses
 * some of it outside.
 */
#include "sparse.h"

#include <math.h>

#include "text.h"

/* Blocks along the longer side of the picture. */
#define BLOCKS 16
/* Deviation of a block's samples, of their mean: a checkerboard has 1. */
#define LEAST_DEVIATION 1.0
/* Darker blocks do not count. */
#define LEAST_LIGHT 1e-3
/* Light that must be lost in such blocks together, of what it was, and in standard errors
 * of that. */
#define LEAST_LOSS 0.1
#define LEAST_ERRORS 4.0
/* Share of the picture that is worth a warning. */
#define LEAST_SHARE 0.05

struct block {
    int32_t x0, y0, x1, y1;
};

/* Sums of light, with many rays where neighbours differ and with one. */
struct block_sums {
    double n, many, one, one_squared;
};

/* As the picture has it, or as POV-Ray computed it. */
static double light_of(const float *rgba, const struct decode_space *space)
{
    double light = 0;
    for (int i = 0; i < 3; i++)
        light += space ? decode_value(space, (double)rgba[i]) : (double)rgba[i];
    return light;
}

static struct block_sums add_up(const struct povray_passes *passes, const float *base,
                                const struct block *block,
                                const struct decode_space *space)
{
    struct block_sums sums = {.n = (double)(block->x1 - block->x0) *
                                   (double)(block->y1 - block->y0)};
    for (int32_t y = block->y0; y < block->y1; y++)
        for (int32_t x = block->x0; x < block->x1; x++) {
            const size_t i = 4 * ((size_t)y * (size_t)passes->width + (size_t)x);
            const double one = light_of(&base[i], space);
            sums.many += light_of(&passes->colour[i], space);
            sums.one += one;
            sums.one_squared += one * one;
        }
    return sums;
}

static double variance(const struct block_sums *sums)
{
    const double mean = sums->one / sums->n;
    return fmax(sums->one_squared / sums->n - mean * mean, 0);
}

/* Dark but for few bright samples? */
static bool is_sparse(const struct block_sums *sums)
{
    const double mean = sums->one / sums->n;
    return mean > 3 * LEAST_LIGHT && sqrt(variance(sums)) > LEAST_DEVIATION * mean;
}

void sparse_look(struct povray_passes *passes, const float *base,
                 const struct decode_space *space)
{
    const int32_t longer =
        passes->width > passes->height ? passes->width : passes->height;
    const int32_t size = longer / BLOCKS > 0 ? longer / BLOCKS : 1;
    struct block_sums all = {0};
    double error_squared = 0;
    for (int32_t y = 0; y < passes->height; y += size)
        for (int32_t x = 0; x < passes->width; x += size) {
            const struct block block = {
                x, y, x + size < passes->width ? x + size : passes->width,
                y + size < passes->height ? y + size : passes->height};
            struct block_sums sums = add_up(passes, base, &block, NULL);
            if (!is_sparse(&sums))
                continue;
            sums = add_up(passes, base, &block, space);
            all.n += sums.n;
            all.one += sums.one;
            all.many += sums.many;
            error_squared += sums.n * variance(&sums);
        }
    const double share = all.n / ((double)passes->width * passes->height);
    const double lost = all.one - all.many;
    if (share > LEAST_SHARE && lost > LEAST_LOSS * all.one &&
        lost > LEAST_ERRORS * sqrt(error_squared))
        scene_add_warning(passes,
                          "POV-Ray's anti-aliasing takes %.0f %% of the light in %.0f "
                          "%% of the picture, which comes from things smaller than a "
                          "sample, such as stars; -A after -- keeps it",
                          100 * lost / all.one, 100 * share);
}
