/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/shrink.h"

#include <stddef.h>

#include "parallel.h"

int32_t shrink_side(int32_t side, int times)
{
    return (side + times - 1) / times;
}

static int32_t smaller(int32_t a, int32_t b)
{
    return a < b ? a : b;
}

static void average_block(const float *in, int32_t width, int n_channels, int32_t x0,
                          int32_t x1, int32_t y0, int32_t y1, float *out)
{
    const float share = 1.0f / (float)((x1 - x0) * (y1 - y0));
    for (int c = 0; c < n_channels; c++) {
        float sum = 0;
        for (int32_t y = y0; y < y1; y++)
            for (int32_t x = x0; x < x1; x++)
                sum += in[((size_t)y * (size_t)width + (size_t)x) * (size_t)n_channels +
                          (size_t)c];
        out[c] = sum * share;
    }
}

/* What the threads share that shrink a picture. */
struct shrinking {
    const float *in;
    int32_t width, height; /* of `in` */
    int n_channels, times;
    float *out;
};

static void shrink_colour_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct shrinking *s = data;
    const int times = s->times;
    const int32_t w = shrink_side(s->width, times);
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int32_t x = 0; x < w; x++)
            average_block(s->in, s->width, s->n_channels, x * times,
                          smaller((x + 1) * times, s->width), y * times,
                          smaller((y + 1) * times, s->height),
                          s->out + ((size_t)y * (size_t)w + (size_t)x) *
                                       (size_t)s->n_channels);
}

static void shrink_depth_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct shrinking *s = data;
    const int times = s->times;
    const int32_t w = shrink_side(s->width, times);
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int32_t x = 0; x < w; x++) {
            const int32_t from_x = smaller(x * times + times / 2, s->width - 1);
            const int32_t from_y = smaller(y * times + times / 2, s->height - 1);
            s->out[(size_t)y * (size_t)w + (size_t)x] =
                s->in[(size_t)from_y * (size_t)s->width + (size_t)from_x];
        }
}

void shrink_colour(const float *in, int32_t width, int32_t height, int n_channels,
                   int times, float *out)
{
    struct shrinking s = {in, width, height, n_channels, times, out};
    os_parallel(0, shrink_side(height, times), 0, shrink_colour_rows, &s);
}

void shrink_depth(const float *in, int32_t width, int32_t height, int times, float *out)
{
    struct shrinking s = {in, width, height, 1, times, out};
    os_parallel(0, shrink_side(height, times), 0, shrink_depth_rows, &s);
}

void shrink_params(struct rf_params *params, const struct rf_lens *lens, int times)
{
    const double share = 1.0 / times;
    if (lens->focal_length_px > 0)
        params->focal_length_px = lens->focal_length_px * share;
    params->max_radius *= share;
    params->aperture_coefficient *= share;
    params->blur_radius *= share;
}
