/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light that cat's eyes and barn doors leave, over a picture: the share of the
 * aperture's area that is open at each place (lens/look.c), or of its light where that is
 * not even (a picture of the aperture, an obstruction, hollow blades). It is smooth but
 * for the middle of the picture, where cat's eyes begin: a node each 16 px is right within
 * 2e-3 there and 1e-5 elsewhere at 1920 x 1080.
 */
#include "compose/light_map.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "compose/lens_light.h"
#include "input/bokeh.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

struct making {
    const struct rf_light_map *map;
    struct rf_lens_light light;
};

static void make_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct making *m = data;
    const struct rf_light_map *map = m->map;
    (void)thread;
    for (int i = (int)begin; i < (int)end; i++)
        for (int k = 0; k < map->n_x; k++) {
            double q[2];
            rf_look_place(&m->light.look, (map->x + k) * RF_LIGHT_STEP,
                          (map->y + i) * RF_LIGHT_STEP, q);
            map->at[i * map->n_x + k] = (float)rf_lens_light_open(&m->light, q, 0);
        }
}

rf_result rf_light_map_make(struct rf_light_map *map, const struct rf_frame *frame,
                            const struct rf_shape *shape, int plane,
                            struct rf_error *error)
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
    const struct rf_look look = rf_frame_look(frame);
    struct making m = {.map = map};
    rf_lens_light_init(&m.light, &look, shape, rf_frame_bokeh(frame), plane);
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
    int from, to; /* channels */
};

static void darken_row(const struct darkening *d, int row)
{
    enum { N = 64 };
    const struct rf_image *out = d->out;
    for (int from = 0; from < out->width; from += N) {
        float share[N] = {0};
        int n = rf_min_int(N, out->width - from);
        rf_light_map_row(d->map, d->x + from, d->y + row, n, share);
        for (int i = 0; i < n; i++)
            for (int c = d->from; c < d->to; c++)
                *(float *)rf_image_at(out, from + i, row, c) *= share[i];
    }
}

static void darken_rows(void *data, int64_t begin, int64_t end, int thread)
{
    (void)thread;
    for (int64_t row = begin; row < end; row++)
        darken_row(data, (int)row);
}

/* Darkens some channels by the light of a plane of the picture of the aperture. */
static rf_result darken(const struct rf_frame *frame, struct darkening d, int plane,
                        struct rf_error *error)
{
    struct rf_light_map map;
    rf_result result = rf_light_map_make(&map, frame, &frame->shape, plane, error);
    d.map = &map;
    if (result == RF_OK)
        rf_parallel(frame->context, d.out->height, RF_EQUAL_PARTS, darken_rows, &d);
    rf_light_map_free(&map, frame->context);
    return result;
}

rf_result rf_take_vignette(const struct rf_frame *frame, int x, int y,
                           const struct rf_image *out, struct rf_error *error)
{
    const struct rf_look look = rf_frame_look(frame);
    const struct rf_bokeh *bokeh = rf_frame_bokeh(frame);
    rf_result result = RF_OK;
    if (!rf_look_is_dark(&look) || frame->params.cat_eye_exposure == RF_EXPOSURE_KEEP)
        return RF_OK;
    struct darkening d = {NULL, x, y, out, 0, rf_min_int(out->channels, RF_N_COLOURS)};
    bool has_colours = bokeh && bokeh->n_planes > 1 && frame->colour == 0;
    if (!has_colours || d.to < RF_N_COLOURS)
        return darken(frame, d, rf_frame_bokeh_plane(frame), error);
    for (int c = 0; c < RF_N_COLOURS && result == RF_OK; c++) {
        d.from = c;
        d.to = c + 1;
        result = darken(frame, d, c, error);
    }
    return result;
}
