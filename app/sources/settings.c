/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/settings.h"

#include "sources/camera_facts.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* ---- the table ------------------------------------------------------------------ */

static size_t index_of(const char *name)
{
    return (size_t)(rf_param_find(name) - rf_param_list(NULL));
}

static double number_of(const struct rf_params *params, const char *name)
{
    const struct rf_param_info *info = rf_param_find(name);
    const char *member = (const char *)params + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

void settings_init(struct settings *settings)
{
    memset(settings, 0, sizeof(*settings));
    rf_params_init(&settings->params);
}

static void set_origin(struct settings *settings, const char *name, enum origin origin,
                       const char *source)
{
    const size_t i = index_of(name);
    settings->origins[i] = origin;
    snprintf(settings->sources[i], sizeof(settings->sources[i]), "%s", source);
}

enum origin settings_origin(const struct settings *settings, const char *name)
{
    return settings->origins[index_of(name)];
}

bool settings_is_by(const struct settings *settings, const char *name,
                    const char *attribute)
{
    return settings_origin(settings, name) == ORIGIN_HEADER &&
           strcmp(settings->sources[index_of(name)], attribute) == 0;
}

bool settings_acts(const struct settings *settings, const char *key)
{
    size_t n;
    char option[64];
    rf_param_list(&n);
    snprintf(option, sizeof(option), "--%s", key);
    for (size_t i = 0; i < n; i++) {
        const char *at = settings->origins[i] == ORIGIN_DERIVED
                             ? strstr(settings->sources[i], option)
                             : NULL;
        if (at && strchr(",)", at[strlen(option)]))
            return true;
    }
    return false;
}

void settings_describe_origin(const struct settings *settings, const char *name,
                              char *text, size_t n_bytes)
{
    const size_t i = index_of(name);
    static const char *const words[] = {"default", "header", "command line",
                                        "command line"};
    const char *source = settings->sources[i];
    snprintf(text, n_bytes, "%s%s%s", words[settings->origins[i]], *source ? " " : "",
             source);
}

rf_result settings_set(struct settings *settings, const char *name, const char *text,
                       struct rf_error *error)
{
    const rf_result result = rf_params_set(&settings->params, name, text, error);
    if (result == RF_OK)
        set_origin(settings, name, ORIGIN_COMMAND_LINE, "");
    return result;
}

void settings_take(struct settings *settings, const struct settings *from,
                   const char *name)
{
    const struct rf_param_info *info = rf_param_find(name);
    const size_t i = index_of(name);
    const size_t n_bytes =
        info->type == RF_TYPE_FLOAT ? sizeof(double) : sizeof(int32_t);
    memcpy((char *)&settings->params + info->offset,
           (const char *)&from->params + info->offset, n_bytes);
    settings->origins[i] = from->origins[i];
    memcpy(settings->sources[i], from->sources[i], sizeof(settings->sources[i]));
}

rf_result settings_set_header(struct settings *settings, const char *name, double value,
                              const char *source, struct rf_error *error)
{
    if (settings_origin(settings, name) == ORIGIN_COMMAND_LINE)
        return RF_OK;
    const rf_result result =
        rf_params_set_number(&settings->params, name, value, error);
    if (result == RF_OK)
        set_origin(settings, name, ORIGIN_HEADER, source);
    return result;
}

static bool is_from(const struct settings *settings, const char *name,
                    enum origin origin)
{
    return settings_origin(settings, name) == origin;
}

static bool is_typed(const struct settings *settings, const char *name)
{
    return is_from(settings, name, ORIGIN_COMMAND_LINE);
}

static bool is_open(const struct settings *settings, const char *name)
{
    return is_from(settings, name, ORIGIN_DEFAULT);
}

/* ---- attributes ----------------------------------------------------------------- */

/* One run of reading a header; `facts` is what the header alone says. */
struct reader {
    struct settings *settings; /* with the command line in it */
    struct settings facts;
    const struct image_input *input;
    char *text; /* for the message */
    size_t n_bytes;
};

static bool fail_attribute(const struct reader *reader,
                           const struct rf_param_info *info, const char *reason)
{
    snprintf(reader->text, reader->n_bytes,
             "%s: attribute %s of the header: %s; give --%s to overrule it",
             image_path(reader->input), info->attribute, reason, info->key);
    return false;
}

/* rackfocus:* attributes, one per parameter. */
static bool read_own_attribute(struct reader *reader, const struct rf_param_info *info)
{
    struct settings *facts = &reader->facts;
    struct rf_error error;
    rf_result result = RF_OK;
    double number;
    const char *text;
    if (image_attribute_string(reader->input, info->attribute, &text))
        result = rf_params_set(&facts->params, info->key, text, &error);
    else if (image_attribute_number(reader->input, info->attribute, &number))
        result = rf_params_set_number(&facts->params, info->key, number, &error);
    else
        return true;
    if (result != RF_OK)
        return is_typed(reader->settings, info->key)
                   ? true
                   : fail_attribute(reader, info, error.message);
    set_origin(facts, info->key, ORIGIN_HEADER, info->attribute);
    return true;
}

/* Sets a fact that a standard attribute gives, where rackfocus:* left it open. Values
 * out of range mean "unknown" in the files of other programs. */
static void set_fact(struct reader *reader, const char *key, double value,
                     const char *attribute)
{
    struct settings *facts = &reader->facts;
    if (is_open(facts, key) &&
        rf_params_set_number(&facts->params, key, value, NULL) == RF_OK)
        set_origin(facts, key, ORIGIN_HEADER, attribute);
}

static bool fact_value(const struct reader *reader, const char *name, double *value)
{
    *value = number_of(&reader->facts.params, name);
    return is_from(&reader->facts, name, ORIGIN_HEADER);
}

static void set_fact_text(struct reader *reader, const char *key, const char *text,
                          const char *attribute)
{
    struct settings *facts = &reader->facts;
    if (is_open(facts, key) && rf_params_set(&facts->params, key, text, NULL) == RF_OK)
        set_origin(facts, key, ORIGIN_HEADER, attribute);
}

/* Attributes that other programs write: lengths in mm, the focus in metres. */
static void read_standard_attributes(struct reader *reader)
{
    const struct image_input *input = reader->input;
    double number, size[2];
    if (image_attribute_number(input, "aperture", &number))
        set_fact(reader, "f-stop", number, "aperture");
    if (image_attribute_number(input, "pinholeFocalLength", &number))
        set_fact(reader, "focal-length", number, "pinholeFocalLength");
    if (image_attribute_number(input, "nominalFocalLength", &number))
        set_fact(reader, "focal-length", number, "nominalFocalLength");
    if (image_attribute_v2f(input, "sensorOverallDimensions", size) && size[0] > 0 &&
        is_open(&reader->facts, "sensor-width")) {
        set_fact(reader, "sensor-width", size[0], "sensorOverallDimensions");
        set_fact(reader, "sensor-height", size[1], "sensorOverallDimensions");
        /* It is the width of the sensor whichever side is longer. */
        set_fact(reader, "sensor-fit", RF_SENSOR_FIT_HORIZONTAL,
                 "sensorOverallDimensions");
    }
    if (image_attribute_number(input, "focus", &number) && number > 0) {
        const struct settings *known = is_typed(reader->settings, "unit-scale")
                                           ? reader->settings
                                           : &reader->facts;
        set_fact(reader, "focus-distance", fmin(number * known->params.unit_scale, 1e9),
                 "focus");
    }
}

static bool is_sensor_typed(const struct settings *settings)
{
    return is_typed(settings, "sensor-width") || is_typed(settings, "sensor-height") ||
           is_typed(settings, "sensor-fit");
}

/* The width of the picture, whichever side is longer. */
static void set_width(struct reader *reader, double width, const char *text,
                      const char *attribute)
{
    if (!is_open(&reader->facts, "sensor-width"))
        return;
    if (text)
        set_fact_text(reader, "sensor-width", text, attribute);
    else
        set_fact(reader, "sensor-width", width, attribute);
    if (!is_sensor_typed(reader->settings))
        set_fact(reader, "sensor-fit", RF_SENSOR_FIT_HORIZONTAL, attribute);
}

/* Keeps how wide the picture is, against which what the user typed is held. */
static void keep_width(struct reader *reader, double width, const char *attribute)
{
    struct settings *settings = reader->settings;
    if (settings->seen_width > 0)
        return;
    settings->seen_width = width;
    snprintf(settings->seen_by, sizeof(settings->seen_by), "%s", attribute);
}

static void read_angle(struct reader *reader, int part)
{
    int n_parts;
    double width;
    const char *attribute;
    const struct image_part_info *parts = image_parts(reader->input, &n_parts);
    const struct settings *known =
        is_open(reader->settings, "focal-length") ? &reader->facts : reader->settings;
    if (part < 0 || part >= n_parts || !is_open(&reader->facts, "focal-length-px") ||
        !(attribute = camera_facts_width(reader->input, &parts[part], &width)))
        return;
    set_width(reader, width * known->params.focal_length, NULL, attribute);
    keep_width(reader, width, attribute);
}

/* What the programs say that do not use the standard attributes. */
static void read_foreign_attributes(struct reader *reader, int part)
{
    struct camera_fact found[CAMERA_MOST_FACTS];
    const int n = camera_facts_read(reader->input, found);
    for (int i = 0; i < n; i++) {
        const struct camera_fact *fact = &found[i];
        if (strcmp(fact->key, "sensor-width") == 0)
            set_width(reader, fact->value, fact->text, fact->attribute);
        else if (fact->text)
            set_fact_text(reader, fact->key, fact->text, fact->attribute);
        else
            set_fact(reader, fact->key, fact->value, fact->attribute);
    }
    double focal, sensor;
    if (n > 1 && fact_value(reader, "focal-length", &focal) &&
        fact_value(reader, "sensor-width", &sensor))
        keep_width(reader, sensor / focal, found[1].attribute);
    read_angle(reader, part);
}

/* ---- one fact in two parameters -------------------------------------------------- */

/* The value that holds for `name`: typed, else from the header; false if neither. */
static bool known_value(const struct reader *reader, const char *name, double *value)
{
    const bool is_user = is_typed(reader->settings, name);
    const struct settings *source = is_user ? reader->settings : &reader->facts;
    *value = number_of(&source->params, name);
    return is_user || is_from(&reader->facts, name, ORIGIN_HEADER);
}

/* Replaces a fact by what follows from the options `because`. 0 leaves it to the core.
 */
static void derive(struct reader *reader, const char *name, double value,
                   const char *because)
{
    struct settings *facts = &reader->facts;
    const double scaled = fmin(value, rf_param_find(name)->max);
    rf_params_set_number(&facts->params, name, scaled, NULL);
    set_origin(facts, name, ORIGIN_DERIVED, because);
}

/*
 * R = f / (2 N). The header gives R, the user N or f: R is scaled by the old over the
 * new f-stop and the new over the old focal length; where the header lacks the old one,
 * R follows from the formula, provided that both are known.
 */
static bool settle_lens_radius(struct reader *reader)
{
    const bool has_stop = is_typed(reader->settings, "f-stop");
    const bool has_focal = is_typed(reader->settings, "focal-length");
    double radius, old_stop, old_focal, stop, focal, projection;
    if (is_typed(reader->settings, "lens-radius") || !(has_stop || has_focal) ||
        !fact_value(reader, "lens-radius", &radius) || radius == 0)
        return true;
    const char *because = has_stop && has_focal ? "(--f-stop, --focal-length)"
                          : has_stop            ? "(--f-stop)"
                                                : "(--focal-length)";
    const bool has_old_stop = fact_value(reader, "f-stop", &old_stop);
    const bool has_old_focal = fact_value(reader, "focal-length", &old_focal);
    const bool is_stop_known = known_value(reader, "f-stop", &stop);
    const bool is_focal_known = known_value(reader, "focal-length", &focal);
    known_value(reader, "projection", &projection);
    if ((!has_stop || has_old_stop) && (!has_focal || has_old_focal)) {
        const double by_stop = has_stop ? old_stop / stop : 1;
        const double by_focal = has_focal ? focal / old_focal : 1;
        derive(reader, "lens-radius", radius * by_stop * by_focal, because);
        return true;
    }
    const bool is_ortho = projection == RF_PROJECTION_ORTHOGRAPHIC;
    if (is_stop_known && (is_focal_known || is_ortho)) {
        derive(reader, "lens-radius", 0, because);
        return true;
    }
    const char *typed = has_stop ? "f-stop" : "focal-length";
    snprintf(reader->text, reader->n_bytes,
             "%s: its header gives the lens radius (%g) without %s, so --%s cannot be "
             "applied; give --lens-radius %.3g for one stop more blur or --lens-radius "
             "%.3g for one stop less, or --f-stop and --focal-length together",
             image_path(reader->input), radius,
             has_stop ? "an f-stop" : "a focal length", typed, radius * M_SQRT2,
             radius * M_SQRT1_2);
    return false;
}

/*
 * f_px = W f / S. The header gives f_px, the user f or the sensor: f_px follows from
 * the formula where f and S are known, else it is scaled by the new over the old f.
 */
static bool settle_focal_length_px(struct reader *reader)
{
    const bool has_focal = is_typed(reader->settings, "focal-length");
    const bool has_sensor = is_sensor_typed(reader->settings);
    double focal_px, focal, old_focal, sensor;
    if (is_typed(reader->settings, "focal-length-px") || !(has_focal || has_sensor) ||
        !fact_value(reader, "focal-length-px", &focal_px) || focal_px == 0)
        return true;
    const bool is_focal_known = known_value(reader, "focal-length", &focal);
    const bool is_sensor_known = known_value(reader, "sensor-width", &sensor) ||
                                 known_value(reader, "sensor-height", &sensor);
    if (is_focal_known && is_sensor_known) {
        derive(reader, "focal-length-px", 0,
               has_focal ? "(--focal-length)" : "(--sensor-*)");
        return true;
    }
    if (has_focal && !has_sensor && fact_value(reader, "focal-length", &old_focal)) {
        derive(reader, "focal-length-px", focal_px * focal / old_focal,
               "(--focal-length)");
        return true;
    }
    snprintf(
        reader->text, reader->n_bytes,
        "%s: its header gives the focal length in pixels only (%g), so --%s cannot "
        "be applied; give --focal-length-px, or --focal-length and --sensor-width "
        "together",
        image_path(reader->input), focal_px,
        has_focal ? "focal-length" : "sensor-width");
    return false;
}

/* Facts that would hide what the user typed and simply give way to it. */
static void drop_hidden_facts(struct reader *reader)
{
    static const struct {
        const char *typed, *fact, *because;
    } rules[] = {
        {"focus-distance", "screen-position", "(--focus-distance)"},
        {"f-stop", "aperture-coefficient", "(--f-stop)"},
        {"lens-radius", "aperture-coefficient", "(--lens-radius)"},
        {"blades", "aperture", "(--blades)"},
    };
    for (size_t i = 0; i < sizeof(rules) / sizeof(rules[0]); i++)
        if (is_typed(reader->settings, rules[i].typed) &&
            is_from(&reader->facts, rules[i].fact, ORIGIN_HEADER))
            derive(reader, rules[i].fact, 0, rules[i].because);
}

/* ---- the whole header ------------------------------------------------------------ */

/* What was set before, on the command line or by another file, wins over the facts. */
static void merge_facts(struct reader *reader)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    struct settings *settings = reader->settings;
    for (size_t i = 0; i < n; i++) {
        if (settings->origins[i] != ORIGIN_DEFAULT ||
            reader->facts.origins[i] == ORIGIN_DEFAULT)
            continue;
        rf_params_set_number(&settings->params, list[i].key,
                             number_of(&reader->facts.params, list[i].key), NULL);
        set_origin(settings, list[i].key, reader->facts.origins[i],
                   reader->facts.sources[i]);
    }
}

void settings_imply(struct settings *settings)
{
    if (!is_typed(settings, "ortho-scale") || is_typed(settings, "projection"))
        return;
    settings->params.projection = RF_PROJECTION_ORTHOGRAPHIC;
    set_origin(settings, "projection", ORIGIN_COMMAND_LINE, "(--ortho-scale)");
}

bool settings_read_header(struct settings *settings, const struct image_input *input,
                          int part, char *text, size_t n_bytes)
{
    struct reader reader = {
        .settings = settings, .input = input, .text = text, .n_bytes = n_bytes};
    settings_init(&reader.facts);
    settings_imply(settings);
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        if (!read_own_attribute(&reader, &list[i]))
            return false;
    read_standard_attributes(&reader);
    read_foreign_attributes(&reader, part);
    int n_parts;
    const struct image_part_info *parts = image_parts(input, &n_parts);
    if (part >= 0 && part < n_parts && parts[part].pixel_aspect != 1)
        set_fact(&reader, "pixel-aspect", parts[part].pixel_aspect, "pixelAspectRatio");
    if (!settle_lens_radius(&reader) || !settle_focal_length_px(&reader))
        return false;
    drop_hidden_facts(&reader);
    merge_facts(&reader);
    return true;
}

/* ---- windows --------------------------------------------------------------------- */

static int32_t side(int32_t min, int32_t max)
{
    return max - min + 1;
}

/* The shift that puts the principal point at `target_px`; it depends linearly on it. */
static double solve_shift(double at_zero, double at_one, double target_px)
{
    return (target_px - at_zero) / (at_one - at_zero);
}

/* Half of the diagonal of a box, px of the picture's width. */
static double half_diagonal(const struct image_box *box, double pixel_aspect)
{
    return hypot(side(box->min_x, box->max_x),
                 side(box->min_y, box->max_y) / pixel_aspect) /
           2;
}

/*
 * The looks that count places in halves of the diagonal (core/lens/look.c), for the data
 * window of a picture whose display window has `scale` of its diagonal: `power` is that
 * of the place in the look's formula.
 */
static bool scale_looks(struct rf_params *params, double scale)
{
    static const struct {
        const char *key;
        int power;
    } looks[] = {{"cat-eye", 1},        {"barn-left", 1},       {"barn-right", 1},
                 {"barn-top", 1},       {"barn-bottom", 1},     {"astigmatism", 2},
                 {"swirl", 2},          {"field-curvature", 2}, {"split-offset", -1},
                 {"split-softness", -1}};
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        const double value = number_of(params, looks[i].key);
        if (rf_params_set_number(params, looks[i].key,
                                 value * pow(scale, -looks[i].power), NULL) != RF_OK)
            return false;
    }
    return true;
}

bool settings_fit_looks(const struct image_part_info *part, struct rf_params *params)
{
    const struct image_box *data = &part->data_window, *display = &part->display_window;
    const double aspect = params->pixel_aspect;
    struct rf_params scaled = *params;
    if (data->min_x + data->max_x != display->min_x + display->max_x ||
        data->min_y + data->max_y != display->min_y + display->max_y ||
        !scale_looks(&scaled,
                     half_diagonal(display, aspect) / half_diagonal(data, aspect)))
        return false;
    *params = scaled;
    return true;
}

rf_result settings_fit_window(const struct settings *settings,
                              const struct image_part_info *part,
                              struct rf_params *params, struct rf_error *error)
{
    const struct image_box *data = &part->data_window, *display = &part->display_window;
    *params = settings->params;
    if (memcmp(data, display, sizeof(*data)) == 0)
        return RF_OK;
    struct rf_lens whole, centred, shifted;
    const int32_t width = side(data->min_x, data->max_x);
    const int32_t height = side(data->min_y, data->max_y);
    rf_result result =
        rf_lens_init(&whole, params, side(display->min_x, display->max_x),
                     side(display->min_y, display->max_y), error);
    if (result != RF_OK)
        return result;
    params->shift_x = params->shift_y = 0;
    result = rf_lens_init(&centred, params, width, height, error);
    params->shift_x = params->shift_y = 1;
    if (result == RF_OK)
        result = rf_lens_init(&shifted, params, width, height, error);
    if (result != RF_OK)
        return result;
    params->shift_x = solve_shift(centred.principal_px[0], shifted.principal_px[0],
                                  whole.principal_px[0] + display->min_x - data->min_x);
    params->shift_y = solve_shift(centred.principal_px[1], shifted.principal_px[1],
                                  whole.principal_px[1] + display->min_y - data->min_y);
    if (params->projection == RF_PROJECTION_ORTHOGRAPHIC)
        params->ortho_scale *= centred.px_per_unit / whole.px_per_unit;
    else
        params->focal_length_px = whole.focal_length_px;
    if (params->max_radius == 0)
        params->max_radius = whole.max_radius_px;
    settings_fit_looks(part, params);
    return RF_OK;
}

void settings_print_options(const struct rf_params *params, char *text, size_t n_bytes)
{
    size_t n, used = 0;
    const struct rf_param_info *list = rf_param_list(&n);
    struct rf_params defaults;
    rf_params_init(&defaults);
    *text = 0;
    for (size_t i = 0; i < n && used < n_bytes; i++) {
        char value[64];
        if (number_of(params, list[i].key) == number_of(&defaults, list[i].key))
            continue;
        rf_params_get(params, list[i].key, value, sizeof(value));
        used += (size_t)snprintf(text + used, n_bytes - used, "%s--%s %s",
                                 used ? " " : "", list[i].key, value);
    }
}
