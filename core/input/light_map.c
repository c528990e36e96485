/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light that cat's eyes and barn doors leave, over a picture: the share of the
 * aperture's area that is open at each place (lens/look.c). It is smooth but for the
 * middle of the picture, where cat's eyes begin: a node each 16 px is right within 2e-3
 * there and 1e-5 elsewhere at 1920 x 1080.
 */
#include "input/light_map.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

struct making {
    const struct rf_light_map *map;
    struct rf_look look;
    const struct rf_shape *shape;
};

static void make_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct making *m = data;
    const struct rf_light_map *map = m->map;
    (void)thread;
    for (int i = (int)begin; i < (int)end; i++)
        for (int k = 0; k < map->n_x; k++) {
            double q[2];
            rf_look_place(&m->look, (map->x + k) * RF_LIGHT_STEP,
                          (map->y + i) * RF_LIGHT_STEP, q);
            map->at[i * map->n_x + k] = (float)rf_look_light(&m->look, m->shape, q);
        }
}

rf_result rf_light_map_make(struct rf_light_map *map, const struct rf_frame *frame,
                            const struct rf_shape *shape, struct rf_error *error)
{
    int x = frame->place.x, y = frame->place.y;
    *map = (struct rf_light_map){
        .x = x / RF_LIGHT_STEP, .y = y / RF_LIGHT_STEP, .first_x = x, .first_y = y};
    map->n_x = (x + frame->width) / RF_LIGHT_STEP - map->x + 2;
    map->n_y = (y + frame->height) / RF_LIGHT_STEP - map->y + 2;
    size_t n = (size_t)map->n_x * (size_t)map->n_y;
    map->at = rf_alloc(frame->context, n, sizeof *map->at);
    if (!map->at)
        return rf_fail_memory(error, n, sizeof *map->at);
    struct making m = {map, rf_frame_look(frame), shape};
    rf_parallel(frame->context, map->n_y, RF_EQUAL_PARTS, make_rows, &m);
    return RF_OK;
}

void rf_light_map_free(struct rf_light_map *map, const struct rf_context *context)
{
    rf_free(context, map->at);
    map->at = NULL;
}

void rf_light_map_row(const struct rf_light_map *map, int x, int y, int n, float *out)
{
    static const float SCALE = 1.0f / RF_LIGHT_STEP;
    int at_y = map->first_y + y - map->y * RF_LIGHT_STEP;
    const float *low = map->at + at_y / RF_LIGHT_STEP * map->n_x,
                *high = low + map->n_x;
    float t = ((float)(at_y % RF_LIGHT_STEP) + 0.5f) * SCALE;
    int at_x = map->first_x + x - map->x * RF_LIGHT_STEP;
    for (int i = 0, first, step; i < n; i += step) {
        int node = (at_x + i) / RF_LIGHT_STEP;
        first = (at_x + i) % RF_LIGHT_STEP;
        step = rf_min_int(RF_LIGHT_STEP - first, n - i);
        float left = low[node] + (high[node] - low[node]) * t;
        float right = low[node + 1] + (high[node + 1] - low[node + 1]) * t;
        for (int k = 0; k < step; k++)
            out[i + k] = left + (right - left) * (((float)(first + k) + 0.5f) * SCALE);
    }
}

struct darkening {
    const struct rf_light_map *map;
    int x, y; /* where `out` begins, in the frame */
    const struct rf_image *out;
};

static void darken_row(const struct darkening *d, int row)
{
    enum { N = 64 };
    const struct rf_image *out = d->out;
    int n_colours = rf_min_int(out->channels, 3);
    for (int from = 0; from < out->width; from += N) {
        float share[N];
        int n = rf_min_int(N, out->width - from);
        rf_light_map_row(d->map, d->x + from, d->y + row, n, share);
        for (int i = 0; i < n; i++)
            for (int c = 0; c < n_colours; c++)
                *(float *)rf_image_at(out, from + i, row, c) *= share[i];
    }
}

static void darken_rows(void *data, int64_t begin, int64_t end, int thread)
{
    (void)thread;
    for (int64_t row = begin; row < end; row++)
        darken_row(data, (int)row);
}

rf_result rf_take_vignette(const struct rf_frame *frame, int x, int y,
                           const struct rf_image *out, struct rf_error *error)
{
    const struct rf_look look = rf_frame_look(frame);
    struct rf_light_map map;
    if (!rf_look_is_dark(&look) || frame->params.cat_eye_exposure == RF_EXPOSURE_KEEP)
        return RF_OK;
    rf_result result = rf_light_map_make(&map, frame, &frame->shape, error);
    struct darkening d = {&map, x, y, out};
    if (result == RF_OK)
        rf_parallel(frame->context, out->height, RF_EQUAL_PARTS, darken_rows, &d);
    rf_light_map_free(&map, frame->context);
    return result;
}
