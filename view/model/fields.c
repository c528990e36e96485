/* SPDX-License-Identifier: Apache-2.0 */
#include "model/fields.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* Ranges of sliders are what is common; typing goes as far as params.def. Labels where
 * the key makes no good one. */
static const struct {
    const char *key, *label;
    enum field_section section;
    double min, max;
    bool is_log;
} list[] = {
    {"focus-distance", NULL, FIELD_OWN, 0.1, 100, true},
    {"f-stop", "f-stop", FIELD_OWN, 0.5, 64, true},
    {"focal-length", NULL, FIELD_OWN, 8, 400, true},
    {"lens-radius", NULL, FIELD_OWN, 1e-4, 10, true},
    {"screen-position", NULL, FIELD_OWN, 0, 1, false},
    {"optics", NULL, FIELD_OWN, 0, 1, false},
    {"method", NULL, FIELD_OWN, 0, 1, false},
    {"coc-limit", "Sharpness limit", FIELD_CAMERA, 0.05, 5, true},
    {"sensor-width", NULL, FIELD_CAMERA, 4, 70, true},
    {"sensor-height", NULL, FIELD_CAMERA, 3, 56, true},
    {"unit-scale", NULL, FIELD_CAMERA, 0.001, 1000, true},
    {"focal-length-px", "Focal length in px", FIELD_CAMERA, 0, 8000, false},
    {"ortho-scale", NULL, FIELD_CAMERA, 0.1, 100, true},
    {"shift-x", NULL, FIELD_CAMERA, -1, 1, false},
    {"shift-y", NULL, FIELD_CAMERA, -1, 1, false},
    {"pixel-aspect", NULL, FIELD_CAMERA, 0.5, 2, true},
    {"aperture-coefficient", NULL, FIELD_CAMERA, 0, 1000, false},
    {"tilt-x", NULL, FIELD_FOCUS_SURFACE, -15, 15, false},
    {"tilt-y", NULL, FIELD_FOCUS_SURFACE, -15, 15, false},
    {"field-curvature", NULL, FIELD_FOCUS_SURFACE, -1, 1, false},
    {"split-diopter", NULL, FIELD_FOCUS_SURFACE, 0, 20, false},
    {"split-angle", NULL, FIELD_FOCUS_SURFACE, -180, 180, false},
    {"split-offset", NULL, FIELD_FOCUS_SURFACE, -1, 1, false},
    {"split-softness", NULL, FIELD_FOCUS_SURFACE, 0, 1, false},
    {"aperture", "Shape", FIELD_APERTURE, 0, 1, false},
    {"blades", NULL, FIELD_APERTURE, 0, 16, false},
    {"blade-rotation", "Rotation", FIELD_APERTURE, -180, 180, false},
    {"blade-orientation", "Orientation", FIELD_APERTURE, 0, 1, false},
    {"blade-curvature", "Curvature", FIELD_APERTURE, -1, 1, false},
    {"aperture-ratio", "Ratio", FIELD_APERTURE, 0.25, 4, true},
    {"cat-eye", "Cat's eye", FIELD_CHARACTER, 0, 1.5, false},
    {"cat-eye-exposure", "Vignetting", FIELD_CHARACTER, 0, 1, false},
    {"astigmatism", NULL, FIELD_CHARACTER, -0.5, 1, false},
    {"swirl", NULL, FIELD_CHARACTER, -0.5, 1, false},
    {"barn-left", NULL, FIELD_CHARACTER, 0, 1, false},
    {"barn-right", NULL, FIELD_CHARACTER, 0, 1, false},
    {"barn-top", NULL, FIELD_CHARACTER, 0, 1, false},
    {"barn-bottom", NULL, FIELD_CHARACTER, 0, 1, false},
    {"spherical", NULL, FIELD_CHARACTER, -5, 5, false},
    {"axial-chroma", NULL, FIELD_CHARACTER, -3, 3, false},
    {"lateral-chroma", NULL, FIELD_CHARACTER, -0.005, 0.005, false},
    {"obstruction", NULL, FIELD_CHARACTER, 0, 0.8, false},
    {"highlight-clamp", NULL, FIELD_CHARACTER, 0, 100, false},
    {"highlight-threshold", NULL, FIELD_CHARACTER, 0, 10, false},
    {"highlight-gain", NULL, FIELD_CHARACTER, 0, 10, false},
    {"highlight-saturation", NULL, FIELD_CHARACTER, 0, 2, false},
    {"depth-near", NULL, FIELD_DEPTH, 0, 10, false},
    {"depth-far", NULL, FIELD_DEPTH, 1, 1000, true},
    {"depth-scale", NULL, FIELD_DEPTH, -2, 2, false},
    {"depth-offset", NULL, FIELD_DEPTH, -1, 1, false},
    {"depth-infinity", NULL, FIELD_DEPTH, 1, 1e12, true},
    {"max-radius", NULL, FIELD_METHOD, 0, 256, false},
    {"blur-radius", NULL, FIELD_METHOD, 0, 64, false},
    {"blend-gamma", NULL, FIELD_METHOD, 0.4, 2.6, true},
    {"lowres-factor", NULL, FIELD_METHOD, 2, 64, true},
    {"mipmap-bias", NULL, FIELD_METHOD, -4, 4, false},
    {"region-size", NULL, FIELD_METHOD, 0, 10, false},
    {"region-slope", NULL, FIELD_METHOD, 0, 2, false},
    {"lens-seed", NULL, FIELD_METHOD, 0, 1000, false},
    {"distribution", "Light", FIELD_METHOD, 0, 1, false},
};

/* "sub-apertures" is "Sub-apertures": only keys of the list have another. */
static void make_label(const char *key, char *label, size_t n_bytes)
{
    snprintf(label, n_bytes, "%s", key);
    label[0] = (char)toupper((unsigned char)label[0]);
    for (char *c = label; *c; c++)
        if (*c == '-' && strncmp(key, "sub-", 4) != 0)
            *c = ' ';
}

static enum field_section section_of(const struct rf_param_info *info)
{
    switch (info->group) {
    case RF_GROUP_LENS:
        return FIELD_CAMERA;
    case RF_GROUP_APERTURE:
    case RF_GROUP_HIGHLIGHTS:
        return FIELD_CHARACTER;
    case RF_GROUP_DEPTH:
        return FIELD_DEPTH;
    default:
        return FIELD_METHOD;
    }
}

static const char *short_unit(const char *unit)
{
    if (strcmp(unit, "mm") == 0 || strcmp(unit, "px") == 0)
        return unit;
    return strcmp(unit, "degrees") == 0 ? "°" : "";
}

/* A range about the default that sliders can go along. */
static void make_range(const struct rf_param_info *info, struct field *field)
{
    const bool is_small = info->max - info->min <= 64;
    field->min = is_small ? info->min : fmax(info->min, info->def > 0 ? 0 : -10);
    field->max =
        is_small ? info->max : fmin(info->max, info->def > 0 ? 10 * info->def : 10);
}

void field_of(const struct rf_param_info *info, struct field *field)
{
    *field =
        (struct field){.section = section_of(info), .unit = short_unit(info->unit)};
    make_label(info->key, field->label, sizeof(field->label));
    make_range(info, field);
    for (size_t i = 0; i < sizeof(list) / sizeof(list[0]); i++) {
        if (strcmp(info->key, list[i].key) != 0)
            continue;
        field->section = list[i].section;
        field->min = list[i].min;
        field->max = list[i].max;
        field->is_log = list[i].is_log;
        if (list[i].label)
            snprintf(field->label, sizeof(field->label), "%s", list[i].label);
    }
}

void field_number(const struct rf_param_info *info, const struct field *field,
                  double units_per_mm, struct ui_number *number)
{
    const bool is_mm = strcmp(info->unit, "mm") == 0;
    const bool is_scene = strcmp(info->unit, "scene units") == 0;
    *number =
        (struct ui_number){.label = field->label,
                           .unit = field->unit,
                           .min = field->min,
                           .max = field->max,
                           .min_limit = info->min,
                           .max_limit = info->max,
                           .is_log = field->is_log,
                           .is_whole = info->type == RF_TYPE_INT,
                           .has_infinity = strcmp(info->key, "focus-distance") == 0,
                           .field = {.per_mm = is_mm      ? 1
                                               : is_scene ? units_per_mm
                                                          : 0,
                                     .is_angle = strcmp(info->unit, "degrees") == 0,
                                     .is_f_stop = strcmp(info->key, "f-stop") == 0,
                                     .own = info->unit}};
}
