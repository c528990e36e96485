/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A point that view j shows at (x, y) lies in view k at
 *
 *   x + (u_k - u_j) s,  y - (v_k - v_j) s
 *
 * - (u, v): place of the eye on the lens, scene units right and up
 * - s: shift_px of the pixel, f (1/D - 1/z) for a perspective camera
 *
 * The nearest pixel there shows the same point if its own shift is the same within
 * SAME_PX at the lens's radius R, |s_k - s_j| R < SAME_PX. What light it sends depends on
 * where it is seen from (mirrors, glass, gloss), and renderers give what a mirror shows
 * as its albedo: the mean of colours, albedos and normals is over views whose colours
 * agree with those of view j within the grain,
 *
 *   (m_k - m_j)^2 < AGREE^2 (e_k^2 + e_j^2) + LEAST   for each of red, green, blue
 *
 * - m: mean of 5 x 5 px of t = sqrt(clip(v))
 * - e^2 = (mean of t^2 - m^2) / 25, the error of that mean; none within 2 px of lights
 *   of more than LIGHT: blurred, their edges show, and posts with 64 samples in 4
 *   views loses 0.5 dB where they are shared
 *
 * Ours. Worth: docs/notebook/rivals.md.
 */
#include "denoise/denoise_share.h"

#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "parallel.h"

/* SAME_PX: depths of one surface differ by less within a pixel where views overlap, and
 * two surfaces so close have one blur. AGREE: without the test portrait loses 1.6 dB
 * with 16 samples in 8 views (glossy balls). LEAST: of tones without any grain. */
static const float SAME_PX = 0.35f, AGREE = 2, LEAST = 1e-5f, LIGHT = 2;

enum { REACH = 2, SIDE = 2 * REACH + 1, N_TONES = 6 }; /* three m, three e^2 */

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

static size_t n_pixels(const struct share *s)
{
    return (size_t)s->width * (size_t)s->height;
}

/* ---- tones: what colours are compared by --------------------------------------------
 */

/* False of a pixel of a light. */
static bool add_tone(const struct share *s, const float *samples, float sums[N_TONES])
{
    bool is_light = false;
    for (int c = 0; c < 3; c++) {
        const float v = samples[s->n_channels >= 3 ? c : 0] / s->white;
        is_light |= v > LIGHT;
        const float clipped = fminf(fmaxf(v, 0), 1);
        sums[c] += sqrtf(clipped);
        sums[c + 3] += clipped;
    }
    return !is_light;
}

static void find_tone(const struct share *s, const float *samples, int x, int y,
                      float tone[N_TONES])
{
    const float n = SIDE * SIDE;
    float sums[N_TONES] = {0};
    bool is_dim = true;
    for (int j = -REACH; j <= REACH; j++)
        for (int i = -REACH; i <= REACH; i++) {
            const size_t at = (size_t)clamp(y + j, s->height - 1) * (size_t)s->width +
                              (size_t)clamp(x + i, s->width - 1);
            is_dim &= add_tone(s, samples + at * (size_t)s->n_channels, sums);
        }
    for (int c = 0; c < 3; c++) {
        tone[c] = sums[c] / n;
        tone[c + 3] = fmaxf(sums[c + 3] / n - tone[c] * tone[c], 0) / n;
        if (!is_dim)
            tone[c + 3] = -INFINITY;
    }
}

static void find_tones(void *data, int64_t begin, int64_t end, int thread)
{
    const struct share *s = data;
    (void)thread;
    for (int64_t row = begin; row < end; row++) {
        const float *samples = s->views[row / s->height].samples;
        float *tone = s->tones + (size_t)row * (size_t)s->width * N_TONES;
        for (int x = 0; x < s->width; x++)
            find_tone(s, samples, x, (int)(row % s->height), tone + N_TONES * x);
    }
}

bool share_open(struct share *s, struct image_error *error)
{
    s->tones = app_memory(n_pixels(s) * (size_t)s->n, N_TONES * sizeof(float), error);
    if (s->tones)
        os_parallel(s->n_threads, (int64_t)s->n * s->height, 16, find_tones, s);
    return s->tones;
}

void share_close(struct share *s)
{
    free(s->tones);
    s->tones = NULL;
}

/* ---- collecting ---------------------------------------------------------------------
 */

/* What one call of share_collect() is about. */
struct collection {
    const struct share *share;
    int view;
    float *samples, *n_shared;
    struct denoise_guides *guides;
    atomic_llong n_agreed;
};

/* The pixel of view k that shows the point of pixel (x, y) of view j; false: none. */
static bool find_same(const struct share *s, int j, int k, int x, int y, size_t *found)
{
    const struct share_view *from = &s->views[j], *to = &s->views[k];
    const float shift = from->shift_px[(size_t)y * (size_t)s->width + (size_t)x];
    const double u = to->offset[0] - from->offset[0];
    const double v = to->offset[1] - from->offset[1];
    const double at_x = x + u * (double)shift, at_y = y - v * (double)shift;
    if (!(at_x > -0.5 && at_x < s->width - 0.5 && at_y > -0.5 &&
          at_y < s->height - 0.5))
        return false;
    *found = (size_t)(at_y + 0.5) * (size_t)s->width + (size_t)(at_x + 0.5);
    return fabsf(to->shift_px[*found] - shift) * (float)s->lens_radius < SAME_PX;
}

static bool agree(const struct share *s, int j, size_t at, int k, size_t found)
{
    const size_t n = n_pixels(s);
    const float *a = s->tones + N_TONES * (n * (size_t)j + at);
    const float *b = s->tones + N_TONES * (n * (size_t)k + found);
    for (int c = 0; c < 3; c++) {
        const float d = a[c] - b[c];
        if (!(d * d < AGREE * AGREE * (a[c + 3] + b[c + 3]) + LEAST))
            return false;
    }
    return true;
}

/* Sums of a pixel over n views. */
struct sums {
    float colour[4], albedo[3], normal[3];
    int n;
};

static void add_guide(float sum[3], const float *guide, size_t at)
{
    for (int c = 0; guide && c < 3; c++)
        sum[c] += guide[3 * at + (size_t)c];
}

static void add_view(const struct share *s, int k, size_t at, struct sums *sums)
{
    const struct share_view *view = &s->views[k];
    for (int c = 0; c < s->n_channels; c++)
        sums->colour[c] += view->samples[at * (size_t)s->n_channels + (size_t)c];
    add_guide(sums->albedo, view->guides.albedo, at);
    add_guide(sums->normal, view->guides.normal, at);
    sums->n++;
}

static void store(const struct collection *c, size_t at, const struct sums *sums)
{
    const size_t n = (size_t)c->share->n_channels;
    for (size_t i = 0; i < n; i++)
        c->samples[at * n + i] = sums->colour[i] / (float)sums->n;
    for (size_t i = 0; i < 3; i++) {
        if (c->guides->albedo)
            c->guides->albedo[3 * at + i] = sums->albedo[i] / (float)sums->n;
        if (c->guides->normal)
            c->guides->normal[3 * at + i] = sums->normal[i] / (float)sums->n;
    }
}

static void collect_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct collection *c = data;
    const struct share *s = c->share;
    long long n_agreed = 0;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < s->width; x++) {
            const size_t at = (size_t)y * (size_t)s->width + (size_t)x;
            struct sums sums = {0};
            size_t found;
            add_view(s, c->view, at, &sums);
            for (int k = 0; k < s->n; k++)
                if (k != c->view && find_same(s, c->view, k, x, y, &found) &&
                    agree(s, c->view, at, k, found))
                    add_view(s, k, found, &sums);
            store(c, at, &sums);
            if (c->n_shared)
                c->n_shared[at] = (float)sums.n;
            n_agreed += sums.n;
        }
    atomic_fetch_add(&c->n_agreed, n_agreed);
}

double share_collect(const struct share *s, int j, float *samples, float *n_shared,
                     struct denoise_guides *guides)
{
    struct collection c = {.share = s,
                           .view = j,
                           .samples = samples,
                           .n_shared = n_shared,
                           .guides = guides};
    os_parallel(s->n_threads, s->height, 8, collect_rows, &c);
    return (double)c.n_agreed / (double)n_pixels(s);
}
