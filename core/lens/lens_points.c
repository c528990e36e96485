/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Points of the lens for several views.
 *
 *   disc     radius sqrt((i + h) / n), angle g i + a             Vogel 1979
 *   ring     radius and angle of RINGS: the disc's and the polygon's two, three and
 *            four, where they are not random; not for the method accumulate, whose
 *            mean square radius must be the lens'                ours
 *   circle   radius 1, angle 2 pi i / n + a                      OpenGL wikibook
 *   polygon  with (rho, phi) of the disc and k + t = phi N / (2 pi), k whole:
 *            rho ((1 - t) C_k + t C_k+1)                         ours
 *   grid     (x, y) at random within cell i of the unit square, to the disc by
 *            Shirley and Chiu 1997, and on to the polygon as above
 *
 *   n    number of points, i = 0 .. n - 1
 *   g    golden angle, pi (3 - sqrt 5)
 *   h a  1/2 and 0; random per frame: h in [0, 1) and a in [0, 2 pi)
 *   C_k  corners of the aperture's polygon of N blades, rotation and ratio included
 *
 * An obstruction of the share o of the radius leaves the ring outside of it: a radius
 * rho is sqrt(o^2 + (1 - o^2) rho^2) then.
 *
 * Curved and hollow blades are polygons of more corners. The polygon's map keeps shares
 * of area: a point's radius says how much of the triangle (centre, C_k, C_k+1) lies nearer
 * to the centre, t cuts it lengthwise. The random numbers make each point's place uniform over
 * the lens, so that the mean over frames is that of the whole lens. The circle is a lens
 * that is all rim, as the source has it.
 *
 * Moments: every n-th part of the shutter's time belongs to one point, its middle or,
 * at random, any place of it. Of N_SHUFFLES ways to deal them out the one is taken in
 * which the time t goes least with the place: the smallest (sum t' u)^2 + (sum t' v)^2
 * + (sum t' (u^2 + v^2))^2, t' = t - 1/2. So no side of the lens belongs to a part of
 * the time.
 */
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "lens/aperture.h"
#include "lens/params.h"
#include "rackfocus/rackfocus.h"

#define GOLDEN_ANGLE 2.39996322972865332

enum { N_SHUFFLES = 64 };

/* ---- random numbers ------------------------------------------------------------ */

struct random {
    uint64_t state;
};

/* splitmix64 (Steele, Lea and Flood 2014), to [0, 1). */
static double draw(struct random *random)
{
    uint64_t z = random->state += 0x9E3779B97F4A7C15u;
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    z ^= z >> 31;
    return (double)(z >> 11) * 0x1p-53;
}

static struct random random_of(const struct rf_params *params, int32_t frame)
{
    uint64_t seed = (uint64_t)params->lens_seed << 32;
    return (struct random){seed + (params->lens_random ? (uint32_t)frame : 0)};
}

/* ---- patterns ------------------------------------------------------------------ */

struct pattern {
    int n;
    struct rf_shape shape;
    struct random random;
    double half, turn; /* h and a */
    double obstruction;
    bool is_hollow; /* its blades are */
};

/* A radius of the whole lens to what an obstruction leaves, in equal shares of area. */
static double open_radius(const struct pattern *p, double radius)
{
    double hidden = p->obstruction * p->obstruction;
    return hidden > 0 ? sqrt(hidden + (1 - hidden) * radius * radius) : radius;
}

/* A point of the disc, radius and angle, to the lens. */
static void put_on_disc(const struct pattern *p, double radius, double angle,
                        struct rf_lens_point *point)
{
    radius = open_radius(p, radius);
    point->u = radius * cos(angle) / p->shape.ratio;
    point->v = radius * sin(angle);
}

static void put_on_polygon(const struct pattern *p, double radius, double angle,
                           struct rf_lens_point *point)
{
    int n = p->shape.n_corners;
    radius = open_radius(p, radius);
    double turns = angle / (2 * RF_PI);
    double along = (turns - floor(turns)) * n;
    int k = rf_min_int((int)along, n - 1);
    double t = along - k;
    const double *from = p->shape.corner[k], *to = p->shape.corner[(k + 1) % n];
    point->u = radius * ((1 - t) * from[0] + t * to[0]);
    point->v = radius * ((1 - t) * from[1] + t * to[1]);
}

static void put_on_shape(const struct pattern *p, double radius, double angle,
                         struct rf_lens_point *point)
{
    (p->shape.is_disc ? put_on_disc : put_on_polygon)(p, radius, angle, point);
}

static void place_spiral(struct pattern *p, struct rf_lens_point *points)
{
    for (int i = 0; i < p->n; i++)
        put_on_shape(p, sqrt((i + p->half) / p->n), GOLDEN_ANGLE * i + p->turn,
                     &points[i]);
}

/*
 * Few points are nearest to the rest of the lens where the middles of its sectors are:
 * the mean square distance of three is 0.20 (the spiral's 0.25), of four 0.14 (0.19).
 * Two do best a little farther out. Their angles are askew, as most edges are upright
 * or level: four are evenly spaced along both axes. Two lie within any polygon.
 */
static const struct {
    double radius, angle;
} RINGS[] = {{0.5, RF_PI / 4}, {0.551, RF_PI / 12}, {0.6, -0.321750554396642193}};

enum { LEAST_OF_RING = 2, MOST_OF_RING = 4 };

static void place_ring(struct pattern *p, struct rf_lens_point *points)
{
    int kind = p->n - LEAST_OF_RING;
    for (int i = 0; i < p->n; i++)
        (p->n == LEAST_OF_RING && !p->is_hollow ? put_on_disc : put_on_shape)(
            p, RINGS[kind].radius, RINGS[kind].angle + 2 * RF_PI * i / p->n,
            &points[i]);
}

static void place_circle(struct pattern *p, struct rf_lens_point *points)
{
    for (int i = 0; i < p->n; i++)
        put_on_disc(p, 1, 2 * RF_PI * i / p->n + p->turn, &points[i]);
}

/* The unit square to the disc, squares to rings, areas kept. */
static void place_square(const struct pattern *p, double x, double y,
                         struct rf_lens_point *point)
{
    double a = 2 * x - 1, b = 2 * y - 1;
    if (a == 0 && b == 0)
        put_on_shape(p, 0, 0, point);
    else if (fabs(a) > fabs(b))
        put_on_shape(p, fabs(a), RF_PI / 4 * (b / a) + (a < 0 ? RF_PI : 0), point);
    else
        put_on_shape(p, fabs(b), RF_PI / 2 - RF_PI / 4 * (a / b) + (b < 0 ? RF_PI : 0),
                     point);
}

static void place_grid(struct pattern *p, struct rf_lens_point *points)
{
    int n_rows = (int)(sqrt((double)p->n) + 0.5);
    for (int row = 0; row < n_rows; row++) {
        int first = p->n * row / n_rows, end = p->n * (row + 1) / n_rows;
        for (int i = first; i < end; i++) {
            double x = (i - first + draw(&p->random)) / (end - first);
            double y = (first + (end - first) * draw(&p->random)) / p->n;
            place_square(p, x, y, &points[i]);
        }
    }
}

/* ---- moments ------------------------------------------------------------------- */

static void shuffle(struct random *random, int *order, int n)
{
    for (int i = 0; i < n; i++)
        order[i] = i;
    for (int i = n - 1; i > 0; i--) {
        int j = (int)(draw(random) * (i + 1)), kept = order[i];
        order[i] = order[j];
        order[j] = kept;
    }
}

/* How much the time goes with the place. */
static double tie(const struct rf_lens_point *points, const int *order, int n)
{
    double u = 0, v = 0, square = 0;
    for (int i = 0; i < n; i++) {
        const struct rf_lens_point *at = &points[i];
        double t = (order[i] + 0.5) / n - 0.5;
        u += t * at->u;
        v += t * at->v;
        square += t * (at->u * at->u + at->v * at->v);
    }
    return u * u + v * v + square * square;
}

static void place_in_time(const struct pattern *p, bool is_random,
                          struct rf_lens_point *points)
{
    int order[RF_MAX_LENS_POINTS], best[RF_MAX_LENS_POINTS];
    struct random deal = is_random ? p->random : (struct random){0};
    double least = INFINITY;
    for (int k = 0; k < N_SHUFFLES; k++) {
        shuffle(&deal, order, p->n);
        double value = tie(points, order, p->n);
        if (value < least) {
            least = value;
            memcpy(best, order, sizeof best);
        }
    }
    for (int i = 0; i < p->n; i++)
        points[i].time = (best[i] + (is_random ? draw(&deal) : 0.5)) / p->n;
}

/* ---- the whole ----------------------------------------------------------------- */

static rf_result check(const struct rf_params *params, int32_t n,
                       const struct rf_lens_point *points, struct rf_error *error)
{
    if (!points)
        return rf_fail(error, RF_ERROR_ARGUMENT, "points", "points is NULL");
    rf_result result = rf_params_check_ranges(params, error);
    if (result != RF_OK)
        return result;
    if (n < 2 || n > RF_MAX_LENS_POINTS)
        return rf_fail(error, RF_ERROR_PARAMETER, "n",
                       "%d points of the lens: 2 to %d can be had", n,
                       RF_MAX_LENS_POINTS);
    return RF_OK;
}

rf_result rf_lens_points(const struct rf_params *params, int32_t n, int32_t frame,
                         struct rf_lens_point *points, struct rf_error *error)
{
    rf_result result = check(params, n, points, error);
    if (result != RF_OK)
        return result;
    struct rf_params own;
    rf_params_complete(&own, params);
    if (own.lens_pattern == RF_LENS_PATTERN_DISC)
        own.aperture = RF_APERTURE_DISC;
    else if (own.lens_pattern == RF_LENS_PATTERN_POLYGON)
        own.aperture = RF_APERTURE_POLYGON;
    if (own.aperture == RF_APERTURE_POLYGON && own.blades < 3)
        return rf_fail(error, RF_ERROR_PARAMETER, "blades",
                       "a polygon of %d blades: give 3 to 16", own.blades);
    struct pattern p = {.n = n,
                        .half = 0.5,
                        .random = random_of(&own, frame),
                        .obstruction =
                            own.aperture == RF_APERTURE_IMAGE ? 0 : own.obstruction};
    rf_shape_init(&p.shape, &own);
    p.is_hollow = rf_shape_hollow_out(&p.shape, &own);
    if (own.lens_random) {
        p.half = draw(&p.random);
        p.turn = 2 * RF_PI * draw(&p.random);
    }
    if (own.lens_pattern == RF_LENS_PATTERN_CIRCLE)
        place_circle(&p, points);
    else if (own.lens_pattern == RF_LENS_PATTERN_GRID)
        place_grid(&p, points);
    else if (n <= MOST_OF_RING && !own.lens_random &&
             own.method != RF_METHOD_ACCUMULATE)
        place_ring(&p, points);
    else
        place_spiral(&p, points);
    place_in_time(&p, own.lens_random, points);
    return RF_OK;
}
