/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From a pixel of one frame to its place in another.
 *
 *   matrices   (x, y) at planar distance z is the point
 *              p = ((x - cx) z / f, s_y (cy - y) z / (f a), s_z z)
 *              of its camera, q = p W_from^-1 W_to that of the other, which shows it at
 *              distance s_z q_z
 *   vectors    what the renderer says; the distance stays
 *
 *   f, cx, cy  focal length and principal point, px;  a  pixel aspect
 *   s_y, s_z   signs of the camera's axes
 *   W          worldToCamera
 *
 * A view from a point of the lens shows what its lens' centre shows at x, y moved by
 * u f (1/D - 1/z), D its shear distance (core/input/views_in.c).
 */
#include "filter/temporal_map.h"

#include <math.h>
#include <string.h>

/* Solves for the inverse of a matrix whose last column is 0 0 0 1. */
static bool invert(const double m[16], double out[16])
{
    const double a = m[0], b = m[1], c = m[2], d = m[4], e = m[5], f = m[6], g = m[8],
                 h = m[9], i = m[10];
    const double det = a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g);
    if (!(fabs(det) > 1e-12) || !isfinite(det))
        return false;
    const double r[9] = {e * i - f * h, c * h - b * i, b * f - c * e,
                         f * g - d * i, a * i - c * g, c * d - a * f,
                         d * h - e * g, b * g - a * h, a * e - b * d};
    memset(out, 0, 16 * sizeof(*out));
    for (int row = 0; row < 3; row++)
        for (int k = 0; k < 3; k++)
            out[4 * row + k] = r[3 * row + k] / det;
    for (int k = 0; k < 3; k++)
        out[12 + k] = -(m[12] * out[k] + m[13] * out[4 + k] + m[14] * out[8 + k]);
    out[15] = 1;
    return true;
}

bool temporal_map_join(struct temporal_map *map)
{
    double back[16];
    if (!invert(map->from.world_to_camera, back))
        return false;
    for (int row = 0; row < 4; row++)
        for (int k = 0; k < 4; k++) {
            double sum = 0;
            for (int n = 0; n < 4; n++)
                sum += back[4 * row + n] * map->to.world_to_camera[4 * n + k];
            map->between[4 * row + k] = sum;
        }
    return true;
}

void temporal_map_take_axes(struct temporal_map *map, int i)
{
    static const double axes[TEMPORAL_N_AXES][2] = {{1, -1}, {1, 1}, {-1, 1}};
    memcpy(map->axes, axes[i], sizeof(map->axes));
}

/* Pixels per scene unit at distance z, right and down. */
static void scale_at(const struct temporal_camera *camera, double z, double scale[2])
{
    const struct rf_lens *lens = &camera->lens;
    scale[0] = lens->projection == RF_PROJECTION_ORTHOGRAPHIC
                   ? lens->px_per_unit
                   : lens->focal_length_px / z;
    scale[1] = scale[0] * camera->pixel_aspect;
}

/* How far a view shows what lies at distance z from where its lens' centre does. */
static void view_shift(const struct temporal_camera *camera, double z, double shift[2])
{
    const struct rf_lens *lens = &camera->lens;
    const double d = camera->shear_distance;
    double px = lens->projection == RF_PROJECTION_ORTHOGRAPHIC
                    ? lens->px_per_unit * (d > 0 ? z / d - 1 : -1)
                    : lens->focal_length_px * ((d > 0 ? 1 / d : 0) - 1 / z);
    shift[0] = camera->lens_offset[0] * px;
    shift[1] = -camera->lens_offset[1] * px;
}

static bool place_by_matrix(const struct temporal_map *map, int32_t x, int32_t y,
                            double z, struct temporal_place *place)
{
    const bool is_sky = isinf(z);
    const double near = is_sky ? 1 : z;
    double scale[2], shift[2], p[4], q[3];
    if (is_sky && map->from.lens.projection == RF_PROJECTION_ORTHOGRAPHIC)
        return false;
    scale_at(&map->from, near, scale);
    view_shift(&map->from, z, shift);
    p[0] = (x + 0.5 - shift[0] - map->from.lens.principal_px[0]) / scale[0];
    p[1] = -map->axes[0] * (y + 0.5 - shift[1] - map->from.lens.principal_px[1]) /
           scale[1];
    p[2] = map->axes[1] * near;
    p[3] = is_sky ? 0 : 1;
    for (int k = 0; k < 3; k++)
        q[k] = p[0] * map->between[k] + p[1] * map->between[4 + k] +
               p[2] * map->between[8 + k] + p[3] * map->between[12 + k];
    q[2] *= map->axes[1];
    if (!(q[2] > 0))
        return false;
    place->z = is_sky ? INFINITY : q[2];
    scale_at(&map->to, q[2], scale);
    view_shift(&map->to, place->z, shift);
    place->x = map->to.lens.principal_px[0] + shift[0] + q[0] * scale[0];
    place->y = map->to.lens.principal_px[1] + shift[1] - map->axes[0] * q[1] * scale[1];
    return isfinite(place->x) && isfinite(place->y);
}

bool temporal_map_place(const struct temporal_map *map, int32_t x, int32_t y, double z,
                        struct temporal_place *place)
{
    if (map->kind == TEMPORAL_MATRICES)
        return place_by_matrix(map, x, y, z, place);
    const float *v = map->vectors + 2 * ((size_t)y * (size_t)map->width + (size_t)x);
    *place = (struct temporal_place){x + 0.5 + map->vector_sign[0] * (double)v[0],
                                     y + 0.5 + map->vector_sign[1] * (double)v[1], z};
    return isfinite(place->x) && isfinite(place->y);
}
