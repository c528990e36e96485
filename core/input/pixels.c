/* SPDX-License-Identifier: Apache-2.0 */
/* Views of the caller's pixels, and their way into and out of the blend space. */
#include "input/pixels.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/system_threads.h"
#include "input/frame.h"
#include "input/highlights.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

struct rf_image rf_image_input(const float *data, int32_t width, int32_t height,
                               int32_t channels)
{
    return rf_image_packed((float *)data, width, height, channels);
}

struct rf_image rf_image_packed(float *data, int32_t width, int32_t height,
                                int32_t channels)
{
    ptrdiff_t pixel = channels * (ptrdiff_t)sizeof(float);
    return (struct rf_image){.data = data,
                             .width = width,
                             .height = height,
                             .channels = channels,
                             .channel_bytes = sizeof(float),
                             .pixel_bytes = pixel,
                             .row_bytes = pixel * width};
}

void rf_image_copy(const struct rf_image *from, const struct rf_image *to)
{
    if (from->data == to->data && from->channel_bytes == to->channel_bytes &&
        from->pixel_bytes == to->pixel_bytes && from->row_bytes == to->row_bytes)
        return;
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++)
            for (int c = 0; c < to->channels; c++)
                memcpy((void *)rf_image_at(to, x, y, c), rf_image_at(from, x, y, c),
                       sizeof(float));
}

/* Odd in v, so that negative values survive the way there and back. */
static float signed_power(float v, double exponent)
{
    return copysignf((float)pow(fabs((double)v), exponent), v);
}

float rf_to_blend_space(const struct rf_params *params, float v)
{
    return params->blend_gamma == 1 ? v : signed_power(v, 1 / params->blend_gamma);
}

/* A blend gamma makes infinities of finite values; sums of them come before. */
static const float MOST_LIGHT = 1e36f;

bool rf_is_light(const struct rf_params *params, float v)
{
    return params->blend_gamma == 1 ? isfinite(v) : fabsf(v) <= MOST_LIGHT;
}

/* Alpha is coverage, not light: the blend gamma leaves it alone. */
static bool has_gamma(const struct rf_params *params, int plane)
{
    return params->blend_gamma != 1 && plane < 3;
}

/* The pixel (x, y) of a view with its highlights as they are wanted. */
static void read_pixel(const struct rf_params *params, const struct rf_image *colour,
                       int x, int y, float c[4])
{
    for (int i = 0; i < colour->channels; i++)
        c[i] = *rf_image_at(colour, x, y, i);
    if (rf_highlights_are_changed(params))
        rf_highlights_change(params, c, colour->channels);
}

/* Row y of a view to planes (NULL: only checks); how many values cannot be summed. */
static int64_t load_row(const struct rf_params *params, const struct rf_image *colour,
                        int y, float *const planes[4], int *bad_x)
{
    int64_t n_bad = 0;
    double power = 1 / params->blend_gamma;
    for (int x = 0; x < colour->width; x++) {
        float v[4];
        read_pixel(params, colour, x, y, v);
        for (int c = 0; c < colour->channels; c++) {
            if (has_gamma(params, c))
                v[c] = signed_power(v[c], power);
            if (!rf_is_light(params, v[c])) {
                if (n_bad++ == 0)
                    *bad_x = x;
                v[c] = 0;
            }
            if (planes)
                planes[c][(size_t)y * (size_t)colour->width + (size_t)x] = v[c];
        }
    }
    return n_bad;
}

bool rf_image_is_light(const struct rf_params *params, const struct rf_image *image)
{
    return rf_image_is_plain(params, image) && !rf_highlights_are_changed(params);
}

bool rf_image_is_plain(const struct rf_params *params, const struct rf_image *image)
{
    return image->channels == 4 && image->channel_bytes == sizeof(float) &&
           image->pixel_bytes == 4 * sizeof(float) && params->blend_gamma == 1;
}

/* A row of floats copied as it is; false where a value is not finite. */
static bool copy_row(const float *from, float *to, int n)
{
    uint32_t largest = 0; /* bits without sign: those of infinity and above are bad */
    for (int i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, from + i, sizeof bits);
        memcpy(to + i, &bits, sizeof bits);
        bits &= 0x7fffffffu;
        largest = bits > largest ? bits : largest;
    }
    return largest < 0x7f800000u;
}

/* What the threads share that copy a picture. */
struct copying {
    const struct rf_image *colour, *out;
    bool is_bad; /* atomic: some value is */
};

static void copy_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct copying *c = data;
    int n = c->colour->width * c->colour->channels;
    for (int y = (int)begin; y < (int)end; y++)
        if (!copy_row(rf_image_at(c->colour, 0, y, 0),
                      (float *)rf_image_at(c->out, 0, y, 0), n))
            __atomic_store_n(&c->is_bad, true, __ATOMIC_RELAXED);
}

bool rf_frame_copy(const struct rf_context *context, const struct rf_image *colour,
                   const struct rf_image *out)
{
    ptrdiff_t pixel = colour->channels * (ptrdiff_t)sizeof(float);
    const struct rf_image *both[] = {colour, out};
    for (int i = 0; i < 2; i++)
        if (both[i]->channel_bytes != sizeof(float) || both[i]->pixel_bytes != pixel)
            return false;
    if (out->data == colour->data)
        return false;
    struct copying c = {colour, out, false};
    rf_parallel(context, colour->height, RF_EQUAL_PARTS, copy_rows, &c);
    return !c.is_bad;
}

void rf_frame_copy_light(const struct rf_params *params, const struct rf_image *from,
                         const struct rf_image *out)
{
    if (!rf_highlights_are_changed(params)) {
        rf_image_copy(from, out);
        return;
    }
    for (int y = 0; y < out->height; y++)
        for (int x = 0; x < out->width; x++) {
            float c[4];
            read_pixel(params, from, x, y, c);
            for (int i = 0; i < out->channels; i++)
                *(float *)rf_image_at(out, x, y, i) = c[i];
        }
}

/* Values that cannot be summed: how many, and the first pixel that has one. */
struct bad_values {
    bool lock;
    int64_t n;
    int x, y;
};

static void count_bad(struct bad_values *bad, int64_t n, int x, int y)
{
    if (n == 0)
        return;
    rf_spin_lock(&bad->lock);
    if (bad->n == 0 || y < bad->y) {
        bad->y = y;
        bad->x = x;
    }
    bad->n += n;
    rf_spin_unlock(&bad->lock);
}

static rf_result fail_bad(const struct bad_values *bad, const struct rf_frame *frame,
                          struct rf_error *error)
{
    return rf_fail(error, RF_ERROR_PIXEL, "colour",
                   "%lld colour value%s NaN or infinite%s, the first at pixel "
                   "(%d, %d): repair the render, the blur would spread them",
                   (long long)bad->n, bad->n == 1 ? " is" : "s are",
                   frame->params.blend_gamma == 1 ? "" : " in the blend gamma",
                   bad->x + frame->place.x, bad->y + frame->place.y);
}

/* What the threads share that load or store a picture. */
struct loading {
    const struct rf_kernels *kernels;
    const struct rf_params *params;
    const struct rf_image *image;
    float *const *planes; /* NULL: what would be loaded is only checked */
    size_t stride;        /* of the planes, floats */
    struct bad_values bad;
};

static void load_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct loading *l = data;
    const struct rf_image *colour = l->image;
    for (int y = (int)begin; y < (int)end; y++) {
        int bad_x = 0;
        float *rows[4];
        for (int c = 0; c < colour->channels && l->planes; c++)
            rows[c] = l->planes[c] + (size_t)y * l->stride;
        if (l->planes && rf_image_is_light(l->params, colour) &&
            l->kernels->unpack(rf_image_at(colour, 0, y, 0), colour->width, rows))
            continue;
        int64_t n = load_row(l->params, colour, y, l->planes, &bad_x);
        count_bad(&l->bad, n, bad_x, y);
    }
}

rf_result rf_frame_load(const struct rf_frame *frame, const struct rf_image *colour,
                        float *const planes[4], struct rf_error *error)
{
    struct loading l = {.kernels = frame->context->kernels,
                        .params = &frame->params,
                        .image = colour,
                        .planes = planes,
                        .stride = (size_t)colour->width};
    rf_parallel(frame->context, colour->height, RF_EQUAL_PARTS, load_rows, &l);
    return l.bad.n ? fail_bad(&l.bad, frame, error) : RF_OK;
}

rf_result rf_frame_check(const struct rf_frame *frame, const struct rf_image *colour,
                         struct rf_error *error)
{
    return rf_frame_load(frame, colour, NULL, error);
}

static void store_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct loading *l = data;
    const struct rf_image *out = l->image;
    for (int y = (int)begin; y < (int)end; y++) {
        const float *rows[4];
        for (int c = 0; c < out->channels; c++)
            rows[c] = l->planes[c] + (size_t)y * l->stride;
        if (rf_image_is_plain(l->params, out)) {
            l->kernels->pack(rows, out->width, (float *)rf_image_at(out, 0, y, 0));
            continue;
        }
        for (int c = 0; c < out->channels; c++) {
            for (int x = 0; x < out->width; x++) {
                float v = rows[c][x];
                if (has_gamma(l->params, c))
                    v = signed_power(v, l->params->blend_gamma);
                *(float *)rf_image_at(out, x, y, c) = v;
            }
        }
    }
}

void rf_frame_store(const struct rf_context *context, const struct rf_params *params,
                    float *const planes[4], size_t stride, const struct rf_image *out)
{
    struct loading l = {.kernels = context->kernels,
                        .params = params,
                        .image = out,
                        .planes = planes,
                        .stride = stride};
    rf_parallel(context, out->height, RF_EQUAL_PARTS, store_rows, &l);
}
