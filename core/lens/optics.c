/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The circle of confusion: from a depth to a signed radius in pixels.
 *
 *   r = K (1/s - 1/z)          CG camera and real lens, perspective
 *   r = R p (z - s) / s        orthographic (Cycles): R lens radius, p px per unit
 *
 *   K   lens radius R times the image distance in px
 *   s   focus distance, z planar depth, f focal length, N f-number
 *   R   f / (2 N)
 *
 * CG camera (Cycles, POV-Ray): the image distance is the focal length, f_px = W f / S
 * with W the picture's fitted side in px and S the sensor's in mm, so the picture does
 * not breathe with the focus. Real lens: the image lies at v = f s / (s - f), K = R
 * v_px.
 *
 * Yu 2004: diameter c = |a (v (1/f - 1/d) - 1)|, v the screen position, a the aperture
 * coefficient. With v set from the focus distance v/f - 1 = v/s, so c = a v |1/s -
 * 1/d|: the real lens in other letters, with a = 2 R f_px / f (the diameter of the
 * aperture in px of the sensor) and K = a v / 2.
 *
 * Reed: with d the value of a depth buffer, 1/z = (1 - d)/n + d/f_far (perspective), so
 * r = bias + scale d: a scale and a bias per frame, no division per pixel.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "lens/params.h"
#include "rackfocus/rackfocus.h"

static double fitted_side_px(const struct rf_params *p, int width, int height,
                             double *sensor_mm)
{
    double w = width, h = height * (1 / p->pixel_aspect);
    bool is_vertical = p->sensor_fit == RF_SENSOR_FIT_VERTICAL;
    bool is_upright = p->sensor_fit == RF_SENSOR_FIT_AUTO && h > w;
    *sensor_mm = is_vertical ? p->sensor_height : p->sensor_width;
    return is_vertical || is_upright ? h : w;
}

static rf_result check_real_lens(const struct rf_lens *lens, struct rf_error *error)
{
    if (lens->focal_length <= 0)
        return rf_fail(error, RF_ERROR_PARAMETER, "focal_length",
                       "a real lens needs its focal length");
    if (lens->focus_distance <= lens->focal_length)
        return rf_fail(
            error, RF_ERROR_PARAMETER, "focus_distance",
            "the focus distance %g lies inside the focal length %g (scene "
            "units): a real lens cannot focus there; use a longer distance, a "
            "shorter lens, another unit scale, or optics camera",
            lens->focus_distance, lens->focal_length);
    return RF_OK;
}

/* K of a perspective lens, in px times scene units. */
static rf_result perspective_scale(struct rf_lens *lens, const struct rf_params *p,
                                   double *k, double *bias, struct rf_error *error)
{
    *k = lens->lens_radius * lens->focal_length_px;
    *bias = *k / lens->focus_distance;
    if (p->optics != RF_OPTICS_LENS && p->optics != RF_OPTICS_YU)
        return RF_OK;
    bool is_screen_given = p->optics == RF_OPTICS_YU && p->screen_position > 0;
    double f = lens->focal_length, v = p->screen_position;
    if (!is_screen_given) {
        rf_result result = check_real_lens(lens, error);
        if (result != RF_OK)
            return result;
        v = rf_screen_position(f, lens->focus_distance);
    } else if (v <= f) {
        return rf_fail(error, RF_ERROR_PARAMETER, "screen_position",
                       "the screen at %g stands inside the focal length %g (scene "
                       "units): nothing is in focus; move it beyond",
                       v, f);
    }
    double a = 2 * lens->lens_radius * lens->focal_length_px / f;
    if (p->optics == RF_OPTICS_YU && p->aperture_coefficient > 0)
        a = p->aperture_coefficient;
    lens->screen_position = v;
    lens->focus_distance = v * f / (v - f);
    *k = a * v / 2;
    *bias = a * (v / f - 1) / 2;
    return RF_OK;
}

/* 1/z is linear in the buffer value: 1/z = near_term + slope d. */
static rf_result buffer_terms(struct rf_lens *lens, const struct rf_params *p,
                              struct rf_error *error)
{
    double n = p->depth_near, f = p->depth_far, at_zero, at_one;
    switch (p->depth) {
    case RF_DEPTH_BUFFER:
        at_zero = 1 / n, at_one = 1 / f;
        break;
    case RF_DEPTH_BUFFER_REVERSED:
        at_zero = 1 / f, at_one = 1 / n;
        break;
    case RF_DEPTH_BUFFER_INFINITE:
        at_zero = 1 / n, at_one = 0;
        break;
    case RF_DEPTH_BUFFER_REVERSED_INFINITE:
        at_zero = 0, at_one = 1 / n;
        break;
    default:
        return rf_fail(error, RF_ERROR_PARAMETER, "depth",
                       "optics buffer works on a depth buffer: set depth to buffer or "
                       "one of its variants");
    }
    if (p->projection != RF_PROJECTION_PERSPECTIVE)
        return rf_fail(error, RF_ERROR_PARAMETER, "optics",
                       "optics buffer is for perspective cameras");
    lens->buffer_bias_px = lens->bias_px + lens->scale * at_zero;
    lens->buffer_scale_px = lens->scale * (at_one - at_zero);
    return RF_OK;
}

static rf_result check_planes(const struct rf_params *p, struct rf_error *error)
{
    bool is_buffer =
        p->depth >= RF_DEPTH_BUFFER && p->depth <= RF_DEPTH_BUFFER_REVERSED_INFINITE;
    bool has_far = p->depth == RF_DEPTH_BUFFER ||
                   p->depth == RF_DEPTH_BUFFER_REVERSED ||
                   p->depth == RF_DEPTH_NORMALISED;
    if (is_buffer && p->depth_near <= 0)
        return rf_fail(error, RF_ERROR_PARAMETER, "depth_near",
                       "the near plane of a depth buffer must be above 0");
    if (has_far && p->depth_far <= p->depth_near)
        return rf_fail(error, RF_ERROR_PARAMETER, "depth_far",
                       "the far plane %g must lie beyond the near plane %g",
                       p->depth_far, p->depth_near);
    if (p->depth_scale == 0)
        return rf_fail(error, RF_ERROR_PARAMETER, "depth_scale",
                       "a depth scale of 0 erases the depth");
    return RF_OK;
}

static rf_result resolve(struct rf_lens *lens, const struct rf_params *params,
                         int32_t width, int32_t height, struct rf_error *error)
{
    rf_result result = rf_params_check_ranges(params, error);
    if (result == RF_OK)
        result = rf_lens_check_size(width, height, error);
    if (result != RF_OK)
        return result;
    struct rf_params full;
    const struct rf_params *p = &full;
    rf_params_complete(&full, params);
    result = check_planes(p, error);
    if (result != RF_OK)
        return result;
    double sensor_mm, side_px = fitted_side_px(p, width, height, &sensor_mm);
    double max_px = p->max_radius > 0 ? p->max_radius : rf_max_int(width, height) / 2.0;
    *lens = (struct rf_lens){
        .focus_distance = p->focus_distance,
        .focal_length = p->focal_length * 1e-3 * p->unit_scale,
        .max_radius_px = max_px,
        .coc_limit_px = p->coc_limit,
        .projection = p->projection,
        .optics = p->optics,
    };
    lens->lens_radius =
        p->lens_radius > 0 ? p->lens_radius : lens->focal_length / (2 * p->f_stop);
    lens->principal_px[0] = width / 2.0 - p->shift_x * side_px;
    lens->principal_px[1] = height / 2.0 + p->shift_y * side_px * p->pixel_aspect;
    if (p->projection == RF_PROJECTION_ORTHOGRAPHIC) {
        /* Cycles: the lens of an orthographic camera has the radius 1 / (2 N). */
        if (p->lens_radius <= 0)
            lens->lens_radius = p->unit_scale / (2 * p->f_stop);
        lens->px_per_unit = side_px / p->ortho_scale;
        lens->bias_px = -lens->lens_radius * lens->px_per_unit;
        lens->scale = -lens->bias_px / p->focus_distance;
    } else {
        lens->focal_length_px = p->focal_length_px > 0
                                    ? p->focal_length_px
                                    : side_px * p->focal_length / sensor_mm;
        double k;
        result = perspective_scale(lens, p, &k, &lens->bias_px, error);
        lens->scale = -k;
    }
    if (result == RF_OK && p->optics == RF_OPTICS_BUFFER)
        result = buffer_terms(lens, p, error);
    return result;
}

rf_result rf_lens_init_sized(struct rf_lens *lens, size_t size,
                             const struct rf_params *params, int32_t width,
                             int32_t height, struct rf_error *error)
{
    if (!lens || size == 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "lens", "lens is NULL or has no size");
    struct rf_lens own;
    memset(&own, 0, sizeof own);
    rf_result result = resolve(&own, params, width, height, error);
    own.size = size < sizeof own ? size : sizeof own;
    if (result == RF_OK)
        memcpy(lens, &own, own.size);
    return result;
}

double rf_lens_radius_px(const struct rf_lens *lens, double z)
{
    double r;
    if (isnan(z))
        return NAN;
    if (lens->projection == RF_PROJECTION_ORTHOGRAPHIC)
        r = isinf(z) && lens->scale == 0 ? 0 : lens->bias_px + lens->scale * z;
    else
        r = lens->bias_px + lens->scale / z;
    return fmin(fmax(r, -lens->max_radius_px), lens->max_radius_px);
}

double rf_lens_depth_at(const struct rf_lens *lens, double r_px)
{
    double t = r_px - lens->bias_px;
    if (isnan(r_px))
        return NAN;
    if (lens->scale == 0)
        return r_px > 0 ? INFINITY : 0;
    if (lens->projection == RF_PROJECTION_ORTHOGRAPHIC)
        return fmax(t / lens->scale, 0);
    return t >= 0 ? INFINITY : lens->scale / t;
}

void rf_lens_depth_of_field(const struct rf_lens *lens, double *near_limit,
                            double *far_limit)
{
    *near_limit = rf_lens_depth_at(lens, -lens->coc_limit_px);
    *far_limit = rf_lens_depth_at(lens, lens->coc_limit_px);
}

double rf_lens_hyperfocal(const struct rf_lens *lens)
{
    if (lens->projection == RF_PROJECTION_ORTHOGRAPHIC)
        return INFINITY;
    double focal_px = lens->focal_length_px, k = lens->lens_radius * focal_px;
    bool is_real = lens->optics == RF_OPTICS_LENS || lens->optics == RF_OPTICS_YU;
    if (!is_real)
        return k / lens->coc_limit_px;
    /*
     * At infinity r = a (v / f - 1) / 2 = a f / (2 (s - f)), since v / f - 1 = f / (s -
     * f); it equals the limit for s = f + a f / (2 limit).
     */
    double f = lens->focal_length;
    double a = -2 * lens->scale / lens->screen_position;
    return f + a * f / (2 * lens->coc_limit_px);
}

double rf_screen_position(double focal_length, double focus_distance)
{
    if (!(focus_distance > focal_length))
        return NAN;
    return focal_length * focus_distance / (focus_distance - focal_length);
}
