/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of a sequence: going to one, playing them, key frames of focus and aperture. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "clock.h"

static int32_t frame_of(const struct app *app, int picture)
{
    return pull_frame_of(app->playlist.pictures[picture].paths[0], picture + 1);
}

void play_go(struct app *app, int picture)
{
    const int n = app->playlist.n;
    picture = picture >= n ? n - 1 : picture < 0 ? 0 : picture;
    app->play.wanted = picture;
    if (app->loader.is_running || picture == app->picture)
        return;
    app->picture = picture;
    load_begin(app);
}

/* ---- key frames ------------------------------------------------------------------- */

static const char *aperture_key(const struct app *app)
{
    return app->pull.is_radius ? "lens-radius" : "f-stop";
}

void play_set_key(struct app *app)
{
    const struct state *state = &app->state;
    if (play_defer(app, play_set_key))
        return;
    if (app->playlist.n < 2) {
        view_say(app, "keys are for sequences: start with a folder of frames");
        return;
    }
    if (app->pull.n == 0)
        app->pull.is_radius = isnan(state_f_stop(state));
    const struct pull_key key = {.frame = frame_of(app, app->picture),
                                 .focus = state->settings.params.focus_distance,
                                 .aperture = app->pull.is_radius
                                                 ? state->lens.lens_radius
                                                 : state_f_stop(state)};
    if (isnan(key.aperture))
        view_say(app, "the f-stop is not known here; the keys so far have one");
    else if (pull_set(&app->pull, &key))
        view_say(app, "key at frame %d: focus %.5g, %s %.5g", key.frame, key.focus,
                 aperture_key(app), key.aperture);
    else
        view_say(app, "there are %d keys already", PULL_MAX);
}

static void remove_key(struct app *app)
{
    if (play_defer(app, remove_key))
        return;
    const int32_t frame = frame_of(app, app->picture);
    if (pull_remove(&app->pull, frame))
        view_say(app, "no key at frame %d any more", frame);
}

static void apply_pull(struct app *app)
{
    struct pull_key key;
    struct state *state = &app->state;
    if (app->playlist.n < 2 || !pull_at(&app->pull, frame_of(app, app->picture), &key))
        return;
    state_set(state, "focus-distance", key.focus);
    if (state->settings.params.lens_radius > 0 || app->pull.is_radius ||
        fabs(state_f_stop(state) - key.aperture) > 1e-9)
        state_set(state, aperture_key(app), key.aperture);
}

void play_take_frame(struct app *app)
{
    if (!app->has_stage)
        return;
    apply_pull(app);
    if (!app->play.is_on && app->play.wanted != app->picture)
        play_go(app, app->play.wanted);
    void (*const then)(struct app * app) = app->play.then;
    if (then && !app->loader.is_running) {
        app->play.then = NULL;
        then(app);
    }
}

static void save_keys(struct app *app)
{
    char path[MAX_PATH];
    struct image_error error;
    save_name_beside(app, ".csv", path);
    if (!save_may_replace(app, path))
        return;
    if (pull_write(&app->pull, path, &error))
        view_say(app, "saved %s; filter takes it with --frame-parameters", path);
    else
        view_say(app, "%s", error.message);
    trace_text(app, "saved", app->status);
}

/* ---- playing ---------------------------------------------------------------------- */

static uint32_t hash(uint32_t sum, const void *data, size_t n_bytes)
{
    for (const unsigned char *at = data; n_bytes > 0; n_bytes--)
        sum = (sum ^ *at++) * 16777619u;
    return sum;
}

/* All that the frames share and that makes them what they are. */
static uint32_t look_of(const struct app *app)
{
    static struct look look; /* too large for the stack; of this thread alone */
    static const char *const of_keys[] = {"focus-distance", "f-stop", "lens-radius"};
    const struct state *state = &app->state;
    state_look(state, &look);
    for (size_t i = 0; i < 3 && app->pull.n > 0; i++)
        settings_take(&look.typed, &state->started, of_keys[i]);
    uint32_t sum = hash(2166136261u, &look, sizeof(look));
    sum = hash(sum, app->pull.keys, (size_t)app->pull.n * sizeof(*app->pull.keys));
    sum = hash(sum, &state->mode, sizeof(state->mode));
    return hash(sum, &state->colour, sizeof(state->colour));
}

bool play_keep(struct app *app, const struct shot *shot)
{
    const bool is_whole = shot->quality == SHOT_BEST && shot->id == app->state.id &&
                          !shot->is_pinhole && shot->times == 1 &&
                          !app->loader.is_running && !app->state.has_eye;
    if (app->playlist.n < 2 || !is_whole)
        return false;
    if (app->frames.n != app->playlist.n)
        frames_start(&app->frames, app->playlist.n);
    const struct frame_shot kept = {.rgba = shot->rgba,
                                    .width = shot->width,
                                    .height = shot->height,
                                    .look = look_of(app)};
    frames_keep(&app->frames, app->picture, &kept);
    return true;
}

static void say_frame(struct app *app, const char *how)
{
    char text[64];
    snprintf(text, sizeof(text), "%d %s", frame_of(app, app->play.at), how);
    trace_text(app, "frame", text);
}

static void show_frame(struct app *app, int picture, const struct frame_shot *shot)
{
    const double now_s = os_clock_s(), step_s = 1 / app->play.rate;
    gl_picture_put(&app->after, shot->rgba, shot->width, shot->height);
    app->play.at = picture;
    app->play.is_ahead = picture != app->picture;
    /* Where a frame came late the next ones come as fast as they should, not faster. */
    app->play.due_s = fmax(app->play.due_s + step_s, now_s);
    app->is_redraw_due = true;
    say_frame(app, "played");
}

void play_step(struct app *app)
{
    struct play *play = &app->play;
    if (!play->is_on || os_clock_s() < play->due_s)
        return;
    const int next = (play->at + 1) % app->playlist.n;
    const struct frame_shot *shot = frames_find(&app->frames, next, look_of(app));
    if (shot)
        show_frame(app, next, shot);
    else if (!app->loader.is_running && app->picture != next)
        play_go(app, next);
}

double play_waits_s(const struct app *app)
{
    if (!app->play.is_on)
        return INFINITY;
    return fmin(fmax(app->play.due_s - os_clock_s(), 0.001), 0.02);
}

void play_toggle(struct app *app)
{
    struct play *play = &app->play;
    if (app->playlist.n < 2) {
        view_say(app, "there is one picture; start with a folder of frames to play");
        return;
    }
    play->is_on = !play->is_on;
    play->due_s = os_clock_s();
    if (!play->is_on) {
        play_go(app, play->at); /* what is shown can be worked with */
        return;
    }
    play->at = app->picture;
    app->state.is_filter_on = true;
    app->state.is_split = false;
}

bool play_defer(struct app *app, void (*action)(struct app *app))
{
    struct play *play = &app->play;
    if (play->is_on)
        play_toggle(app);
    else if (!play->then)
        return false;
    play->then = app->loader.is_running ? action : NULL;
    return play->then != NULL;
}

bool play_lacks_pixels(struct app *app)
{
    if (!app->play.is_ahead)
        return false;
    if (app->play.is_on)
        play_toggle(app);
    view_say(app, "playing stops at frame %d, which is read now: once more after that",
             frame_of(app, app->play.at));
    return true;
}

/* ---- the panel -------------------------------------------------------------------- */

static void frame_row(struct app *app)
{
    char text[64];
    struct ui *ui = &app->ui;
    const int n = app->playlist.n,
              shown = app->play.is_on ? app->play.at : app->picture;
    const struct ui_number slider = {.label = "Frame",
                                     .unit = "",
                                     .min = 1,
                                     .max = n,
                                     .min_limit = 1,
                                     .max_limit = n,
                                     .is_whole = true};
    double at = shown + 1;
    ui_about(ui, &(struct ui_about){.tip = "Which picture of the folder is shown."});
    if (ui_number(ui, &slider, &at)) {
        app->play.is_on = false;
        play_go(app, (int)at - 1);
    }
    snprintf(text, sizeof(text), "%d, %d of %d", frame_of(app, shown), shown + 1, n);
    ui_readout(ui, "Number", text);
}

static void key_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    char text[96];
    const int shown = app->play.is_on ? app->play.at : app->picture;
    const bool has_key = pull_has(&app->pull, frame_of(app, shown));
    snprintf(text, sizeof(text), "%d%s", app->pull.n, has_key ? ", one here" : "");
    ui_readout(ui, "Keys", text);
    ui_columns(ui, 2);
    ui_about(ui, &(struct ui_about){
                     .tip = "Keeps focus and aperture as they are at this frame; those "
                            "between two keys go from one to the other."});
    if (ui_button(ui, "Set key (M)"))
        play_set_key(app);
    ui_about(ui,
             &(struct ui_about){.why_off = has_key ? NULL : "there is no key here"});
    if (ui_button(ui, "Remove key"))
        remove_key(app);
    ui_about(ui, &(struct ui_about){
                     .tip = "As CSV, for rackfocus filter --frame-parameters.",
                     .why_off = app->pull.n > 0 ? NULL : "there are no keys"});
    if (ui_button(ui, "Save keys"))
        save_keys(app);
}

void play_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct ui_number rate = {.label = "Frames a second",
                                   .unit = "",
                                   .min = 1,
                                   .max = 60,
                                   .min_limit = 0.1,
                                   .max_limit = 240};
    if (app->playlist.n < 2 || !ui_section(ui, "Frames", true))
        return;
    frame_row(app);
    bool is_on = app->play.is_on;
    ui_about(ui, &(struct ui_about){
                     .tip = "Plays the frames: at first as fast as they are made, then "
                            "from memory at the given speed."});
    if (ui_toggle(ui, "Play (L)", &is_on))
        play_toggle(app);
    ui_number(ui, &rate, &app->play.rate);
    key_rows(app);
}
