/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The sRGB curve by table. A float's sign, exponent and first 8 bits of mantissa name a
 * cell; within one cell at most one step of the 8 bit result lies, so the step's exact
 * threshold decides:
 *
 *   code(v) = base[cell(v)] + (v >= threshold[base[cell(v)] + 1])
 */
#include "pixels/display.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "parallel.h"
#include "srgb.h"

enum {
    MANTISSA_BITS = 8,
    SHIFT = 23 - MANTISSA_BITS,
    FIRST_CELL = (127 - 14) << MANTISSA_BITS, /* 2^-14, which is far below 1/255 */
    N_CELLS = (14 << MANTISSA_BITS) + 1,      /* up to 1 */
};

struct tone {
    uint8_t base[N_CELLS];
    float threshold[257]; /* smallest v of each code; above 255 infinite */
};

static uint32_t bits_of(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof(bits));
    return bits;
}

static float of_bits(uint32_t bits)
{
    float v;
    memcpy(&v, &bits, sizeof(v));
    return v;
}

/* As png_write computes it. */
static int encode_slowly(float v)
{
    return (int)lrintf(fminf(fmaxf(srgb_encode(v), 0), 1) * 255);
}

/* Positive floats are ordered as their bits are: halves the range of bits. */
static float find_threshold(int code)
{
    uint32_t below = 0, from = bits_of(1);
    while (from - below > 1) {
        const uint32_t middle = below + (from - below) / 2;
        if (encode_slowly(of_bits(middle)) >= code)
            from = middle;
        else
            below = middle;
    }
    return of_bits(from);
}

struct tone *tone_create(void)
{
    struct tone *tone = malloc(sizeof(*tone));
    if (!tone)
        return NULL;
    tone->threshold[0] = 0;
    for (int code = 1; code < 256; code++)
        tone->threshold[code] = find_threshold(code);
    tone->threshold[256] = INFINITY;
    for (uint32_t i = 0; i < N_CELLS; i++)
        tone->base[i] = (uint8_t)encode_slowly(of_bits((FIRST_CELL + i) << SHIFT));
    return tone;
}

void tone_destroy(struct tone *tone)
{
    free(tone);
}

uint8_t tone_encode(const struct tone *tone, float linear)
{
    /* Also false for NaN. */
    if (!(linear >= 0x1p-14f))
        return 0;
    if (linear >= 1)
        return 255;
    const int base = tone->base[(bits_of(linear) >> SHIFT) - FIRST_CELL];
    return (uint8_t)(base + (linear >= tone->threshold[base + 1]));
}

/* What the threads share that fill the pixels of a display. */
struct painting {
    const struct tone *tone;
    const float *in;
    int n_channels;
    double gain, scale; /* of colours, of what is shown as one */
    double top;         /* of depth: 1 / the nearest */
    double limit_px;
    uint8_t *rgba;
};

static void paint_picture(void *data, int64_t begin, int64_t end, int thread)
{
    const struct painting *p = data;
    const float gain = (float)p->gain;
    const int green = p->n_channels > 1 ? 1 : 0, blue = p->n_channels > 1 ? 2 : 0;
    for (int64_t i = begin; i < end; i++) {
        const float *in = p->in + i * p->n_channels;
        uint8_t *out = p->rgba + 4 * i;
        out[0] = tone_encode(p->tone, gain * in[0]);
        out[1] = tone_encode(p->tone, gain * in[green]);
        out[2] = tone_encode(p->tone, gain * in[blue]);
        out[3] = 255;
    }
}

void display_picture(const struct tone *tone, const float *pixels, int n_channels,
                     size_t n, double exposure, uint8_t *rgba)
{
    struct painting p = {.tone = tone,
                         .in = pixels,
                         .n_channels = n_channels,
                         .gain = exp2(exposure),
                         .rgba = rgba};
    os_parallel(0, (int64_t)n, 0, paint_picture, &p);
}

static void put_grey(uint8_t *rgba, double grey)
{
    const uint8_t code = (uint8_t)lrint(255 * fmin(fmax(grey, 0), 1));
    rgba[0] = rgba[1] = rgba[2] = code;
    rgba[3] = 255;
}

static void paint_depth(void *data, int64_t begin, int64_t end, int thread)
{
    const struct painting *p = data;
    for (int64_t i = begin; i < end; i++)
        put_grey(p->rgba + 4 * i,
                 isfinite(p->in[i]) ? (p->top - 1 / p->in[i]) * p->scale : 1);
}

void display_depth(const float *planar, size_t n, double near, double far,
                   uint8_t *rgba)
{
    const double range = 1 / near - 1 / far;
    struct painting p = {.in = planar,
                         .top = 1 / near,
                         .scale = range > 0 ? 1 / range : 0,
                         .rgba = rgba};
    os_parallel(0, (int64_t)n, 0, paint_depth, &p);
}

static void paint_coc(void *data, int64_t begin, int64_t end, int thread)
{
    static const double before[3] = {1, 0.62, 0.1}, behind[3] = {0.25, 0.6, 1};
    const struct painting *p = data;
    for (int64_t i = begin; i < end; i++) {
        const double *colour = p->in[i] < 0 ? before : behind;
        const double light = sqrt(fmin(fabs(p->in[i]) * p->scale, 1));
        for (int c = 0; c < 3; c++)
            p->rgba[4 * i + c] = (uint8_t)lrint(255 * light * colour[c]);
        p->rgba[4 * i + 3] = 255;
    }
}

void display_coc(const float *radius, size_t n, double full, uint8_t *rgba)
{
    struct painting p = {.in = radius, .scale = full > 0 ? 1 / full : 0, .rgba = rgba};
    os_parallel(0, (int64_t)n, 0, paint_coc, &p);
}

static void paint_band(void *data, int64_t begin, int64_t end, int thread)
{
    const struct painting *p = data;
    for (int64_t i = begin; i < end; i++) {
        uint8_t *out = p->rgba + 4 * i;
        if (fabsf(p->in[i]) <= p->limit_px)
            continue;
        const int luma = (54 * out[0] + 183 * out[1] + 19 * out[2]) / 256;
        out[0] = out[1] = (uint8_t)(luma * 2 / 5);
        out[2] = (uint8_t)(luma / 2);
    }
}

void display_band(const struct tone *tone, const float *pixels, int n_channels,
                  const float *radius, size_t n, double exposure, double limit,
                  uint8_t *rgba)
{
    struct painting p = {.in = radius, .limit_px = limit, .rgba = rgba};
    display_picture(tone, pixels, n_channels, n, exposure, rgba);
    os_parallel(0, (int64_t)n, 0, paint_band, &p);
}

/* ---- false colours ---------------------------------------------------------------- */

#define MIDDLE_GREY 0.18

void display_exposure_colour(double stops, uint8_t rgb[3])
{
    static const uint8_t deep[3] = {96, 0, 128}, dark[3] = {24, 72, 200},
                         middle[3] = {40, 170, 60}, bright[3] = {235, 205, 40},
                         clipped[3] = {225, 30, 30};
    const uint8_t *colour = NULL;
    if (MIDDLE_GREY * exp2(stops) >= 1)
        colour = clipped;
    else if (stops >= 2)
        colour = bright;
    else if (stops >= -0.5 && stops <= 0.5)
        colour = middle;
    else if (!(stops >= -6)) /* black and NaN, too */
        colour = deep;
    else if (stops < -3)
        colour = dark;
    const uint8_t grey = (uint8_t)lrint(60 + 30 * (fmin(fmax(stops, -3), 2) + 3));
    for (int c = 0; c < 3; c++)
        rgb[c] = colour ? colour[c] : grey;
}

static void paint_exposure(void *data, int64_t begin, int64_t end, int thread)
{
    const struct painting *p = data;
    const int green = p->n_channels > 1 ? 1 : 0, blue = p->n_channels > 1 ? 2 : 0;
    for (int64_t i = begin; i < end; i++) {
        const float *in = p->in + i * p->n_channels;
        const double r = p->gain * in[0], g = p->gain * in[green],
                     b = p->gain * in[blue];
        const bool is_clipped = fmax(r, fmax(g, b)) >= 1;
        const double y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        display_exposure_colour(is_clipped ? INFINITY : log2(fmax(y, 0) / MIDDLE_GREY),
                                p->rgba + 4 * i);
        p->rgba[4 * i + 3] = 255;
    }
}

void display_exposure(const float *pixels, int n_channels, size_t n, double exposure,
                      uint8_t *rgba)
{
    struct painting p = {
        .in = pixels, .n_channels = n_channels, .gain = exp2(exposure), .rgba = rgba};
    os_parallel(0, (int64_t)n, 0, paint_exposure, &p);
}

static void paint_encoded(void *data, int64_t begin, int64_t end, int thread)
{
    const struct painting *p = data;
    for (int64_t i = begin; i < end; i++) {
        for (int c = 0; c < 3; c++)
            p->rgba[4 * i + c] =
                (uint8_t)lrintf(255 * fminf(fmaxf(p->in[3 * i + c], 0), 1));
        p->rgba[4 * i + 3] = 255;
    }
}

void display_encoded(const float *rgb, size_t n, uint8_t *rgba)
{
    struct painting p = {.in = rgb, .rgba = rgba};
    os_parallel(0, (int64_t)n, 0, paint_encoded, &p);
}
