/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Depth conventions: from the number in the depth channel to planar distance and to the
 * signed radius. v = scale * value + offset comes first; then, with n and f the near
 * and far plane,
 *
 *   planar                     z = v
 *   radial                     z = v / sqrt(1 + x^2 + y^2), (x, y, 1) the pixel's ray
 *   buffer                     z = n f / (f - v (f - n))
 *   buffer-reversed            the same with v -> 1 - v
 *   buffer-infinite            z = n / (1 - v)
 *   buffer-reversed-infinite   z = n / v
 *   inverse, disparity         z = 1 / v
 *   normalised                 z = n + v (f - n)
 *
 * Nothing hit: infinity, from depth_infinity on, the far plane of a buffer or of a
 * range, and a planar or radial depth of exactly 0, which some renderers write for it;
 * of these also a value from depth_infinity on whose scale is negative.
 * NaN and negative depths, and buffer values outside [0, 1], are errors.
 */
#include "input/depth.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

struct depth_map {
    const struct rf_params *params;
    const struct rf_lens *lens;
    int x, y; /* of the first pixel, in the whole picture */
};

static double ray_length(const struct depth_map *map, int x, int y)
{
    const struct rf_lens *lens = map->lens;
    if (lens->projection == RF_PROJECTION_ORTHOGRAPHIC)
        return 1;
    double f = lens->focal_length_px;
    double dx = (map->x + x + 0.5 - lens->principal_px[0]) / f;
    double dy =
        (map->y + y + 0.5 - lens->principal_px[1]) / (f * map->params->pixel_aspect);
    return sqrt(1 + dx * dx + dy * dy);
}

/* Planar distance, INFINITY for no hit, NAN for a value that cannot be a depth. */
static double planar_distance(const struct depth_map *map, double value, int x, int y)
{
    const struct rf_params *p = map->params;
    double n = p->depth_near, f = p->depth_far;
    double v = value * p->depth_scale + p->depth_offset, z;
    const bool is_distance = p->depth == RF_DEPTH_PLANAR || p->depth == RF_DEPTH_RADIAL;
    if (v < 0 && is_distance && value >= p->depth_infinity)
        return INFINITY;
    if (isnan(v) || v < 0)
        return NAN;
    switch (p->depth) {
    case RF_DEPTH_BUFFER_REVERSED:
        v = 1 - v;
        /* fall through */
    case RF_DEPTH_BUFFER:
        if (!(v >= 0 && v <= 1))
            return NAN;
        z = v == 1 ? INFINITY : n * f / (f - v * (f - n));
        break;
    case RF_DEPTH_BUFFER_REVERSED_INFINITE:
        v = 1 - v;
        /* fall through */
    case RF_DEPTH_BUFFER_INFINITE:
        if (!(v >= 0 && v <= 1))
            return NAN;
        z = n / (1 - v);
        break;
    case RF_DEPTH_INVERSE:
    case RF_DEPTH_DISPARITY:
        z = 1 / v;
        break;
    case RF_DEPTH_NORMALISED:
        z = v >= 1 ? INFINITY : n + v * (f - n);
        break;
    case RF_DEPTH_RADIAL:
        z = v == 0 || v >= p->depth_infinity ? INFINITY : v / ray_length(map, x, y);
        break;
    default:
        z = v == 0 ? INFINITY : v;
    }
    return z >= p->depth_infinity ? INFINITY : z;
}

/* Signed radius in px; z as planar_distance() gives it. */
static double radius_of(const struct depth_map *map, double value, double z)
{
    const struct rf_lens *lens = map->lens;
    if (map->params->optics != RF_OPTICS_BUFFER || !isfinite(z))
        return rf_lens_radius_px(lens, z);
    double v = value * map->params->depth_scale + map->params->depth_offset;
    double r = lens->buffer_bias_px + lens->buffer_scale_px * v;
    return fmin(fmax(r, -lens->max_radius_px), lens->max_radius_px);
}

double rf_depth_of_value(const struct rf_params *params, const struct rf_lens *lens,
                         float value, int x, int y, float *radius)
{
    struct depth_map map = {params, lens, 0, 0};
    double z = planar_distance(&map, value, x, y);
    *radius = (float)radius_of(&map, value, isnan(z) ? INFINITY : z);
    return z;
}

/* Is the depth packed planar distance in a perspective, blurred by the lens? */
static bool is_plain(const struct depth_map *map, const struct rf_image *depth)
{
    return map->params->depth == RF_DEPTH_PLANAR &&
           map->params->optics != RF_OPTICS_BUFFER &&
           map->lens->projection == RF_PROJECTION_PERSPECTIVE &&
           depth->pixel_bytes == sizeof(float);
}

struct row_tally {
    int64_t n_bad, n_known;
    int bad_x;
    float bad_value;
    float largest; /* magnitude of a radius */
};

/* A row of plain depth, without branches; false where a value is bad. */
static bool convert_plain_row(const struct depth_map *map,
                              const struct rf_kernels *kernels,
                              const struct rf_image *depth, int y, float *radius,
                              struct row_tally *tally)
{
    const struct rf_plain_depth plain = {.factor = map->params->depth_scale,
                                         .offset = map->params->depth_offset,
                                         .infinity = map->params->depth_infinity,
                                         .bias = map->lens->bias_px,
                                         .scale = map->lens->scale,
                                         .most = map->lens->max_radius_px};
    return kernels->radii(&plain, rf_image_at(depth, 0, y, 0), depth->width, radius,
                          &tally->n_known, &tally->largest);
}

/* Is what is infinitely far told from a channel that nothing was written to? */
static bool says_something(const struct depth_map *map, double value)
{
    return value * map->params->depth_scale + map->params->depth_offset != 0;
}

static void convert_row(const struct depth_map *map, const struct rf_image *depth,
                        int y, float *radius, float *planar, struct row_tally *tally)
{
    for (int x = 0; x < depth->width; x++) {
        float value = *rf_image_at(depth, x, y, 0);
        double z = planar_distance(map, value, x, y);
        if (isnan(z)) {
            if (tally->n_bad++ == 0) {
                tally->bad_x = x;
                tally->bad_value = value;
            }
            z = INFINITY;
        } else {
            tally->n_known += isfinite(z) || says_something(map, value);
        }
        if (radius) {
            radius[x] = (float)radius_of(map, value, z);
            tally->largest = rf_max_float(fabsf(radius[x]), tally->largest);
        }
        if (planar)
            planar[x] = (float)z;
    }
}

rf_result rf_fail_empty_depth(struct rf_error *error)
{
    return rf_fail(error, RF_ERROR_DEPTH, "depth",
                   "every depth is 0, as in an empty channel; check the depth channel "
                   "and its kind (nothing but sky is infinity or 1e10 everywhere)");
}

void rf_bad_depth_words(const struct rf_params *params, double value,
                        char words[RF_BAD_DEPTH_WORDS])
{
    const double scale = params->depth_scale, offset = params->depth_offset;
    const bool is_buffer = params->depth >= RF_DEPTH_BUFFER &&
                           params->depth <= RF_DEPTH_BUFFER_REVERSED_INFINITE;
    int n = 0;
    if (!isnan(value) && (scale != 1 || offset != 0))
        n = snprintf(words, RF_BAD_DEPTH_WORDS,
                     ", %g by depth-scale %g and depth-offset %g",
                     value * scale + offset, scale, offset);
    snprintf(words + n, (size_t)(RF_BAD_DEPTH_WORDS - n), ": NaN or %s",
             is_buffer ? "outside of 0 to 1" : "negative");
}

static rf_result report(const struct depth_map *map, const struct rf_image *depth,
                        const struct row_tally *rows, int64_t *n_known,
                        struct rf_error *error)
{
    int64_t n_bad = 0, known = 0;
    int first = -1;
    for (int y = 0; y < depth->height; y++) {
        if (rows[y].n_bad && first < 0)
            first = y;
        n_bad += rows[y].n_bad;
        known += rows[y].n_known;
    }
    if (n_bad) {
        char words[RF_BAD_DEPTH_WORDS];
        rf_bad_depth_words(map->params, (double)rows[first].bad_value, words);
        return rf_fail(error, RF_ERROR_DEPTH, "depth",
                       "%lld bad depth value%s, the first is %g at pixel (%d, %d)%s; "
                       "check which kind of depth it is",
                       (long long)n_bad, n_bad == 1 ? "" : "s",
                       (double)rows[first].bad_value, map->x + rows[first].bad_x,
                       map->y + first, words);
    }
    if (n_known)
        *n_known = known;
    else if (!known)
        return rf_fail_empty_depth(error);
    return RF_OK;
}

/* What the threads share that convert a depth channel. */
struct converting {
    const struct depth_map *map;
    const struct rf_kernels *kernels;
    const struct rf_image *depth;
    float *radius, *planar; /* NULL: not wanted */
    struct row_tally *rows;
};

static void convert_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct converting *c = data;
    for (int y = (int)begin; y < (int)end; y++) {
        size_t at = (size_t)y * (size_t)c->depth->width;
        if (c->radius && !c->planar && is_plain(c->map, c->depth) &&
            convert_plain_row(c->map, c->kernels, c->depth, y, c->radius + at,
                              &c->rows[y]))
            continue;
        c->rows[y] = (struct row_tally){0};
        convert_row(c->map, c->depth, y, c->radius ? c->radius + at : NULL,
                    c->planar ? c->planar + at : NULL, &c->rows[y]);
    }
}

rf_result rf_depth_to_radius(const struct rf_frame *frame, const struct rf_image *depth,
                             float *radius, float *planar, int64_t *n_known,
                             float *largest, struct rf_error *error)
{
    const struct rf_context *context = frame->context;
    const struct rf_lens lens = rf_field_lens(frame);
    struct depth_map map = {&frame->params, &lens, frame->place.x, frame->place.y};
    int height = depth->height;
    struct row_tally *rows = rf_calloc(context, (size_t)height, sizeof *rows);
    if (!rows)
        return rf_fail_memory(error, (size_t)height, sizeof *rows);
    struct converting c = {&map, context->kernels, depth, radius, planar, rows};
    rf_parallel(context, height, RF_EQUAL_PARTS, convert_rows, &c);
    float most = 0;
    for (int y = 0; y < height; y++)
        most = rf_max_float(rows[y].largest, most);
    if (largest)
        *largest = most;
    rf_result result = report(&map, depth, rows, n_known, error);
    rf_free(context, rows);
    return result;
}
