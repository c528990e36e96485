/* SPDX-License-Identifier: Apache-2.0 */
/*
 * With c the merge of views without grain, r that of views with their grain and f that
 * of views whose grain has random signs:
 *
 *   e   = G[|r - c|^2]     grain of the merge, and what the denoiser did wrong, squared
 *   g   = G[|f - c|^2]     grain of the merge alone, squared
 *   w   = (e - g) / e, less where e < 2 g, 0 where e < 1.6 g
 *   out = c + min(w, w') (r - c)    w' with G' in place of G
 *
 * |d|^2 is the sum of the squares over red, green and blue, of d as far as c + d or c - d
 * lies in 0 to 1: lamps would rule otherwise, and flipped grain of dark things, below 0,
 * counts. Views are merged for f with 0.25 added, since merges cut what is below 0. G and
 * G' are means over three boxes of 17 x 17 and 7 x 7 px, nearly Gaussians of sigma 8.5 and
 * 3.5 px; by G alone, what is wrong in one place would bring grain back beside it.
 *
 * With an error b of c that is independent of the grain of r, w = b^2 / (b^2 + grain^2)
 * leaves the least error of all mixtures; less is taken where e may be grain alone. f has
 * the grain of r as merging spreads it, for any lens. Ours; flipped signs as the wild
 * bootstrap of Wu (1986) has them. Worth: docs/notebook/rivals.md.
 */
#include "denoise_mix.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "parallel.h"
#include "report.h"

/* REACH_PX: on 25 pictures 4 to 32 px of sigma differ by 0.1 dB on average. NEAR_PX: grain
 * shows beside bright blurred things without it; costs 0.01 dB on average. */
enum { REACH_PX = 8, NEAR_PX = 3, N_BOXES = 3 };

/* Ratios of e and g: grain came back over surfaces in focus of a stranger's file, where
 * every e > g counted. A tree loses 0.6 dB by it, a toy in grain gains 0.4. */
static const float DOUBTFUL = 1.6f, CERTAIN = 2;

/* Merges cut what is below 0, where the flipped grain of dark things lies; it is merged as
 * much brighter. 1 in place of a quarter changes 0.1 dB, either way. */
static const float LIFT = 0.25f;

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
        const bool is_kept = scramble((uint64_t)index << 48 ^ (uint64_t)i) & 1;
        for (int c = 0; c < n_colours(n_channels); c++) {
            const size_t k = i * (size_t)n_channels + (size_t)c;
            const float v = is_kept ? grainy[k] : 2 * clean[k] - grainy[k];
            grainy[k] = fminf(fmaxf(v + LIFT, 0), FLT_MAX);
        }
    }
}

/* ---- means -------------------------------------------------------------------------
 */

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

struct planes {
    float *values, *room;
    int width, height, reach;
};

/* Means of 2 reach + 1 values each of a line of n whose ends are repeated. */
static void mean_of_line(const float *from, float *to, int n, size_t step, int reach)
{
    double sum = 0;
    for (int i = -reach; i <= reach; i++)
        sum += (double)from[(size_t)clamp(i, n - 1) * step];
    for (int i = 0; i < n; i++) {
        to[(size_t)i * step] = (float)(fmax(sum, 0) / (2 * reach + 1));
        sum += (double)from[(size_t)clamp(i + reach + 1, n - 1) * step] -
               (double)from[(size_t)clamp(i - reach, n - 1) * step];
    }
}

static void mean_of_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct planes *p = data;
    (void)thread;
    for (int64_t y = begin; y < end; y++)
        mean_of_line(p->values + y * p->width, p->room + y * p->width, p->width, 1,
                     p->reach);
}

static void mean_of_columns(void *data, int64_t begin, int64_t end, int thread)
{
    const struct planes *p = data;
    (void)thread;
    for (int64_t x = begin; x < end; x++)
        mean_of_line(p->room + x, p->values + x, p->height, (size_t)p->width, p->reach);
}

/* Means of `values` in place; `room` is as large. */
static void smooth(const struct denoise_merges *m, int reach, float *values,
                   float *room)
{
    struct planes planes = {values, room, m->width, m->height, reach};
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

/* Of v from a clean value on a display, upwards or downwards, where it shows more. */
static float difference(float clean, float v)
{
    const float d = fabsf(v - clean), shown = in_display(clean);
    return fmaxf(in_display(clean + d) - shown, shown - in_display(clean - d));
}

/* Squares of how far a merge of views that are brighter by `lift` differs. */
static void find_squares(const struct denoise_merges *m, const float *other, float lift,
                         float *squares)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    for (size_t i = 0; i < n; i++) {
        float sum = 0;
        for (int c = 0; c < n_colours(m->n_channels); c++) {
            const size_t k = i * (size_t)m->n_channels + (size_t)c;
            const float d = difference(m->clean[k], other[k] - lift);
            sum += d * d;
        }
        squares[i] = sum;
    }
}

/* w of e and g. */
static float weight_of(float all, float grain)
{
    if (!(all > DOUBTFUL * grain))
        return 0;
    const float certain = (CERTAIN - DOUBTFUL) / CERTAIN * all;
    return (all - grain) / all * fminf((all - DOUBTFUL * grain) / certain, 1);
}

/* Lowers weights to those of means of this reach; room for three planes. */
static void lower_weights(const struct denoise_merges *m, int reach, float *weights,
                          float *room)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    float *all = room, *grain = room + n;
    find_squares(m, m->grainy, 0, all);
    find_squares(m, m->flipped, LIFT, grain);
    smooth(m, reach, all, room + 2 * n);
    smooth(m, reach, grain, room + 2 * n);
    for (size_t i = 0; i < n; i++)
        weights[i] = fminf(weights[i], weight_of(all[i], grain[i]));
}

bool denoise_mix(const struct denoise_merges *m, struct image_error *error)
{
    const size_t n = (size_t)m->width * (size_t)m->height;
    float *weights = app_memory(4, n * sizeof(float), error);
    if (!weights)
        return false;
    for (size_t i = 0; i < n; i++)
        weights[i] = 1;
    lower_weights(m, REACH_PX, weights, weights + n);
    lower_weights(m, NEAR_PX, weights, weights + n);
    for (size_t i = 0; i < n; i++)
        for (int c = 0; c < n_colours(m->n_channels); c++) {
            const size_t k = i * (size_t)m->n_channels + (size_t)c;
            m->clean[k] += weights[i] * (m->grainy[k] - m->clean[k]);
        }
    free(weights);
    return true;
}
