/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Zones. Cat's eyes, swirl and their like make the footprint depend on the place, and a
 * footprint of its own for every pixel would cost more than the picture. So places are
 * rounded to a grid, as radii are: every sample of a tile has the footprints of the
 * zone in which the middle of the tile lies. Places count in the whole picture, so that
 * windows of it have the same zones. Highlights, which show their footprint, have a
 * finer grid of their own (highlights_add.c).
 */
#include "compose/zones.h"

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
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/*
 * By how much a zone may be wrong, as the shift of an edge of the footprint in parts of
 * its radius: half a step. At 32 px that is a pixel, in what has no highlights.
 */
static const double SHIFT = 0.04;
static const double LEAST_STEP = 1.0 / 24, MOST_STEP = 0.5;

/* Of the light of a picture that is a point, per unit radius: nothing is so small. */
static const double LEAST_VARIANCE = 1e-4;

/* How fast an edge of the footprint moves with the place. */
static double speed_of(const struct rf_look *look)
{
    double most = look->cat_eye;
    for (int i = 0; i < RF_N_DOORS; i++)
        most = fmax(most, look->door[i]);
    return most + 2 * fabs(look->astigmatism) + 2 * fabs(look->swirl);
}

static void set_grid(struct rf_zones *zones)
{
    const struct rf_look *look = &zones->look;
    zones->n_x = zones->n_y = 0;
    if (rf_look_is_on(look)) {
        double step = 2 * SHIFT / fmax(speed_of(look), 1e-6);
        zones->step = fmin(fmax(step, LEAST_STEP), MOST_STEP);
        double height = look->centre[1] / look->pixel_aspect;
        zones->n_x = (int)ceil(look->centre[0] / look->half_px / zones->step);
        zones->n_y = (int)ceil(height / look->half_px / zones->step);
    }
    zones->n = (2 * zones->n_x + 1) * (2 * zones->n_y + 1);
}

/*
 * Of the whole lens' light, 1: what is left of the rounding of its sums where the lens
 * is dark. A place that sees nothing but an obstruction would spread that as if it were
 * its light, of either sign.
 */
static const double ROUNDED_LIGHT = 1e-14;

/*
 * The point of the whole lens that a zone's point is of. Returns by how much an area
 * around it is smaller there, as a length.
 */
static double lens_point(const struct rf_zone *zone, const double at[2], double u[2])
{
    const double *origin = zone->shape->origin;
    double whole[2] = {at[0] + zone->centroid[0] + origin[0],
                       at[1] + zone->centroid[1] + origin[1]};
    if (zone->is_moved)
        return rf_look_lens_at(&zone->look, zone->q, zone->r, whole, u);
    memcpy(u, whole, sizeof whole);
    return 1;
}

/* The part of the whole lens that a piece is of; returns its size as lens_point(). What
 * was turned is a square of the same area. */
static double lens_piece(const struct rf_zone *zone, const struct rf_piece *piece,
                         double corner[2][2])
{
    double middle[2], size = 1;
    if (!zone->is_moved) {
        lens_point(zone, piece->from, corner[0]);
        lens_point(zone, piece->to, corner[1]);
        return size;
    }
    for (int k = 0; k < 2; k++)
        middle[k] = (piece->from[k] + piece->to[k]) / 2;
    size = lens_point(zone, (double[2]){middle[0], middle[1]}, middle);
    for (int k = 0; k < 2; k++) {
        double half = (piece->to[k] - piece->from[k]) / 2 * size;
        corner[0][k] = middle[k] - half;
        corner[1][k] = middle[k] + half;
    }
    return size;
}

double rf_zone_light(const struct rf_zone *zone, const struct rf_bokeh *bokeh,
                     int plane, const struct rf_piece *piece)
{
    double at[2][2], corner[2][2], longer;
    if (!bokeh)
        return (piece->to[0] - piece->from[0]) * (piece->to[1] - piece->from[1]);
    longer = rf_max_int(bokeh->width, bokeh->height) / 2.0;
    double size = lens_piece(zone, piece, corner);
    for (int i = 0; i < 2; i++) {
        at[i][0] = bokeh->width / 2.0 + corner[i][0] * zone->shape->ratio * longer;
        at[i][1] = bokeh->height / 2.0 - corner[i][1] * longer;
    }
    double light = rf_bokeh_sum(bokeh, plane, at[1][0], at[0][1]) -
                   rf_bokeh_sum(bokeh, plane, at[0][0], at[0][1]) -
                   rf_bokeh_sum(bokeh, plane, at[1][0], at[1][1]) +
                   rf_bokeh_sum(bokeh, plane, at[0][0], at[1][1]);
    return light > ROUNDED_LIGHT ? light / (size * size) : 0;
}

double rf_zone_height2(const struct rf_zone *zone, const double u[2])
{
    double at[2];
    lens_point(zone, u, at);
    at[0] *= zone->shape->ratio;
    return at[0] * at[0] + at[1] * at[1];
}

double rf_zone_weigh(struct rf_zone *zone, const struct rf_bokeh *bokeh, int plane)
{
    enum { N = 256 };
    struct rf_interval range = rf_shape_v_range(zone->shape), cut[N];
    double sum = 0, at[2] = {0}, square[2] = {0}, share[RF_MAX_CELLS] = {0};
    double step = (range.to - range.from) / N;
    rf_shape_lines(zone->shape, range, N, cut);
    for (int i = 0; i < N * zone->cells.n; i++) {
        int line = i / zone->cells.n, cell = i % zone->cells.n;
        double v = rf_line_at(range, line, N);
        struct rf_interval part = rf_lens_cell_line(&zone->cells, cell, v, cut[line]);
        int n = (int)ceil(fmax(part.to - part.from, 0) / step);
        for (int k = 0; k < n; k++) {
            double wide = (part.to - part.from) / n, from = part.from + wide * k;
            const struct rf_piece piece = {{from, v - step / 2},
                                           {from + wide, v + step / 2}};
            double w = rf_zone_light(zone, bokeh, plane, &piece);
            double u[2] = {from + wide / 2, v};
            sum += w;
            share[cell] += w;
            for (int c = 0; c < 2; c++) {
                at[c] += w * u[c];
                square[c] += w * u[c] * u[c];
            }
        }
    }
    for (int c = 0; c < 2 && sum > 0; c++)
        zone->variance[c] =
            fmax(square[c] / sum - at[c] * at[c] / sum / sum, LEAST_VARIANCE);
    for (int c = 0; c < zone->cells.n && sum > 0; c++)
        zone->cells.share[c] = share[c] / sum;
    return sum;
}

static void set_plain(struct rf_zone *zone, const struct rf_footprint_use *use)
{
    *zone = (struct rf_zone){.shape = use->shape};
    rf_lens_cells_init(&zone->cells, use->shape, use->n_cells);
    rf_shape_line_variance(use->shape, zone->variance);
    if (use->bokeh)
        rf_zone_weigh(zone, use->bokeh, use->bokeh_plane);
}

static void set_zone(const struct rf_zones *zones, const struct rf_shape *whole,
                     const struct rf_bokeh *bokeh, int i)
{
    const struct rf_zone *plain = &zones->at[rf_zone_middle(zones)];
    struct rf_zone *zone = &zones->at[i];
    int n_row = 2 * zones->n_x + 1;
    int column = i % n_row - zones->n_x, row = i / n_row - zones->n_y;
    const double q[2] = {column * zones->step, row * zones->step};
    rf_zone_make(zone, &zones->shapes[i], whole, &zones->look, q, 0);
    if (bokeh) { /* by light they have other shares anyway */
        zone->cells = plain->cells;
        return;
    }
    double variance[2][2] = {{plain->variance[0], plain->variance[1]},
                             {zone->variance[0], zone->variance[1]}};
    rf_lens_cells_follow(&zone->cells, zone->shape, &plain->cells, variance);
}

struct setting {
    const struct rf_zones *zones;
    const struct rf_footprint_use *use;
};

static void set_zones(void *data, int64_t begin, int64_t end, int thread)
{
    const struct setting *s = data;
    (void)thread;
    for (int i = (int)begin; i < (int)end; i++)
        if (i != rf_zone_middle(s->zones))
            set_zone(s->zones, s->use->shape, s->use->bokeh, i);
}

rf_result rf_zones_init(struct rf_zones *zones, const struct rf_context *context,
                        const struct rf_footprint_use *use, struct rf_error *error)
{
    *zones = (struct rf_zones){.look = use->look};
    set_grid(zones);
    zones->at = rf_alloc(context, (size_t)zones->n, sizeof *zones->at);
    if (zones->n > 1)
        zones->shapes = rf_alloc(context, (size_t)zones->n, sizeof *zones->shapes);
    if (!zones->at || (zones->n > 1 && !zones->shapes))
        return rf_fail_memory(error, (size_t)zones->n, sizeof *zones->shapes);
    set_plain(&zones->at[rf_zone_middle(zones)], use);
    struct setting s = {zones, use};
    rf_parallel(context, zones->n, 1, set_zones, &s);
    return RF_OK;
}

void rf_zones_free(struct rf_zones *zones, const struct rf_context *context)
{
    rf_free(context, zones->at);
    rf_free(context, zones->shapes);
    zones->at = NULL;
    zones->shapes = NULL;
}

static int nearest(double at, double step, int n)
{
    return rf_min_int(rf_max_int((int)floor(at / step + 0.5), -n), n) + n;
}

int rf_zone_at(const struct rf_zones *zones, const double q[2])
{
    if (zones->n == 1)
        return 0;
    return nearest(q[1], zones->step, zones->n_y) * (2 * zones->n_x + 1) +
           nearest(q[0], zones->step, zones->n_x);
}

double rf_zone_make(struct rf_zone *zone, struct rf_shape *shape,
                    const struct rf_shape *whole, const struct rf_look *look,
                    const double q[2], double r)
{
    double share = rf_look_shape(look, whole, q, r, shape, zone->centroid);
    zone->shape = shape;
    rf_shape_variance(shape, zone->variance);
    zone->cells = (struct rf_lens_cells){.n = 1, .share = {1}};
    zone->is_moved = !rf_look_is_scaled(look);
    zone->look = *look;
    zone->q[0] = q[0];
    zone->q[1] = q[1];
    zone->r = r;
    return share;
}
