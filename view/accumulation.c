/* SPDX-License-Identifier: Apache-2.0 */
#include "accumulation.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "common/report.h"

#define SEEN_S 0.03 /* of drawing between two frames of the window while it is seen */
#define UNSEEN_S 0.012 /* while something else is: the mouse must not wait */
#define WORKER_MS 10   /* between two looks whether the picture is there */

/* ---- on and off ------------------------------------------------------------------- */

static void drop_reference(struct app *app)
{
    if (app->reference && app->reference->n_views > 0) {
        reference_drop(app->reference);
        app->reference = NULL;
    }
    app->accumulation.n_published = 0;
    app->accumulation.is_picture_good = false;
}

static bool make_memory(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    const size_t n = (size_t)app->demo.width * (size_t)app->demo.height;
    if (!a->mean)
        a->mean = app_memory(n, 3 * sizeof(float), NULL);
    if (!a->rgba)
        a->rgba = app_memory(n, 4, NULL);
    if (!a->tone)
        a->tone = tone_create();
    return a->mean && a->rgba && a->tone && demo_views_make(&a->views, &app->demo);
}

void accumulation_switch(struct app *app, bool is_on)
{
    struct accumulation *a = &app->accumulation;
    if (!app->options->is_demo || a->is_on == is_on)
        return;
    if (is_on && !make_memory(app)) {
        view_say(app, "out of memory for the views");
        return;
    }
    a->is_on = is_on;
    a->views.n = 0; /* begins anew */
    drop_reference(app);
    if (is_on) {
        reference_drop(app->reference);
        app->reference = NULL;
        app->reference_path[0] = 0;
    }
    app->state.compares_reference = app->state.draws_views = is_on;
    if (!is_on && app->state.mode == MODE_DIFFERENCE)
        app->state.mode = MODE_PICTURE;
    app->state.id++;
    app->is_redraw_due = true;
}

void accumulation_toggle(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    if (!app->options->is_demo) {
        view_say(app, "views are drawn in the demo: rackfocus view --demo; those of "
                      "files are averaged by rackfocus accumulate");
        return;
    }
    if (!a->is_on && app->demo.is_stereo) {
        view_say(app, "views are those of one eye: switch Both eyes off first");
        return;
    }
    accumulation_switch(app, !a->is_on);
    if (a->is_on)
        view_say(app,
                 "%d views are drawn and accumulated: F flips, S wipes, X shows "
                 "the difference",
                 a->n);
}

void accumulation_close(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    demo_views_free(&a->views);
    gl_picture_free(&a->picture);
    free(a->mean);
    free(a->rgba);
    tone_destroy(a->tone);
    *a = (struct accumulation){0};
}

/* ---- what is seen of it ----------------------------------------------------------- */

static bool is_seen(const struct app *app)
{
    const struct state *state = &app->state;
    return state->compares_reference && state->mode == MODE_PICTURE &&
           (state->is_split || !state->is_filter_on);
}

const struct gl_picture *accumulation_picture(const struct app *app)
{
    const struct accumulation *a = &app->accumulation;
    return a->is_on && a->is_picture_good && app->state.compares_reference ? &a->picture
                                                                           : NULL;
}

static void put_picture(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    const int32_t width = app->demo.width, height = app->demo.height;
    const size_t n = (size_t)width * (size_t)height;
    if (app->state.colour)
        colour_show(app->state.colour, a->mean, 3, n, app->state.exposure, a->rgba);
    else
        display_picture(a->tone, a->mean, 3, n, app->state.exposure, a->rgba);
    gl_picture_put(&a->picture, a->rgba, width, height);
    a->is_picture_good = true;
    app->is_redraw_due = true;
}

/* Gives the mean to the worker, which measures against it. */
static void publish(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    const size_t n = (size_t)app->demo.width * (size_t)app->demo.height;
    struct picture picture = {.samples = app_memory(n, 3 * sizeof(float), NULL),
                              .width = app->demo.width,
                              .height = app->demo.height};
    a->n_published = a->views.n_done;
    if (!picture.samples) {
        view_say(app, "out of memory for the reference");
        return;
    }
    demo_views_mean(&a->views, &app->demo, picture.samples);
    struct reference *made = reference_create(&picture, a->views.n_done);
    reference_drop(app->reference);
    app->reference = made;
    app->state.id++;
    app->is_redraw_due = true;
    if (a->views.n_done == a->views.n) {
        char text[96];
        snprintf(text, sizeof(text), "%d views in %.0f ms", a->views.n,
                 a->views.drawn_ms);
        trace_text(app, "accumulated", text);
    }
}

/* ---- the main loop ---------------------------------------------------------------- */

/* Points the views at what is set now. False where they cannot be drawn. */
static bool aim(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    struct rf_error error;
    bool is_new;
    if (!demo_views_aim(&a->views, &app->demo, a->n, a->move, &app->state.params,
                        &app->state.lens, &is_new, &error)) {
        drop_reference(app);
        a->views.n = 0;
        if (strcmp(a->problem, error.message) != 0)
            view_say(app, "no views: %.300s", error.message);
        snprintf(a->problem, sizeof(a->problem), "%s", error.message);
        return false;
    }
    a->problem[0] = 0;
    if (is_new)
        drop_reference(app);
    return true;
}

static bool is_worker_busy(const struct app *app)
{
    struct worker_state worker;
    worker_state(app->worker, &worker);
    return worker.is_busy || app->state.id != app->asked_id;
}

static bool has_all(const struct accumulation *a)
{
    return a->views.n > 0 && a->views.n_done == a->views.n;
}

void accumulation_step(struct app *app)
{
    struct accumulation *a = &app->accumulation;
    if (!a->is_on || !app->has_stage || !app->state.is_valid || !aim(app))
        return;
    const bool is_difference = app->state.mode == MODE_DIFFERENCE;
    const bool is_first = is_difference && a->n_published == 0;
    /* The picture has the machine first, unless it waits for the views itself. */
    if (!is_seen(app) && !is_first && is_worker_busy(app))
        return;
    if (!has_all(a)) {
        const int before = a->views.n_done;
        demo_views_step(&a->views, &app->demo,
                        os_clock_s() + (is_seen(app) ? SEEN_S : UNSEEN_S));
        a->n_drawn += a->views.n_done - before;
        a->n_complete += has_all(a);
        a->is_picture_good = false;
    }
    if (is_seen(app) && !a->is_picture_good) {
        demo_views_mean(&a->views, &app->demo, a->mean);
        put_picture(app);
    }
    const bool is_grown = is_difference && a->views.n_done >= 2 * a->n_published;
    if (a->n_published < a->views.n_done && (is_grown || has_all(a)) &&
        (is_first || !is_worker_busy(app)))
        publish(app);
}

double accumulation_waits_ms(const struct app *app)
{
    const struct accumulation *a = &app->accumulation;
    if (!a->is_on || !app->has_stage || a->problem[0] ||
        (has_all(a) && a->n_published == a->views.n))
        return INFINITY;
    return has_all(a) || (!is_seen(app) && is_worker_busy(app)) ? WORKER_MS : 0;
}

/* ---- the panel -------------------------------------------------------------------- */

static void pattern_row(struct app *app, const char *why_off)
{
    const char *names[16], *tips[16];
    const struct rf_param_info *info = rf_param_find("lens-pattern");
    for (int i = 0; i < info->n_choices && i < 16; i++) {
        names[i] = info->choices[i].name;
        tips[i] = info->choices[i].help;
    }
    int index = app->state.settings.params.lens_pattern;
    ui_about(&app->ui, &(struct ui_about){
                           .tip = info->help, .why_off = why_off, .choice_tips = tips});
    if (ui_choice(&app->ui, "Points", names, info->n_choices, &index) &&
        !state_set(&app->state, "lens-pattern", index))
        ui_fail(&app->ui, app->state.problem);
}

void accumulation_rows(struct app *app)
{
    static const char *const moves[] = {"shift", "look-at"};
    static const char *const move_tips[] = {
        "The axis stays parallel: the plane in focus does not move.",
        "The camera turns to the middle of the plane in focus, which alone stays "
        "sharp."};
    struct ui *ui = &app->ui;
    struct accumulation *a = &app->accumulation;
    const char *why_off = a->is_on ? NULL : "no views are accumulated: press V";
    char text[64];
    bool is_on = a->is_on;
    ui_about(ui, &(struct ui_about){.tip = "OpenGL draws the scene from points of the "
                                           "lens and averages it: what a lens sees."});
    if (ui_toggle(ui, "Accumulate views (V)", &is_on))
        accumulation_toggle(app);
    const struct ui_number number = {.label = "Views",
                                     .unit = "",
                                     .min = 1,
                                     .max = DEMO_MOST_VIEWS,
                                     .min_limit = 1,
                                     .max_limit = DEMO_MOST_VIEWS,
                                     .is_log = true,
                                     .is_whole = true};
    double n = a->n;
    ui_about(ui, &(struct ui_about){.tip = "How many points of the lens; one is the "
                                           "pinhole in its middle.",
                                    .why_off = why_off});
    if (ui_number(ui, &number, &n))
        a->n = (int)lrint(n);
    if (ui_was_reset(ui))
        a->n = DEMO_MOST_VIEWS;
    int move = (int)a->move;
    ui_about(ui, &(struct ui_about){.tip = "How the camera moves from point to point.",
                                    .why_off = why_off,
                                    .choice_tips = move_tips});
    if (ui_choice(ui, "Camera move", moves, 2, &move))
        a->move = (enum demo_move)move;
    pattern_row(app, why_off);
    if (!a->is_on || a->views.n == 0)
        return;
    snprintf(text, sizeof(text), "%d of %d, %.0f ms", a->views.n_done, a->views.n,
             a->views.drawn_ms);
    ui_readout(ui, "Drawn", text);
}
