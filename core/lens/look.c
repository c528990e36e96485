/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens looks that depend on the place (docs/looks.md).
 *
 * The pixel P gathers light through the lens points u of the aperture for which, with
 * q = q(P) its place and p = (ratio u, v),
 *
 *   |p - c q| <= 1                    cat's eyes, a second disc of the same size
 *   n . p >= b_n (n . q) - 1          a barn door on the side n of the picture
 *
 * and what it gathers from the depth of radius r has its image at x in the pinhole's
 * picture, with P = x + r M(q) u (v up):
 *
 *   M(q) = (1 + a |q|^2) e e' + (1 + s |q|^2) t t'     e = q / |q|, t across it
 *
 *   a  astigmatism, along the line from the centre; s  swirl, across it
 *
 * Where the surface in focus is tilted or bent, r is that of the pixel P, too: with g(q)
 * what the surface adds to radii, r + g(q(P)) - g(q(x)) for a sample of radius r.
 *
 * A sample knows x, not P: the corners of its footprint are where both hold, which
 * ROUNDS of putting P in on the right hand side find. A disc of the second kind stays a
 * disc, of radius 1 / (1 - c r / h) with h half of the diagonal in px.
 *
 * Beyond |q| = 1, where no pixel lies, M and g are those of the nearest place with
 * |q| = 1, so that no footprint is wider than |r| (1 + max(a, s, 0)).
 *
 * The rounds take the way left by L per round,
 *
 *   L = |r| / h |u| 2 (|a| + |s|) |q| + |M u| |grad g| / h      at the most
 *
 * and up to L = 1 one P only belongs to u. Where L > MOST_SLOPE the footprint is traced:
 * u is a plain function of P (rf_look_lens_point()).
 *
 * Ours; the second disc is the usual model of optical vignetting (docs/looks.md).
 */
#include "lens/look.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/math.h"
#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

enum { ROUNDS = 8, EYE_CORNERS = 96 };
/* Of rough shapes, which are compared with each other. */
enum { ROUGH_ROUNDS = 4, ROUGH_EYE_CORNERS = 24, ROUGH_DISC_CORNERS = 32 };

/* Less of a lens is nothing. */
static const double LEAST_SHARE = 1e-4;

/* Regular polygons have the area of their disc when their corners lie that far out. */
static double corner_of_area(int n_corners)
{
    double angle = 2 * RF_PI / n_corners;
    return sqrt(angle / sin(angle));
}

struct rf_look rf_look_make(const struct rf_params *p, int width, int height)
{
    struct rf_look look = {
        .centre = {width / 2.0, height / 2.0},
        .half_px = rf_length(width, height / p->pixel_aspect) / 2,
        .pixel_aspect = p->pixel_aspect,
        .ratio = p->aperture_ratio,
        .cat_eye = p->cat_eye,
        .astigmatism = p->astigmatism,
        .swirl = p->swirl,
        .door = {p->barn_left, p->barn_right, p->barn_top, p->barn_bottom},
    };
    return look;
}

static bool has_doors(const struct rf_look *look)
{
    for (int i = 0; i < RF_N_DOORS; i++)
        if (look->door[i] > 0)
            return true;
    return false;
}

bool rf_look_is_dark(const struct rf_look *look)
{
    return look->cat_eye > 0 || has_doors(look);
}

struct rf_look rf_look_bright(const struct rf_look *look)
{
    struct rf_look bright = *look;
    bright.cat_eye = 0;
    bright.is_measured = true;
    memset(bright.door, 0, sizeof bright.door);
    return bright;
}

/* Does the radius depend on the pixel? */
static bool is_bent(const struct rf_look *look)
{
    return look->slope[0] != 0 || look->slope[1] != 0 || look->bend != 0;
}

bool rf_look_is_scaled(const struct rf_look *look)
{
    return look->astigmatism == 0 && look->swirl == 0 && !is_bent(look);
}

bool rf_look_is_on(const struct rf_look *look)
{
    return rf_look_is_dark(look) || !rf_look_is_scaled(look);
}

double rf_look_growth(const struct rf_look *look)
{
    return 1 + fmax(fmax(look->astigmatism, look->swirl), 0);
}

/* The place where M and g are taken for q. */
static void clip_place(const double q[2], double to[2])
{
    double q2 = q[0] * q[0] + q[1] * q[1];
    double scale = q2 > 1 ? 1 / sqrt(q2) : 1;
    for (int k = 0; k < 2; k++)
        to[k] = q[k] * scale;
}

/* M(q) u. */
static void stretch(const struct rf_look *look, const double q[2], const double u[2],
                    double out[2])
{
    double q2 = q[0] * q[0] + q[1] * q[1];
    if (q2 == 0) {
        memcpy(out, u, 2 * sizeof *u);
        return;
    }
    double along = (q[0] * u[0] + q[1] * u[1]) / q2;
    double across = (q[0] * u[1] - q[1] * u[0]) / q2;
    along *= 1 + look->astigmatism * q2;
    across *= 1 + look->swirl * q2;
    out[0] = along * q[0] - across * q[1];
    out[1] = along * q[1] + across * q[0];
}

/* The radius by which a sample at q of radius r reaches the pixel's place `to`. */
static double radius_to(const struct rf_look *look, const double q[2], double r,
                        const double to[2])
{
    if (!is_bent(look))
        return r;
    double step = to[0] * to[0] + to[1] * to[1] - q[0] * q[0] - q[1] * q[1];
    double to_px = r + look->slope[0] * (to[0] - q[0]) +
                   look->slope[1] * (to[1] - q[1]) + look->bend * step;
    return fmin(fmax(to_px, -look->most_px), look->most_px);
}

/* The pixel's place that a sample at q of radius r reaches through the lens point u. */
static void reach(const struct rf_look *look, const double q[2], double r,
                  const double u[2], double out[2])
{
    double at[2], seen[2];
    clip_place(out, seen);
    double size = radius_to(look, q, r, seen) / look->half_px;
    stretch(look, seen, u, at);
    for (int k = 0; k < 2; k++)
        out[k] = q[k] + at[k] * size;
}

static int rounds_of(const struct rf_look *look)
{
    return look->is_rough ? ROUGH_ROUNDS : ROUNDS;
}

/* Where the footprint of radius 1 has the lens point u. */
static void map_point(const struct rf_look *look, const double q[2], double r,
                      const double u[2], double out[2])
{
    double to[2] = {q[0], q[1]};
    for (int i = 0; i < rounds_of(look) && r != 0; i++)
        reach(look, q, r, u, to);
    if (r != 0)
        clip_place((double[2]){to[0], to[1]}, to);
    stretch(look, to, u, out);
    for (int k = 0; k < 2 && r != 0; k++)
        out[k] *= radius_to(look, q, r, to) / r;
}

/*
 * What the second disc's size is divided by along an axis: 1 - c r / h where pixels
 * look through p, which follows the pixel.
 */
static double eye_scale(const struct rf_look *look, double r, int axis)
{
    return 1 - look->cat_eye * r / look->half_px / (axis ? 1 : look->ratio);
}

/* The lens point on the second disc's rim in direction (cos, sin) of `rim`. */
static void eye_point(const struct rf_look *look, const double q[2], double r,
                      const double rim[2], double out[2])
{
    bool is_plain = rf_look_is_scaled(look);
    double to[2] = {q[0], q[1]};
    for (int i = 0; i < (is_plain || r == 0 ? 1 : rounds_of(look)); i++) {
        if (i > 0)
            reach(look, q, r, out, to);
        for (int k = 0; k < 2; k++) {
            double beside = i > 0 ? to[k] - out[k] * r / look->half_px : q[k];
            double p = (rim[k] + look->cat_eye * beside) / eye_scale(look, r, k);
            out[k] = k ? p : p / look->ratio;
        }
    }
}

/* Keeps what is seen through the second disc. */
static void cut_eye(const struct rf_look *look, const double q[2], double r,
                    struct rf_shape *shape)
{
    static const double LEAST = 0.02; /* the disc is 50 times the aperture */
    const int n_corners = look->is_rough ? ROUGH_EYE_CORNERS : EYE_CORNERS;
    double first[2], from[2], to[2] = {0}, out = corner_of_area(n_corners);
    if (eye_scale(look, r, 0) * eye_scale(look, r, 1) < LEAST * LEAST)
        return;
    for (int i = 0; i <= n_corners && shape->n_corners > 0; i++) {
        double angle = 2 * RF_PI * i / n_corners;
        const double rim[2] = {out * cos(angle), out * sin(angle)};
        if (i < n_corners)
            eye_point(look, q, r, rim, to);
        else
            memcpy(to, first, sizeof to);
        if (i == 0)
            memcpy(first, to, sizeof first);
        else
            rf_shape_cut(shape, (double[2]){to[1] - from[1], from[0] - to[0]},
                         (to[1] - from[1]) * from[0] + (from[0] - to[0]) * from[1]);
        memcpy(from, to, sizeof from);
    }
}

/* Keeps what a door lets through: n . p (1 - b r / h) >= b n . q - 1 without M. */
static void cut_doors(const struct rf_look *look, const double q[2], double r,
                      struct rf_shape *shape)
{
    static const double side[RF_N_DOORS][2] = {{-1, 0}, {1, 0}, {0, 1}, {0, -1}};
    for (int i = 0; i < RF_N_DOORS; i++) {
        double b = look->door[i], size = i < RF_DOOR_TOP ? look->ratio : 1;
        double least = b * (side[i][0] * q[0] + side[i][1] * q[1]) - 1;
        double k = size - b * r / look->half_px;
        if (b > 0)
            rf_shape_cut(shape, (double[2]){-side[i][0] * k, -side[i][1] * k}, -least);
    }
}

/* Cuts long edges, which bend where the look moves them. */
static void cut_edges(const struct rf_look *look, struct rf_shape *shape)
{
    const double most = look->is_rough ? 0.3 : 0.1;
    double corner[RF_MAX_CORNERS][2];
    int n = shape->n_corners, left = RF_MAX_CORNERS - n, n_cut = 0;
    memcpy(corner, shape->corner, (size_t)n * sizeof *corner);
    for (int i = 0; i < n; i++) {
        const double *a = corner[i], *b = corner[i + 1 < n ? i + 1 : 0];
        int n_parts = (int)(rf_length(b[0] - a[0], b[1] - a[1]) / most) + 1;
        n_parts = rf_min_int(n_parts, left + 1);
        left -= n_parts - 1;
        for (int part = 0; part < n_parts; part++, n_cut++)
            for (int k = 0; k < 2; k++)
                shape->corner[n_cut][k] = a[k] + (b[k] - a[k]) * part / n_parts;
    }
    shape->n_corners = n_cut;
}

static void map_corners(const struct rf_look *look, const double q[2], double r,
                        struct rf_shape *shape)
{
    if (rf_look_is_scaled(look))
        return;
    cut_edges(look, shape);
    for (int i = 0; i < shape->n_corners; i++) {
        double u[2] = {shape->corner[i][0], shape->corner[i][1]};
        map_point(look, q, r, u, shape->corner[i]);
    }
}

/* Back from points of the whole lens to the shape's own. */
static void recentre(const double origin[2], struct rf_shape *shape, double centroid[2])
{
    rf_shape_area(shape, centroid);
    shape->size[0] = shape->size[1] = 0;
    for (int i = 0; i < shape->n_corners; i++)
        for (int k = 0; k < 2; k++) {
            shape->corner[i][k] -= centroid[k];
            shape->size[k] = fmax(shape->size[k], fabs(shape->corner[i][k]));
        }
    shape->min_lines = rf_shape_min_lines(shape->size[1]);
    for (int k = 0; k < 2; k++)
        centroid[k] -= origin[k];
}

/* Leaves ROUGH_DISC_CORNERS of a disc's. */
static void thin_corners(struct rf_shape *shape)
{
    static const int STEP = RF_DISC_CORNERS / ROUGH_DISC_CORNERS;
    shape->n_corners = ROUGH_DISC_CORNERS;
    for (int i = 0; i < shape->n_corners; i++)
        memcpy(shape->corner[i], shape->corner[STEP * i], sizeof shape->corner[i]);
}

/* The aperture in points of the whole lens; its area is right where that is asked for. */
static void set_whole(const struct rf_look *look, const struct rf_shape *whole,
                      struct rf_shape *shape)
{
    double out = 1;
    *shape = *whole;
    if (whole->is_disc && look->is_rough)
        thin_corners(shape);
    if (whole->is_disc && (rf_look_is_dark(look) || look->is_measured))
        out = corner_of_area(shape->n_corners);
    shape->is_disc = false;
    shape->is_cut = true;
    for (int i = 0; i < shape->n_corners; i++)
        for (int k = 0; k < 2; k++)
            shape->corner[i][k] = out * shape->corner[i][k] + whole->origin[k];
}

/* The same, and what is cut out of it. */
static double cut_all(const struct rf_look *look, const struct rf_shape *whole,
                      const double q[2], double r, struct rf_shape *shape)
{
    double middle[2];
    set_whole(look, whole, shape);
    double area = rf_shape_area(shape, middle);
    if (look->cat_eye > 0)
        cut_eye(look, q, r, shape);
    cut_doors(look, q, r, shape);
    double share = rf_shape_area(shape, middle) / area;
    return share > LEAST_SHARE ? fmin(share, 1) : 0;
}

double rf_look_shape(const struct rf_look *look, const struct rf_shape *whole,
                     const double q[2], double r, struct rf_shape *shape,
                     double centroid[2])
{
    double share = cut_all(look, whole, q, r, shape);
    if (share == 0) {
        const struct rf_look bright = rf_look_bright(look);
        cut_all(&bright, whole, q, r, shape);
    }
    map_corners(look, q, r, shape);
    recentre(whole->origin, shape, centroid);
    return share;
}

/* ---- traced footprints --------------------------------------------------------- */

/* By which a sample at q of radius r is seen at the most. */
static double most_radius(const struct rf_look *look, const double q[2], double r)
{
    if (!is_bent(look))
        return fabs(r);
    double away = 1 + rf_length(q[0], q[1]);
    double more = rf_length(look->slope[0], look->slope[1]) * away +
                  fabs(look->bend) * away * away;
    return fmin(fabs(r) + more, fmax(look->most_px, fabs(r)));
}

/* The length of the lens' farthest point from its middle, at the most. */
static double lens_reach(const struct rf_shape *whole)
{
    return rf_length(fabs(whole->origin[0]) + whole->size[0],
                     fabs(whole->origin[1]) + whole->size[1]);
}

double rf_look_bound_px(const struct rf_look *look, const struct rf_shape *whole,
                        const double q[2], double r)
{
    return most_radius(look, q, r) * lens_reach(whole) * rf_look_growth(look);
}

bool rf_look_is_folded(const struct rf_look *look, const struct rf_shape *whole,
                       const double q[2], double r)
{
    static const double MOST_SLOPE = 0.25; /* from 0.28 on shapes are wrong by 2.2 % */
    if (rf_look_is_scaled(look) || r == 0)
        return false;
    double bound = rf_look_bound_px(look, whole, q, r) / look->half_px;
    double away = fmin(rf_length(q[0], q[1]) + bound, 1), wide = lens_reach(whole);
    double of_place = 2 * (fabs(look->astigmatism) + fabs(look->swirl)) * away *
                      most_radius(look, q, r) * wide;
    double bent =
        (rf_length(look->slope[0], look->slope[1]) + 2 * fabs(look->bend) * away) *
        wide * rf_look_growth(look);
    return (of_place + bent) / look->half_px > MOST_SLOPE;
}

/* M(q)^-1 v. */
static void shrink(const struct rf_look *look, const double q[2], const double v[2],
                   double out[2])
{
    double q2 = q[0] * q[0] + q[1] * q[1];
    if (q2 == 0) {
        memcpy(out, v, 2 * sizeof *v);
        return;
    }
    double along = (q[0] * v[0] + q[1] * v[1]) / (q2 * (1 + look->astigmatism * q2));
    double across = (q[0] * v[1] - q[1] * v[0]) / (q2 * (1 + look->swirl * q2));
    out[0] = along * q[0] - across * q[1];
    out[1] = along * q[1] + across * q[0];
}

double rf_look_lens_at(const struct rf_look *look, const double q[2], double r,
                       const double at[2], double u[2])
{
    double to[2], seen[2];
    for (int k = 0; k < 2; k++)
        to[k] = q[k] + at[k] * r / look->half_px;
    clip_place(to, seen);
    double to_px = radius_to(look, q, r, seen),
           size = r != 0 && to_px != 0 ? to_px / r : 1;
    double q2 = seen[0] * seen[0] + seen[1] * seen[1];
    shrink(look, seen, at, u);
    for (int k = 0; k < 2; k++)
        u[k] /= size;
    return 1 /
           (fabs(size) * sqrt((1 + look->astigmatism * q2) * (1 + look->swirl * q2)));
}

/* Do the second disc and the doors let the lens point u through to the place q? */
static bool is_let_through(const struct rf_look *look, const double q[2],
                           const double u[2])
{
    const double p[2] = {look->ratio * u[0], u[1]};
    double beside[2] = {p[0] - look->cat_eye * q[0], p[1] - look->cat_eye * q[1]};
    if (look->cat_eye > 0 && rf_length(beside[0], beside[1]) > 1)
        return false;
    for (int i = 0; i < RF_N_DOORS; i++) {
        double side = i == RF_DOOR_RIGHT || i == RF_DOOR_TOP ? 1 : -1;
        double b = look->door[i], at = side * (p[i / 2] - b * q[i / 2]);
        if (b > 0 && at < -1)
            return false;
    }
    return true;
}

bool rf_look_lens_point(const struct rf_look *look, const struct rf_shape *whole,
                        const double q[2], double r, const double to[2], double u[2])
{
    double seen[2];
    clip_place(to, seen);
    double size = radius_to(look, q, r, seen) / look->half_px;
    if (size == 0)
        return false;
    const double way[2] = {(to[0] - q[0]) / size, (to[1] - q[1]) / size};
    shrink(look, seen, way, u);
    return rf_shape_contains(whole, u[0] - whole->origin[0], u[1] - whole->origin[1]) &&
           is_let_through(look, seen, u);
}

/* The radius of a disc around the lens' middle that is open everywhere. */
static double open_radius(const struct rf_look *look, const struct rf_shape *whole)
{
    double radius = INFINITY;
    if (rf_look_is_dark(look))
        return 0;
    if (whole->is_disc)
        radius = fmin(1, 1 / whole->ratio);
    for (int i = 0; i < whole->n_corners && !whole->is_disc; i++) {
        const double *a = whole->corner[i];
        const double *b = whole->corner[(i + 1) % whole->n_corners];
        double along[2] = {b[0] - a[0], b[1] - a[1]};
        double length = rf_length(along[0], along[1]);
        radius = fmin(radius, (along[1] * a[0] - along[0] * a[1]) / length);
    }
    return fmax(radius - rf_length(whole->origin[0], whole->origin[1]), 0);
}

struct rf_look_limits rf_look_limits_make(const struct rf_look *look,
                                          const struct rf_shape *whole)
{
    return (struct rf_look_limits){.reach = lens_reach(whole),
                                   .open = open_radius(look, whole)};
}

enum rf_look_lit rf_look_lit_in(const struct rf_look *look,
                                const struct rf_look_limits *limits, const double q[2],
                                double r, const double to[2], double away)
{
    static const double SAFE = 1e-6; /* of a radius: far above what is rounded */
    double seen[2], way = rf_length(to[0] - q[0], to[1] - q[1]);
    clip_place(to, seen);
    double out = fmin(rf_length(seen[0], seen[1]) + away, 1), out2 = out * out;
    double slope =
        rf_length(look->slope[0], look->slope[1]) + 2 * fabs(look->bend) * out;
    double size = fabs(radius_to(look, q, r, seen)) / look->half_px;
    double more = slope * away / look->half_px + SAFE * size;
    double most = 1 + fmax(fmax(look->astigmatism, look->swirl), 0) * out2;
    double least = 1 + fmin(fmin(look->astigmatism, look->swirl), 0) * out2;
    if (way - away > limits->reach * most * (size + more))
        return RF_LIT_NOWHERE;
    return least > 0 && way + away < limits->open * least * (size - more)
               ? RF_LIT_EVERYWHERE
               : RF_LIT_SOMEWHERE;
}

/* ---- light --------------------------------------------------------------------- */

/*
 * Of two discs of radius 1 whose middles are d apart, the share that both cover: 4 / pi
 * times the integral of sqrt(1 - x^2) from d / 2 to 1, with x = 1 - t^2, by Gauss and
 * Legendre (8 points: within 1e-7).
 */
static double lens_share(double d)
{
    static const double at[4] = {0.1834346424956498, 0.5255324099163290,
                                 0.7966664774136267, 0.9602898564975363};
    static const double weight[4] = {0.3626837833783620, 0.3137066458778873,
                                     0.2223810344533745, 0.1012285362903763};
    double half = d < 2 ? sqrt(1 - d / 2) / 2 : 0, sum = 0;
    for (int i = 0; i < 8; i++) {
        double t = half * (1 + (i % 2 ? at[i / 2] : -at[i / 2]));
        sum += weight[i / 2] * 2 * t * t * sqrt(2 - t * t);
    }
    return sum * half * 4 / RF_PI;
}

/* ---- what is open ----------------------------------------------------------------- */

struct rf_look_opening rf_look_opening_at(const struct rf_look *look, const double q[2],
                                          double r)
{
    static const double LEAST = 1e-9; /* less is a line, or all of the plane */
    static const double side[RF_N_DOORS][2] = {{-1, 0}, {1, 0}, {0, 1}, {0, -1}};
    static const double unit[2][2] = {{1, 0}, {0, 1}};
    struct rf_look_opening open = {.has_eye = look->cat_eye > 0};
    double at[2], seen[2], lens[2][2] = {{look->ratio, 0}, {0, 1}}, moved[2][2];
    clip_place(q, seen);
    for (int k = 0; k < 2; k++) {
        stretch(look, seen, unit[k], at);
        for (int i = 0; i < 2; i++)
            moved[i][k] = at[i] * r / look->half_px;
    }
    for (int i = 0; i < 2; i++) {
        open.middle[i] = look->cat_eye * q[i];
        for (int k = 0; k < 2; k++)
            open.eye[i][k] = lens[i][k] - look->cat_eye * moved[i][k];
    }
    open.scale = open.eye[0][0] * open.eye[1][1] - open.eye[0][1] * open.eye[1][0];
    if (fabs(open.scale) < LEAST) {
        open.eye[0][0] += sqrt(LEAST);
        open.eye[1][1] += sqrt(LEAST);
        open.scale = open.eye[0][0] * open.eye[1][1] - open.eye[0][1] * open.eye[1][0];
    }
    for (int i = 0; i < RF_N_DOORS; i++) {
        double b = look->door[i], *normal = open.normal[open.n_doors];
        if (b <= 0)
            continue;
        for (int k = 0; k < 2; k++)
            normal[k] = -side[i][0] * (lens[0][k] - b * moved[0][k]) -
                        side[i][1] * (lens[1][k] - b * moved[1][k]);
        open.limit[open.n_doors++] = 1 - b * (side[i][0] * q[0] + side[i][1] * q[1]);
    }
    return open;
}

/* Of the triangle of a, b and the middle of a disc of radius 1, the area in the disc;
 * negative where b is to the right of a. */
static double triangle_in_disc(const double a[2], const double b[2])
{
    double way[2] = {b[0] - a[0], b[1] - a[1]};
    double cross = a[0] * b[1] - a[1] * b[0];
    double length2 = way[0] * way[0] + way[1] * way[1];
    double along = -(a[0] * way[0] + a[1] * way[1]); /* of the foot, times length2 */
    double rest = length2 - cross * cross;           /* of half the chord, squared */
    if (length2 == 0)
        return 0;
    double half = rest > 0 ? sqrt(rest) : 0;
    double from = fmax((along - half) / length2, 0),
           to = fmin((along + half) / length2, 1);
    if (from == 0 && to == 1)
        return cross / 2;
    if (!(from < to)) /* all of it is outside */
        return atan2(cross, a[0] * b[0] + a[1] * b[1]) / 2;
    const double in[2] = {a[0] + from * way[0], a[1] + from * way[1]};
    const double out[2] = {a[0] + to * way[0], a[1] + to * way[1]};
    return (atan2(a[0] * in[1] - a[1] * in[0], a[0] * in[0] + a[1] * in[1]) +
            cross * (to - from) +
            atan2(out[0] * b[1] - out[1] * b[0], out[0] * b[0] + out[1] * b[1])) /
           2;
}

/* The area of a polygon that the second disc leaves. */
static double area_in_eye(const struct rf_look_opening *open,
                          const struct rf_shape *shape)
{
    double at[2][2], area = 0;
    for (int i = 0; i <= shape->n_corners; i++) {
        const double *u = shape->corner[i < shape->n_corners ? i : 0];
        for (int k = 0; k < 2; k++)
            at[i % 2][k] =
                open->eye[k][0] * u[0] + open->eye[k][1] * u[1] - open->middle[k];
        if (i > 0)
            area += triangle_in_disc(at[(i + 1) % 2], at[i % 2]);
    }
    return area / open->scale;
}

/* The area that a disc of radius 1 and one of radius r share whose middles are d apart,
 * in parts of the first. */
static double discs_share(double r, double d)
{
    if (d >= 1 + r)
        return 0;
    if (d <= fabs(1 - r))
        return fmin(r * r, 1);
    double first = (d * d + 1 - r * r) / (2 * d), chord = 1 - first * first;
    double second = (d - first) / r, high = sqrt(fmax(chord, 0));
    return (acos(fmin(fmax(first, -1), 1)) + r * r * acos(fmin(fmax(second, -1), 1)) -
            d * high) /
           RF_PI;
}

/* A disc that doors alone cut is the second disc of a square without bounds. */
static void swap_disc(const struct rf_look *look, struct rf_shape *shape,
                      struct rf_look_opening *open)
{
    static const double FAR = 2;
    open->has_eye = true;
    open->eye[0][0] = open->scale = look->ratio;
    open->eye[0][1] = open->eye[1][0] = open->middle[0] = open->middle[1] = 0;
    open->eye[1][1] = 1;
    shape->n_corners = 4;
    for (int i = 0; i < 4; i++) {
        shape->corner[i][0] = (i == 0 || i == 3 ? FAR : -FAR) / look->ratio;
        shape->corner[i][1] = i < 2 ? FAR : -FAR;
    }
}

double rf_look_open_near(const struct rf_look *look, const struct rf_shape *whole,
                         const double q[2], double r)
{
    struct rf_shape shape;
    double middle[2], scale = fabs(1 - look->cat_eye * r / look->half_px);
    if (!rf_look_is_dark(look))
        return 1;
    if (whole->is_disc && !has_doors(look)) {
        double d = look->cat_eye * rf_length(q[0], q[1]);
        if (r == 0)
            return lens_share(d);
        if (look->ratio == 1 && rf_look_is_scaled(look) && scale > 1e-6)
            return discs_share(1 / scale, d / scale);
    }
    struct rf_look_opening open = rf_look_opening_at(look, q, r);
    set_whole(look, whole, &shape);
    double area = rf_shape_area(&shape, middle);
    if (whole->is_disc && !open.has_eye)
        swap_disc(look, &shape, &open);
    for (int i = 0; i < open.n_doors; i++)
        rf_shape_cut(&shape, open.normal[i], open.limit[i]);
    double left =
        open.has_eye ? area_in_eye(&open, &shape) : rf_shape_area(&shape, middle);
    return fmin(fmax(left / area, 0), 1);
}

double rf_look_open(const struct rf_look *look, const struct rf_shape *whole,
                    const double q[2], double r)
{
    struct rf_shape shape;
    double centroid[2];
    if (rf_look_is_scaled(look)) {
        double share = rf_look_open_near(look, whole, q, r);
        return share > LEAST_SHARE ? share : 0;
    }
    double share = rf_look_shape(look, whole, q, r, &shape, centroid);
    if (share == 0 || !rf_look_is_dark(look))
        return share;
    double left = rf_shape_area(&shape, centroid);
    const struct rf_look bright = rf_look_bright(look);
    rf_look_shape(&bright, whole, q, r, &shape, centroid);
    return fmin(left / rf_shape_area(&shape, centroid), 1);
}
