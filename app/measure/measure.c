/* SPDX-License-Identifier: Apache-2.0 */
#include "measure/measure.h"

#include <math.h>
#include <stdlib.h>

#include "common/stop.h"
#include "parallel.h"

double measure_tone(double value)
{
    return pow(fmin(fmax(value, 0), 1), 1 / 2.2);
}

double measure_gaussian(double *taps, int radius, double sigma)
{
    double sum = 0;
    for (int i = 0; i <= 2 * radius; i++) {
        const double x = i - radius;
        taps[i] = exp(-x * x / (2 * sigma * sigma));
        sum += taps[i];
    }
    for (int i = 0; i <= 2 * radius; i++)
        taps[i] /= sum;
    return sum;
}

static double clip(double value)
{
    return fmin(fmax(value, 0), 1);
}

static double decibel(double mean_square)
{
    return mean_square > 0 ? -10 * log10(mean_square) : INFINITY;
}

/* ---- SSIM ------------------------------------------------------------------------ */

#define RADIUS 5
#define TAPS (2 * RADIUS + 1)
#define SIGMA 1.5

enum moment { MEAN_A, MEAN_B, SQUARE_A, SQUARE_B, PRODUCT, N_MOMENTS };

/* One channel of two pictures under the sliding window. */
struct window {
    const float *a, *b; /* tone mapped, every third value */
    int32_t width, height;
    double weights[TAPS];
    double *rows;        /* TAPS rows, filtered horizontally: [row][moment][x] */
    int32_t row_y[TAPS]; /* which row of the picture it is; -1: none yet */
    double *wide;        /* a row of products, mirrored at both ends */
    double *moments;     /* a row filtered both ways: [moment][x] */
};

/* Mirrors at the border, the border's own pixel twice: b a | a b c | c b. */
static int32_t mirror(int32_t i, int32_t n)
{
    while (i < 0 || i >= n)
        i = i < 0 ? -1 - i : 2 * n - 1 - i;
    return i;
}

/* One moment of row y before filtering, RADIUS mirrored values at either end. */
static void fill_wide(const struct window *window, int32_t y, enum moment moment)
{
    const int32_t width = window->width;
    const float *a = window->a + (size_t)y * width * 3;
    const float *b = window->b + (size_t)y * width * 3;
    for (int32_t x = -RADIUS; x < width + RADIUS; x++) {
        const size_t at = 3 * (size_t)mirror(x, width);
        const double va = a[at], vb = b[at];
        const double values[N_MOMENTS] = {va, vb, va * va, vb * vb, va * vb};
        window->wide[x + RADIUS] = values[moment];
    }
}

static void filter_row(const struct window *window, int32_t y, double *row)
{
    const size_t width = (size_t)window->width;
    const double *wide = window->wide;
    for (int m = 0; m < N_MOMENTS; m++, row += width) {
        fill_wide(window, y, m);
        for (size_t x = 0; x < width; x++)
            row[x] = 0;
        for (size_t i = 0; i < TAPS; i++)
            for (size_t x = 0; x < width; x++)
                row[x] += window->weights[i] * wide[x + i];
    }
}

/* The filtered row y; the last TAPS rows are kept. */
static const double *get_row(struct window *window, int32_t y)
{
    const int slot = y % TAPS;
    double *row = window->rows + (size_t)slot * N_MOMENTS * window->width;
    if (window->row_y[slot] != y) {
        filter_row(window, y, row);
        window->row_y[slot] = y;
    }
    return row;
}

static double similarity(const double *moments)
{
    const double c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    const double mean_a = moments[MEAN_A], mean_b = moments[MEAN_B];
    const double variance_a = moments[SQUARE_A] - mean_a * mean_a;
    const double variance_b = moments[SQUARE_B] - mean_b * mean_b;
    const double covariance = moments[PRODUCT] - mean_a * mean_b;
    return (2 * mean_a * mean_b + c1) * (2 * covariance + c2) /
           ((mean_a * mean_a + mean_b * mean_b + c1) * (variance_a + variance_b + c2));
}

/* The moments of row y, filtered both ways. */
static void filter_column(struct window *window, int32_t y)
{
    const size_t n = (size_t)N_MOMENTS * (size_t)window->width;
    double *moments = window->moments;
    for (size_t k = 0; k < n; k++)
        moments[k] = 0;
    for (int i = 0; i < TAPS; i++) {
        const double *row = get_row(window, mirror(y + i - RADIUS, window->height));
        for (size_t k = 0; k < n; k++)
            moments[k] += window->weights[i] * row[k];
    }
}

static double sum_row(const struct window *window, int32_t skip)
{
    double sum = 0;
    for (int32_t x = skip; x < window->width - skip; x++) {
        double moments[N_MOMENTS];
        for (int m = 0; m < N_MOMENTS; m++)
            moments[m] = window->moments[(size_t)m * window->width + x];
        sum += similarity(moments);
    }
    return sum;
}

/* Mean over the window's places; the border is left out where the picture allows. */
static bool channel_ssim(const float *a, const float *b, int32_t width, int32_t height,
                         double *ssim, const bool *stop)
{
    struct window window = {.a = a, .b = b, .width = width, .height = height};
    const size_t row = (size_t)width;
    measure_gaussian(window.weights, RADIUS, SIGMA);
    window.rows = calloc((size_t)TAPS * N_MOMENTS * row, sizeof(double));
    window.wide = calloc(row + 2 * RADIUS, sizeof(double));
    window.moments = calloc(N_MOMENTS * row, sizeof(double));
    const bool is_good = window.rows && window.wide && window.moments;
    for (int i = 0; i < TAPS; i++)
        window.row_y[i] = -1;
    const int32_t skip_x = width < TAPS ? 0 : RADIUS;
    const int32_t skip_y = height < TAPS ? 0 : RADIUS;
    double sum = 0;
    for (int32_t y = skip_y; is_good && y < height - skip_y && !is_stopped(stop); y++) {
        filter_column(&window, y);
        sum += sum_row(&window, skip_x);
    }
    free(window.rows);
    free(window.wide);
    free(window.moments);
    *ssim = sum / ((double)(width - 2 * skip_x) * (height - 2 * skip_y));
    return is_good && !is_stopped(stop);
}

struct toning {
    const float *samples;
    float *toned;
    const bool *stop;
};

enum { TONED_PART = 1 << 16 };

static void tone_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct toning *t = data;
    if (is_stopped(t->stop))
        return;
    for (int64_t i = begin; i < end; i++)
        t->toned[i] = (float)measure_tone(t->samples[i]);
}

static float *tone_mapped(const float *samples, size_t n, const bool *stop)
{
    float *toned = malloc((n ? n : 1) * sizeof(*toned));
    if (!toned)
        return NULL;
    struct toning t = {samples, toned, stop};
    os_parallel(0, (int64_t)n, TONED_PART, tone_some, &t);
    return toned;
}

/* Two pictures, and what their channels have in common. */
struct likeness {
    const float *a, *b;
    int32_t width, height;
    double ssim[3];
    bool are_good[3];
    const bool *stop;
};

static void compare_channels(void *data, int64_t begin, int64_t end, int thread)
{
    struct likeness *l = data;
    for (int64_t c = begin; c < end; c++)
        l->are_good[c] =
            channel_ssim(l->a + c, l->b + c, l->width, l->height, &l->ssim[c], l->stop);
}

static bool mean_ssim(const float *a, const float *b, int32_t width, int32_t height,
                      double *ssim, const bool *stop)
{
    struct likeness l = {
        .a = a, .b = b, .width = width, .height = height, .stop = stop};
    os_parallel(0, 3, 1, compare_channels, &l);
    *ssim = (l.ssim[0] + l.ssim[1] + l.ssim[2]) / 3;
    return l.are_good[0] && l.are_good[1] && l.are_good[2];
}

/* ---- sums ------------------------------------------------------------------------ */

struct sums {
    double square, clipped_square, toned_square, energy_a, energy_b;
};

static void add_sample(struct sums *sums, double a, double b, double toned_difference)
{
    const double clipped = clip(a) - clip(b);
    sums->square += (a - b) * (a - b);
    sums->clipped_square += clipped * clipped;
    sums->toned_square += toned_difference * toned_difference;
    sums->energy_a += a;
    sums->energy_b += b;
}

static void find_maximum(struct measures *measures, const float *a, const float *b,
                         int32_t width, size_t n)
{
    size_t at = 0;
    double largest = -1;
    for (size_t i = 0; i < n; i++) {
        const double error = fabs((double)a[i] - b[i]);
        if (error > largest) {
            largest = error;
            at = i;
        }
    }
    measures->max_error = largest;
    measures->max_channel = (int)(at % 3);
    measures->max_x = (int32_t)(at / 3 % (size_t)width);
    measures->max_y = (int32_t)(at / 3 / (size_t)width);
}

bool measure_pictures(const float *a, const float *b, int32_t width, int32_t height,
                      struct measures *measures, const bool *stop)
{
    const size_t n = 3 * (size_t)width * (size_t)height;
    float *toned_a = tone_mapped(a, n, stop);
    float *toned_b = toned_a ? tone_mapped(b, n, stop) : NULL;
    const bool is_good =
        toned_b && mean_ssim(toned_a, toned_b, width, height, &measures->ssim, stop);
    struct sums sums = {0};
    for (size_t i = 0; is_good && i < n; i++)
        add_sample(&sums, a[i], b[i], (double)toned_a[i] - toned_b[i]);
    free(toned_a);
    free(toned_b);
    if (!is_good)
        return false;
    const double count = (double)n;
    measures->psnr_db = decibel(sums.clipped_square / count);
    measures->tpsnr_db = decibel(sums.toned_square / count);
    measures->rmse = sqrt(sums.square / count);
    measures->energy_ratio = sums.energy_b != 0 ? sums.energy_a / sums.energy_b : NAN;
    find_maximum(measures, a, b, width, n);
    return true;
}

struct toned_rows {
    const float *a, *b;
    int32_t width;
    double *squares; /* of each row, so that the sum does not depend on the threads */
};

static void sum_toned_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct toned_rows *t = data;
    const size_t n = 3 * (size_t)t->width;
    for (int64_t y = begin; y < end; y++) {
        double sum = 0;
        for (size_t i = (size_t)y * n; i < (size_t)(y + 1) * n; i++) {
            const double error =
                (float)measure_tone(t->a[i]) - (double)(float)measure_tone(t->b[i]);
            sum += error * error;
        }
        t->squares[y] = sum;
    }
}

double measure_tpsnr(const float *a, const float *b, int32_t width, int32_t height)
{
    struct toned_rows t = {a, b, width, malloc((size_t)height * sizeof(double))};
    double sum = 0;
    if (!t.squares)
        return NAN;
    os_parallel(0, height, 0, sum_toned_rows, &t);
    for (int32_t y = 0; y < height; y++)
        sum += t.squares[y];
    free(t.squares);
    return decibel(sum / (3.0 * width * height));
}

/* ---- heat map -------------------------------------------------------------------- */

static const float heat_colours[][3] = {
    {0, 0, 0},
    {0.25f, 0.05f, 0.45f},
    {0.73f, 0.21f, 0.33f},
    {0.98f, 0.55f, 0.04f},
    {0.99f, 0.91f, 0.35f},
    {1, 1, 1},
};

static void heat_colour(double heat, float *rgb)
{
    const int n = (int)(sizeof(heat_colours) / sizeof(heat_colours[0])) - 1;
    const double place = clip(heat) * n;
    const int i = place >= n ? n - 1 : (int)place;
    for (int c = 0; c < 3; c++) {
        const double from = heat_colours[i][c], to = heat_colours[i + 1][c];
        rgb[c] = (float)(from + (place - i) * (to - from));
    }
}

struct heating {
    const float *a, *b;
    double full_scale;
    float *rgb;
};

static void heat_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct heating *h = data;
    for (int64_t i = begin; i < end; i++) {
        double largest = 0;
        for (int64_t c = 3 * i; c < 3 * i + 3; c++)
            largest =
                fmax(largest, fabs(measure_tone(h->a[c]) - measure_tone(h->b[c])));
        heat_colour(largest / h->full_scale, h->rgb + 3 * i);
    }
}

void measure_heatmap(const float *a, const float *b, int32_t width, int32_t height,
                     float *rgb)
{
    measure_heatmap_to(a, b, width, height, HEAT_FULL_SCALE, rgb);
}

void measure_heatmap_to(const float *a, const float *b, int32_t width, int32_t height,
                        double full_scale, float *rgb)
{
    struct heating h = {a, b, full_scale, rgb};
    os_parallel(0, (int64_t)width * height, 0, heat_some, &h);
}
