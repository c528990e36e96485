/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Apertures. A new one is one function here and one line in the list below and in
 * RF_LIST_APERTURE.
 *
 * Every shape fits the unit circle: its corner radius is the lens radius, as in Cycles.
 * Rotation comes first, then `aperture_ratio` divides u. A sample with signed radius r
 * lands at (x + u r, y - v r), so shapes turn over by themselves before the focus.
 */
#include "lens/aperture.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/math.h"
#include "rackfocus/rackfocus.h"

enum { MIN_LINES = 64, MIN_LINES_OF_PART = 16 };

typedef void (*shape_fn)(struct rf_shape *shape, const struct rf_params *params);

static void put_corner(struct rf_shape *shape, int i, double angle)
{
    shape->corner[i][0] = cos(angle);
    shape->corner[i][1] = sin(angle);
}

static void shape_disc(struct rf_shape *shape, const struct rf_params *params)
{
    shape->is_disc = true;
    shape->n_corners = RF_DISC_CORNERS;
    for (int i = 0; i < shape->n_corners; i++)
        put_corner(shape, i, 2 * RF_PI * i / shape->n_corners);
}

/* Cycles: the middle of an edge at the rotation; POV-Ray: a corner. Both measured. */
static double first_corner(const struct rf_params *params)
{
    double turn = params->blade_rotation * RF_PI / 180;
    bool is_edge = params->blade_orientation == RF_ORIENTATION_CYCLES;
    return turn + (is_edge ? RF_PI / params->blades : 0);
}

/*
 * Blades whose edges are arcs of circles through the corners, of sagitta c (1 - cos a)
 * and half chord sin a, a = pi / blades: c = 0 is straight, 1 the unit circle. As a
 * polygon of as many corners as a disc has, the area is off by less than 0.1 %.
 */
static void shape_curved(struct rf_shape *shape, const struct rf_params *params)
{
    int n = params->blades, n_arc = RF_DISC_CORNERS / n;
    double a = RF_PI / n, sagitta = params->blade_curvature * (1 - cos(a));
    double radius = (sin(a) * sin(a) + sagitta * sagitta) / (2 * sagitta);
    double middle = cos(a) + sagitta - radius; /* of the arc's circle, along its edge */
    double half = atan2(sin(a), cos(a) - middle);
    shape->n_corners = n * n_arc;
    for (int i = 0; i < shape->n_corners; i++) {
        int blade = i / n_arc;
        double turn = first_corner(params) + a + 2 * a * blade;
        double at = half * (2.0 * (i % n_arc) / n_arc - 1);
        double x = middle + radius * cos(at), y = radius * sin(at);
        shape->corner[i][0] = x * cos(turn) - y * sin(turn);
        shape->corner[i][1] = x * sin(turn) + y * cos(turn);
    }
}

/* The sagitta of less is below a thousandth of the radius for any blades. */
static const double STRAIGHT = 1e-3;

static void shape_polygon(struct rf_shape *shape, const struct rf_params *params)
{
    if (params->blade_curvature > STRAIGHT) {
        shape_curved(shape, params);
        return;
    }
    shape->n_corners = params->blades;
    for (int i = 0; i < shape->n_corners; i++)
        put_corner(shape, i, first_corner(params) + 2 * RF_PI * i / params->blades);
}

static void shape_auto(struct rf_shape *shape, const struct rf_params *params)
{
    (params->blades >= 3 ? shape_polygon : shape_disc)(shape, params);
}

/* The square that the longer side of a picture of the aperture fills. */
static void shape_image(struct rf_shape *shape, const struct rf_params *params)
{
    shape->n_corners = 4;
    for (int i = 0; i < 4; i++) {
        shape->corner[i][0] = i == 0 || i == 3 ? 1 : -1;
        shape->corner[i][1] = i < 2 ? 1 : -1;
    }
}

static const shape_fn shapes[] = {
    [RF_APERTURE_AUTO] = shape_auto,
    [RF_APERTURE_DISC] = shape_disc,
    [RF_APERTURE_POLYGON] = shape_polygon,
    [RF_APERTURE_IMAGE] = shape_image,
};

/* ---- hollow blades --------------------------------------------------------------- */

void rf_hollow_init(struct rf_hollow *hollow, const struct rf_params *params)
{
    bool is_polygon = params->aperture == RF_APERTURE_POLYGON ||
                      (params->aperture == RF_APERTURE_AUTO && params->blades >= 3);
    *hollow = (struct rf_hollow){.n = 0};
    if (!is_polygon || !(params->blade_curvature < -STRAIGHT))
        return;
    hollow->n = params->blades;
    double a = RF_PI / hollow->n, sagitta = -params->blade_curvature * (1 - cos(a));
    hollow->edge = cos(a);
    hollow->r = (sin(a) * sin(a) + sagitta * sagitta) / (2 * sagitta);
    hollow->m = hollow->edge - sagitta + hollow->r;
    for (int i = 0; i < hollow->n; i++) {
        double turn = first_corner(params) + a + 2 * a * i;
        hollow->normal[i][0] = cos(turn);
        hollow->normal[i][1] = sin(turn);
    }
}

double rf_hollow_within(const struct rf_hollow *hollow, double u, double v,
                        double *beside)
{
    double far = -INFINITY;
    for (int i = 0; i < hollow->n; i++) {
        const double *n = hollow->normal[i];
        double along = u * n[0] + v * n[1];
        if (along <= far)
            continue;
        far = along;
        *beside = rf_length(along - hollow->m, v * n[0] - u * n[1]) - hollow->r;
    }
    return hollow->edge - far;
}

/*
 * The angle at an arc's middle whose corner takes this share, -1 to 1, of the area of the
 * half sector: A(t) = (m R sin t - R^2 t) / 2, which grows as far as the arc is seen from
 * the middle of the lens.
 */
static double angle_of_share(const struct rf_hollow *h, double most, double share)
{
    enum { N_HALVINGS = 50 };
    double from = -most, to = most;
    double want = share * (h->m * sin(most) - h->r * most);
    for (int i = 0; i < N_HALVINGS; i++) {
        double t = (from + to) / 2;
        *(h->m * sin(t) - h->r * t < want ? &from : &to) = t;
    }
    return (from + to) / 2;
}

/* The angle at which an arc ends: at a corner, or where it meets its neighbour. */
static double end_of_arc(const struct rf_hollow *h)
{
    double a = RF_PI / h->n, along = h->m * cos(a);
    double rho = along - sqrt(fmax(along * along - h->m * h->m + h->r * h->r, 0));
    return atan2(rho * sin(a), h->m - rho * cos(a));
}

bool rf_shape_hollow_out(struct rf_shape *shape, const struct rf_params *params)
{
    struct rf_hollow h;
    rf_hollow_init(&h, params);
    if (h.n == 0)
        return false;
    int n_arc = RF_DISC_CORNERS / h.n;
    double most = end_of_arc(&h);
    shape->n_corners = h.n * n_arc;
    for (int i = 0; i < shape->n_corners; i++) {
        const double *n = h.normal[i / n_arc];
        double at = angle_of_share(&h, most, 2.0 * (i % n_arc) / n_arc - 1);
        double x = h.m - h.r * cos(at), y = h.r * sin(at);
        shape->corner[i][0] = (x * n[0] - y * n[1]) / shape->ratio;
        shape->corner[i][1] = x * n[1] + y * n[0];
    }
    return true;
}

void rf_shape_init(struct rf_shape *shape, const struct rf_params *params)
{
    *shape = (struct rf_shape){
        .ratio = params->aperture_ratio,
        .size = {1 / params->aperture_ratio, 1},
        .pixel_aspect = params->pixel_aspect,
        .min_lines = MIN_LINES,
        .glow_px = fabs(params->spherical),
        .glows_near = params->spherical > 0,
        .growth = 1 + fmax(fmax(params->astigmatism, params->swirl), 0)};
    shapes[params->aperture](shape, params);
    for (int i = 0; i < shape->n_corners; i++)
        shape->corner[i][0] /= shape->ratio;
}

bool rf_shape_contains(const struct rf_shape *shape, double u, double v)
{
    if (shape->is_disc)
        return u * u * shape->ratio * shape->ratio + v * v < 1;
    for (int i = 0; i < shape->n_corners; i++) {
        const double *a = shape->corner[i];
        const double *b = shape->corner[(i + 1) % shape->n_corners];
        if ((b[0] - a[0]) * (v - a[1]) - (b[1] - a[1]) * (u - a[0]) <= 0)
            return false;
    }
    return true;
}

void rf_shape_extent(const struct rf_shape *shape, double extent[2])
{
    extent[0] = extent[1] = 0;
    for (int i = 0; i < shape->n_corners; i++) {
        extent[0] = fmax(extent[0], fabs(shape->corner[i][0]));
        extent[1] = fmax(extent[1], fabs(shape->corner[i][1]) * shape->pixel_aspect);
    }
    double more = (shape->growth - 1) * fmax(1 / shape->ratio, 1);
    extent[0] += more;
    extent[1] += more * shape->pixel_aspect;
}

struct rf_reach rf_shape_reach(const struct rf_shape *shape, const double point[2])
{
    const double aspect = shape->pixel_aspect;
    const double more =
        (shape->growth - 1) * fmax(1 / shape->ratio, 1) * fmax(aspect, 1);
    struct rf_reach reach = {.most = 0};
    for (int i = 0; i < shape->n_corners; i++) {
        const double u = shape->corner[i][0] - point[0];
        const double v = shape->corner[i][1] * aspect - point[1];
        const double at[4] = {u, v, u + v, u - v};
        reach.most = fmaxf(reach.most, (float)(hypot(u, v) + more));
        for (int k = 0; k < 4; k++) {
            const double beside = k < 2 ? more : 2 * more;
            const float from = (float)(at[k] - beside), to = (float)(at[k] + beside);
            reach.from[k] = i ? fminf(reach.from[k], from) : from;
            reach.to[k] = i ? fmaxf(reach.to[k], to) : to;
        }
    }
    return reach;
}

/* ---- parts --------------------------------------------------------------------- */

static bool is_same(const double a[2], const double b[2])
{
    return fabs(a[0] - b[0]) + fabs(a[1] - b[1]) < 1e-9;
}

/* Adds a corner, but for one at the place of its neighbour: its edge has no side. */
static void add_corner(struct rf_shape *shape, const double corner[2])
{
    int n = shape->n_corners;
    if (n > 0 && is_same(shape->corner[n - 1], corner))
        return;
    memcpy(shape->corner[n], corner, sizeof shape->corner[n]);
    shape->n_corners++;
}

static bool is_beyond_any(const struct rf_shape *shape, const double normal[2],
                          double limit)
{
    for (int i = 0; i < shape->n_corners; i++)
        if (shape->corner[i][0] * normal[0] + shape->corner[i][1] * normal[1] > limit)
            return true;
    return false;
}

void rf_shape_cut(struct rf_shape *shape, const double normal[2], double limit)
{
    if (!is_beyond_any(shape, normal, limit))
        return;
    double corner[RF_MAX_CORNERS][2];
    int n_corners = shape->n_corners;
    memcpy(corner, shape->corner, (size_t)n_corners * sizeof *corner);
    shape->n_corners = 0;
    for (int i = 0; i < n_corners; i++) {
        const double *a = corner[i], *b = corner[(i + 1) % n_corners];
        double beyond_a = a[0] * normal[0] + a[1] * normal[1] - limit;
        double beyond_b = b[0] * normal[0] + b[1] * normal[1] - limit;
        if (beyond_a <= 0)
            add_corner(shape, a);
        if ((beyond_a < 0 && beyond_b > 0) || (beyond_a > 0 && beyond_b < 0)) {
            double t = beyond_a / (beyond_a - beyond_b);
            add_corner(shape,
                       (double[]){a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])});
        }
    }
    int n = shape->n_corners;
    if (n > 1 && is_same(shape->corner[n - 1], shape->corner[0]))
        shape->n_corners--;
}

double rf_shape_area(const struct rf_shape *shape, double centroid[2])
{
    double area = 0, u = 0, v = 0;
    for (int i = 0; i < shape->n_corners; i++) {
        const double *a = shape->corner[i];
        const double *b = shape->corner[(i + 1) % shape->n_corners];
        double cross = a[0] * b[1] - a[1] * b[0];
        area += cross / 2;
        u += cross * (a[0] + b[0]) / 6;
        v += cross * (a[1] + b[1]) / 6;
    }
    centroid[0] = area > 0 ? u / area : 0;
    centroid[1] = area > 0 ? v / area : 0;
    return area;
}

void rf_shape_variance(const struct rf_shape *shape, double variance[2])
{
    double centroid[2], area = rf_shape_area(shape, centroid), square[2] = {0};
    for (int i = 0; i < shape->n_corners; i++) {
        const double *a = shape->corner[i];
        const double *b = shape->corner[(i + 1) % shape->n_corners];
        double cross = a[0] * b[1] - a[1] * b[0];
        for (int k = 0; k < 2; k++)
            square[k] += cross * (a[k] * a[k] + a[k] * b[k] + b[k] * b[k]) / 12;
    }
    for (int k = 0; k < 2; k++)
        variance[k] = square[k] / area - centroid[k] * centroid[k];
}

int rf_shape_min_lines(double half_height)
{
    return rf_max_int((int)(half_height * MIN_LINES), MIN_LINES_OF_PART);
}

double rf_shape_part(const struct rf_shape *whole, double (*site)[2], int n, int j,
                     struct rf_shape *part, double centroid[2])
{
    static const double LEAST_AREA = 1e-6;
    *part = *whole;
    part->is_disc = false;
    part->is_part = true;
    int n_same = 1;
    for (int k = 0; k < n; k++) {
        double to[2] = {site[k][0] - site[j][0], site[k][1] - site[j][1]};
        double middle = to[0] * (site[k][0] + site[j][0]) / 2 +
                        to[1] * (site[k][1] + site[j][1]) / 2;
        if (k == j)
            continue;
        if (to[0] == 0 && to[1] == 0)
            n_same++;
        else
            rf_shape_cut(part, to, middle);
    }
    double area = rf_shape_area(part, centroid);
    if (!(area > LEAST_AREA))
        return 0;
    part->size[0] = part->size[1] = 0;
    for (int i = 0; i < part->n_corners; i++)
        for (int k = 0; k < 2; k++) {
            part->corner[i][k] -= centroid[k];
            part->size[k] = fmax(part->size[k], fabs(part->corner[i][k]));
        }
    for (int k = 0; k < 2; k++)
        part->origin[k] = whole->origin[k] + centroid[k];
    part->min_lines = rf_shape_min_lines(part->size[1]);
    return area / n_same;
}
