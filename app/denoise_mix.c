/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With c the merge of views without grain, r that of views with their grain and f that
 * of views whose grain has random signs:
 *
 *   e   = G[|r - c|^2]     grain of the merge, and what the denoiser did wrong, squared
 *   g   = G[|f - c|^2]     grain of the merge alone, squared
 *   w   = max(0, e - g) / e
 *   out = c + w (r - c)
 *
 * |d|^2 is the sum over red, green and blue of differences of values in 0 to 1, which
 * lamps would rule otherwise; G is a mean over three boxes of 17 x 17 px, nearly a
 * Gaussian of sigma 8.5 px. With an error b of c that is independent of the grain of r,
 * w = b^2 / (b^2 + grain^2) leaves the least error of all mixtures. f has the grain of r
 * as merging spreads it, for any lens. Ours; flipped signs as the wild bootstrap of Wu
 * (1986) has them. Worth: docs/notebook/rivals.md.
 */
#include "denoise_mix.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "parallel.h"
#include "report.h"

/* REACH_PX: on 25 pictures 4 to 32 px of sigma differ by 0.1 dB on average. */
enum { REACH_PX = 8, N_BOXES = 3, SIDE_PX = 2 * REACH_PX + 1 };

static int n_colours(int n_channels)
{
    return n_channels >= 3 ? 3 : 1;
}

/* ---- signs -------------------------------------------------------------------------
 */

/* The finalizer of SplitMix64 (Steele, Lea and Flood 2014): bits that look random. */
static uint64_t scramble(uint64_t v)
{
    v += 0x9e3779b97f4a7c15u;
    v = (v ^ v >> 30) * 0xbf58476d1ce4e5b9u;
    v = (v ^ v >> 27) * 0x94d049bb133111ebu;
    return v ^ v >> 31;
}

void denoise_flip(float *grainy, const float *clean, size_t n, int n_channels,
                  int index)
{
    for (size_t i = 0; i < n; i++) {
        if (scramble((uint64_t)index << 48 ^ (uint64_t)i) & 1)
            continue;
        for (int c = 0; c < n_colours(n_channels); c++) {
            const size_t k = i * (size_t)n_channels + (size_t)c;
            grainy[k] = fminf(fmaxf(2 * clean[k] - grainy[k], 0), FLT_MAX);
        }
    }
}

/* ---- means -------------------------------------------------------------------------
 */

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

/* Means of SIDE_PX values each of a line whose ends are repeated. */
static void mean_of_line(const float *from, float *to, int n, size_t step)
{
    double sum = 0;
    for (int i = -REACH_PX; i <= REACH_PX; i++)
        sum += (double)from[(size_t)clamp(i, n - 1) * step];
    for (int i = 0; i < n; i++) {
        to[(size_t)i * step] = (float)(fmax(sum, 0) / SIDE_PX);
        sum += (double)from[(size_t)clamp(i + REACH_PX + 1, n - 1) * step] -
               (double)from[(size_t)clamp(i - REACH_PX, n - 1) * step];
    }
}

struct planes {
    float *values, *room;
    int width, height;
};

static void mean_of_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct planes *p = data;
    (void)thread;
    for (int64_t y = begin; y < end; y++)
        mean_of_line(p->values + y * p->width, p->room + y * p->width, p->width, 1);
}

static void mean_of_columns(void *data, int64_t begin, int64_t end, int thread)
{
    const struct planes *p = data;
    (void)thread;
    for (int64_t x = begin; x < end; x++)
        mean_of_line(p->room + x, p->values + x, p->height, (size_t)p->width);
}

/* G of `values` in place; `room` is as large. */
static void smooth(const struct denoise_merges *m, float *values, float *room)
{
    struct planes planes = {values, room, m->width, m->height};
    for (int k = 0; k < N_BOXES; k++) {
        os_parallel(m->n_threads, m->height, 0, mean_of_rows, &planes);
        os_parallel(m->n_threads, m->width, 0, mean_of_columns, &planes);
    }
}

/* ---- mixing ------------------------------------------------------------------------
 */

static float in_display(float v)
{
    return fminf(fmaxf(v, 0), 1);
}

/* Squares of how far merges differ. */
static void find_squares(const struct denoise_merges *m, const float *other,
                         float *squares)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    for (size_t i = 0; i < n; i++) {
        float sum = 0;
        for (int c = 0; c < n_colours(m->n_channels); c++) {
            const size_t k = i * (size_t)m->n_channels + (size_t)c;
            const float d = in_display(other[k]) - in_display(m->clean[k]);
            sum += d * d;
        }
        squares[i] = sum;
    }
}

static void mix(const struct denoise_merges *m, const float *all, const float *grain)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    for (size_t i = 0; i < n; i++) {
        if (!(all[i] > grain[i]))
            continue;
        const float w = (all[i] - grain[i]) / all[i];
        for (int c = 0; c < n_colours(m->n_channels); c++) {
            const size_t k = i * (size_t)m->n_channels + (size_t)c;
            m->clean[k] += w * (m->grainy[k] - m->clean[k]);
        }
    }
}

bool denoise_mix(const struct denoise_merges *m, struct image_error *error)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    float *room = app_memory(3, n * sizeof(float), error);
    if (!room)
        return false;
    find_squares(m, m->grainy, room);
    find_squares(m, m->flipped, room + n);
    smooth(m, room, room + 2 * n);
    smooth(m, room + n, room + 2 * n);
    mix(m, room, room + n);
    free(room);
    return true;
}
