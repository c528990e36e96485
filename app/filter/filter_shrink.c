/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --supersample N: what was filtered at N times the size is brought to the size that was
 * asked for, each pixel the mean of N x N. The lens and the pixel filter are both sums
 * of light, so that their order does not matter; a pixel of the larger picture is nearly
 * always of one surface, whose depth is its own.
 */
#include "filter/filter_shrink.h"

#include <stdlib.h>
#include <string.h>

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

/* The mean of n x n pixels from `from` on; rows are `stride` values apart. */
static void average(const float *from, size_t stride, int n, int n_channels, float *to)
{
    for (int c = 0; c < n_channels; c++) {
        float sum = 0;
        for (int y = 0; y < n; y++)
            for (int x = 0; x < n; x++)
                sum += from[(size_t)y * stride + (size_t)(x * n_channels + c)];
        to[c] = sum / (float)(n * n);
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
    float *row =
        app_memory((size_t)width, (size_t)n_channels * sizeof(float), run->error);
    if (!row)
        return APP_NO_MEMORY;
    const size_t n_row = (size_t)width * (size_t)n_channels;
    for (int32_t y = 0; y < height; y++) {
        /* In place: rows that are read lie at or beyond those that are written. */
        const float *from = run->colour + (size_t)(y * n) * stride;
        for (int32_t x = 0; x < width; x++)
            average(from + (size_t)(x * n * n_channels), stride, n, n_channels,
                    row + (size_t)(x * n_channels));
        memcpy(run->colour + (size_t)y * n_row, row, n_row * sizeof(float));
    }
    free(row);
    source->width = width;
    source->height = height;
    source->info.data_window = filter_shrunk_box(&source->info.data_window, n);
    source->info.display_window = filter_shrunk_box(&source->info.display_window, n);
    return APP_DONE;
}
