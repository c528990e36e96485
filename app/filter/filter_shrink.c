/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --supersample N: what was filtered at N times the size is brought to the size that was
 * asked for. The lens and the pixel filter are both sums of light, so that their order
 * does not matter; a pixel of the larger picture is nearly always of one surface, whose
 * depth is its own.
 *
 * The renderer's own picture has its pixel filter in pixels of the picture, the passes
 * have the same in theirs, which are N times smaller. So N x N pixels are not averaged, but
 * weighed by a filter of that kind whose variance is what is missing:
 *
 *     missing, px^2 of the passes = N^2 V - V - 1/8
 *
 * V is the variance of the renderer's filter in its pixels, on each axis. 1/8 is what the
 * lens spreads: a pixel is blurred as a whole, 1/12, and rims of footprints are smoothed.
 * That is where there is blur alone, and seen most at the rims of lamps, which like more
 * of it, as textures in focus like none.
 *
 * Where views of few samples are moved within their pixels (docs/views.md), which a plane
 * off the focus tells that stays in place, they have a disc of 0.5 px of the picture in
 * place of V, 1/16 of its px^2, and are placed between pixels, 1/6. Of both 0.85 are made
 * up for, of which textures in focus like less and rims more.
 *
 * Worth of it against the mean of N x N px, whose edges in focus are 5.9 % off the
 * renderer's: docs/notebook/rivals.md.
 */
#include "filter/filter_shrink.h"

#include <math.h>
#include <stdlib.h>

#include "common/report.h"
#include "filter/filter_private.h"

int filter_check_supersample(const struct run *run)
{
    const int n = run->tool->supersample;
    const struct source *source = &run->source;
    const struct image_box *data = &source->info.data_window;
    const struct image_box *display = &source->info.display_window;
    if (n < 2)
        return APP_DONE;
    if (run->is_deep || run->tool->filter_layers || run->tool->pass_through ||
        run->tool->output_coc)
        return app_fail(run->error, APP_USAGE,
                        "--supersample: goes with flat pictures alone; leave out "
                        "--filter-layers, --pass-through and --output-coc");
    if (source->width % n || source->height % n || data->min_x % n || data->min_y % n ||
        display->min_x % n || display->min_y % n || (display->max_x + 1) % n ||
        (display->max_y + 1) % n)
        return app_fail(run->error, APP_FAILED,
                        "%s: is %d x %d px from (%d, %d), which --supersample %d does "
                        "not divide; render at %d times the size of the picture",
                        image_path(source->colour), source->width, source->height,
                        data->min_x, data->min_y, n, n);
    return APP_DONE;
}

/* ---- weights -------------------------------------------------------------------- */

/* Weights of the pixels of a side, symmetric, about the middle of a block. */
struct taps {
    float weights[FILTER_MOST_TAPS];
    int n;
};

/* The kinds, of x from -1 to 1. */
static double blackman_harris(double x)
{
    const double a = acos(-1) * x;
    return 0.35875 + 0.48829 * cos(a) + 0.14128 * cos(2 * a) + 0.01168 * cos(3 * a);
}

static double gaussian(double x)
{
    return exp(-18 * x * x);
}

static const struct {
    double (*at)(double x);
    double reach;    /* in widths as Cycles has them */
    double variance; /* of x */
} KINDS[] = {[FILTER_PIXELS_BLACKMAN_HARRIS] = {blackman_harris, 1, 0.0767371},
             [FILTER_PIXELS_GAUSSIAN] = {gaussian, 1.5, 0.0277777}};

static const double SPREAD = 1 / 8.0, DISC = 1 / 16.0, PLACING = 1 / 6.0;
static const double MADE_UP_FOR = 0.85;

/* Does a plane off the focus, by more than this px of radius, stay in place in the views?
 * Those of few samples have 1.5, others 0. */
static bool are_moved(const struct run *run)
{
    static const double OFF_PX = 0.5;
    const struct rf_lens *lens = rf_filter_lens(run->filter);
    for (int i = 0; run->has_views && i < run->views.n; i++) {
        const double plane = run->views.views[i].shear_distance;
        if (fabs(rf_lens_radius_px(lens, plane > 0 ? plane : HUGE_VAL)) > OFF_PX)
            return true;
    }
    return false;
}

/* How far the weights reach, px of the passes. */
static double reach_of(const struct run *run)
{
    const int kind = run->tool->pixel_filter, n = run->tool->supersample;
    const double given = run->tool->pixel_filter_width;
    const double width = given > 0 ? given : FILTER_PIXELS_USUAL_WIDTH;
    const double whole =
        width * width * KINDS[kind].reach * KINDS[kind].reach * KINDS[kind].variance;
    const double there =
        are_moved(run) ? MADE_UP_FOR * (n * n * DISC + PLACING) : whole + SPREAD;
    const double missing = fmax(n * n * whole - there, 0);
    return sqrt(missing / KINDS[kind].variance);
}

/*
 * Weights are multiples of 2^-16 that sum to 1: the C libraries' last bits differ, and
 * the picture's must not.
 */
static struct taps shrink_taps(const struct run *run)
{
    const int n = run->tool->supersample, kind = run->tool->pixel_filter;
    struct taps taps = {.n = n};
    if (kind == FILTER_PIXELS_BOX) {
        for (int i = 0; i < n; i++)
            taps.weights[i] = 1 / (float)n;
        return taps;
    }
    const double reach = reach_of(run);
    /* Pixels lie half a step off the middle of an even block. */
    const double last = n % 2 ? floor(reach) : floor(reach + 0.5) - 0.5;
    const double half = fmax(last, n % 2 ? 0 : 0.5);
    double all[FILTER_MOST_TAPS], sum = 0;
    taps.n = (int)(2 * half) + 1;
    for (int i = 0; i < taps.n; i++) {
        all[i] = KINDS[kind].at(reach > 0 ? fmin(fabs(i - half) / reach, 1) : 0);
        sum += all[i];
    }
    const double unit = 0x1p-16;
    double left = 1;
    for (int i = 0; i < taps.n; i++) {
        const double weight = unit * floor(all[i] / sum / unit + 0.5);
        taps.weights[i] = (float)weight;
        left -= weight;
    }
    /* What rounding left goes to the middle, to both sides of it alike. */
    taps.weights[(taps.n - 1) / 2] += (float)(left / 2);
    taps.weights[taps.n / 2] += (float)(left / 2);
    return taps;
}

/* ---- the picture ---------------------------------------------------------------- */

static int32_t within(int32_t at, int32_t n)
{
    return at < 0 ? 0 : at < n ? at : n - 1;
}

/* One row of `width` pixels along x; edges are repeated. */
static void shrink_row(const struct taps *taps, int n, const float *from, int32_t width,
                       int n_channels, float *to)
{
    const int32_t before = (taps->n - n) / 2; /* pixels, of the block */
    for (int32_t x = 0; x < width / n; x++, to += n_channels) {
        for (int c = 0; c < n_channels; c++)
            to[c] = 0;
        for (int i = 0; i < taps->n; i++) {
            const float *pixel =
                from + (size_t)within(x * n + i - before, width) * (size_t)n_channels;
            for (int c = 0; c < n_channels; c++)
                to[c] += taps->weights[i] * pixel[c];
        }
    }
}

/* Row y of the small picture, of the rows in the ring. */
static void add_rows(const struct taps *taps, int n, const float *ring, int32_t y,
                     int32_t height, size_t n_row, float *to)
{
    const int32_t before = (taps->n - n) / 2;
    for (size_t x = 0; x < n_row; x++)
        to[x] = 0;
    for (int i = 0; i < taps->n; i++) {
        const int32_t row = within(y * n + i - before, height) % taps->n;
        for (size_t x = 0; x < n_row; x++)
            to[x] += taps->weights[i] * ring[(size_t)row * n_row + x];
    }
}

struct image_box filter_shrunk_box(const struct image_box *box, int n)
{
    return (struct image_box){.min_x = box->min_x / n,
                              .min_y = box->min_y / n,
                              .max_x = (box->max_x + 1) / n - 1,
                              .max_y = (box->max_y + 1) / n - 1};
}

int filter_shrink(struct run *run)
{
    struct source *source = &run->source;
    const int n = run->tool->supersample, n_channels = source->n_channels;
    if (n < 2)
        return APP_DONE;
    const size_t stride = (size_t)source->width * (size_t)n_channels;
    const int32_t width = source->width / n, height = source->height / n;
    const size_t n_row = (size_t)width * (size_t)n_channels;
    const struct taps taps = shrink_taps(run);
    float *ring = app_memory(n_row, (size_t)taps.n * sizeof(float), run->error);
    if (!ring)
        return APP_NO_MEMORY;
    int32_t n_read = 0;
    for (int32_t y = 0; y < height; y++) {
        /* In place: rows that are read lie at or beyond those that are written. */
        const int32_t last = within(y * n + (taps.n + n) / 2 - 1, source->height);
        for (; n_read <= last; n_read++)
            shrink_row(&taps, n, run->colour + (size_t)n_read * stride, source->width,
                       n_channels, ring + (size_t)(n_read % taps.n) * n_row);
        add_rows(&taps, n, ring, y, source->height, n_row,
                 run->colour + (size_t)y * n_row);
    }
    free(ring);
    source->width = width;
    source->height = height;
    source->info.data_window = filter_shrunk_box(&source->info.data_window, n);
    source->info.display_window = filter_shrunk_box(&source->info.display_window, n);
    return APP_DONE;
}
