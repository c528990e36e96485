/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus-view: the window of `rackfocus view`. */
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "cli.h"
#include "clean_up.h"
#include "clock.h"
#include "cmd_view.h"
#include "interrupt.h"
#include "memory.h"
#include "report.h"

#define STATUS_S 6.0
#define DRAG_FRAME_S 0.04 /* between two frames without a new picture */

void view_say(struct app *app, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(app->status, sizeof(app->status), format, arguments);
    va_end(arguments);
    app->status_until_s = os_clock_s() + STATUS_S;
    app->state.problem[0] = 0;
    app->is_redraw_due = true;
    trace_text(app, "said", app->status);
}

bool view_depth_at(const struct app *app, double x, double y, double *depth,
                   int32_t *px, int32_t *py)
{
    const struct input *input = app->shot ? app->shot->input : NULL;
    const struct area area = view_picture_area(app);
    if (!app->has_stage || !input || !input->planar || !area_has(&area, x, y) ||
        !zoom_pick(&app->state.zoom, input->width, input->height, x, y, px, py))
        return false;
    *depth = input->planar[(size_t)*py * (size_t)input->width + (size_t)*px];
    return true;
}

/* ---- actions -------------------------------------------------------------------- */

static void focus_on_centre(struct app *app)
{
    const struct area area = view_picture_area(app);
    double depth;
    int32_t x, y;
    if (view_depth_at(app, area.x + area.width / 2.0, area.y + area.height / 2.0,
                      &depth, &x, &y))
        state_focus(&app->state, depth);
}

static void focus_nearest(struct app *app)
{
    if (app->options->is_demo)
        state_focus(&app->state, demo_distance(&app->demo, 0));
    else if (app->shot && app->shot->input)
        state_focus(&app->state, app->shot->input->nearest);
}

/* Multiplies the radius of the lens, by whichever parameter gives it. */
static void open_aperture(struct app *app, double factor)
{
    const double f_stop = state_f_stop(&app->state);
    struct state *state = &app->state;
    if (state->params.lens_radius > 0)
        state_set(state, "lens-radius", state->params.lens_radius * factor);
    else if (!isnan(f_stop))
        state_set(state, "f-stop", f_stop / factor);
}

static void show_difference(struct app *app)
{
    if (!app->has_reference)
        view_say(app, "there is no reference; start with --reference FILE");
    else if (app->reference.width != app->state.width ||
             app->reference.height != app->state.height)
        view_say(app, "%s: is %d x %d, the picture %d x %d: no difference can be shown",
                 app->options->reference, app->reference.width, app->reference.height,
                 app->state.width, app->state.height);
    else
        state_toggle_mode(&app->state, MODE_DIFFERENCE);
}

static void step_picture(struct app *app, int step)
{
    const int next = app->picture + step;
    if (app->loader.is_running || next < 0 || next >= app->playlist.n) {
        view_say(app, "picture %d of %d", app->picture + 1, app->playlist.n);
        return;
    }
    app->picture = next;
    load_begin(app);
}

static void zoom_in_window(struct app *app, double factor)
{
    const struct area area = view_picture_area(app);
    const double x = area.x + area.width / 2.0, y = area.y + area.height / 2.0;
    struct zoom *zoom = &app->state.zoom;
    if (factor == 0)
        zoom_fit(zoom, &area, app->state.width, app->state.height);
    else if (factor == 1)
        zoom_to_actual(zoom, x, y);
    else
        zoom_by(zoom, factor, x, y);
    zoom_settle(zoom, &area, app->state.width, app->state.height);
}

static void move(struct app *app, double right, double down)
{
    const struct area area = view_picture_area(app);
    if (app->options->is_demo) {
        demo_turn(&app->demo, 12 * right, 12 * down);
        app->is_demo_due = true;
    } else {
        zoom_pan(&app->state.zoom, -32 * right, -32 * down);
        zoom_settle(&app->state.zoom, &area, app->state.width, app->state.height);
    }
}

static void move_eye(struct app *app, double right, double up)
{
    const double *eye = app->state.eye;
    state_set_eye(&app->state, true, eye[0] + 0.125 * right, eye[1] + 0.125 * up);
}

static void go_home(struct app *app)
{
    state_set_eye(&app->state, false, 0, 0);
    if (app->options->is_demo) {
        app->demo.yaw = app->demo.pitch = 0;
        app->is_demo_due = true;
    }
    zoom_in_window(app, 0);
}

static void reload(struct app *app)
{
    if (app->stage)
        load_begin(app);
}

void view_act(struct app *app, enum action action)
{
    struct state *state = &app->state;
    const double focus = state->settings.params.focus_distance;
    if (action == ACTION_QUIT)
        app->is_ending = true;
    if (action == ACTION_HELP)
        app->has_help = !app->has_help;
    if (!app->has_stage)
        return;
    switch (action) {
    case ACTION_STATS:
        app->has_stats = !app->has_stats;
        stats_start(&app->stats, os_clock_s());
        break;
    case ACTION_PANEL:
        app->has_panel = !app->has_panel;
        window_measure(app);
        break;
    case ACTION_FILTER:
        state_toggle_filter(state);
        break;
    case ACTION_SPLIT:
        state_toggle_split(state);
        break;
    case ACTION_DEPTH:
        state_toggle_mode(state, MODE_DEPTH);
        break;
    case ACTION_COC:
        state_toggle_mode(state, MODE_COC);
        break;
    case ACTION_BAND:
        state_toggle_mode(state, MODE_BAND);
        break;
    case ACTION_DIFFERENCE:
        show_difference(app);
        break;
    case ACTION_CENTRE:
        focus_on_centre(app);
        break;
    case ACTION_NEARER:
        state_focus(state, focus / 1.05);
        break;
    case ACTION_FARTHER:
        state_focus(state, focus * 1.05);
        break;
    case ACTION_NEAREST:
        focus_nearest(app);
        break;
    case ACTION_INFINITY:
        state_focus(state, INFINITY);
        break;
    case ACTION_WIDER:
        open_aperture(app, pow(2, 1.0 / 6));
        break;
    case ACTION_NARROWER:
        open_aperture(app, pow(2, -1.0 / 6));
        break;
    case ACTION_BRIGHTER:
        state_set_exposure(state, state->exposure + 0.5);
        break;
    case ACTION_DARKER:
        state_set_exposure(state, state->exposure - 0.5);
        break;
    case ACTION_FIT:
        zoom_in_window(app, 0);
        break;
    case ACTION_ACTUAL:
        zoom_in_window(app, 1);
        break;
    case ACTION_ZOOM_IN:
        zoom_in_window(app, sqrt(2));
        break;
    case ACTION_ZOOM_OUT:
        zoom_in_window(app, sqrt(0.5));
        break;
    case ACTION_EYE_LEFT:
        move_eye(app, -1, 0);
        break;
    case ACTION_EYE_RIGHT:
        move_eye(app, 1, 0);
        break;
    case ACTION_EYE_UP:
        move_eye(app, 0, 1);
        break;
    case ACTION_EYE_DOWN:
        move_eye(app, 0, -1);
        break;
    case ACTION_LEFT:
        move(app, -1, 0);
        break;
    case ACTION_RIGHT:
        move(app, 1, 0);
        break;
    case ACTION_UP:
        move(app, 0, -1);
        break;
    case ACTION_DOWN:
        move(app, 0, 1);
        break;
    case ACTION_HOME:
        go_home(app);
        break;
    case ACTION_NEXT:
        step_picture(app, 1);
        break;
    case ACTION_PREVIOUS:
        step_picture(app, -1);
        break;
    case ACTION_RELOAD:
        reload(app);
        break;
    case ACTION_SAVE:
        save_picture(app);
        break;
    case ACTION_SAVE_PARAMS:
        save_params(app);
        break;
    case ACTION_SAVE_PASSES:
        save_passes(app);
        break;
    case ACTION_COPY:
        save_command(app);
        break;
    default:
        break;
    }
}

/* ---- passes --------------------------------------------------------------------- */

/* Tells the worker what is looked at now. */
void view_job(const struct app *app, const struct picture *reference, struct job *job)
{
    state_job(&app->state, app->source, reference, job);
    job->light = app->light.data ? &app->light : NULL;
}

static void ask(struct app *app)
{
    struct job job;
    if (app->is_demo_due) {
        input_drop(app->source);
        app->source = demo_draw(&app->demo);
        app->is_demo_due = false;
        app->state.id++;
    }
    if (!app->has_stage || !app->state.is_valid || app->state.id == app->asked_id) {
        stats_no_change(&app->stats);
        return;
    }
    app->asked_id = app->state.id;
    stats_change(&app->stats, app->state.id);
    view_job(app, app->has_reference ? &app->reference : NULL, &job);
    worker_ask(app->worker, &job);
}

void view_pass(struct app *app)
{
    panel_build(app);
    struct ui_input *input = &app->input;
    input->is_pressed = input->is_released = false;
    input->key = UI_KEY_NONE;
    input->text[0] = 0;
    input->wheel = 0;
    app->is_redraw_due = true;
}

/* Brings the newest picture into a texture; true where there was one. */
static bool take_shot(struct app *app, bool is_pinhole)
{
    struct shot *shot = worker_take(app->worker, is_pinhole);
    if (!shot)
        return false;
    app->is_redraw_due = true;
    if (shot->error[0]) {
        snprintf(app->state.problem, sizeof(app->state.problem), "%s", shot->error);
        trace_text(app, "problem", shot->error);
        shot_free(shot);
        return false;
    }
    const double start_s = os_clock_s();
    gl_picture_put(is_pinhole ? &app->before : &app->after, shot->rgba, shot->width,
                   shot->height);
    app->stats.draw_ms += 1000 * (os_clock_s() - start_s);
    free(shot->rgba);
    shot->rgba = NULL;
    if (is_pinhole && app->shot) {
        app->pinhole_id = shot->id;
        shot_free(shot);
    } else {
        shot_free(app->shot);
        app->shot = shot;
    }
    return true;
}

/* A slider is held, and the last frame is not old: the next picture can be waited for.
 */
static bool is_drawn_soon(const struct app *app)
{
    return ui_is_dragging(&app->ui) && os_clock_s() - app->drawn_s < DRAG_FRAME_S;
}

static void show(struct app *app)
{
    const bool has_new = take_shot(app, false), has_pinhole = take_shot(app, true);
    if (!app->is_redraw_due)
        return;
    view_pass(app);
    ask(app);
    /* While pictures are on their way they bring the controls along. */
    if (!has_new && !has_pinhole && is_drawn_soon(app))
        return;
    window_draw(app);
    trace_layout(app);
    const struct shot *shot = app->shot;
    if (has_new && shot)
        stats_shown(&app->stats, shot->id, os_clock_s(), shot->filter_ms,
                    shot->display_ms, shot->quality == SHOT_PREVIEW, shot->times > 1);
    else if (has_pinhole)
        stats_shown(&app->stats, app->pinhole_id, os_clock_s(), 0, 0, false, false);
    if (has_new)
        trace_shown(app, false);
    if (has_pinhole)
        trace_shown(app, true);
}

static void wake(void *user)
{
    const struct app *app = user;
    SDL_Event event = {.user = {.type = app->event_type, .code = APP_SHOT}};
    SDL_PushEvent(&event);
}

static int wait_ms(const struct app *app)
{
    if (app->options->benchmark_s > 0)
        return 4;
    if (app->is_redraw_due)
        return (int)(1000 * DRAG_FRAME_S);
    return app->loader.is_running ? 100 : 500;
}

static void run(struct app *app)
{
    SDL_Event event;
    while (!app->is_ending && !os_is_interrupted()) {
        if (SDL_WaitEventTimeout(&event, wait_ms(app))) {
            do {
                events_take(app, &event);
            } while (!app->is_ending && SDL_PollEvent(&event));
        } else if (app->loader.is_running || app->status[0]) {
            app->is_redraw_due = true;
            if (os_clock_s() > app->status_until_s)
                app->status[0] = 0;
        }
        load_look_for_files(app);
        if (app->options->benchmark_s > 0)
            bench_step(app);
        show(app);
    }
}

/* ---- start and end -------------------------------------------------------------- */

static bool prepare(struct app *app)
{
    struct image_error error;
    const struct view_options *options = app->options;
    if (!options->is_demo && !playlist_open(&app->playlist, app->operands->items,
                                            app->operands->n, &error)) {
        message("%s", error.message);
        return false;
    }
    if (options->reference &&
        !picture_read(options->reference, NULL, thread_count(options->n_threads),
                      &app->reference, &error)) {
        message("%s", error.message);
        return false;
    }
    app->has_reference = options->reference != NULL;
    const char *light = options->distribution_image;
    if (light && !picture_read(light, NULL, thread_count(options->n_threads),
                               &app->light_picture, &error)) {
        message("%s", error.message);
        return false;
    }
    app->light = rf_image_packed(app->light_picture.samples, app->light_picture.width,
                                 app->light_picture.height, 3);
    if (options->font)
        snprintf(app->font_path, sizeof(app->font_path), "%s", options->font);
    else if (!font_find(app->font_path, sizeof(app->font_path))) {
        message("view: no font was found; install fonts-dejavu-core, or name one with "
                "--font FILE.ttf");
        return false;
    }
    return true;
}

static void close_app(struct app *app)
{
    load_cancel(app);
    if (app->worker)
        worker_stop(app->worker);
    shot_free(app->shot);
    input_drop(app->source);
    window_close(app);
    if (app->stage) {
        stage_close(app->stage);
        free(app->stage);
    }
    picture_free(&app->reference);
    picture_free(&app->light_picture);
    playlist_close(&app->playlist);
    if (app->trace)
        fclose(app->trace);
}

static int run_app(struct app *app)
{
    if (!prepare(app) || !window_open(app))
        return EXIT_FAILED;
    trace_open(app);
    state_init(&app->state, &app->typed, app->options->exposure);
    app->worker = worker_start(app->options->n_threads, wake, app);
    if (!app->worker) {
        message("view: the background thread cannot be started; is there memory left?");
        return EXIT_FAILED;
    }
    if (app->options->is_demo && !load_demo(app))
        return EXIT_FAILED;
    if (!app->options->is_demo) {
        SDL_ShowWindow(app->window);
        window_measure(app);
        load_begin(app);
    }
    run(app);
    if (app->options->benchmark_s > 0 && app->bench.is_over)
        bench_print(app);
    return os_is_interrupted() ? os_interrupt_code() : app->exit_code;
}

int main(int argc, char **argv)
{
    struct view_call call;
    signal(SIGPIPE, SIG_IGN);
    atexit(os_clean_up);
    const int code = view_parse(argc, argv, &call);
    if (code != OPTIONS_GO_ON)
        return code;
    struct app *app = need_memory(1, sizeof(*app));
    *app = (struct app){.options = &call.options,
                        .operands = &call.operands,
                        .typed = call.settings,
                        .has_panel = true,
                        .density = 1};
    os_interrupt_catch();
    app->exit_code = run_app(app);
    const int result = app->exit_code;
    close_app(app);
    free(app);
    operands_free(&call.operands);
    return result;
}
