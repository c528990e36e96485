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
#include "compose/lens_cells.h"
#include "compose/zones.h"
#include "input/bokeh.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

enum { N_LINES = 256 };

struct making {
    const struct rf_light_map *map;
    struct rf_look look;
    const struct rf_shape *shape;
    const struct rf_bokeh *bokeh; /* NULL: the light is even */
    int plane;
    struct rf_interval range, line[N_LINES]; /* of the shape, where it is not */
    double whole;                            /* its light, where nothing is cut */
};

/* What the second disc leaves of a line at the height v of the whole lens. */
static void cut_by_eye(const struct rf_look *look, const double q[2], double v,
                       struct rf_interval *line)
{
    double up = v - look->cat_eye * q[1], half = sqrt(fmax(1 - up * up, 0));
    if (look->cat_eye > 0) {
        line->from = fmax(line->from, (look->cat_eye * q[0] - half) / look->ratio);
        line->to = fmin(line->to, (look->cat_eye * q[0] + half) / look->ratio);
    }
}

/* What the doors leave of a piece of the whole lens. */
static void cut_by_doors(const struct rf_look *look, const double q[2],
                         struct rf_piece *piece)
{
    for (int i = 0; i < RF_N_DOORS; i++) {
        int axis = i >= RF_DOOR_TOP;
        double size = axis ? 1 : look->ratio, at = look->door[i] * q[axis];
        if (look->door[i] > 0 && (i == RF_DOOR_RIGHT || i == RF_DOOR_TOP))
            piece->from[axis] = fmax(piece->from[axis], (at - 1) / size);
        else if (look->door[i] > 0)
            piece->to[axis] = fmin(piece->to[axis], (at + 1) / size);
    }
}

/*
 * The light that comes through to q: exact but for slanted edges, of which a line ends
 * in the middle. Within 5e-5 of the light of the lens.
 */
static double light_at(const struct making *m, const struct rf_look *look,
                       const double q[2])
{
    const double *origin = m->shape->origin;
    const struct rf_zone zone = {.shape = m->shape};
    double half = (m->range.to - m->range.from) / N_LINES / 2, sum = 0;
    for (int i = 0; i < N_LINES; i++) {
        double v = rf_line_at(m->range, i, N_LINES) + origin[1];
        struct rf_interval line = {m->line[i].from + origin[0],
                                   m->line[i].to + origin[0]};
        cut_by_eye(look, q, v, &line);
        struct rf_piece piece = {{line.from, v - half}, {line.to, v + half}};
        cut_by_doors(look, q, &piece);
        for (int k = 0; k < 2; k++) {
            piece.from[k] -= origin[k];
            piece.to[k] -= origin[k];
        }
        if (piece.to[0] > piece.from[0] && piece.to[1] > piece.from[1])
            sum += rf_zone_light(&zone, m->bokeh, m->plane, &piece);
    }
    return sum;
}

static void measure_whole(struct making *m)
{
    const struct rf_look nothing = {.ratio = m->look.ratio};
    const double middle[2] = {0};
    m->range = rf_shape_v_range(m->shape);
    rf_shape_lines(m->shape, m->range, N_LINES, m->line);
    m->whole = light_at(m, &nothing, middle);
}

static double share_at(const struct making *m, const double q[2])
{
    if (!m->bokeh)
        return rf_look_light(&m->look, m->shape, q);
    return m->whole > 0 ? fmin(light_at(m, &m->look, q) / m->whole, 1) : 0;
}

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
            map->at[i * map->n_x + k] = (float)share_at(m, q);
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
    struct making m = {.map = map,
                       .look = rf_frame_look(frame),
                       .shape = shape,
                       .bokeh = rf_frame_bokeh(frame),
                       .plane = plane};
    if (m.bokeh)
        measure_whole(&m);
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
