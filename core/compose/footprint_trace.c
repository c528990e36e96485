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
 * LATTICE x LATTICE points of the box of what is lit, so that it is missing as of every
 * other footprint.
 *
 * Squares of pixels that bounds tell to be dark, or lit by an even lens, are not asked:
 * rows of squares are cut in halves until the bounds decide, or few are left.
 *
 * Approximations: a pixel of a wide footprint asks once (0.4 % of the area of a disc of
 * 128 px); spherical aberration is left out. Cost: 10 to 20 ns per point that is asked.
 */
#include "compose/footprint_trace.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>

#include "base/math.h"
#include "compose/zones.h"
#include "lens/look.h"

enum { LATTICE = 256, MOST_FINE = 8, FEW = 4 };

/* Samples of a list lie where their place was rounded to: as far off, in half
 * diagonals. */
static const double ROUNDED = 1.0 / 128;

/* What is lit farther away is no part of any picture; whole numbers hold it. */
static const double MOST_PX = 5e8;

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

/* The place of (x, y). */
static void place_of(const struct rf_trace *t, double x, double y, double to[2])
{
    double half_px = t->look->half_px;
    to[0] = t->q[0] + (x - t->at[0]) / half_px;
    to[1] = t->q[1] - (y - t->at[1]) / (half_px * t->look->pixel_aspect);
}

/* The light that comes to (x, y), the middle of a square of `side` px. */
static double light_to(const struct rf_trace *t, double x, double y, double side)
{
    double to[2], u[2];
    place_of(t, x, y, to);
    if (!rf_look_lens_point(t->look, t->shape, t->q, t->r, to, u))
        return 0;
    return light_at(t, u, side / fabs(t->r));
}

/* ---- squares ------------------------------------------------------------------- */

/* Columns and rows of squares, the last ones not among them. */
struct span {
    int from[2], to[2];
};

/* Squares of side[] px, the first one at from[], and what becomes of them. */
struct raster {
    const struct rf_trace *trace;
    struct rf_look_limits limits;
    double from[2], side[2];
    int few; /* squares across that are not cut any more */
    /* Spans that may be lit; those that are surely lit everywhere are said to be. */
    void (*note)(struct raster *, const struct span *, bool is_lit);
    const struct area *seen; /* not those in it; NULL: all */
    struct rf_grid *grid;
    int fineness; /* points that a pixel asks for, per axis */
    struct span lit;
    double sum;
};

static struct raster raster_of(const struct rf_trace *t)
{
    struct raster raster = {.trace = t, .side = {1, 1}, .few = FEW};
    raster.limits = rf_look_limits_make(t->look, t->shape);
    if (t->bokeh)
        raster.limits.open = 0; /* no light is 1 everywhere */
    return raster;
}

/* What of a span's squares is lit. */
static enum rf_look_lit light_of(const struct raster *raster, const struct span *span)
{
    const struct rf_trace *t = raster->trace;
    double middle[2], half[2], to[2];
    for (int k = 0; k < 2; k++) {
        middle[k] =
            raster->from[k] + (span->from[k] + span->to[k]) / 2.0 * raster->side[k];
        half[k] = (span->to[k] - span->from[k]) / 2.0 * raster->side[k];
    }
    place_of(t, middle[0], middle[1], to);
    double away = rf_length(half[0], half[1] / t->look->pixel_aspect);
    return rf_look_lit_in(t->look, &raster->limits, t->q, t->r, to,
                          away / t->look->half_px);
}

/* Notes all squares of a span but the dark ones. */
static void visit(struct raster *raster, const struct span *span)
{
    int width = span->to[0] - span->from[0], height = span->to[1] - span->from[1];
    if (width <= 0 || height <= 0)
        return;
    enum rf_look_lit seen = light_of(raster, span);
    if (seen == RF_LIT_NOWHERE)
        return;
    if (seen == RF_LIT_EVERYWHERE || (width <= raster->few && height <= raster->few)) {
        raster->note(raster, span, seen == RF_LIT_EVERYWHERE);
        return;
    }
    int axis = height > width;
    struct span first = *span, second = *span;
    first.to[axis] = second.from[axis] = (span->from[axis] + span->to[axis]) / 2;
    visit(raster, &first);
    visit(raster, &second);
}

/* ---- the picture --------------------------------------------------------------- */

static void note_lit(struct raster *raster, const struct span *span, bool is_lit)
{
    struct span *lit = &raster->lit;
    bool is_first = lit->to[0] <= lit->from[0];
    (void)is_lit;
    for (int k = 0; k < 2; k++) {
        lit->from[k] =
            is_first ? span->from[k] : rf_min_int(lit->from[k], span->from[k]);
        lit->to[k] = is_first ? span->to[k] : rf_max_int(lit->to[k], span->to[k]);
    }
}

/* The whole pixels of an area that may be lit. */
static struct span lit_of(const struct rf_trace *t, const struct area *a)
{
    struct raster raster = raster_of(t);
    struct span all;
    raster.note = note_lit;
    raster.few = MOST_FINE;
    for (int k = 0; k < 2; k++) {
        all.from[k] = (int)floor(fmax(a->from[k], -MOST_PX));
        all.to[k] = (int)ceil(fmin(a->to[k], MOST_PX));
    }
    visit(&raster, &all);
    return raster.lit;
}

void rf_trace_reach(const struct rf_trace *t, double reach[2])
{
    struct area a = seen_of(t);
    struct span lit = lit_of(t, &a);
    for (int k = 0; k < 2; k++)
        reach[k] = rf_max_int(abs(lit.from[k]), abs(lit.to[k]));
}

/* By what is lit, the bound of which may be many times as wide. */
static int fineness_of(const struct span *lit)
{
    int px = rf_min_int(lit->to[0] - lit->from[0], lit->to[1] - lit->from[1]) / 2;
    return px < 16 ? MOST_FINE : px < 64 ? 4 : px < 256 ? 2 : 1;
}

/* The light of a pixel. */
static double pixel_light(const struct rf_trace *t, int x, int y, int n)
{
    double light = 0;
    for (int i = 0; i < n * n; i++) {
        int column = i % n, line = i / n;
        light += light_to(t, x + (column + 0.5) / n, y + (line + 0.5) / n, 1.0 / n);
    }
    return light / (n * n);
}

static void fill_span(struct raster *raster, const struct span *span, bool is_lit)
{
    struct rf_grid *g = raster->grid;
    int n = raster->fineness;
    for (int y = span->from[1]; y < span->to[1]; y++) {
        double *row = rf_grid_row(g, 0, y + g->reach_y) + g->reach_x;
        for (int x = span->from[0]; x < span->to[0]; x++) {
            row[x] = is_lit ? 1 : pixel_light(raster->trace, x, y, n);
            raster->sum += row[x];
        }
    }
}

/* ---- beside it ----------------------------------------------------------------- */

static bool is_inside(const struct area *a, double x, double y)
{
    return x >= a->from[0] && x < a->to[0] && y >= a->from[1] && y < a->to[1];
}

static void add_beside(struct raster *raster, const struct span *span, bool is_lit)
{
    for (int k = span->from[1]; k < span->to[1]; k++)
        for (int i = span->from[0]; i < span->to[0]; i++) {
            double x = raster->from[0] + (i + 0.5) * raster->side[0];
            double y = raster->from[1] + (k + 0.5) * raster->side[1];
            if (!is_inside(raster->seen, x, y))
                raster->sum +=
                    is_lit ? 1 : light_to(raster->trace, x, y, raster->side[0]);
        }
}

/* The light that falls beside what is asked, px^2 of its mean. */
static double light_beside(const struct rf_trace *t, const struct area *seen,
                           const struct span *lit)
{
    static const struct span lattice = {.to = {LATTICE, LATTICE}};
    struct raster raster = raster_of(t);
    raster.note = add_beside;
    raster.seen = seen;
    for (int k = 0; k < 2; k++) {
        raster.from[k] = lit->from[k];
        raster.side[k] = (double)(lit->to[k] - lit->from[k]) / LATTICE;
    }
    visit(&raster, &lattice);
    return raster.sum * raster.side[0] * raster.side[1];
}

double rf_trace_fill(const struct rf_trace *t, struct rf_grid *g)
{
    struct area a = seen_of(t), all = all_of(t);
    struct span lit = lit_of(t, &all);
    struct raster raster = raster_of(t);
    raster.note = fill_span;
    raster.fineness = fineness_of(&lit);
    raster.grid = g;
    const struct span asked = {.from = {rf_max_int((int)a.from[0], -g->reach_x),
                                        rf_max_int((int)a.from[1], -g->reach_y)},
                               .to = {rf_min_int((int)a.to[0], g->reach_x + 1),
                                      rf_min_int((int)a.to[1], g->reach_y + 1)}};
    visit(&raster, &asked);
    double sum = raster.sum;
    return sum > 0 ? sum / (sum + light_beside(t, &a, &lit)) : 0;
}

double rf_trace_open(const struct rf_trace *t)
{
    static const struct area none = {.from = {0}};
    if (!rf_look_is_dark(t->look))
        return 1;
    const struct rf_look bright_look = rf_look_bright(t->look);
    struct rf_trace bright = *t;
    bright.look = &bright_look;
    struct area all = all_of(&bright);
    struct span lit = lit_of(&bright, &all);
    double most = light_beside(&bright, &none, &lit);
    return most > 0 ? fmin(light_beside(t, &none, &lit) / most, 1) : 0;
}
