/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box: a running sum along the rows, then along the columns, repeated n times.
 *
 *   S(k) = sum of c(i) for i < k,  continued linearly between whole k
 *   out(x) = (S(b) - S(a)) / (b - a),   a, b = x + 1/2 -+ W/2, cut at the border
 *   W = 2 k + 1 + 2 f,  v = r^2 / (4 n),  k (k + 1) / 3 <= v < (k + 1) (k + 2) / 3,
 *   f = (v (2 k + 1) - k (k + 1) (2 k + 1) / 3) / (2 ((k + 1)^2 - v))
 *
 *   c   the pixels of a row or column
 *   r   radius of the pixel in that direction, px: along columns times the pixel aspect
 *   W   width of the box, px                n   repeats, --box-repeats
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "convolution": per step add one value and drop one. The thesis blurs the whole
 * picture by one width; a width per pixel, for the blend coc, is ours and costs nothing
 * more with S kept. W, k whole pixels and a share f of the next one on each side, is
 * such that n boxes have the mean square distance of the disc, r^2/4 per axis.
 *
 * --box-direction leaves out one of the two: horizontal is the 1 x N of the thesis, which
 * looks like motion; the other direction then has W = 1, which changes nothing.
 *
 * Approximates the disc by a square (n = 1), a tent (2), nearly a Gaussian (3).
 * Known artefacts: square bokeh; with coc each pixel gathers by its own radius, so a
 * blurred foreground ends at its outline and sharp things run into blurred ones.
 *
 * Cost: the same for every width; proportional to n. S is in double precision, so that
 * a highlight leaves no trace in the rest of its row.
 */
#include "methods/preview/box.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

/* Four sums, as two registers that every processor has. */
typedef double d2 __attribute__((vector_size(16)));
struct sums {
    d2 low, high;
};

enum { STRIP = 8 }; /* columns that go down together: whole cache lines */

struct box {
    const struct rf_blur *blur;
    const struct rf_grid *from;
    struct rf_grid *to; /* NULL: to blur->put */
    int n_repeats;
    float over_n;      /* 1 / n_repeats */
    struct sums *sums; /* per thread */
    size_t n_sums;     /* of one thread */
    float stretch;     /* pixels of this direction per px */
    bool is_still;     /* this direction is not blurred */
};

static inline float box_width(float r, float over_n)
{
    float v = 0.25f * r * r * over_n; /* r^2 / (4 n) */
    float k = (float)(int)(0.5f * sqrtf(1 + 12 * v) - 0.5f);
    float whole = 2 * k + 1, square = (k + 1) * (k + 1);
    float sum = k * (k + 1) * whole * (1 / 3.0f);
    return whole + (v * whole - sum) / (square - v);
}

/* The widths of n boxes from (x, y) on. */
static void widths_at(const struct box *b, int x, int y, int n, float *width)
{
    const struct rf_blur *blur = b->blur;
    const float *r = blur->radius_map;
    if (r)
        r += (size_t)y * (size_t)blur->source->width + (size_t)x;
    const float alone = box_width(blur->radius_px * b->stretch, b->over_n);
    for (int i = 0; i < n; i++)
        width[i] = b->is_still ? 1
                   : r         ? box_width(r[i] * b->stretch, b->over_n)
                               : alone;
}

static inline void add_pixel(struct sums *s, rf_f4 v)
{
    s->low += (d2){(double)v[0], (double)v[1]};
    s->high += (d2){(double)v[2], (double)v[3]};
}

static inline rf_f4 difference(const struct sums *a, const struct sums *b)
{
    d2 low = a->low - b->low, high = a->high - b->high;
    return (rf_f4){(float)low[0], (float)low[1], (float)high[0], (float)high[1]};
}

/* The ends of n boxes, cut to [0, length]; whole part and rest, 1 / (b - a). */
struct ends {
    float width[RF_PIECE];
    int a[RF_PIECE], b[RF_PIECE];
    float rest_a[RF_PIECE], rest_b[RF_PIECE], weight[RF_PIECE];
};

/* Boxes centred in pixels first, first + step, ... */
static inline void find_ends(struct ends *e, int first, int step, int n, int length)
{
    float last = (float)(length - 1);
    for (int i = 0; i < n; i++) {
        float centre = (float)(first + i * step) + 0.5f;
        float a = rf_maxf(centre - 0.5f * e->width[i], 0);
        float b = rf_minf(centre + 0.5f * e->width[i], (float)length);
        e->a[i] = (int)a;
        e->b[i] = (int)rf_minf(b, last);
        e->rest_a[i] = a - (float)e->a[i];
        e->rest_b[i] = b - (float)e->b[i];
        e->weight[i] = 1 / (b - a);
    }
}

/* (S(b) - S(a)) / (b - a); sums and pixels lie `step` apart. */
static inline rf_f4 box_mean(const struct sums *sums, const rf_f4 *pixels, size_t step,
                             const struct ends *e, int i)
{
    size_t a = (size_t)e->a[i], b = (size_t)e->b[i];
    rf_f4 whole = difference(&sums[b * step], &sums[a * step]);
    rf_f4 rest = rf_f4_of(e->rest_b[i]) * pixels[b * step] -
                 rf_f4_of(e->rest_a[i]) * pixels[a * step];
    return (whole + rest) * rf_f4_of(e->weight[i]);
}

/* Between the two directions pixels lie strip after strip, so that going down reads
 * memory in its order. */
static inline rf_f4 *strip_pixel(const struct rf_grid *grid, int x, int y)
{
    size_t strip = (size_t)(x / STRIP) * (size_t)grid->height + (size_t)y;
    return grid->at + strip * STRIP + (size_t)(x % STRIP);
}

static void rows_band(void *user, int from, int to, int thread)
{
    const struct box *b = user;
    int width = b->from->width;
    struct sums *sums = b->sums + b->n_sums * (size_t)thread;
    for (int y = from; y < to; y++) {
        const rf_f4 *row = b->from->at + (size_t)y * (size_t)width;
        struct sums sum = {{0}, {0}};
        for (int x = 0; x < width; x++) {
            sums[x] = sum;
            add_pixel(&sum, row[x]);
        }
        for (int x = 0; x < width; x += RF_PIECE) {
            struct ends ends;
            int n = rf_min_int(RF_PIECE, width - x);
            widths_at(b, x, y, n, ends.width);
            find_ends(&ends, x, 1, n, width);
            for (int i = 0; i < n; i++)
                *strip_pixel(b->to, x + i, y) = box_mean(sums, row, 1, &ends, i);
        }
    }
}

static void strip_down(const struct box *b, int x0, int n, struct sums *sums)
{
    int height = b->from->height;
    const rf_f4 *strip = strip_pixel(b->from, x0, 0);
    struct sums sum[STRIP] = {{{0}, {0}}};
    for (int y = 0; y < height; y++)
        for (int i = 0; i < n; i++) {
            sums[y * STRIP + i] = sum[i];
            add_pixel(&sum[i], strip[y * STRIP + i]);
        }
    for (int y = 0; y < height; y++) {
        rf_f4 out[STRIP];
        struct ends ends;
        widths_at(b, x0, y, n, ends.width);
        find_ends(&ends, y, 0, n, height);
        for (int i = 0; i < n; i++)
            out[i] = box_mean(sums + i, strip + i, STRIP, &ends, i);
        if (b->to)
            memcpy(b->to->at + (size_t)y * (size_t)b->to->width + x0, out,
                   (size_t)n * sizeof *out);
        else
            b->blur->put(b->blur, x0, y, n, out);
    }
}

static void columns_band(void *user, int from, int to, int thread)
{
    const struct box *b = user;
    strip_down(b, from, to - from, b->sums + b->n_sums * (size_t)thread);
}

static void repeat(struct box *b, struct rf_grid *rows, struct rf_grid *columns)
{
    const struct rf_blur *blur = b->blur;
    int n_passes = 2 * b->n_repeats, direction = blur->frame->params.box_direction;
    b->from = blur->source;
    for (int i = 0; i < b->n_repeats; i++) {
        b->to = rows;
        b->stretch = 1;
        b->is_still = direction == RF_DIRECTION_VERTICAL;
        rf_blur_pass(blur, 2 * i, n_passes, blur->source->height, RF_BAND_ROWS,
                     rows_band, b);
        b->from = rows;
        b->to = i + 1 < b->n_repeats ? columns : NULL;
        b->stretch = (float)blur->frame->params.pixel_aspect;
        b->is_still = direction == RF_DIRECTION_HORIZONTAL;
        rf_blur_pass(blur, 2 * i + 1, n_passes, blur->source->width, STRIP,
                     columns_band, b);
        b->from = columns;
    }
}

rf_result rf_generate_box(const struct rf_blur *blur, struct rf_error *error)
{
    const struct rf_context *context = blur->frame->context;
    int width = blur->source->width, height = blur->source->height;
    struct box b = {.blur = blur, .n_repeats = blur->frame->params.box_repeats};
    b.n_sums = (size_t)rf_max_int(width, height * STRIP);
    b.over_n = 1 / (float)b.n_repeats;
    struct rf_grid rows = {0}, columns = {0};
    size_t n_threads = (size_t)context->n_threads;
    b.sums = rf_alloc(context, b.n_sums * n_threads, sizeof *b.sums);
    bool is_complete =
        b.sums &&
        rf_grid_alloc(context, &rows, (width + STRIP - 1) / STRIP * STRIP, height) &&
        (b.n_repeats == 1 || rf_grid_alloc(context, &columns, width, height));
    if (is_complete)
        repeat(&b, &rows, &columns);
    rf_free(context, columns.at);
    rf_free(context, rows.at);
    rf_free(context, b.sums);
    return is_complete ? RF_OK
                       : rf_fail_memory(error, (size_t)width * (size_t)height,
                                        2 * sizeof *rows.at);
}
