/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which parameters are read.
 *
 * Each row of params.def names a rule, a function here: why its parameter has no effect
 * with the others as they are, or NULL where it has. Tests change every parameter under
 * every method and compare what comes out (tests/behaviour/test_reads.c), so that a
 * rule that is not true fails.
 */
#include "methods/param_reads.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "lens/params.h"
#include "rackfocus/rackfocus.h"

static const struct rf_method_info *method_of(const struct rf_params *p)
{
    return rf_method_find(p->method);
}

/* ---- whatever the others are ----------------------------------------------------- */

static const char *read_always(const struct rf_params *p)
{
    return NULL;
}

/* ---- the method ------------------------------------------------------------------ */

static const char *read_depth(const struct rf_params *p)
{
    return method_of(p)->needs_depth ? NULL : "the method reads no depth";
}

static const char *read_layers(const struct rf_params *p)
{
    return method_of(p)->has_layers ? NULL
                                    : "read only by the methods layered and views";
}

static const char *read_cells(const struct rf_params *p)
{
    if (!method_of(p)->has_layers)
        return read_layers(p);
    return p->quality == RF_QUALITY_PREVIEW ? "not read with quality preview" : NULL;
}

static const char *read_stage(const struct rf_params *p)
{
    return method_of(p)->has_blend ? NULL
                                   : "read only by the preview methods, such as box";
}

/* Is it the levels of detail that are made, in place of the picture? */
static bool shows_levels(const struct rf_params *p)
{
    return method_of(p)->has_blend && p->stage == RF_STAGE_LEVELS;
}

/* Are the weights of the blend made in place of the picture, so that no colour counts? */
static bool shows_weights(const struct rf_params *p)
{
    return method_of(p)->has_blend &&
           (p->stage == RF_STAGE_ALPHA || p->stage == RF_STAGE_SLICES);
}

static const char *read_blend(const struct rf_params *p)
{
    if (read_stage(p))
        return read_stage(p);
    return shows_levels(p) ? "not read with stage levels" : NULL;
}

/* Is the blur seen: of the picture, or of the weights where leaks are controlled? */
static const char *read_blur(const struct rf_params *p)
{
    if (shows_levels(p))
        return read_blend(p);
    return shows_weights(p) && p->leak_control == RF_LEAK_NONE
               ? "not read with stage alpha or slices without leak-control"
               : NULL;
}

static const char *read_colour(const struct rf_params *p)
{
    return shows_weights(p) ? "not read with stage alpha or slices" : NULL;
}

static const char *read_several(const struct rf_params *p)
{
    return method_of(p)->max_views > 1
               ? NULL
               : "read only by the methods of several views, views and accumulate";
}

static const char *read_by(const struct rf_params *p, enum rf_method method,
                           const char *why_not)
{
    return p->method == (int32_t)method ? NULL : why_not;
}

static const char *read_scatter(const struct rf_params *p)
{
    return read_by(p, RF_METHOD_SCATTER, "read only by the method scatter");
}

/* The same of the blur of a preview. */
static const char *read_blur_by(const struct rf_params *p, enum rf_method method,
                                const char *why_not)
{
    return p->method == (int32_t)method ? read_blur(p) : why_not;
}

static const char *read_box(const struct rf_params *p)
{
    return read_blur_by(p, RF_METHOD_BOX, "read only by the method box");
}

static const char *read_lowres(const struct rf_params *p)
{
    return read_blur_by(p, RF_METHOD_LOWRES, "read only by the method lowres");
}

static const char *read_mipmap(const struct rf_params *p)
{
    return p->method == RF_METHOD_MIPMAP || p->method == RF_METHOD_MIPMAP_OFFSET
               ? read_blur(p)
               : "read only by the methods mipmap and mipmap-offset";
}

static const char *read_offset(const struct rf_params *p)
{
    return read_blur_by(p, RF_METHOD_OFFSET, "read only by the method offset");
}

static const char *read_recursive(const struct rf_params *p)
{
    return read_blur_by(p, RF_METHOD_RECURSIVE_OFFSET,
                        "read only by the method recursive-offset");
}

/* ---- blends ---------------------------------------------------------------------- */

static const char *read_left_out(const struct rf_params *p)
{
    return read_blend(p) ? read_blend(p) : read_colour(p);
}

static const char *read_region(const struct rf_params *p)
{
    if (read_blend(p))
        return read_blend(p);
    return p->blend == RF_BLEND_REGION ? NULL : "read only with blend region";
}

static const char *read_slices(const struct rf_params *p)
{
    if (read_blend(p))
        return read_blend(p);
    return p->blend == RF_BLEND_SLICES ? NULL : "read only with blend slices";
}

static const char *read_copy(const struct rf_params *p)
{
    if (read_blend(p))
        return read_blend(p);
    if (p->blend == RF_BLEND_REGION)
        return read_blur(p);
    return p->blend == RF_BLEND_SLICES ? NULL : "read only with blend region or slices";
}

static const char *read_product(const struct rf_params *p)
{
    if (read_blend(p))
        return read_blend(p);
    return p->leak_control == RF_LEAK_PRODUCT ? NULL
                                              : "read only with leak-control product";
}

/* ---- points of the lens ---------------------------------------------------------- */

static const char *read_seed(const struct rf_params *p)
{
    if (read_several(p))
        return read_several(p);
    return p->lens_random || p->lens_pattern == RF_LENS_PATTERN_GRID
               ? NULL
               : "read only with lens-random or with lens-pattern grid";
}

/* ---- lens ------------------------------------------------------------------------ */

static bool is_perspective(const struct rf_params *p)
{
    return p->projection == RF_PROJECTION_PERSPECTIVE;
}

static bool is_yu(const struct rf_params *p)
{
    return is_perspective(p) && p->optics == RF_OPTICS_YU;
}

/* Does the image distance follow from focal length and focus? */
static bool is_real_lens(const struct rf_params *p)
{
    return is_yu(p) || (is_perspective(p) && p->optics == RF_OPTICS_LENS);
}

/* Does the sensor say how large the scene is in the picture? */
static bool has_sensor(const struct rf_params *p)
{
    return is_perspective(p) && p->focal_length_px == 0;
}

/* Does the depth of a pixel depend on where its ray goes? */
static bool has_rays(const struct rf_params *p)
{
    return is_perspective(p) && p->depth == RF_DEPTH_RADIAL &&
           method_of(p)->needs_depth;
}

/* Does the tilt of the lens turn the focus, by the focal length? */
static bool is_tilted(const struct rf_params *p)
{
    return is_perspective(p) && method_of(p)->needs_depth &&
           (p->tilt_x != 0 || p->tilt_y != 0);
}

/* Does it matter where the optical axis meets the picture? */
static bool has_axis(const struct rf_params *p)
{
    return has_rays(p) || is_tilted(p);
}

static bool is_shifted(const struct rf_params *p)
{
    return p->shift_x != 0 || p->shift_y != 0;
}

static const char *read_perspective(const struct rf_params *p)
{
    return is_perspective(p) ? NULL : "read only with projection perspective";
}

static const char *read_orthographic(const struct rf_params *p)
{
    return is_perspective(p) ? "read only with projection orthographic" : NULL;
}

static const char *read_yu(const struct rf_params *p)
{
    return is_yu(p) ? NULL : "read only with projection perspective and optics yu";
}

static const char *read_focus(const struct rf_params *p)
{
    return is_yu(p) && p->screen_position > 0 ? "screen-position is given, and says it"
                                              : NULL;
}

static const char *read_f_stop(const struct rf_params *p)
{
    return p->lens_radius > 0 ? "lens-radius is given, and says it" : NULL;
}

static const char *read_focal(const struct rf_params *p)
{
    if (!is_perspective(p))
        return read_perspective(p);
    return is_real_lens(p) || is_tilted(p) || p->lens_radius == 0 ||
                   p->focal_length_px == 0
               ? NULL
               : "lens-radius and focal-length-px are given, and say it";
}

static const char *read_unit(const struct rf_params *p)
{
    return is_real_lens(p) || is_tilted(p) || p->lens_radius == 0
               ? NULL
               : "lens-radius is given, in scene units";
}

static const char *read_sensor(const struct rf_params *p)
{
    if (!is_perspective(p))
        return read_perspective(p);
    return has_sensor(p) ? NULL : "focal-length-px is given, and says it";
}

static const char *read_sensor_width(const struct rf_params *p)
{
    if (!has_sensor(p))
        return read_sensor(p);
    return p->sensor_fit != RF_SENSOR_FIT_VERTICAL
               ? NULL
               : "not read with sensor-fit vertical: sensor-height is";
}

static const char *read_sensor_height(const struct rf_params *p)
{
    if (!has_sensor(p))
        return read_sensor(p);
    return p->sensor_fit == RF_SENSOR_FIT_VERTICAL
               ? NULL
               : "read only with sensor-fit vertical";
}

static const char *read_fit(const struct rf_params *p)
{
    return !is_perspective(p) || has_sensor(p) || (has_axis(p) && is_shifted(p))
               ? NULL
               : "focal-length-px is given, and says it";
}

static const char *read_shift(const struct rf_params *p)
{
    return has_axis(p)
               ? NULL
               : "read only with projection perspective, and depth radial or a tilt";
}

/* Are discs round on the screen, and not in stored pixels? */
static bool has_round_discs(const struct rf_params *p)
{
    bool is_box =
        p->method == RF_METHOD_BOX && p->box_direction != RF_DIRECTION_HORIZONTAL;
    if (read_blur(p))
        return false;
    return method_of(p)->reads_aperture || p->method == RF_METHOD_SCATTER ||
           p->method == RF_METHOD_LOWRES || is_box;
}

static const char *read_aspect(const struct rf_params *p)
{
    bool is_fitted = !read_fit(p) && p->sensor_fit != RF_SENSOR_FIT_HORIZONTAL;
    bool has_place = p->cat_eye > 0 || p->field_curvature != 0 || p->split_diopter > 0;
    return is_fitted || has_axis(p) || has_place || has_round_discs(p)
               ? NULL
               : "not read by this method with this sensor-fit";
}

/* ---- aperture -------------------------------------------------------------------- */

/* Whose shape the aperture group gives: the blur's, that of the points of the lens. */
static bool has_shape(const struct rf_params *p)
{
    return method_of(p)->reads_aperture && !read_blur(p);
}

static bool has_shaped_points(const struct rf_params *p)
{
    return method_of(p)->max_views > 1 && p->lens_pattern != RF_LENS_PATTERN_CIRCLE;
}

static const char *why_no_shape(const struct rf_params *p)
{
    return method_of(p)->reads_aperture ? read_blur(p)
                                        : "the method's blur has no shape but its own";
}

static const char *read_ratio(const struct rf_params *p)
{
    return has_shape(p) || method_of(p)->max_views > 1 ? NULL : why_no_shape(p);
}

/* Do points take the shape that `aperture` names, and not that of their pattern? */
static bool points_follow_aperture(const struct rf_params *p)
{
    return has_shaped_points(p) && p->lens_pattern != RF_LENS_PATTERN_DISC &&
           p->lens_pattern != RF_LENS_PATTERN_POLYGON;
}

static const char *read_aperture(const struct rf_params *p)
{
    if (has_shape(p) || points_follow_aperture(p))
        return NULL;
    return method_of(p)->max_views > 1 ? "lens-pattern says it" : why_no_shape(p);
}

/* May the shape be a polygon, if there are blades? */
static const char *read_blades(const struct rf_params *p)
{
    if (has_shaped_points(p) && p->lens_pattern == RF_LENS_PATTERN_POLYGON)
        return NULL;
    if (read_aperture(p))
        return read_aperture(p);
    return p->aperture == RF_APERTURE_DISC    ? "not read with aperture disc"
           : p->aperture == RF_APERTURE_IMAGE ? "not read with aperture image"
                                              : NULL;
}

static const char *read_polygon(const struct rf_params *p)
{
    if (read_blades(p))
        return read_blades(p);
    return p->blades >= 3 ? NULL : "read only with 3 blades and more";
}

/* ---- looks that depend on the place ---------------------------------------------- */

static const char *read_look(const struct rf_params *p)
{
    return read_layers(p);
}

static const char *read_vignette(const struct rf_params *p)
{
    if (method_of(p)->has_layers)
        return NULL;
    if (p->method != RF_METHOD_SCATTER)
        return "read only by the methods layered, views and scatter";
    return p->distribution == RF_DISTRIBUTION_IMAGE ? "not read with distribution image"
                                                    : NULL;
}

static const char *read_obstruction(const struct rf_params *p)
{
    if (!method_of(p)->has_layers && !has_shaped_points(p))
        return "read only by the methods layered, views and accumulate";
    return p->aperture == RF_APERTURE_IMAGE ? "not read with aperture image" : NULL;
}

static const char *read_chroma(const struct rf_params *p)
{
    return method_of(p)->has_layers || p->method == RF_METHOD_SCATTER
               ? NULL
               : "read only by the methods layered, views and scatter";
}

static const char *read_exposure(const struct rf_params *p)
{
    bool is_dark = p->cat_eye > 0 || p->barn_left > 0 || p->barn_right > 0 ||
                   p->barn_top > 0 || p->barn_bottom > 0;
    if (read_vignette(p))
        return read_vignette(p);
    return is_dark ? NULL : "read only with cat-eye or a barn door above 0";
}

static const char *read_field(const struct rf_params *p)
{
    if (read_depth(p))
        return read_depth(p);
    return read_perspective(p);
}

static const char *read_tilt(const struct rf_params *p)
{
    return read_field(p);
}

static const char *read_split(const struct rf_params *p)
{
    if (read_field(p))
        return read_field(p);
    return p->split_diopter > 0 ? NULL : "read only with a split-diopter above 0";
}

/* ---- depth ----------------------------------------------------------------------- */

static const char *read_far(const struct rf_params *p)
{
    if (read_depth(p))
        return read_depth(p);
    return p->depth == RF_DEPTH_BUFFER || p->depth == RF_DEPTH_BUFFER_REVERSED ||
                   p->depth == RF_DEPTH_NORMALISED
               ? NULL
               : "read only with depth buffer, buffer-reversed and normalised";
}

static const char *read_near(const struct rf_params *p)
{
    if (!read_far(p) || read_depth(p))
        return read_depth(p);
    return p->depth == RF_DEPTH_BUFFER_INFINITE ||
                   p->depth == RF_DEPTH_BUFFER_REVERSED_INFINITE
               ? NULL
               : "read only with a depth buffer and with depth normalised";
}

/* ---- highlights ------------------------------------------------------------------ */

static const char *read_threshold(const struct rf_params *p)
{
    if (read_colour(p))
        return read_colour(p);
    return p->highlight_gain != 1 || p->highlight_saturation != 1
               ? NULL
               : "read only with a highlight-gain or highlight-saturation other than 1";
}

/* ---- all ------------------------------------------------------------------------- */

static const rf_read_rule rules[] = {
#define RF_FLOAT(k, f, a, u, lo, hi, d, g, r, h) read_##r,
#define RF_INT(k, f, a, u, lo, hi, d, g, r, h) read_##r,
#define RF_BOOL(k, f, a, d, g, r, h) read_##r,
#define RF_ENUM(k, f, a, list, d, g, r, h) read_##r,
#include "rackfocus/params.def"
#undef RF_FLOAT
#undef RF_INT
#undef RF_BOOL
#undef RF_ENUM
};

bool rf_param_is_read(const struct rf_params *params, const char *name,
                      const char **why_not)
{
    const struct rf_param_info *info = rf_param_find(name);
    const char *reason = "there is no such parameter";
    if (info && params && rf_params_have_size(params)) {
        struct rf_params full;
        rf_params_complete(&full, params);
        reason = rf_method_find(full.method) ? rules[info - rf_param_list(NULL)](&full)
                                             : "there is no such method";
    }
    if (why_not)
        *why_not = reason;
    return !reason;
}
