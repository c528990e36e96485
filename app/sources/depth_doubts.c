/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Of a flat surface 1 / z is a straight line across the picture, where z is planar
 * distance in a perspective: 1 / z = a + b x + c y. So is the number itself where it is
 * 1 / z already, and m / v where it is a distance v = m z along the ray of length
 * m = sqrt(1 + x^2 + y^2). Of a normalised number v the distance is
 * near + v (far - near), or, where near is white, that of 1 - v. How bent a line is
 * between three places, PLACE_PX apart or farther:
 *
 *   bend = abs(u1 - 2 u2 + u3) / max(abs(u2 - u1), abs(u3 - u2))
 */
#include "sources/depth_doubts.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "sources/depth_grid.h"

enum {
    MOST_PLACES = 60000, /* 0.1 % of a filter */
    PLACE_PX = 8,        /* apart, so that a slope is well above the noise of floats */
    FEWEST_PX = 4
};

/* How the lines through three places are judged. */
struct measure {
    /* Slopes, of the depth, between two places: below it rounding shows, above it lie
     * other things. On the references 20 to 60 % of the places have them. */
    double least_slope, most_slope;
    /* One kind fits alone if its bend is so much less than the others', */
    double clearly;
    double straight; /* and the least bend is below it. */
};

/* Of the references 46 to 88 % of the places on flat things are of their kind then, none of
 * another. */
static const struct measure FINE = {2e-3, 0.2, 0.1, INFINITY};

/* Of 16 bit, a 24th and a 12th of the width apart: 50 to 90 % at one of both, and a 34th of
 * that of another; foliage has none. */
static const struct measure COARSE = {0.02, 0.3, 0.25, 0.02};
static const int32_t COARSE_PARTS[DOUBTS_N_STEPS] = {24, 12};

/* Depth is in another unit than the focus, or nothing is in focus, from so many times it:
 * beyond, radii differ by 5 % at most, as bias (1 - focus / z) does. */
static const double FAR_FOCUSES = 20;

struct doubts_tally {
    const struct rf_params *params;
    struct rf_lens lens; /* the filter that it is from may be made anew */
    int32_t width, height, stride;
    const struct measure *measure;
    int32_t step_px[DOUBTS_N_STEPS]; /* 0: no more */
    struct doubts_range range;
    struct doubts_kinds kinds[DOUBTS_N_STEPS];
    struct depth_grid *grid; /* NULL without memory */
};

/* A place in the rows at hand. */
struct place {
    const struct doubts_rows *rows;
    const float *depth;
    int32_t x, y; /* y of the picture */
};

struct doubts_tally *doubts_create(const struct rf_params *params,
                                   const struct rf_lens *lens, int32_t width,
                                   int32_t height, bool is_half)
{
    struct doubts_tally *tally = malloc(sizeof(*tally));
    const double n = (double)width * height;
    const int32_t stride = (int32_t)fmax(ceil(sqrt(n / MOST_PLACES)), 1);
    if (!tally)
        return NULL;
    *tally = (struct doubts_tally){.params = params,
                                   .lens = *lens,
                                   .width = width,
                                   .height = height,
                                   .stride = stride,
                                   .measure = is_half ? &COARSE : &FINE,
                                   .step_px = {PLACE_PX},
                                   .range = {.nearest = INFINITY},
                                   .grid = depth_grid_create(width, height)};
    for (int i = 0; is_half && i < DOUBTS_N_STEPS; i++) {
        const int32_t step = width / COARSE_PARTS[i];
        tally->step_px[i] = step > FEWEST_PX ? step : FEWEST_PX;
    }
    return tally;
}

void doubts_free(struct doubts_tally *tally)
{
    if (tally)
        depth_grid_free(tally->grid);
    free(tally);
}

static bool is_hit(const struct doubts_tally *tally, float z)
{
    const struct rf_params *p = tally->params;
    const double v = (double)z * p->depth_scale + p->depth_offset;
    return v > 0 && v < p->depth_infinity && (double)z < p->depth_infinity;
}

/* ---- range ----------------------------------------------------------------------- */

static void add_distance(struct doubts_tally *tally, float value)
{
    const struct rf_params *params = tally->params;
    const double z = value * params->depth_scale + params->depth_offset;
    struct doubts_range *range = &tally->range;
    if (!(z > 0))
        return;
    range->n_hits++;
    range->n_far += z > FAR_FOCUSES * tally->lens.focus_distance;
    range->n_near += z * FAR_FOCUSES < tally->lens.focus_distance;
    range->nearest = fmin(range->nearest, z);
    range->farthest = fmax(range->farthest, z);
}

void doubts_find_range(const struct doubts_tally *tally, struct doubts_range *range)
{
    *range = tally->range;
}

/* ---- kinds ----------------------------------------------------------------------- */

static double ray_length(const struct doubts_tally *tally, int32_t x, int32_t y)
{
    const struct rf_lens *lens = &tally->lens;
    const double f = lens->focal_length_px;
    const double dx = (x + 0.5 - lens->principal_px[0]) / f;
    const double dy =
        (y + 0.5 - lens->principal_px[1]) / (f * tally->params->pixel_aspect);
    return sqrt(1 + dx * dx + dy * dy);
}

static double bend(const double u[3])
{
    return fabs(u[0] - 2 * u[1] + u[2]) / fmax(fabs(u[1] - u[0]), fabs(u[2] - u[1]));
}

/* Are the numbers between a near and a far end? */
static bool has_ends(const struct doubts_tally *tally)
{
    const int32_t kind = tally->params->depth;
    return kind == RF_DEPTH_NORMALISED || kind == RF_DEPTH_BUFFER ||
           kind == RF_DEPTH_BUFFER_REVERSED;
}

/* Distance, and the one where near and far are swapped. */
static void find_distances(const struct doubts_tally *tally, double number,
                           double distance[2])
{
    const struct rf_params *p = tally->params;
    const double v = number * p->depth_scale + p->depth_offset;
    const double deep = p->depth_far - p->depth_near;
    distance[0] = has_ends(tally) ? p->depth_near + v * deep : v;
    distance[1] = p->depth_near + (1 - v) * deep;
}

/* What a flat surface makes a straight line of, of each kind. */
static void straighten(const struct doubts_tally *tally, double number, int32_t x,
                       int32_t y, double u[DOUBTS_N_KINDS])
{
    double distance[2];
    find_distances(tally, number, distance);
    const double m = ray_length(tally, x, y);
    u[DOUBTS_PLANAR] = 1 / distance[0];
    u[DOUBTS_INVERSE] = number;
    u[DOUBTS_RADIAL] = m / distance[0];
    u[DOUBTS_SWAPPED] = 1 / distance[1];
    u[DOUBTS_SWAPPED_RADIAL] = m / distance[1];
}

/* The kind that is straight alone; -1: none is. A line that is straight to the last bit is
 * so by chance, of numbers that were rounded. */
static int alone_of(const double bends[], int n, double clearly)
{
    int best = 0;
    double next = INFINITY;
    for (int k = 1; k < n; k++)
        best = bends[k] < bends[best] ? k : best;
    for (int k = 0; k < n; k++)
        next = k == best ? next : fmin(next, bends[k]);
    return bends[best] > 0 && bends[best] < clearly * next ? best : -1;
}

/* Is something seen there that is not at the far end? */
static bool is_seen(const struct doubts_tally *tally, float z)
{
    const struct rf_params *p = tally->params;
    return is_hit(tally, z) &&
           (!has_ends(tally) || (double)z * p->depth_scale + p->depth_offset < 1);
}

/* Looks at a place and its neighbours at -(dx, dy) and (dx, dy). */
static void add_triple(struct doubts_tally *tally, const struct place *place,
                       int32_t dx, int32_t dy, struct doubts_kinds *kinds)
{
    const struct measure *measure = tally->measure;
    const int n_kinds = has_ends(tally) ? DOUBTS_N_KINDS : DOUBTS_SWAPPED;
    double u[3][DOUBTS_N_KINDS], lines[DOUBTS_N_KINDS][3], bends[DOUBTS_N_KINDS];
    for (int32_t i = -1; i <= 1; i++) {
        const float z = place->depth[i * (dx + (ptrdiff_t)dy * tally->width)];
        if (!is_seen(tally, z))
            return;
        straighten(tally, (double)z, place->x + i * dx, place->y + i * dy, u[i + 1]);
    }
    for (int k = 0; k < n_kinds; k++) {
        for (int i = 0; i < 3; i++)
            lines[k][i] = u[i][k];
        bends[k] = bend(lines[k]);
    }
    const double *line = lines[DOUBTS_PLANAR];
    const double slope = fmax(fabs(line[1] / line[0] - 1), fabs(line[1] / line[2] - 1));
    double least = INFINITY;
    for (int k = 0; k < n_kinds; k++)
        least = fmin(least, bends[k]);
    if (!(slope > measure->least_slope && slope < measure->most_slope &&
          least < measure->straight))
        return;
    const int alone = alone_of(bends, n_kinds, measure->clearly);
    kinds->n++;
    if (alone >= 0)
        kinds->n_alone[alone]++;
}

static void add_triples(struct doubts_tally *tally, const struct place *place)
{
    const int32_t row = place->y - place->rows->first;
    if (tally->lens.projection == RF_PROJECTION_ORTHOGRAPHIC)
        return;
    for (int i = 0; i < DOUBTS_N_STEPS && tally->step_px[i] > 0; i++) {
        const int32_t step = tally->step_px[i];
        if (place->x >= step && place->x + step < tally->width)
            add_triple(tally, place, step, 0, &tally->kinds[i]);
        if (row >= step && row + step < place->rows->n)
            add_triple(tally, place, 0, step, &tally->kinds[i]);
    }
}

void doubts_find_kinds(const struct doubts_tally *tally,
                       struct doubts_kinds kinds[DOUBTS_N_STEPS])
{
    memcpy(kinds, tally->kinds, sizeof(tally->kinds));
}

bool doubts_find_size(const struct doubts_tally *tally, int32_t *width, int32_t *height)
{
    return tally->grid && depth_grid_find(tally->grid, width, height);
}

/* ---- all ------------------------------------------------------------------------- */

static void add_place(struct doubts_tally *tally, const struct place *place)
{
    if (!is_hit(tally, *place->depth))
        return;
    add_distance(tally, *place->depth);
    add_triples(tally, place);
}

void doubts_add(struct doubts_tally *tally, const struct doubts_rows *rows)
{
    const int32_t stride = tally->stride;
    int32_t y = (rows->first + stride - 1) / stride * stride;
    if (tally->grid)
        depth_grid_add(tally->grid, rows->depth, rows->n);
    for (; y < rows->first + rows->n; y += stride) {
        const float *row =
            rows->depth + (size_t)(y - rows->first) * (size_t)tally->width;
        /* Not the same columns on each row: things in a scene stand upright. */
        for (int32_t x = y / stride % stride; x < tally->width; x += stride)
            add_place(tally, &(struct place){rows, row + x, x, y});
    }
}
