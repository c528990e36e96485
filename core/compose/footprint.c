/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Footprints of a sample.
 *
 *   W(i, j) = integral over the aperture of  k(x_i - u r) k(y_j + v r a)  du dv
 *
 *   r        signed radius in px; the sample lands at (x + u r, y - v r a)
 *   a        pixel aspect
 *   k        Catmull-Rom's interpolation kernel: r -> 0 becomes the identity and rims
 * stay sharp (a box costs 0.15 dB, a tent 1.2 dB; docs/algorithm.md, "Footprints")
 *
 * A line v = const cuts the convex aperture, and every Voronoi cell of it, in one
 * interval, whose integral over u is a difference of the kernel's antiderivative: exact
 * in x. In y the lines are 1/16 px apart or closer. Each cell is scaled to its share of
 * the lens, so that light is neither made nor lost.
 */
#include "compose/footprint.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/footprint_grid.h"
#include "compose/footprint_trace.h"
#include "compose/lens_cells.h"
#include "compose/lens_light.h"
#include "compose/zones.h"
#include "kernels/data.h"
#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

enum {
    LINES_PER_PX = 16,
    LIGHT_PER_PX = 4, /* lines of uneven light: they are pieces of even ones */
    LEAST_LIGHT = 24,
    LIGHT_FINE_PX = 24, /* of radius, up to which pieces are so small */
    MAX_LINES = 4096,
    N_TRIALS = 3 /* until the variance of a footprint is right within 1 % */
};

static const double RADIUS_STEP = 1.0 / 16; /* px: what rounds a radius, at the most */
static const double MIN_SQUARE = 1e-4;      /* px^2, of a footprint's radius */
static const double BOX = 1.0 / 12; /* px^2, what RF_POSITIVE adds where it is wide */
static const double SAME = 1e-4;    /* of the greatest weight: shares are not exact */
static const double CLOSE = 2e-3;   /* of the variance: near enough */

/* px^2 of the level that averaging down to it and magnifying add to a variance. */
#define LEVEL_LOSS 0.25

/* Weights that are left out, in parts of the greatest. */
static const double DUST = 1e-6;
/* Of the cubic's flat tails where its footprint is wide: they lengthen every row. */
static const double WIDE_DUST = 4e-3, WIDE_PX = 1;
/* Of a part of the lens: most of its rim is inside, where the next part makes up. */
static const double PART_DUST = 5e-2;

/* Pixels to each side that a footprint has at the most: 16 bits hold twice of it. */
static const double MOST_REACH = 16368;

static const double CORNER = 2.83; /* |p|^3 in the corner of a picture */

/* What a px of aberration is at the most, px right or down. */
static double glow_size(const struct rf_footprints *f)
{
    const struct rf_shape *shape = f->shape;
    double stretched = shape->growth * shape->growth * shape->growth;
    return stretched * fmax(shape->pixel_aspect, 1) * fmax(1 / shape->ratio, 1) *
           (f->bokeh ? CORNER : 1);
}

/* The spherical aberration of a level's footprints, px of the level. */
static double glow_of(const struct rf_footprints *f, int level)
{
    double most = f->is_boundless ? INFINITY : RF_MOST_GLOW / glow_size(f);
    return fmin(fmax(ldexp(f->spherical, -level), -most), most);
}

/* How far beyond the radius they reach at the most, px of the level. */
static double most_glow(const struct rf_footprints *f, int level)
{
    return fabs(glow_of(f, level)) * glow_size(f);
}

static void measure_extent(struct rf_footprints *f)
{
    const struct rf_shape *shape = f->shape;
    double extent[2];
    rf_shape_extent(shape, extent);
    extent[0] = fmax(extent[0], shape->size[0]);
    extent[1] = fmax(extent[1], shape->size[1] * shape->pixel_aspect);
    for (int k = 0; k < 2; k++) {
        f->extent[k][0] = fabs(f->drift.base[k]);
        f->extent[k][1] = extent[k] + fabs(f->drift.slope[k]);
    }
}

/* ---- one footprint ------------------------------------------------------------- */

/*
 * Where n lines cut the cells of the aperture, [line][cell]; kept by a thread, since
 * footprints of one radius have as many.
 */
struct lines {
    int n;
    const struct rf_zone *zone;
    struct rf_interval *part;
    size_t missing_bytes; /* the most that memory was asked for in vain */
};

static bool note_missing(struct lines *lines, size_t n_bytes)
{
    if (n_bytes > lines->missing_bytes)
        lines->missing_bytes = n_bytes;
    return false;
}

/* What is to be built. */
struct request {
    const struct rf_zone *zone;
    double r;
    int level;
    enum rf_footprint_kind kind;
    int phase;
};

static bool cut_lines(struct lines *lines, const struct rf_context *context,
                      const struct rf_zone *zone, struct rf_interval range, int n)
{
    int n_cells = zone->cells.n;
    if (lines->part && lines->n == n && lines->zone == zone)
        return true;
    rf_free(context, lines->part);
    /* Room for the lines of the whole lens, behind those of the cells. */
    size_t n_parts = (size_t)n * (size_t)n_cells;
    lines->n = n;
    lines->zone = zone;
    lines->part = rf_alloc(context, n_parts + (size_t)n, sizeof *lines->part);
    if (!lines->part)
        return note_missing(lines, (n_parts + (size_t)n) * sizeof *lines->part);
    struct rf_interval *cut = lines->part + n_parts;
    rf_shape_lines(zone->shape, range, n, cut);
    for (int i = 0; i < n; i++)
        for (int c = 0; c < n_cells; c++)
            lines->part[i * n_cells + c] =
                rf_lens_cell_line(&zone->cells, c, rf_line_at(range, i, n), cut[i]);
    return true;
}

/* False: out of memory. */
static bool fill_grid(struct rf_grid *g, const struct rf_footprints *f,
                      struct lines *lines, const struct rf_zone *zone,
                      const double r[2], const double phase[2])
{
    const struct rf_shape *shape = zone->shape;
    struct rf_interval range = rf_shape_v_range(shape);
    double height_px = (range.to - range.from) * fabs(r[1]) * shape->pixel_aspect;
    int n_lines = rf_min_int(
        rf_max_int((int)(height_px * LINES_PER_PX), shape->min_lines), MAX_LINES);
    if (!cut_lines(lines, f->context, zone, range, n_lines))
        return false;
    for (int i = 0; i < n_lines; i++) {
        double y =
            phase[1] - rf_line_at(range, i, n_lines) * r[1] * shape->pixel_aspect;
        for (int c = 0; c < zone->cells.n; c++) {
            struct rf_interval part = lines->part[i * zone->cells.n + c];
            if (part.to <= part.from)
                continue;
            double a = phase[0] + part.from * r[0], b = phase[0] + part.to * r[0];
            rf_grid_add_line(g, c,
                             &(struct rf_grid_line){fmin(a, b), fmax(a, b), y,
                                                    height_px / n_lines, 1});
        }
    }
    return true;
}

/*
 * The same of a lens whose light is not even: a picture of the aperture, or spherical
 * aberration, by which the lens point p lands at r u - a |p|^2 u. Lines are cut into
 * pieces of half a pixel at the most, each with the light of its part of the lens.
 */
static bool fill_light(struct rf_grid *g, const struct rf_footprints *f,
                       struct lines *lines, const struct request *q, const double r[2],
                       const double at[2])
{
    const struct rf_zone *zone = q->zone;
    const struct rf_shape *shape = zone->shape;
    struct rf_interval range = rf_shape_v_range(shape);
    double glow = glow_of(f, q->level), aspect = shape->pixel_aspect;
    double size =
        fmax(fabs(r[0]) * shape->size[0], fabs(r[1]) * shape->size[1]) + fabs(glow);
    /* Wide ones are smooth but for their rims: coarser pieces do. */
    double rest = fmax(size - LIGHT_FINE_PX, 0), fine = size - rest;
    int n_lines = (int)(2 * (fine * LIGHT_PER_PX + rest));
    n_lines = rf_min_int(rf_max_int(n_lines, LEAST_LIGHT), MAX_LINES);
    double step_v = (range.to - range.from) / n_lines;
    if (!cut_lines(lines, f->context, zone, range, n_lines))
        return false;
    for (int i = 0; i < n_lines * zone->cells.n; i++) {
        struct rf_interval part = lines->part[i];
        double v = rf_line_at(range, i / zone->cells.n, n_lines);
        double length = part.to - part.from, step_u = 2 * shape->size[0] / n_lines;
        int n = length > 0 ? (int)ceil(length / step_u) : 0;
        for (int k = 0; k < n; k++) {
            double u[2] = {part.from + length * (k + 0.5) / n, v}, to[2];
            double half = length / n / 2;
            struct rf_piece piece = {{u[0] - half, v - step_v / 2},
                                     {u[0] + half, v + step_v / 2}};
            double light = rf_zone_light(zone, f->bokeh, f->bokeh_plane, &piece);
            double shift = -glow * rf_zone_height2(zone, u);
            for (int c = 0; c < 2; c++)
                to[c] = u[c] * r[c] +
                        shift * (u[c] + zone->centroid[c] + zone->shape->origin[c]);
            double wide = fmax(fabs(half * (r[0] + shift)), 1e-3);
            double high = fmax(fabs(step_v * (r[1] + shift)) * aspect, 1e-3);
            rf_grid_add_line(g, i % zone->cells.n,
                             &(struct rf_grid_line){
                                 at[0] + to[0] - wide, at[0] + to[0] + wide,
                                 at[1] - to[1] * aspect, high, light / (2 * wide)});
        }
    }
    return true;
}

/* Radius 0: the sample stays in its pixel (or interpolates between pixels). */
static void fill_point(struct rf_grid *g, int n_cells, const double phase[2])
{
    for (int c = 0; c < n_cells; c++)
        for (int y = -g->reach_y; y <= g->reach_y; y++)
            for (int x = -g->reach_x; x <= g->reach_x; x++)
                rf_grid_row(g, c, y + g->reach_y)[x + g->reach_x] =
                    g->kernel->value(x + 0.5 - phase[0], 0) *
                    g->kernel->value(y + 0.5 - phase[1], 0);
}

/* The weights that a footprint does without, in parts of the greatest. */
static double dust_of(const struct request *q)
{
    const struct rf_shape *shape = q->zone->shape;
    double r = q->r;
    double extent = fmin(shape->size[0], shape->size[1]) * fabs(r);
    if (q->kind != RF_SHARP || fabs(r) < WIDE_PX)
        return DUST;
    return shape->is_part && ((q->level > 0) || extent >= WIDE_PX) ? PART_DUST
                                                                   : WIDE_DUST;
}

/* Drops the dust and scales every cell to its share. */
static void normalise(struct rf_grid *g, const struct rf_lens_cells *cells, double dust)
{
    size_t n = (size_t)g->width * (size_t)g->height;
    for (int c = 0; c < cells->n; c++) {
        double *w = g->weight + n * (size_t)c, sum = 0, peak = 0;
        for (size_t i = 0; i < n; i++)
            peak = fmax(peak, w[i]);
        for (size_t i = 0; i < n; i++) {
            if (fabs(w[i]) < dust * peak)
                w[i] = 0;
            sum += w[i];
        }
        for (size_t i = 0; i < n; i++)
            w[i] = sum > 0 ? w[i] * cells->share[c] / sum : 0;
    }
}

/*
 * Takes LEVEL_LOSS off the variance of n values that lie `step` apart. What is 0 stays
 * so: the kernel's tails have room for what is left of a rim, and rows stay as long.
 */
static void sharpen_line(double *at, size_t step, int n)
{
    static const double BESIDE = LEVEL_LOSS / 2;
    double before = 0;
    for (int i = 0; i < n; i++, at += step) {
        double here = *at, after = i + 1 < n ? at[step] : 0;
        if (here != 0)
            *at = (1 + 2 * BESIDE) * here - BESIDE * (before + after);
        before = here;
    }
}

/* Makes up for a coarse level's averaging and magnifying along x and y. */
static void sharpen(struct rf_grid *g, int n_cells)
{
    for (int i = 0; i < n_cells * g->height; i++)
        sharpen_line(g->weight + (size_t)i * (size_t)g->width, 1, g->width);
    for (int c = 0; c < n_cells; c++)
        for (int x = 0; x < g->width; x++)
            sharpen_line(rf_grid_row(g, c, 0) + x, (size_t)g->width, g->height);
}

/* Adds up all cells in the first one, whose weights then add up to 1. */
static void join_cells(struct rf_grid *g, int n_cells)
{
    size_t n = (size_t)g->width * (size_t)g->height;
    for (size_t i = n; i < n * (size_t)n_cells; i++) {
        g->weight[i % n] += g->weight[i];
        g->weight[i] = 0;
    }
}

static bool row_extent(const double *row, int n, int *first, int *last)
{
    *first = n;
    *last = -1;
    for (int x = 0; x < n; x++)
        if (row[x] != 0) {
            *first = rf_min_int(*first, x);
            *last = x;
        }
    return *last >= 0;
}

static int padded(int n)
{
    return (n + RF_FOOTPRINT_LANES - 1) / RF_FOOTPRINT_LANES * RF_FOOTPRINT_LANES;
}

/* The weight that mirrors that of column x and row y: in the other half of its row, or
 * of its column. */
static double *mirrored(const struct rf_grid *g, int x, int y, bool is_in_row)
{
    return is_in_row ? &rf_grid_row(g, 0, y)[g->width - 1 - x]
                     : &rf_grid_row(g, 0, g->height - 1 - y)[x];
}

/* Do the weights mirror each other? Then they become the same numbers. */
static bool mirror(struct rf_grid *g, bool is_in_row)
{
    int width = is_in_row ? g->width / 2 : g->width;
    int height = is_in_row ? g->height : g->height / 2;
    double peak = 0;
    for (int i = 0; i < g->width * g->height; i++)
        peak = fmax(peak, g->weight[i]);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++)
            if (fabs(rf_grid_row(g, 0, y)[x] - *mirrored(g, x, y, is_in_row)) >
                SAME * peak)
                return false;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            double *a = &rf_grid_row(g, 0, y)[x], *b = mirrored(g, x, y, is_in_row);
            *a = *b = 0.5 * (*a + *b);
        }
    return true;
}

/* Turns the grid into segments; one block of memory holds all of it. */
static struct rf_footprint *pack(struct rf_grid *g, const struct rf_context *context,
                                 int n_cells, bool is_common, struct lines *lines)
{
    bool is_mirrored = (n_cells == 1 || is_common) && mirror(g, false);
    bool is_even = is_mirrored && mirror(g, true);
    int n_segments = 0, n_weights = 0, first, last, n_spare = RF_MAX_SIDE_BY_SIDE - 1;
    for (int y = 0; y < g->height; y++)
        for (int c = 0; c < n_cells; c++)
            if (row_extent(rf_grid_row(g, c, y), g->width, &first, &last)) {
                int n = last - first + 1;
                n_segments++;
                n_weights += padded(n);
                n_spare = rf_min_int(n_spare, padded(n) - n);
            }
    size_t head = 64 + RF_FOOTPRINT_LANES * sizeof(float),
           body = ((size_t)n_weights * sizeof(float) + 63) / 64 * 64;
    size_t n_bytes = head + body + (size_t)n_segments * sizeof(struct rf_segment);
    char *memory = rf_calloc(context, 1, n_bytes);
    if (!memory) {
        note_missing(lines, n_bytes);
        return NULL;
    }
    struct rf_footprint *p = (struct rf_footprint *)memory;
    _Static_assert(sizeof *p <= 64, "the head holds the footprint");
    p->weights = (float *)(memory + head);
    p->segments = (struct rf_segment *)(memory + head + body);
    p->is_common = is_common;
    p->is_shut = false;
    p->is_even = is_even;
    p->n_mirrored = is_mirrored ? n_segments / 2 : 0;
    p->n_side_by_side = n_spare + 1;
    p->min_dx = p->min_dy = n_segments > 0 ? INT16_MAX : 0;
    p->max_dx = p->max_dy = n_segments > 0 ? INT16_MIN : 0;
    n_weights = 0;
    for (int y = 0; y < g->height; y++)
        for (int c = 0; c < n_cells; c++) {
            const double *row = rf_grid_row(g, c, y);
            if (!row_extent(row, g->width, &first, &last))
                continue;
            int dx = first - g->reach_x, dy = y - g->reach_y;
            int cell = is_common ? n_cells : c;
            p->segments[p->n_segments++] = (struct rf_segment){
                .dx = (int16_t)dx,
                .dy = (int16_t)dy,
                .n = (int16_t)padded(last - first + 1),
                .n_used = (int16_t)(last - first + 1),
                .cell = (int16_t)cell,
                .row = cell * RF_TILE_H + dy,
                .weight = n_weights,
            };
            for (int x = first; x <= last; x++)
                p->weights[n_weights + x - first] = (float)row[x];
            struct rf_segment *last_one = &p->segments[p->n_segments - 1];
            last_one->sum = rf_segment_sum(last_one, p->weights, is_even);
            n_weights += padded(last - first + 1);
            p->min_dx = rf_min_int(p->min_dx, dx);
            p->max_dx = rf_max_int(p->max_dx, last - g->reach_x);
            p->min_dy = rf_min_int(p->min_dy, dy);
            p->max_dy = rf_max_int(p->max_dy, dy);
        }
    return p;
}

/* Variances of a grid's weights along x and y, px^2. */
static void grid_variance(const struct rf_grid *g, int n_cells, double variance[2])
{
    double sum[3] = {0}, square[2] = {0};
    for (int i = 0; i < n_cells * g->height; i++)
        for (int x = 0; x < g->width; x++) {
            double y = i % g->height, w = g->weight[(size_t)i * (size_t)g->width + x];
            sum[0] += w * x;
            sum[1] += w * y;
            sum[2] += w;
            square[0] += w * x * x;
            square[1] += w * y * y;
        }
    for (int k = 0; k < 2; k++)
        variance[k] = sum[2] > 0 ? (square[k] - sum[k] * sum[k] / sum[2]) / sum[2] : 0;
}

/*
 * Fills the grid so that the variance of what is seen of it at full resolution is that
 * of the aperture at radius r. The level's averaging and magnifying add to it; so does
 * the box of RF_POSITIVE, by 1/12 px^2 where the footprint is wide and by less where it
 * is narrow, which the secant method finds. Up to 1 px at full resolution the box is
 * left alone: it is the pixel. So it is of points of light, of which a pixel gets the
 * share of the lens' shape that lies in it. False: out of memory.
 */
static bool fill_level(struct rf_grid *g, const struct rf_footprints *f,
                       struct lines *lines, const struct request *q,
                       const double phase[2])
{
    const struct rf_zone *zone = q->zone;
    const bool is_coarse = q->level > 0;
    double aspect = zone->shape->pixel_aspect, r = q->r;
    double unit[2] = {zone->variance[0], zone->variance[1] * aspect * aspect};
    bool is_narrower = is_coarse && q->kind != RF_SHARP; /* others are sharpened */
    double loss = is_narrower ? LEVEL_LOSS : 0, target[2], square[2], slope[2];
    double radii[2], variance[2], before[2] = {0}, step[2] = {0};
    size_t n = (size_t)g->width * (size_t)g->height * (size_t)zone->cells.n;
    bool has_box =
        q->kind == RF_POSITIVE && !f->is_of_points && (is_coarse || fabs(r) > 1);
    bool is_tried = has_box && f->spherical == 0;
    if (is_tried && !is_coarse)
        loss -= fmax(2 - fabs(r), 0) / 12;
    for (int k = 0; k < 2; k++) {
        target[k] = r * r * unit[k] - loss;
        slope[k] = unit[k];
        square[k] = (target[k] - (has_box ? BOX : 0)) / unit[k];
        square[k] = fmin(fmax(square[k], MIN_SQUARE), r * r);
    }
    for (int trial = 0; trial <= (is_tried ? N_TRIALS : 0); trial++) {
        for (int k = 0; k < 2; k++)
            radii[k] = copysign(sqrt(square[k]), r);
        memset(g->weight, 0, n * sizeof *g->weight);
        if (!(f->bokeh || f->spherical != 0
                  ? fill_light(g, f, lines, q, radii, phase)
                  : fill_grid(g, f, lines, zone, radii, phase)))
            return false;
        if (!is_tried || trial == N_TRIALS)
            break;
        grid_variance(g, zone->cells.n, variance);
        if (fabs(variance[0] - target[0]) < CLOSE * target[0] &&
            fabs(variance[1] - target[1]) < CLOSE * target[1])
            break;
        for (int k = 0; k < 2; k++) {
            double found = step[k] != 0 ? (variance[k] - before[k]) / step[k] : 0;
            if (found > 0.25 * unit[k] && found < 16 * unit[k])
                slope[k] = found;
            double next = square[k] + (target[k] - variance[k]) / slope[k];
            next = fmin(fmax(next, MIN_SQUARE), r * r);
            step[k] = next - square[k];
            before[k] = variance[k];
            square[k] = next;
        }
    }
    return true;
}

/* What the slot of the table is for. */
static struct request request_of(const struct rf_footprints *f, size_t slot)
{
    size_t n_phases = (size_t)(f->n_phases * f->n_phases);
    size_t n_levels = (size_t)f->n_levels;
    size_t rest = slot / n_levels, n_radii = 2 * (size_t)f->max_index + 1;
    size_t radius = rest / RF_N_KINDS / n_phases;
    return (struct request){
        .zone = &f->zones.at[radius / n_radii],
        .r = rf_radius_of_index((int)(radius % n_radii) - f->max_index),
        .level = (int)(slot % n_levels),
        .kind = (enum rf_footprint_kind)(rest % RF_N_KINDS),
        .phase = (int)(rest / RF_N_KINDS % n_phases),
    };
}

/* The middle of a footprint, px from the corner of the sample's pixel. */
static void middle_of(const struct rf_footprints *f, const struct request *q,
                      double at[2], double reach[2])
{
    for (int k = 0; k < 2; k++) {
        double beside = f->drift.slope[k] * q->r;
        int phase = k ? q->phase / f->n_phases : q->phase % f->n_phases;
        if (!(q->level > 0))
            beside += f->drift.base[k];
        double aspect = k ? q->zone->shape->pixel_aspect : 1;
        beside += (k ? -aspect : 1) * q->zone->centroid[k] * q->r;
        at[k] = (phase + 0.5) / f->n_phases + beside;
        reach[k] = fabs(q->r) * q->zone->shape->size[k] * aspect + fabs(beside) +
                   most_glow(f, q->level);
    }
}

/* A grid of weights 0 for n_cells, `reach` px around the pixel. False: out of memory. */
static bool make_grid(struct rf_grid *g, const struct rf_footprints *f, int n_cells,
                      const double reach[2], struct lines *lines)
{
    g->reach_x = (int)ceil(fmin(reach[0], MOST_REACH)) + 3;
    g->reach_y = (int)ceil(fmin(reach[1], MOST_REACH)) + 3;
    g->width = 2 * g->reach_x + 1;
    g->height = 2 * g->reach_y + 1;
    size_t n = (size_t)g->width * (size_t)g->height * (size_t)n_cells;
    g->weight = rf_calloc(f->context, n + (size_t)g->width, sizeof(double));
    if (!g->weight)
        return note_missing(lines, (n + (size_t)g->width) * sizeof(double));
    g->line = g->weight + n;
    return true;
}

static struct rf_footprint *build_request(const struct rf_footprints *f,
                                          const struct request *q, struct lines *lines)
{
    int n_cells = q->zone->cells.n;
    double at[2], reach[2];
    middle_of(f, q, at, reach);
    struct rf_grid g = {.kernel = &rf_footprint_kernels[q->kind]};
    if (!make_grid(&g, f, n_cells, reach, lines))
        return NULL;
    if (q->r == 0 && f->spherical == 0)
        fill_point(&g, n_cells, at);
    else if (!fill_level(&g, f, lines, q, at)) {
        rf_free(f->context, g.weight);
        return NULL;
    }
    if (q->level > 0 && q->kind == RF_SHARP)
        sharpen(&g, n_cells);
    normalise(&g, &q->zone->cells, dust_of(q));
    bool is_common = n_cells > 1 && !(q->level > 0) && fabs(q->r) < RF_COMMON_PX;
    if (is_common)
        join_cells(&g, n_cells);
    struct rf_footprint *built = pack(&g, f->context, n_cells, is_common, lines);
    rf_free(f->context, g.weight);
    return built;
}

/* That of a list's entry whose shape is no polygon. */
static struct rf_footprint *build_traced(const struct rf_footprints *f,
                                         const struct rf_listed *l, struct lines *lines)
{
    struct rf_lens_cells whole = {.n = 1};
    struct rf_grid g = {.weight = NULL};
    struct rf_trace trace = {.look = &f->zones.look,
                             .shape = f->shape,
                             .bokeh = f->bokeh,
                             .bokeh_plane = f->bokeh_plane,
                             .q = l->q,
                             .r = rf_radius_of_index(l->index)};
    double reach[2];
    const int phase[2] = {l->phase % f->n_phases, l->phase / f->n_phases};
    for (int k = 0; k < 2; k++)
        trace.at[k] = (phase[k] + 0.5) / f->n_phases;
    rf_trace_reach(&trace, reach);
    if (!make_grid(&g, f, 1, reach, lines))
        return NULL;
    double open = rf_trace_open(&trace);
    whole.share[0] = rf_trace_fill(&trace, &g) * (open > 0 ? open : 1);
    normalise(&g, &whole, DUST);
    struct rf_footprint *built = pack(&g, f->context, 1, false, lines);
    rf_free(f->context, g.weight);
    if (built)
        built->is_shut = open == 0;
    return built;
}

/* That of a list's entry, whose zone is its own place. */
static struct rf_footprint *build_listed(const struct rf_footprints *f,
                                         const struct rf_listed *l, struct lines *lines)
{
    struct rf_shape shape;
    struct rf_zone zone;
    double r = rf_radius_of_index(l->index);
    if (rf_look_is_folded(&f->zones.look, f->shape, l->q, r))
        return build_traced(f, l, lines);
    double open = rf_zone_make_lit(&zone, &shape, f->shape, &f->zones.look, l->q, r,
                                   f->bokeh, f->bokeh_plane);
    if (open > 0)
        zone.cells.share[0] = open;
    struct request q = {&zone, r, 0, RF_POSITIVE, l->phase};
    struct rf_footprint *built = build_request(f, &q, lines);
    rf_free(f->context, lines->part);
    lines->part = NULL; /* of the zone here */
    if (built)
        built->is_shut = open == 0;
    return built;
}

static bool build(struct rf_footprints *f, size_t slot, struct lines *lines)
{
    struct rf_footprint *built, *none = NULL;
    if (__atomic_load_n(&f->table[slot], __ATOMIC_ACQUIRE))
        return true;
    if (f->list) {
        built = build_listed(f, &f->list[slot], lines);
    } else {
        struct request q = request_of(f, slot);
        built = build_request(f, &q, lines);
    }
    if (built && !__atomic_compare_exchange_n(&f->table[slot], &none, built, false,
                                              __ATOMIC_ACQ_REL, __ATOMIC_ACQUIRE))
        rf_free(f->context, built); /* another picture was first */
    return built != NULL;
}

/* What the threads share that build footprints. */
struct building {
    struct rf_footprints *footprints;
    const unsigned char *needed;
    struct rf_task *task;
    struct lines *lines; /* one per thread */
    int n_failed;        /* atomic */
};

static void build_needed(void *data, int64_t begin, int64_t end, int thread)
{
    struct building *b = data;
    for (int64_t i = begin; i < end; i++) {
        if (!b->needed[i] || rf_task_is_cancelled(b->task))
            continue;
        if (!build(b->footprints, (size_t)i, &b->lines[thread]))
            __atomic_fetch_add(&b->n_failed, 1, __ATOMIC_RELAXED);
        rf_task_step(b->task);
    }
}

rf_result rf_footprints_build(struct rf_footprints *f, const unsigned char *needed,
                              struct rf_task *task, double progress_to,
                              struct rf_error *error)
{
    size_t n_threads = (size_t)f->context->n_threads;
    int64_t n = (int64_t)rf_footprint_count(f), n_needed = 0;
    struct building b = {.footprints = f, .needed = needed, .task = task};
    b.lines = rf_calloc(f->context, n_threads, sizeof *b.lines);
    if (!b.lines)
        return rf_fail_memory(error, n_threads, sizeof *b.lines);
    for (int64_t i = 0; i < n; i++)
        n_needed += needed[i] != 0;
    rf_task_phase(task, progress_to, n_needed);
    rf_parallel(f->context, n, 4, build_needed, &b);
    size_t missing_bytes = 0;
    for (size_t i = 0; i < n_threads; i++) {
        if (b.lines[i].missing_bytes > missing_bytes)
            missing_bytes = b.lines[i].missing_bytes;
        rf_free(f->context, b.lines[i].part);
    }
    rf_free(f->context, b.lines);
    return b.n_failed ? rf_fail_memory(error, missing_bytes, 1) : RF_OK;
}

int rf_footprints_reach(const struct rf_footprints *f, int level, double r)
{
    double within_px =
        f->n_phases > 1 ? 1 : 0.5; /* where the sample lies at the most */
    double most = 0, glow = most_glow(f, level), wide = fabs(r) + RADIUS_STEP;
    bool is_added = rf_shape_glows(f->shape, r < 0);
    for (int k = 0; k < 2; k++) {
        double reach = wide * f->extent[k][1];
        reach = is_added ? reach + glow : fmax(reach, glow);
        most = fmax(most, f->extent[k][0] + reach);
    }
    return (int)ceil(most + RF_KERNEL_REACH + within_px - 0.5) - 1;
}

/* ---- the table ----------------------------------------------------------------- */

rf_result rf_footprints_init(struct rf_footprints *f, const struct rf_context *context,
                             const struct rf_footprint_use *use, struct rf_error *error)
{
    *f = (struct rf_footprints){.context = context,
                                .shape = use->shape,
                                .drift = use->drift,
                                .n_phases = use->n_phases,
                                .bokeh = use->bokeh,
                                .bokeh_plane = use->bokeh_plane,
                                .obstruction = use->obstruction,
                                .spherical = use->spherical,
                                .is_boundless = use->is_boundless,
                                .is_of_points = use->is_of_points,
                                .n_levels = use->spherical != 0 ? RF_N_LEVELS : 2,
                                .list = use->list,
                                .n_listed = use->n_listed};
    if (use->list)
        f->zones.look = use->look; /* each has a zone of its own */
    rf_result result =
        use->list ? RF_OK : rf_zones_init(&f->zones, context, use, error);
    measure_extent(f);
    f->max_index = INT32_MAX;
    f->max_index = rf_radius_index(f, (float)use->max_radius) + 1;
    size_t n = rf_footprint_count(f);
    if (result == RF_OK && !(f->table = rf_calloc(context, n, sizeof *f->table)))
        result = rf_fail_memory(error, n, sizeof *f->table);
    if (result != RF_OK)
        rf_zones_free(&f->zones, context);
    return result;
}

void rf_footprints_free(struct rf_footprints *f)
{
    if (!f->table)
        return;
    size_t n = rf_footprint_count(f);
    for (size_t i = 0; i < n; i++)
        rf_free(f->context, f->table[i]);
    rf_free(f->context, f->table);
    rf_zones_free(&f->zones, f->context);
    f->table = NULL;
}
