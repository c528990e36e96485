/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus-view: the window of `rackfocus view`. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "arguments.h"
#include "clean_up.h"
#include "clock.h"
#include "commands/cmd_view.h"
#include "common/report.h"
#include "console/cli.h"
#include "controls/font_find.h"
#include "interrupt.h"
#include "path.h"

#define DRAG_FRAME_S 0.04 /* between two frames without a new picture */

/* Brings the newest picture into a texture; true where there was one. */
static bool take_shot(struct app *app, bool is_pinhole)
{
    struct shot *shot = worker_take(app->worker, is_pinhole);
    if (!shot)
        return false;
    app->is_redraw_due = true;
    if (shot->error[0]) {
        snprintf(app->state.problem, sizeof(app->state.problem), "%s%s", shot->error,
                 app->stage ? app->stage->way_out : "");
        trace_text(app, "problem", app->state.problem);
        shot_free(shot);
        return false;
    }
    const double start_s = os_clock_s();
    gl_picture_put(is_pinhole ? &app->before : &app->after, shot->rgba, shot->width,
                   shot->height);
    app->play.is_ahead = app->play.is_ahead && is_pinhole;
    app->stats.draw_ms += 1000 * (os_clock_s() - start_s);
    if (app->has_scopes && !is_pinhole)
        scopes_count(&app->scopes, shot->rgba, shot->width, shot->height);
    if (!play_keep(app, shot))
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
    panel_pass(app);
    view_note_change(app);
    view_ask(app);
    /* While pictures are on their way they bring the controls along. */
    if (!has_new && !has_pinhole && is_drawn_soon(app))
        return;
    window_draw(app);
    trace_layout(app);
    trace_tip(app);
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
    const double views_ms = accumulation_waits_ms(app);
    if (app->is_redraw_due)
        return (int)fmin(1000 * DRAG_FRAME_S, views_ms);
    const double tip_ms = fmin(
        views_ms, 1000 * fmin(ui_waits_s(&app->ui, os_clock_s()), play_waits_s(app)));
    const int most_ms = app->loader.is_running || app->dialog.is_open ? 100 : 500;
    return tip_ms < most_ms ? (int)tip_ms + 1 : most_ms;
}

static void run(struct app *app)
{
    SDL_Event event;
    while (!app->is_ending && !os_is_interrupted()) {
        if (SDL_WaitEventTimeout(&event, wait_ms(app))) {
            do {
                events_take(app, &event);
            } while (!app->is_ending && SDL_PollEvent(&event));
        } else if (app->loader.is_running || app->status[0] || app->mark.is_set ||
                   isfinite(ui_waits_s(&app->ui, os_clock_s()))) {
            app->is_redraw_due = true;
            if (os_clock_s() > app->status_until_s)
                app->status[0] = 0;
            if (os_clock_s() > app->mark.until_s)
                app->mark.is_set = false; /* from the next frame on */
        }
        load_look_for_files(app);
        play_step(app);
        if (app->options->benchmark_s > 0)
            bench_step(app);
        open_step(app);
        accumulation_step(app);
        show(app);
    }
}

/* ---- start and end -------------------------------------------------------------- */

static bool prepare(struct app *app)
{
    struct image_error error;
    struct picture reference;
    const struct view_options *options = app->options;
    if (!options->is_demo && !playlist_open(&app->playlist, app->operands->items,
                                            app->operands->n, &error)) {
        message("%s", error.message);
        return false;
    }
    if (options->reference &&
        !picture_read(options->reference, NULL, thread_count(options->n_threads),
                      &reference, &error)) {
        message("%s", error.message);
        return false;
    }
    if (options->reference)
        view_set_reference(app, &reference, options->reference);
    const char *light = options->distribution_image;
    if (light && !picture_read(light, NULL, thread_count(options->n_threads),
                               &app->light_picture, &error)) {
        message("%s", error.message);
        return false;
    }
    app->light = rf_image_packed(app->light_picture.samples, app->light_picture.width,
                                 app->light_picture.height, 3);
    char text[512];
    if (!colour_list_make(&app->colours, options->ocio, text, sizeof(text)))
        message("view: %s", text);
    if (options->font)
        snprintf(app->font_path, sizeof(app->font_path), "%s", options->font);
    else if (!font_find(app->font_path, sizeof(app->font_path))) {
        message("view: no font was found; install fonts-dejavu-core, or name one with "
                "--font FILE.ttf");
        return false;
    }
    return true;
}

/* Size and place, where the user changed them, and what was opened. */
static void remember(struct app *app)
{
    char path[MAX_PATH];
    struct remembered *r = &app->remembered;
    if (!app->has_stage || app->options->benchmark_s > 0 ||
        !remembered_path(path, sizeof(path)))
        return;
    int width, height;
    SDL_GetWindowSize(app->window, &width, &height);
    const bool is_usual = width == app->fitted_size[0] && height == app->fitted_size[1];
    if (!is_usual && app->window_size[0] == 0) {
        r->has_window = true;
        r->width = width;
        r->height = height;
        SDL_GetWindowPosition(app->window, &r->x, &r->y);
    } else if (is_usual) {
        r->has_window = false;
    }
    remembered_write(r, path);
}

static void close_app(struct app *app)
{
    remember(app);
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
    undo_free(&app->undo);
    for (int i = 0; i < 10; i++)
        free(app->looks[i]);
    colour_list_free(&app->colours);
    reference_drop(app->reference);
    picture_free(&app->light_picture);
    playlist_close(&app->playlist);
    playlist_close(&app->opening);
    browser_free(&app->browser);
    dialog_close(&app->dialog);
    open_forget(app);
    frames_free(&app->frames);
    if (app->trace)
        fclose(app->trace);
}

static int run_app(struct app *app, const struct settings *below_look)
{
    char path[MAX_PATH];
    if (app->options->benchmark_s == 0 && remembered_path(path, sizeof(path)))
        remembered_read(&app->remembered, path);
    if (!prepare(app) || !window_open(app))
        return EXIT_FAILED;
    if (!trace_open(app))
        return EXIT_FAILED;
    state_init(&app->state, &app->typed, app->options->exposure);
    app->sample_type = app->options->type;
    if (app->options->look)
        state_begin_look(&app->state, os_path_name(app->options->look), below_look);
    app->worker = worker_start(app->options->n_threads, wake, app);
    if (!app->worker) {
        message("view: the background thread cannot be started; is there memory left?");
        return EXIT_FAILED;
    }
    if (app->options->is_demo && !load_demo(app))
        return EXIT_FAILED;
    if (!app->options->is_demo) {
        SDL_ShowWindow(app->window);
        view_measure(app);
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
    argv = os_arguments(&argc, argv);
    os_interrupt_not_by_writing();
    atexit(os_clean_up);
    const int code = view_parse(argc, argv, &call);
    if (code != OPTIONS_GO_ON)
        return code;
    struct app *app = app_memory(1, sizeof(*app), NULL);
    if (!app)
        return exit_without_memory();
    *app = (struct app){.options = &call.options,
                        .operands = &call.operands,
                        .typed = call.settings,
                        .has_panel = true,
                        .play = {.rate = 24},
                        .density = 1};
    os_interrupt_catch();
    app->exit_code = run_app(app, &call.below_look);
    const int result = app->exit_code;
    close_app(app);
    free(app);
    operands_free(&call.operands);
    return result;
}
