/* SPDX-License-Identifier: Apache-2.0 */
#include "povray/povray_lens.h"

#include <math.h>
#include <stdio.h>

static bool is_typed(const struct settings *settings, const char *name)
{
    return settings_origin(settings, name) == ORIGIN_COMMAND_LINE;
}

void povray_lens_drop_stop(struct settings *typed)
{
    /* A tilt still goes by the last two. */
    static const char *const names[] = {"f-stop",     "sensor-width", "sensor-height",
                                        "sensor-fit", "focal-length", "unit-scale"};
    const size_t n = sizeof(names) / sizeof(names[0]);
    const bool is_tilted = typed->params.tilt_x != 0 || typed->params.tilt_y != 0;
    struct settings plain;
    settings_init(&plain);
    for (size_t i = 0; i < (is_tilted ? n - 2 : n); i++)
        settings_take(typed, &plain, names[i]);
}

/* Sets a parameter that is not typed. */
static void set_untyped(struct settings *settings, const char *name, double value)
{
    char text[64];
    if (is_typed(settings, name))
        return;
    snprintf(text, sizeof(text), "%.17g", value);
    settings_set(settings, name, text, NULL);
}

void povray_lens_keep(struct settings *typed, double radius, double focal_px)
{
    static const char *const names[] = {"focal-length", "unit-scale", "sensor-width",
                                        "sensor-height"};
    bool is_any_typed = false;
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        is_any_typed |= is_typed(typed, names[i]);
    if (!is_any_typed)
        return;
    set_untyped(typed, "focal-length-px", focal_px);
    set_untyped(typed, "lens-radius", radius);
}

bool povray_lens_take_stop(struct settings *typed, struct povray_stop *stop)
{
    const struct rf_params *params = &typed->params;
    if (!is_typed(typed, "f-stop") || is_typed(typed, "lens-radius") ||
        params->optics != RF_OPTICS_CAMERA)
        return false;
    const double unit = (double)params->unit_scale / (2 * (double)params->f_stop);
    *stop = (struct povray_stop){params->f_stop,
                                 {1e-3 * (double)params->focal_length * unit, unit}};
    povray_lens_drop_stop(typed);
    return true;
}

void povray_lens_tilt(const struct rf_params *params, double tilt[2])
{
    const double focal_length = params->focal_length * 1e-3 * params->unit_scale;
    const double degree = 3.14159265358979324 / 180;
    tilt[0] = sin(params->tilt_x * degree) / focal_length;
    tilt[1] = sin(params->tilt_y * degree) / focal_length;
}

void povray_lens_options(struct povray_options *options, const struct settings *typed,
                         const struct povray_stop *stop)
{
    const struct rf_params *params = &typed->params;
    options->has_aperture = is_typed(typed, "lens-radius");
    options->has_f_stop =
        stop->f_stop > 0 || (is_typed(typed, "f-stop") && !options->has_aperture);
    options->stop = *stop;
    options->aperture = 4 * (double)params->lens_radius;
    options->has_focus_distance = is_typed(typed, "focus-distance");
    options->focus_distance = params->focus_distance;
    povray_lens_tilt(params, options->tilt);
    options->curvature = params->field_curvature;
    options->split_distance = params->split_diopter;
}
