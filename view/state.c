/* SPDX-License-Identifier: Apache-2.0 */
#include "state.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void state_init(struct state *state, const struct settings *typed, double exposure)
{
    *state = (struct state){.typed = *typed,
                            .is_filter_on = true,
                            .split = 0.5,
                            .exposure = exposure,
                            .zoom = {.scale = 1, .aspect = 1, .is_fitted = true}};
}

/* ---- parameters ----------------------------------------------------------------- */

static bool resolve(struct state *state, const struct settings *typed)
{
    struct settings settings;
    struct rf_params params;
    struct rf_lens lens;
    struct rf_error error;
    if (!state->resolver.resolve(state->resolver.user, typed, &settings, &params,
                                 state->problem, sizeof(state->problem)))
        return false;
    if (rf_lens_init(&lens, &params, state->width, state->height, &error) != RF_OK) {
        snprintf(state->problem, sizeof(state->problem), "%s", error.message);
        return false;
    }
    state->typed = *typed;
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
    return resolve(state, &typed);
}

bool state_set(struct state *state, const char *key, double value)
{
    struct settings typed = state->typed;
    struct rf_error error;
    char text[40];
    const struct rf_param_info *info = rf_param_find(key);
    if (!state->is_valid)
        return false;
    if (info->choices)
        snprintf(text, sizeof(text), "%s", info->choices[(int)value].name);
    else
        snprintf(text, sizeof(text), "%.17g", fmin(fmax(value, info->min), info->max));
    if (settings_set(&typed, key, text, &error) != RF_OK) {
        snprintf(state->problem, sizeof(state->problem), "%s", error.message);
        return false;
    }
    return resolve(state, &typed);
}

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
    const double f = state->lens.focal_length;
    return f > 0 ? rf_screen_position(f, state->lens.focus_distance) : NAN;
}

double state_f_stop(const struct state *state)
{
    const struct rf_lens *lens = &state->lens;
    if (state->params.lens_radius == 0)
        return state->params.f_stop;
    return lens->focal_length > 0 ? lens->focal_length / (2 * lens->lens_radius) : NAN;
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

void state_set_eye(struct state *state, bool is_on, double right, double up)
{
    const double r = hypot(right, up), scale = r > 1 ? 1 / r : 1;
    state->has_eye = is_on;
    state->eye[0] = is_on ? right * scale : 0;
    state->eye[1] = is_on ? up * scale : 0;
    state->id++;
}

void state_job(const struct state *state, struct input *input,
               const struct picture *reference, struct job *job)
{
    const bool is_picture = state->mode == MODE_PICTURE;
    *job = (struct job){
        .id = state->id,
        .input = input,
        .params = state->params,
        .mode = state->mode,
        .exposure = state->exposure,
        .has_eye = state->has_eye && is_picture,
        .eye = {state->eye[0], state->eye[1]},
        .wants_filter = state->is_filter_on || !is_picture || state->has_eye,
        .wants_pinhole = state->is_split || (is_picture && !state->is_filter_on),
        .reference = reference};
    if (!job->has_eye)
        job->eye[0] = job->eye[1] = 0;
}
