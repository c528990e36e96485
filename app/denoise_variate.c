/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Control variates in the picture's space (Rousselle, Jarosz, Novak, "Image-space
 * control variates for rendering", 2016, with OIDN's guides in place of coarser
 * renders). Colour, albedo and normals of a pixel are means of the same samples, so
 * that one sample more on the bright side of an edge shows in all of them. Per channel
 *
 *   x = c - b . v,  v = (a - A, n - N)
 *   b = (E[v v^T] + r I)^-1 E[v e],  e = c - d limited to +-LIMIT
 *
 * - c, a, n: the picture's colour, its albedo in that channel and its normals
 * - A, N: albedo and normals without grain
 * - d: the picture denoised
 * - E: Gaussian mean, sigma 2 px
 * - r: of the grain that is too small to tell anything
 *
 * Worth, one picture of 32 samples before any denoising: a plane's texture 36.1 to
 * 42.7 dB. What several views gain: docs/notebook/rivals.md. Cost: 1500 operations per
 * pixel, less than one run of the denoiser.
 */
#include "denoise_variate.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"
#include "report.h"

/* LIMIT: one sample of a lamp says nothing of its surroundings; without it posts loses
 * 1.4 dB with 32 samples. LEAST: variance of albedo and normals; 1e-4 and 3e-4 are
 * alike. SIGMA_PX: 4 in place of 2 loses 2.7 dB on posts. */
static const float LIMIT = 1, LEAST = 3e-4f;
static const double SIGMA_PX = 2;

enum {
    REACH = 8, /* px, 4 sigma */
    N_VARIATES = 4,
    /* Moments that all channels share: of the normals. And of each channel: a a, a n,
     * a e, n e. */
    N_SHARED = 6,
    N_OF_CHANNEL = 8,
    N_MOMENTS = N_SHARED + 3 * N_OF_CHANNEL,
};

/* What the threads share. */
struct work {
    const struct variates *variates;
    float weights[2 * REACH + 1];
    float *rows; /* of each thread: moments of a row of pixels */
    float *made;
};

/* What one pixel differs by from what is without grain. */
struct differences {
    float albedo[3], normal[3], colour[3];
};

static int clamp(int v, int most)
{
    return v < 0 ? 0 : v > most ? most : v;
}

static int n_colours(const struct variates *v)
{
    return v->picture.n_channels >= 3 ? 3 : 1;
}

static void find_differences(const struct variates *v, size_t at, struct differences *d)
{
    const size_t n_channels = (size_t)v->picture.n_channels;
    *d = (struct differences){0};
    for (int c = 0; c < n_colours(v); c++) {
        const size_t i = at * n_channels + (size_t)c;
        const float e = v->picture.samples[i] - v->denoised[i];
        d->colour[c] = fminf(fmaxf(e, -LIMIT), LIMIT);
    }
    for (size_t c = 0; c < 3; c++) {
        d->albedo[c] = v->sampled->albedo[3 * at + c] - v->clean->albedo[3 * at + c];
        if (v->sampled->normal && v->clean->normal)
            d->normal[c] =
                v->sampled->normal[3 * at + c] - v->clean->normal[3 * at + c];
    }
}

static void add_moments(const struct differences *d, float weight, float *moments)
{
    const float *n = d->normal;
    float *m = moments;
    for (int i = 0; i < 3; i++)
        for (int j = i; j < 3; j++)
            *m++ += weight * n[i] * n[j];
    for (int c = 0; c < 3; c++) {
        const float a = d->albedo[c], e = d->colour[c];
        *m++ += weight * a * a;
        for (int i = 0; i < 3; i++)
            *m++ += weight * a * n[i];
        *m++ += weight * a * e;
        for (int i = 0; i < 3; i++)
            *m++ += weight * n[i] * e;
    }
}

/* Solves A x = b for a symmetric A of which r I makes a positive one; A and b are lost.
 */
static void solve(double a[N_VARIATES][N_VARIATES], double b[N_VARIATES],
                  double x[N_VARIATES])
{
    for (int i = 0; i < N_VARIATES; i++)
        for (int j = i + 1; j < N_VARIATES; j++) {
            const double by = a[j][i] / a[i][i];
            for (int k = i; k < N_VARIATES; k++)
                a[j][k] -= by * a[i][k];
            b[j] -= by * b[i];
        }
    for (int i = N_VARIATES - 1; i >= 0; i--) {
        double left = b[i];
        for (int j = i + 1; j < N_VARIATES; j++)
            left -= a[i][j] * x[j];
        x[i] = left / a[i][i];
    }
}

/* The grain of a channel that the differences of its pixel explain. */
static float explain(const float *moments, int channel, const struct differences *d)
{
    static const int at[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    const float *of = moments + N_SHARED + N_OF_CHANNEL * channel;
    double a[N_VARIATES][N_VARIATES], b[N_VARIATES], x[N_VARIATES];
    for (int i = 0; i < N_VARIATES; i++) {
        for (int j = 0; j < N_VARIATES; j++)
            a[i][j] =
                (double)(i == 0 || j == 0 ? of[i + j] : moments[at[i - 1][j - 1]]);
        a[i][i] += (double)LEAST;
        b[i] = (double)of[N_VARIATES + i];
    }
    solve(a, b, x);
    double sum = x[0] * (double)d->albedo[channel];
    for (int i = 0; i < 3; i++)
        sum += x[1 + i] * (double)d->normal[i];
    return (float)sum;
}

/* Moments of a row, averaged over the rows around it. */
static void gather_row(const struct work *w, int y, float *row)
{
    const struct denoise_picture *p = &w->variates->picture;
    memset(row, 0, (size_t)p->width * N_MOMENTS * sizeof(*row));
    for (int j = -REACH; j <= REACH; j++) {
        const size_t start = (size_t)clamp(y + j, p->height - 1) * (size_t)p->width;
        for (int x = 0; x < p->width; x++) {
            struct differences d;
            find_differences(w->variates, start + (size_t)x, &d);
            add_moments(&d, w->weights[j + REACH], row + (size_t)x * N_MOMENTS);
        }
    }
}

static void make_pixel(const struct work *w, const float *row, int x, size_t at)
{
    const struct variates *v = w->variates;
    const size_t n_channels = (size_t)v->picture.n_channels;
    float moments[N_MOMENTS] = {0};
    struct differences d;
    for (int i = -REACH; i <= REACH; i++) {
        const float *from =
            row + (size_t)clamp(x + i, v->picture.width - 1) * N_MOMENTS;
        for (int k = 0; k < N_MOMENTS; k++)
            moments[k] += w->weights[i + REACH] * from[k];
    }
    find_differences(v, at, &d);
    for (int c = 0; c < n_colours(v); c++)
        w->made[at * n_channels + (size_t)c] -= explain(moments, c, &d);
}

static void make_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct work *w = data;
    const size_t width = (size_t)w->variates->picture.width;
    float *row = w->rows + (size_t)thread * width * N_MOMENTS;
    for (int64_t y = begin; y < end; y++) {
        gather_row(w, (int)y, row);
        for (size_t x = 0; x < width; x++)
            make_pixel(w, row, (int)x, (size_t)y * width + x);
    }
}

static void make_weights(float weights[2 * REACH + 1])
{
    double sum = 0;
    for (int i = -REACH; i <= REACH; i++)
        sum += exp(-i * i / (2 * SIGMA_PX * SIGMA_PX));
    for (int i = -REACH; i <= REACH; i++)
        weights[i + REACH] = (float)(exp(-i * i / (2 * SIGMA_PX * SIGMA_PX)) / sum);
}

bool variates_remove(const struct variates *v, float *made, struct image_error *error)
{
    const struct denoise_picture *p = &v->picture;
    const size_t n = (size_t)p->width * (size_t)p->height * (size_t)p->n_channels;
    struct work work = {.variates = v, .made = made};
    memcpy(made, p->samples, n * sizeof(*made));
    for (size_t i = 0; i < n; i++)
        if (!isfinite(p->samples[i]))
            return true;
    work.rows = app_memory((size_t)v->n_threads * (size_t)p->width,
                           N_MOMENTS * sizeof(float), error);
    if (!work.rows)
        return false;
    make_weights(work.weights);
    os_parallel(v->n_threads, p->height, 8, make_rows, &work);
    free(work.rows);
    return true;
}
