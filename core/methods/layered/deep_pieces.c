/* SPDX-License-Identifier: Apache-2.0 */
#include "methods/layered/deep_pieces.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/error.h"
#include "base/log.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/depth.h"
#include "input/highlights.h"
#include "input/image.h"
#include "input/pixels.h"

static const float SLICE_PX = 1;          /* of radius, where RF_DEEP_SLICES allow it */
static const float LEAST_OPACITY = 1e-6f; /* below, colour / opacity means nothing */
/* Above, an opacity is worth a remark: a half that is rounded up is 1.001. */
static const float MOST_OPACITY = 1.001f;

/* ---- the pieces of a pixel ----------------------------------------------------- */

static int compare_pieces(const void *a, const void *b)
{
    const struct rf_deep_piece *p = a, *q = b;
    if (p->z != q->z)
        return p->z < q->z ? -1 : 1;
    /* A total order, so that equal depths give the same picture for any sort. */
    for (int n = 0; n < 4; n++)
        if (p->c[n] != q->c[n])
            return p->c[n] < q->c[n] ? -1 : 1;
    return (p->a > q->a) - (p->a < q->a);
}

static void sort_pieces(struct rf_deep_piece *pieces, int n)
{
    if (n > 32) {
        qsort(pieces, (size_t)n, sizeof *pieces, compare_pieces);
        return;
    }
    for (int i = 1; i < n; i++) {
        struct rf_deep_piece p = pieces[i];
        int k = i;
        for (; k > 0 && compare_pieces(&pieces[k - 1], &p) > 0; k--)
            pieces[k] = pieces[k - 1];
        pieces[k] = p;
    }
}

static struct rf_deep_piece whole_piece(const struct rf_deep_work *d,
                                        const struct rf_deep_sample *s)
{
    struct rf_deep_piece p = {.a = rf_clamp01(s->opacity), .value = s->depth};
    if (p.a < LEAST_OPACITY)
        p.a = 0;
    const struct rf_params *params = &d->frame->params;
    for (int n = 0; n < 3; n++)
        p.c[n] = s->colour[d->n_planes == 1 ? 0 : n];
    if (rf_highlights_are_changed(params))
        rf_highlights_change(params, p.c, 3);
    /* The gamma belongs to the light, not to light times coverage. */
    if (params->blend_gamma != 1)
        for (int n = 0; n < 3; n++)
            p.c[n] = p.a > 0 ? rf_to_blend_space(params, p.c[n] / p.a) * p.a
                             : rf_to_blend_space(params, p.c[n]);
    p.c[3] = d->n_planes == 4 ? rf_clamp01(s->colour[3]) : p.a;
    return p;
}

/* One sample as slices, from the front; returns how many. */
static int slice_sample(const struct rf_deep_work *d, const struct rf_deep_sample *s,
                        int x, int y, struct rf_deep_piece *out)
{
    const struct rf_frame *f = d->frame;
    struct rf_deep_piece p = whole_piece(d, s);
    p.z = rf_depth_of_value(&f->params, &f->lens, s->depth, x, y, &p.r);
    out[0] = p;
    if (s->depth_back == s->depth || !isfinite(s->depth_back) || p.a >= RF_OPAQUE_ALPHA)
        return 1;
    float back_r;
    double back = rf_depth_of_value(&f->params, &f->lens, s->depth_back, x, y, &back_r);
    if (!isfinite(p.z) || !isfinite(back) || !(back > p.z))
        return 1;
    float slices = ceilf(fabsf(back_r - p.r) / SLICE_PX);
    int n = slices < RF_DEEP_SLICES ? rf_max_int((int)slices, 1) : RF_DEEP_SLICES;
    float a = (float)-expm1(log1p(-(double)p.a) / n);
    float share = p.a > 0 ? a / p.a : 1 / (float)n;
    for (int k = 0; k < n; k++) {
        float at = ((float)k + 0.5f) / (float)n;
        struct rf_deep_piece *q = &out[k];
        *q = p;
        q->value = s->depth + at * (s->depth_back - s->depth);
        q->z = rf_depth_of_value(&f->params, &f->lens, q->value, x, y, &q->r);
        q->a = a;
        for (int i = 0; i < 4; i++)
            q->c[i] *= share;
    }
    return n;
}

/* The pieces of pixel (x, y), near to far. */
int rf_deep_pieces_of(const struct rf_deep_work *d, int x, int y,
                      struct rf_deep_piece *pieces)
{
    size_t i = (size_t)y * (size_t)d->deep->width + (size_t)x;
    int n = 0;
    for (size_t k = d->deep->first[i]; k < d->deep->first[i + 1]; k++)
        n += slice_sample(d, &d->deep->samples[k], x, y, pieces + n);
    sort_pieces(pieces, n);
    return n;
}

struct rf_deep_piece *rf_deep_scratch(const struct rf_deep_work *d, int thread)
{
    return d->scratch + (d->most_samples * RF_DEEP_SLICES + 1) * (size_t)thread;
}

/* ---- checks -------------------------------------------------------------------- */

struct tally {
    int64_t n_depth, n_pixel, n_above;
    int x_depth, x_pixel, x_above;
    float depth;
};

static bool is_colour_good(const struct rf_deep_work *d, const struct rf_deep_sample *s)
{
    struct rf_deep_piece p = whole_piece(d, s);
    bool is_good = s->opacity >= 0 && isfinite(s->opacity);
    for (int n = 0; n < 4; n++)
        is_good &= isfinite(s->colour[n]) && rf_is_light(&d->frame->params, p.c[n]);
    return is_good;
}

static void check_row(const struct rf_deep_work *d, int y, struct tally *t)
{
    const struct rf_frame *f = d->frame;
    const struct rf_deep *deep = d->deep;
    for (int x = 0; x < deep->width; x++) {
        size_t i = (size_t)y * (size_t)deep->width + (size_t)x;
        for (size_t k = deep->first[i]; k < deep->first[i + 1]; k++) {
            const struct rf_deep_sample *s = &deep->samples[k];
            float r;
            if (isnan(rf_depth_of_value(&f->params, &f->lens, s->depth, x, y, &r))) {
                if (t->n_depth++ == 0) {
                    t->x_depth = x;
                    t->depth = s->depth;
                }
            }
            if (!is_colour_good(d, s) && t->n_pixel++ == 0)
                t->x_pixel = x;
            if (s->opacity > MOST_OPACITY && t->n_above++ == 0)
                t->x_above = x;
        }
    }
}

static rf_result report_tallies(const struct rf_params *params,
                                const struct tally *rows, int height,
                                struct rf_error *error)
{
    int64_t n_depth = 0, n_pixel = 0;
    int y_depth = -1, y_pixel = -1;
    for (int y = 0; y < height; y++) {
        y_depth = rows[y].n_depth && y_depth < 0 ? y : y_depth;
        y_pixel = rows[y].n_pixel && y_pixel < 0 ? y : y_pixel;
        n_depth += rows[y].n_depth;
        n_pixel += rows[y].n_pixel;
    }
    if (n_depth) {
        char words[RF_BAD_DEPTH_WORDS];
        rf_bad_depth_words(params, (double)rows[y_depth].depth, words);
        return rf_fail(error, RF_ERROR_DEPTH, "depth",
                       "%lld deep sample%s with a bad depth, the first is %g at pixel "
                       "(%d, %d)%s; check which kind of depth it is",
                       (long long)n_depth, n_depth == 1 ? "" : "s",
                       (double)rows[y_depth].depth, rows[y_depth].x_depth, y_depth,
                       words);
    }
    if (n_pixel)
        return rf_fail(error, RF_ERROR_PIXEL, "colour",
                       "%lld deep sample%s with NaN, infinite colour or negative "
                       "alpha, the first at pixel (%d, %d): repair the render, the "
                       "blur would spread them",
                       (long long)n_pixel, n_pixel == 1 ? "" : "s",
                       rows[y_pixel].x_pixel, y_pixel);
    return RF_OK;
}

/* Renderers' pixel filters make an opacity of 1.02, so that it is no error. */
static void remark_above(const struct rf_deep_work *d, const struct tally *rows)
{
    int64_t n = 0;
    int first = -1;
    for (int y = 0; y < d->deep->height; y++) {
        first = rows[y].n_above && first < 0 ? y : first;
        n += rows[y].n_above;
    }
    if (n)
        rf_log(d->frame->context, RF_LOG_WARNING,
               "%lld deep sample%s an opacity above 1, the first at pixel (%d, %d): "
               "taken as 1",
               (long long)n, n == 1 ? " has" : "s have", rows[first].x_above, first);
}

/* What the threads share that check samples. */
struct checking {
    const struct rf_deep_work *d;
    struct tally *rows;
};

static void check_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct checking *c = data;
    for (int y = (int)begin; y < (int)end; y++)
        check_row(c->d, y, &c->rows[y]);
}

rf_result rf_deep_check(struct rf_deep_work *d, struct rf_error *error)
{
    const struct rf_context *context = d->frame->context;
    const struct rf_deep *deep = d->deep;
    size_t n = (size_t)deep->width * (size_t)deep->height;
    if (deep->first[0] != 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "deep", "first[0] must be 0");
    for (size_t i = 0; i < n; i++) {
        if (deep->first[i + 1] < deep->first[i] ||
            deep->first[i + 1] - deep->first[i] > INT32_MAX / RF_DEEP_SLICES / 2)
            return rf_fail(error, RF_ERROR_ARGUMENT, "deep",
                           "the offsets fall, or a pixel has too many samples, at "
                           "pixel %zu",
                           i);
        size_t n_samples = deep->first[i + 1] - deep->first[i];
        d->most_samples = n_samples > d->most_samples ? n_samples : d->most_samples;
    }
    struct tally *rows = rf_calloc(context, (size_t)deep->height, sizeof *rows);
    if (!rows)
        return rf_fail_memory(error, (size_t)deep->height, sizeof *rows);
    struct checking checking = {d, rows};
    rf_parallel(context, deep->height, 8, check_rows, &checking);
    rf_result result = report_tallies(&d->frame->params, rows, deep->height, error);
    if (result == RF_OK)
        remark_above(d, rows);
    rf_free(context, rows);
    return result;
}
