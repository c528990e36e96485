/* SPDX-License-Identifier: Apache-2.0 */
#include "model/state.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "sources/looks.h"

void state_init(struct state *state, const struct settings *typed, double exposure)
{
    *state = (struct state){.started = *typed,
                            .typed = *typed,
                            .is_filter_on = true,
                            .split = 0.5,
                            .exposure = exposure,
                            .gain = 1,
                            .zoom = {.scale = 1, .aspect = 1, .is_fitted = true}};
}

void state_begin_look(struct state *state, const char *name,
                      const struct settings *below)
{
    size_t n;
    struct setters *setters = &state->setters;
    const struct rf_param_info *list = rf_param_list(&n);
    memcpy(&setters->below, below, sizeof(*below)); /* compared with padding */
    snprintf(setters->look, sizeof(setters->look), "%s", name);
    for (size_t i = 0; i < n; i++)
        if (settings_origin(&state->typed, list[i].key) == ORIGIN_COMMAND_LINE &&
            settings_origin(below, list[i].key) != ORIGIN_COMMAND_LINE)
            setters->of_typed[i] = SETTER_LOOK;
}

/* ---- parameters ----------------------------------------------------------------- */

/* `setters` of what was typed; NULL: they stay. */
static bool resolve(struct state *state, const struct settings *typed,
                    const struct setters *setters)
{
    struct settings settings;
    struct rf_params params;
    struct rf_lens lens;
    struct rf_error error;
    if (!state->resolver.resolve(state->resolver.user, typed, &settings, &params,
                                 state->problem, sizeof(state->problem)))
        return false;
    if (rf_params_check(&params, &error) != RF_OK ||
        rf_lens_init(&lens, &params, state->width, state->height, &error) != RF_OK) {
        snprintf(state->problem, sizeof(state->problem), "%s", error.message);
        return false;
    }
    state->typed = *typed;
    if (setters)
        memcpy(&state->setters, setters, sizeof(*setters)); /* compared with padding */
    state->settings = settings;
    state->params = params;
    state->lens = lens;
    state->is_valid = true;
    state->problem[0] = 0;
    state->id++;
    return true;
}

bool state_open(struct state *state, const struct resolver *resolver, int32_t width,
                int32_t height, double aspect)
{
    state->resolver = *resolver;
    state->width = width;
    state->height = height;
    state->zoom.aspect = aspect;
    state->is_valid = false;
    const struct settings typed = state->typed;
    return resolve(state, &typed, NULL);
}

static bool is_default(const struct state *state, const char *key)
{
    return settings_origin(&state->settings, key) == ORIGIN_DEFAULT;
}

/* Is it said how large the lens is in scene units, and nothing in millimetres? */
static bool lacks_millimetres(const struct state *state)
{
    return state->settings.params.lens_radius > 0 && is_default(state, "focal-length");
}

/* Parameters that say the same: setting one takes the other back, or the new value
 * would be hidden by the old one. */
static const struct {
    const char *a, *b;
} same[] = {
    {"f-stop", "lens-radius"},           {"focal-length", "focal-length-px"},
    {"sensor-width", "focal-length-px"}, {"focus-distance", "screen-position"},
    {"f-stop", "aperture-coefficient"},  {"lens-radius", "aperture-coefficient"},
};

static unsigned char *setter_of(struct setters *setters, const char *key)
{
    return &setters->of_typed[rf_param_find(key) - rf_param_list(NULL)];
}

/* Takes what says the same as `key` back to `from`; all of them are the setter's. */
static void take_back_others(const struct settings *from, struct settings *typed,
                             struct setters *setters, const char *key,
                             enum setter setter)
{
    *setter_of(setters, key) = (unsigned char)setter;
    for (size_t i = 0; i < sizeof(same) / sizeof(same[0]); i++) {
        const char *other = strcmp(key, same[i].a) == 0   ? same[i].b
                            : strcmp(key, same[i].b) == 0 ? same[i].a
                                                          : NULL;
        if (!other)
            continue;
        settings_take(typed, from, other);
        *setter_of(setters, other) = (unsigned char)setter;
    }
}

bool state_set(struct state *state, const char *key, double value)
{
    struct settings plain, typed = state->typed;
    struct setters setters = state->setters;
    struct rf_error error;
    char text[40];
    const struct rf_param_info *info = rf_param_find(key);
    if (!state->is_valid)
        return false;
    settings_init(&plain);
    take_back_others(&plain, &typed, &setters, key, SETTER_USER);
    if (info->choices)
        snprintf(text, sizeof(text), "%s", info->choices[(int)value].name);
    else if (info->type == RF_TYPE_BOOL)
        snprintf(text, sizeof(text), "%s", value != 0 ? "true" : "false");
    else
        snprintf(text, sizeof(text), "%.17g", fmin(fmax(value, info->min), info->max));
    if (settings_set(&typed, key, text, &error) != RF_OK) {
        snprintf(state->problem, sizeof(state->problem), "%s", error.message);
        return false;
    }
    return resolve(state, &typed, &setters);
}

bool state_reset(struct state *state, const char *key)
{
    struct settings typed = state->typed;
    struct setters setters = state->setters;
    if (!state->is_valid)
        return false;
    settings_take(&typed, &state->started, key);
    take_back_others(&state->started, &typed, &setters, key, SETTER_COMMAND_LINE);
    return resolve(state, &typed, &setters);
}

/* Takes what `over` says over `typed`, for the setter. */
static void put_over(const struct settings *over, struct settings *typed,
                     struct setters *setters, enum setter setter)
{
    struct settings plain;
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    settings_init(&plain);
    for (size_t i = 0; i < n; i++) {
        if (settings_origin(over, list[i].key) != ORIGIN_COMMAND_LINE)
            continue;
        take_back_others(&plain, typed, setters, list[i].key, setter);
        settings_take(typed, over, list[i].key);
    }
}

bool state_merge(struct state *state, const struct settings *over)
{
    struct settings typed = state->typed;
    struct setters setters = state->setters;
    if (!state->is_valid)
        return false;
    put_over(over, &typed, &setters, SETTER_USER);
    return resolve(state, &typed, &setters);
}

enum setter state_setter(const struct state *state, const char *key)
{
    const ptrdiff_t i = rf_param_find(key) - rf_param_list(NULL);
    return (enum setter)state->setters.of_typed[i];
}

/* Takes away what the look set that nobody has set since. */
static void take_back_look(struct settings *typed, struct setters *setters)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++) {
        if (setters->of_typed[i] != SETTER_LOOK)
            continue;
        settings_take(typed, &setters->below, list[i].key);
        setters->of_typed[i] = setters->of_below[i];
    }
}

bool state_set_look(struct state *state, const char *name)
{
    struct settings of_look, typed = state->typed;
    struct setters setters = state->setters;
    struct image_error error;
    settings_init(&of_look);
    if (!state->is_valid)
        return false;
    if (*name && !look_read(name, &of_look, &error)) {
        snprintf(state->problem, sizeof(state->problem), "%.500s", error.message);
        return false;
    }
    take_back_look(&typed, &setters);
    memset(&setters.below, 0, sizeof(setters.below));
    memset(setters.look, 0, sizeof(setters.look));
    if (*name) {
        memcpy(&setters.below, &typed, sizeof(typed));
        memcpy(setters.of_below, setters.of_typed, sizeof(setters.of_below));
        snprintf(setters.look, sizeof(setters.look), "%s", name);
    } else {
        memset(setters.of_below, 0, sizeof(setters.of_below));
    }
    put_over(&of_look, &typed, &setters, SETTER_LOOK);
    return resolve(state, &typed, &setters);
}

void state_look(const struct state *state, struct look *look)
{
    memset(look, 0, sizeof(*look)); /* its padding too */
    memcpy(&look->typed, &state->typed, sizeof(look->typed));
    memcpy(&look->setters, &state->setters, sizeof(look->setters));
    look->exposure = state->exposure;
}

bool state_apply(struct state *state, const struct look *look)
{
    if (!state->is_valid || !resolve(state, &look->typed, &look->setters))
        return false;
    state->exposure = look->exposure;
    return true;
}

/* ---- what has an effect ----------------------------------------------------------- */

static const char *why_not_read(const struct rf_params *params, const char *key)
{
    const char *why;
    rf_param_is_read(params, key, &why);
    return why;
}

const char *state_why_off(const struct state *state, const char *key)
{
    static const char *const of_mm[] = {"f-stop", "focal-length", "unit-scale"};
    struct rf_params params = state->settings.params;
    const char *why = why_not_read(&params, key);
    if (why && state->draws_views) {
        struct rf_params of_views = params;
        of_views.method = RF_METHOD_ACCUMULATE;
        why = why_not_read(&of_views, key) ? why : NULL;
    }
    if (!why)
        return NULL;
    const enum origin radius = settings_origin(&state->settings, "lens-radius");
    const bool is_of_units =
        radius == ORIGIN_HEADER ||
        (radius == ORIGIN_COMMAND_LINE &&
         settings_origin(&state->settings, "focal-length-px") == ORIGIN_HEADER);
    for (size_t i = 0; i < sizeof(of_mm) / sizeof(of_mm[0]); i++)
        if (strcmp(key, of_mm[i]) == 0 && lacks_millimetres(state) && is_of_units)
            return "the lens is given by its radius in scene units, without "
                   "millimetres: set the lens radius";
    if (settings_origin(&state->settings, "focal-length-px") == ORIGIN_HEADER &&
        is_default(state, "focal-length") && is_default(state, "sensor-width") &&
        strncmp(key, "sensor-", 7) == 0)
        return "the file gives the focal length in pixels alone";
    /* What the file says gives way to what is set. */
    params.lens_radius = params.focal_length_px = params.screen_position = 0;
    return why_not_read(&params, key) ? why : NULL;
}

bool state_is_guess(const struct state *state, const char *key)
{
    static const char *const facts[] = {"focus-distance", "f-stop", "focal-length",
                                        "sensor-width", "unit-scale"};
    for (size_t i = 0; i < sizeof(facts) / sizeof(facts[0]); i++)
        if (strcmp(key, facts[i]) == 0)
            return is_default(state, key) &&
                   !why_not_read(&state->settings.params, key);
    return false;
}

/* ---- the focus -------------------------------------------------------------------- */

bool state_focus(struct state *state, double depth)
{
    const struct rf_param_info *info = rf_param_find("focus-distance");
    char text[32];
    /* Six digits are a hundredth of a px of blur, and can be read and typed. */
    snprintf(text, sizeof(text), "%.6g", fmin(fmax(depth, info->min), info->max));
    double distance;
    sscanf(text, "%lf", &distance);
    return state_set(state, "focus-distance", distance);
}

bool state_set_screen(struct state *state, double position)
{
    const double f = state->lens.focal_length;
    if (!(f > 0) || position <= f) {
        snprintf(state->problem, sizeof(state->problem),
                 "the screen must stand beyond the focal length, %g scene units", f);
        return false;
    }
    return state_focus(state, position * f / (position - f));
}

double state_screen(const struct state *state)
{
    if (state->lens.screen_position > 0)
        return state->lens.screen_position;
    const double f = lacks_millimetres(state) ? 0 : state->lens.focal_length;
    return f > 0 ? rf_screen_position(f, state->lens.focus_distance) : NAN;
}

double state_f_stop(const struct state *state)
{
    const struct rf_lens *lens = &state->lens;
    if (state->params.lens_radius == 0)
        return state->params.f_stop;
    return lens->focal_length > 0 && !lacks_millimetres(state)
               ? lens->focal_length / (2 * lens->lens_radius)
               : NAN;
}

/* ---- the view ------------------------------------------------------------------- */

void state_toggle_mode(struct state *state, enum view_mode mode)
{
    state->mode = state->mode == mode ? MODE_PICTURE : mode;
    state->id++;
}

void state_toggle_filter(struct state *state)
{
    state->is_filter_on = !state->is_filter_on;
    state->id++;
}

void state_toggle_split(struct state *state)
{
    state->is_split = !state->is_split;
    state->id++;
}

void state_set_exposure(struct state *state, double stops)
{
    state->exposure = fmin(fmax(stops, -20), 20);
    state->id++;
}

void state_set_gain(struct state *state, double gain)
{
    state->gain = fmin(fmax(gain, 1), 64);
    state->id++;
}

void state_set_eye(struct state *state, bool is_on, double right, double up)
{
    const double r = hypot(right, up), scale = r > 1 ? 1 / r : 1;
    state->has_eye = is_on;
    state->eye[0] = is_on ? right * scale : 0;
    state->eye[1] = is_on ? up * scale : 0;
    state->id++;
}

void state_job(const struct state *state, struct input *input,
               struct reference *reference, struct job *job)
{
    const bool is_picture = state->mode == MODE_PICTURE;
    *job = (struct job){
        .id = state->id,
        .input = input,
        .params = state->params,
        .mode = state->mode,
        .exposure = state->exposure,
        .gain = state->gain,
        .has_eye = state->has_eye && is_picture,
        .eye = {state->eye[0], state->eye[1]},
        .wants_filter = state->is_filter_on || !is_picture || state->has_eye,
        .wants_pinhole = state->is_split || (is_picture && !state->is_filter_on),
        .reference = reference,
        .compares_reference = state->compares_reference && reference,
        .colour = state->colour};
    if (!job->has_eye)
        job->eye[0] = job->eye[1] = 0;
}
