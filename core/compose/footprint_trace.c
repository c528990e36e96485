/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Traced footprints. Where a look moves lens points by more than the footprint is wide,
 * one lens point lights several pixels, or none, and what the aperture becomes is no
 * polygon. So every pixel asks through which lens point it sees the sample
 * (rf_look_lens_point()), n x n times, and is lit where that is open.
 *
 *   W(i, j) = mean over the pixel of  light(u(P))    0 where u is beside the aperture
 *
 * Only pixels of the picture are asked. What falls beside it is counted on a lattice of
 * LATTICE x LATTICE points, so that it is missing as of every other footprint.
 *
 * Approximations: a pixel of a wide footprint asks once (0.4 % of the area of a disc of
 * 128 px); spherical aberration is left out. Cost: 10 to 20 ns per point.
 */
#include "compose/footprint_trace.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
#include "compose/zones.h"
#include "lens/look.h"

enum { LATTICE = 256, MOST_FINE = 8 };

/* Samples of a list lie where their place was rounded to: as far off, in half
 * diagonals. */
static const double ROUNDED = 1.0 / 128;

/* What is asked: px right of and below the corner of the sample's pixel. */
struct area {
    double from[2], to[2];
};

static double aspect_of(const struct rf_trace *t, int axis)
{
    return axis ? t->shape->pixel_aspect : 1;
}

/* All that the lens can light. */
static struct area all_of(const struct rf_trace *t)
{
    struct area all;
    double bound = rf_look_bound_px(t->look, t->shape, t->q, t->r);
    for (int k = 0; k < 2; k++) {
        all.from[k] = t->at[k] - bound * aspect_of(t, k);
        all.to[k] = t->at[k] + bound * aspect_of(t, k);
    }
    return all;
}

/* What of it lies in the picture, in whole pixels; `from` and `to` may be the same. */
static struct area seen_of(const struct rf_trace *t)
{
    const struct rf_look *look = t->look;
    struct area a = all_of(t);
    for (int k = 0; k < 2; k++) {
        double px = look->half_px * aspect_of(t, k), rest = ROUNDED * px + 1;
        double middle = t->at[k] - (k ? -t->q[1] : t->q[0]) * px;
        double first = floor(fmax(a.from[k], middle - look->centre[k] - rest));
        double last = ceil(fmin(a.to[k], middle + look->centre[k] + rest));
        a.from[k] = first;
        a.to[k] = fmax(first, last);
    }
    return a;
}

void rf_trace_reach(const struct rf_trace *t, double reach[2])
{
    struct area a = seen_of(t);
    for (int k = 0; k < 2; k++)
        reach[k] = a.to[k] > a.from[k] ? fmax(fabs(a.from[k]), fabs(a.to[k])) : 0;
}

/* The light of the lens' part of `wide` around u, in parts of its mean. */
static double light_at(const struct rf_trace *t, const double u[2], double wide)
{
    if (!t->bokeh)
        return 1;
    const struct rf_zone zone = {.shape = t->shape};
    double half = fmin(wide, 1) / 2;
    const struct rf_piece piece = {
        {u[0] - t->shape->origin[0] - half, u[1] - t->shape->origin[1] - half},
        {u[0] - t->shape->origin[0] + half, u[1] - t->shape->origin[1] + half}};
    return rf_zone_light(&zone, t->bokeh, t->bokeh_plane, &piece) / (4 * half * half);
}

/* The light that comes to (x, y), the middle of a square of `side` px. */
static double light_to(const struct rf_trace *t, double x, double y, double side)
{
    const struct rf_look *look = t->look;
    const double to[2] = {t->q[0] + (x - t->at[0]) / look->half_px,
                          t->q[1] -
                              (y - t->at[1]) / (look->half_px * look->pixel_aspect)};
    double u[2];
    if (!rf_look_lens_point(look, t->shape, t->q, t->r, to, u))
        return 0;
    return light_at(t, u, side / fabs(t->r));
}

/* How many points a pixel asks for, per axis. */
static int fineness(const struct rf_trace *t)
{
    struct area all = all_of(t);
    double px = fmin(all.to[0] - all.from[0], all.to[1] - all.from[1]) / 2;
    return px < 16 ? MOST_FINE : px < 64 ? 4 : px < 256 ? 2 : 1;
}

static bool is_inside(const struct area *a, double x, double y)
{
    return x >= a->from[0] && x < a->to[0] && y >= a->from[1] && y < a->to[1];
}

/* The light that falls beside what is asked, px^2 of its mean. */
static double light_beside(const struct rf_trace *t, const struct area *seen)
{
    struct area all = all_of(t);
    double sum = 0, side[2];
    for (int k = 0; k < 2; k++)
        side[k] = (all.to[k] - all.from[k]) / LATTICE;
    for (int k = 0; k < LATTICE; k++)
        for (int i = 0; i < LATTICE; i++) {
            double x = all.from[0] + (i + 0.5) * side[0];
            double y = all.from[1] + (k + 0.5) * side[1];
            if (!is_inside(seen, x, y))
                sum += light_to(t, x, y, side[0]);
        }
    return sum * side[0] * side[1];
}

double rf_trace_fill(const struct rf_trace *t, struct rf_grid *g)
{
    struct area a = seen_of(t);
    int n = fineness(t);
    int left = rf_max_int((int)a.from[0], -g->reach_x);
    int right = rf_min_int((int)a.to[0], g->reach_x + 1);
    int top = rf_max_int((int)a.from[1], -g->reach_y);
    int bottom = rf_min_int((int)a.to[1], g->reach_y + 1);
    double sum = 0;
    for (int y = top; y < bottom; y++) {
        double *row = rf_grid_row(g, 0, y + g->reach_y) + g->reach_x;
        for (int x = left; x < right; x++) {
            double light = 0;
            for (int i = 0; i < n * n; i++) {
                int column = i % n, line = i / n;
                light +=
                    light_to(t, x + (column + 0.5) / n, y + (line + 0.5) / n, 1.0 / n);
            }
            row[x] = light / (n * n);
            sum += row[x];
        }
    }
    return sum > 0 ? sum / (sum + light_beside(t, &a)) : 0;
}
