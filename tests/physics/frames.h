/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Small pictures for tests: a frame with colour, depth and output, a plain lens whose
 * radii are easy to choose, random numbers that are the same everywhere.
 */
#ifndef RF_TEST_FRAMES_H
#define RF_TEST_FRAMES_H

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "rackfocus/rackfocus.h"

struct frame {
    int width, height, channels;
    float *colour, *depth, *out;
};

static inline struct frame frame_make(int width, int height, int channels)
{
    size_t n = (size_t)width * (size_t)height;
    struct frame f = {width, height, channels, NULL, NULL, NULL};
    f.colour = calloc(n * (size_t)channels, sizeof(float));
    f.depth = calloc(n, sizeof(float));
    f.out = calloc(n * (size_t)channels, sizeof(float));
    if (!f.colour || !f.depth || !f.out)
        abort();
    return f;
}

static inline void frame_free(struct frame *f)
{
    free(f->colour);
    free(f->depth);
    free(f->out);
}

static inline size_t frame_pixels(const struct frame *f)
{
    return (size_t)f->width * (size_t)f->height;
}

static inline size_t frame_bytes(const struct frame *f)
{
    return frame_pixels(f) * (size_t)f->channels * sizeof(float);
}

static inline float *frame_at(const struct frame *f, float *samples, int x, int y)
{
    return samples + ((size_t)y * (size_t)f->width + (size_t)x) * (size_t)f->channels;
}

/* Pixels of a part's output that differ from those of the whole from (x0, y0) on; says
 * so where there are any. */
static inline size_t frame_count_different(const struct frame *whole,
                                           const struct frame *part, int x0, int y0)
{
    size_t n = 0, pixel = (size_t)whole->channels * sizeof(float);
    for (int y = 0; y < part->height; y++)
        for (int x = 0; x < part->width; x++)
            n += memcmp(frame_at(whole, whole->out, x0 + x, y0 + y),
                        frame_at(part, part->out, x, y), pixel) != 0;
    if (n)
        fprintf(stderr, "# %d x %d px from (%d, %d): %zu differ\n", part->width,
                part->height, x0, y0, n);
    return n;
}

/* Numbers in [0, 1), the same on every machine. */
static inline double random_unit(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (*state >> 8) / 16777216.0;
}

enum { PLAIN_FOCUS = 100 };

/*
 * A lens with r = 400 - 40000 / z px (perspective), exactly 0 at z = 100, that reaches
 * 400 px behind the focus; nothing is clipped.
 */
static inline void plain_params(struct rf_params *params, int method)
{
    rf_params_init(params);
    params->method = method;
    params->focus_distance = PLAIN_FOCUS;
    params->lens_radius = 40;
    params->focal_length_px = 1000;
    params->max_radius = 16384;
}

/* For frame_fill_scene(): what nothing hit blurs by 30 px instead of 400. */
static inline void scene_params(struct rf_params *params, int method)
{
    plain_params(params, method);
    params->max_radius = 30;
}

/*
 * How many methods, from the first, spread light as a lens does. Those after them are
 * the previews: they gather, and neither keep the light of a lone lamp nor draw the
 * aperture; tests/methods holds them to their own formulas.
 */
static inline size_t n_physical_methods(void)
{
    return RF_METHOD_SCATTER + 1;
}

/* The planar depth that the plain lens blurs by r px, r below 400. */
static inline float plain_depth(double r_px)
{
    return (float)(40000 / (400 - r_px));
}

static inline rf_result frame_filter_by(struct frame *f, const struct rf_params *params,
                                        const struct rf_context_params *run,
                                        struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    rf_result result = rf_context_create(&context, run, error);
    if (result != RF_OK)
        return result;
    result = rf_filter_create(&filter, context, params, f->width, f->height, error);
    if (result == RF_OK) {
        struct rf_view view = {
            .colour = rf_image_packed(f->colour, f->width, f->height, f->channels),
            .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
        struct rf_image out = rf_image_packed(f->out, f->width, f->height, f->channels);
        result = rf_filter_process(filter, &view, 1, &out, NULL, error);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return result;
}

static inline rf_result frame_filter(struct frame *f, const struct rf_params *params,
                                     int n_threads, struct rf_error *error)
{
    struct rf_context_params run = {.size = sizeof run, .n_threads = n_threads};
    return frame_filter_by(f, params, &run, error);
}

/* FNV-1a over bytes. */
static inline uint64_t hash_bytes(uint64_t hash, const void *data, size_t n_bytes)
{
    const unsigned char *bytes = data;
    if (hash == 0)
        hash = 14695981039346656037u;
    for (size_t i = 0; i < n_bytes; i++)
        hash = (hash ^ bytes[i]) * 1099511628211u;
    return hash;
}

/*
 * A scene with everything in it: a textured floor that recedes through the focus, a
 * thin post in front with an anti-aliased edge, a wall behind, lamps of 50 to 5000, sky
 * that nothing hit. Radii of about +-r_px. Arithmetic is plain: same bits everywhere.
 */
static inline void frame_fill_scene(struct frame *f, double r_px)
{
    uint32_t seed = 7;
    int w = f->width, h = f->height;
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            float *c = frame_at(f, f->colour, x, y);
            double r = r_px * (0.8 - 1.6 * y / h), light = random_unit(&seed);
            double share = 0;
            if (y < h / 3)
                r = r_px * 0.9;
            if (x % 17 == 5 || x % 17 == 6) {
                share = x % 17 == 5 ? 1 : 0.4;
                if (share > 0.5)
                    r = -r_px * 0.7;
            }
            bool is_lamp = y < h / 3 && (x * 7 + y * 13) % 61 == 0;
            for (int k = 0; k < f->channels; k++) {
                double back = 0.1 + 0.2 * k + 0.4 * light * ((x / 4 + y / 4) % 2);
                if (is_lamp)
                    back = 50 * (1 + x % 100);
                double v = share * 0.7 * (k == 0) + (1 - share) * back;
                c[k] = (float)(k == 3 ? 1 : v);
            }
            bool is_sky = y < h / 6 && x > w / 2 && share == 0;
            f->depth[(size_t)y * (size_t)w + (size_t)x] =
                is_sky ? 1e10f : plain_depth(r);
        }
}

#endif
