/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Of a flat surface 1 / z is a straight line across the picture, where z is planar
 * distance in a perspective: 1 / z = a + b x + c y. So is the number itself where it is
 * 1 / z already, and m / v where it is a distance v = m z along the ray of length
 * m = sqrt(1 + x^2 + y^2). How bent a line is between three places, PLACE_PX apart:
 *
 *   bend = abs(u1 - 2 u2 + u3) / max(abs(u2 - u1), abs(u3 - u2))
 *
 * Steps of colours are abs(a - b) / (a + b) of the luminances beside a place, which is
 * half of the step of their logarithm where it is small and at most 1 beside a lamp.
 */
#include "depth_doubts.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "luminance.h"

enum {
    MOST_PLACES = 60000, /* ratios of edges come out within 3 %: 0.1 % of a filter */
    STEPS_PER_PLACE = 8, /* memory for steps; edges of the finest foliage need 4 */
    PLACE_PX = 8         /* apart, so that a slope is well above the noise of floats */
};

/* Slopes, of the depth, between two places: below it rounding shows, above it lie other
 * things. On the references 20 to 60 % of the places have them. */
static const double LEAST_SLOPE = 2e-3, MOST_SLOPE = 0.2;

/* One kind fits alone if its bend is so much less than the others': of the references
 * 46 to 88 % of the places on flat things are of their kind then, none of another. */
static const double CLEARLY = 0.1;

/* Depth is in another unit than the focus, or nothing is in focus, from so many times it:
 * beyond, radii differ by 5 % at most, as bias (1 - focus / z) does. */
static const double FAR_FOCUSES = 20;

/* A step of the depth, (a - b) / (a + b): things one of which is a tenth farther. */
static const float STEP = 0.05f;

/* Of the white: a picture's blacks, whose steps are of rounding and grain. */
static const float BLACK = 1.0f / 128;

enum where { AT_EDGE, MIRRORED_X, MIRRORED_Y, ELSEWHERE, N_WHERE };

struct colour_step {
    float before, at, after; /* luminances of neighbours in a row */
    int32_t where;           /* enum where */
};

struct doubts_tally {
    const struct rf_params *params;
    struct rf_lens lens; /* the filter that it is from may be made anew */
    int32_t width, height, stride;
    struct doubts_range range;
    struct doubts_kinds kinds;
    struct colour_step *steps;
    size_t n_steps, room;
};

/* A place in the rows at hand. */
struct place {
    const struct doubts_rows *rows;
    const float *depth;
    int32_t x, y; /* y of the picture */
};

struct doubts_tally *doubts_create(const struct rf_params *params,
                                   const struct rf_lens *lens, int32_t width,
                                   int32_t height)
{
    struct doubts_tally *tally = malloc(sizeof(*tally));
    const double n = (double)width * height;
    const int32_t stride = (int32_t)fmax(ceil(sqrt(n / MOST_PLACES)), 1);
    const size_t room = STEPS_PER_PLACE * ((size_t)(width / stride) + 1) *
                        ((size_t)(height / stride) + 1);
    struct colour_step *steps = malloc(room * sizeof(*steps));
    if (!tally || !steps) {
        free(tally);
        free(steps);
        return NULL;
    }
    *tally = (struct doubts_tally){.params = params,
                                   .lens = *lens,
                                   .width = width,
                                   .height = height,
                                   .stride = stride,
                                   .range = {.nearest = INFINITY},
                                   .steps = steps,
                                   .room = room};
    return tally;
}

void doubts_free(struct doubts_tally *tally)
{
    if (tally)
        free(tally->steps);
    free(tally);
}

static bool is_hit(const struct doubts_tally *tally, float z)
{
    return z > 0 && isfinite(z) && z < tally->params->depth_infinity;
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

static double bend(double a, double b, double c)
{
    return fabs(a - 2 * b + c) / fmax(fabs(b - a), fabs(c - b));
}

/* A line that is straight to the last bit is so by chance, of numbers that were rounded. */
static bool is_alone(double bent, double other, double another)
{
    return bent > 0 && bent < CLEARLY * fmin(other, another);
}

/* Looks at a place and its neighbours at -(dx, dy) and (dx, dy). */
static void add_triple(struct doubts_tally *tally, const struct place *place,
                       int32_t dx, int32_t dy)
{
    const ptrdiff_t to = dx + (ptrdiff_t)dy * tally->width;
    const float a = place->depth[-to], b = place->depth[0], c = place->depth[to];
    const int32_t x = place->x, y = place->y;
    if (!is_hit(tally, a) || !is_hit(tally, c))
        return;
    const double slope = fmax(fabs((double)b - a), fabs((double)c - b)) / b;
    if (!(slope > LEAST_SLOPE && slope < MOST_SLOPE))
        return;
    struct doubts_kinds *kinds = &tally->kinds;
    const double inverse = bend(a, b, c), planar = bend(1.0 / a, 1.0 / b, 1.0 / c);
    const double radial =
        bend(ray_length(tally, x - dx, y - dy) / a, ray_length(tally, x, y) / b,
             ray_length(tally, x + dx, y + dy) / c);
    kinds->n++;
    kinds->n_planar += is_alone(planar, inverse, radial);
    kinds->n_inverse += is_alone(inverse, planar, radial);
    kinds->n_radial += is_alone(radial, planar, inverse);
}

static void add_triples(struct doubts_tally *tally, const struct place *place)
{
    const int32_t row = place->y - place->rows->first;
    if (tally->lens.projection == RF_PROJECTION_ORTHOGRAPHIC)
        return;
    if (place->x >= PLACE_PX && place->x + PLACE_PX < tally->width)
        add_triple(tally, place, PLACE_PX, 0);
    if (row >= PLACE_PX && row + PLACE_PX < place->rows->n)
        add_triple(tally, place, 0, PLACE_PX);
}

void doubts_find_kinds(const struct doubts_tally *tally, struct doubts_kinds *kinds)
{
    *kinds = tally->kinds;
}

/* ---- edges ----------------------------------------------------------------------- */

static bool is_edge(const struct doubts_tally *tally, float a, float b)
{
    const bool is_a = is_hit(tally, a), is_b = is_hit(tally, b);
    return is_a && is_b ? fabsf(a - b) > STEP * (a + b) : is_a != is_b;
}

static void add_step(struct doubts_tally *tally, const struct doubts_rows *rows,
                     int32_t x, int32_t y, enum where where)
{
    const int n = rows->n_channels;
    const size_t at = (size_t)(y - rows->first) * (size_t)tally->width + (size_t)x;
    const float *c = rows->colour + at * (size_t)n;
    if (tally->n_steps < tally->room)
        tally->steps[tally->n_steps++] =
            (struct colour_step){luminance_of(c - n, n), luminance_of(c, n),
                                 luminance_of(c + n, n), (int32_t)where};
}

static void add_edges(struct doubts_tally *tally, const struct doubts_rows *rows,
                      int32_t y)
{
    const int32_t width = tally->width;
    const float *z = rows->depth + (size_t)(y - rows->first) * (size_t)width;
    for (int32_t x = 1; x + 1 < width; x++) {
        if (z[x - 1] == z[x + 1] || !is_edge(tally, z[x - 1], z[x + 1]))
            continue;
        add_step(tally, rows, x, y, AT_EDGE);
        add_step(tally, rows, width - 1 - x, y, MIRRORED_X);
        if (rows->n == tally->height)
            add_step(tally, rows, x, tally->height - 1 - y, MIRRORED_Y);
    }
}

void doubts_find_edges(const struct doubts_tally *tally, struct doubts_edges *edges)
{
    double sums[N_WHERE] = {0}, second = 0;
    size_t n[N_WHERE] = {0};
    const float black = (float)tally->params->white * BLACK;
    for (size_t i = 0; i < tally->n_steps; i++) {
        const struct colour_step *step = &tally->steps[i];
        const float a = fmaxf(step->before, 0), b = fmaxf(step->at, 0);
        const float c = fmaxf(step->after, 0);
        if (!(a + c >= 2 * black && a + c < INFINITY))
            continue;
        n[step->where]++;
        sums[step->where] += fabsf(a - c) / (a + c);
        if (step->where == ELSEWHERE && b < INFINITY)
            second += 2 * fabsf(a + c - 2 * b) / (a + c + 2 * b);
    }
    double means[N_WHERE];
    for (int i = 0; i < N_WHERE; i++)
        means[i] = n[i] > 0 ? sums[i] / (double)n[i] : 0;
    const double other = fmax(means[ELSEWHERE], 1e-9);
    *edges = (struct doubts_edges){
        .n = n[AT_EDGE],
        .ratio = means[AT_EDGE] / other,
        .mirrored = {means[MIRRORED_X] / other, means[MIRRORED_Y] / other},
        .grain = second / fmax(sums[ELSEWHERE], 1e-9),
    };
}

/* ---- all ------------------------------------------------------------------------- */

static void add_place(struct doubts_tally *tally, const struct place *place)
{
    const float *z = place->depth;
    const int32_t x = place->x;
    if (is_hit(tally, *z)) {
        add_distance(tally, *z);
        add_triples(tally, place);
    }
    if (x >= 1 && x + 1 < tally->width && !is_edge(tally, z[-1], z[1]))
        add_step(tally, place->rows, x, place->y, ELSEWHERE);
}

void doubts_add(struct doubts_tally *tally, const struct doubts_rows *rows)
{
    const int32_t stride = tally->stride;
    int32_t y = (rows->first + stride - 1) / stride * stride;
    for (; y < rows->first + rows->n; y += stride) {
        const float *row =
            rows->depth + (size_t)(y - rows->first) * (size_t)tally->width;
        /* Not the same columns on each row: things in a scene stand upright. */
        for (int32_t x = y / stride % stride; x < tally->width; x += stride)
            add_place(tally, &(struct place){rows, row + x, x, y});
        add_edges(tally, rows, y);
    }
}
