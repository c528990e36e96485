/* SPDX-License-Identifier: Apache-2.0 */
/* Opening what is to be shown, on a thread of its own. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "common/report.h"
#include "console/cli.h"
#include "file.h"

static void push_event(const struct app *app, enum app_event code, void *data)
{
    SDL_Event event = {.user = {.type = app->event_type, .code = code, .data1 = data}};
    SDL_PushEvent(&event);
}

static void load(void *user)
{
    struct app *app = user;
    struct loader *loader = &app->loader;
    loader->is_good = stage_load(loader->stage, &loader->typed, &loader->error);
    push_event(app, APP_LOADED, NULL);
}

void load_begin(struct app *app)
{
    struct loader *loader = &app->loader;
    if (loader->is_running)
        return;
    loader->stage = app_memory(1, sizeof(*loader->stage), &loader->error);
    if (!loader->stage) {
        view_say(app, "%s", loader->error.message);
        return;
    }
    *loader->stage =
        (struct stage){.options = app->options,
                       .files = app->is_opening ? &app->opening.pictures[0]
                                                : &app->playlist.pictures[app->picture],
                       .povray_args = app->operands->rest,
                       .n_povray_args = app->operands->n_rest};
    loader->typed = app->state.typed;
    loader->is_running = true;
    if (os_thread_start(&loader->thread, load, app) != 0) {
        message("view: a thread cannot be started; is there memory left?");
        loader->is_running = false;
        free(loader->stage);
        loader->stage = NULL;
        app->exit_code = EXIT_FAILED;
        app->is_ending = true;
    }
    app->is_redraw_due = true;
}

static void drop_stage(struct stage *stage)
{
    if (!stage)
        return;
    stage_close(stage);
    free(stage);
}

static void join(struct app *app)
{
    os_thread_join(&app->loader.thread);
    app->loader.is_running = false;
}

void load_cancel(struct app *app)
{
    if (!app->loader.is_running)
        return;
    app->loader.stage->is_cancelled = true;
    join(app);
    drop_stage(app->loader.stage);
    app->loader.stage = NULL;
}

/* ---- showing it ----------------------------------------------------------------- */

static bool resolve_stage(void *user, const struct settings *typed,
                          struct settings *settings, struct rf_params *params,
                          char *text, size_t n_bytes)
{
    return stage_resolve(user, typed, settings, params, text, n_bytes);
}

static bool resolve_demo(void *user, const struct settings *typed,
                         struct settings *settings, struct rf_params *params,
                         char *text, size_t n_bytes)
{
    (void)user;
    (void)text;
    (void)n_bytes;
    *settings = *typed;
    demo_facts(settings);
    *params = settings->params;
    return true;
}

/* What could not be opened: the end, unless something is shown already. */
static void fail_to_show(struct app *app, const char *text)
{
    trace_text(app, "error", text);
    if (app->has_stage) {
        view_say(app, "%s", text);
        return;
    }
    message("%s", text);
    app->exit_code = EXIT_FAILED;
    app->is_ending = true;
}

static const char *last_name(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

static void name_window(struct app *app, const char *name)
{
    char title[512];
    snprintf(title, sizeof(title), "%.400s - Rack Focus", last_name(name));
    SDL_SetWindowTitle(app->window, title);
}

/* A new window is as large and stands where the user left the last one; else it is as
 * large as its picture, the controls beside it, where there is room. */
static void fit_window(struct app *app)
{
    SDL_Rect usable = {0, 0, 1280, 720};
    const int display = SDL_GetWindowDisplayIndex(app->window);
    SDL_GetDisplayUsableBounds(display < 0 ? 0 : display, &usable);
    const struct area status = view_status_area(app);
    const int panel = view_panel_width(app);
    const double shown = app->state.width * app->state.zoom.aspect;
    const double width = (fmax(shown, 1.3 * panel) + panel) / app->density;
    const double height = (app->state.height + status.height) / app->density;
    const double least_height = 780 * app->scale / app->density;
    const struct remembered *last = &app->remembered;
    int *size = app->fitted_size;
    size[0] = (int)fmin(width, 0.9 * usable.w);
    size[1] = (int)fmin(fmax(height, least_height), 0.9 * usable.h);
    const bool is_seen = last->has_window && last->x < usable.x + usable.w - 50 &&
                         last->y < usable.y + usable.h - 50 &&
                         last->x + last->width > usable.x + 50 &&
                         last->y >= usable.y - 50;
    if (is_seen) {
        SDL_SetWindowSize(app->window, last->width, last->height);
        SDL_SetWindowPosition(app->window, last->x, last->y);
    } else {
        SDL_SetWindowSize(app->window, size[0], size[1]);
        SDL_SetWindowPosition(app->window, SDL_WINDOWPOS_CENTERED,
                              SDL_WINDOWPOS_CENTERED);
    }
    SDL_ShowWindow(app->window);
    view_measure(app);
}

/* Shows the input; the first time the window gets its size. False: conflicting facts.
 */
static bool show_input(struct app *app, const struct resolver *resolver,
                       struct input *input, double aspect)
{
    const bool is_first = !app->has_stage;
    const bool is_same =
        input->width == app->state.width && input->height == app->state.height;
    struct state before = app->state;
    if (!state_open(&app->state, resolver, input->width, input->height, aspect)) {
        memcpy(before.problem, app->state.problem, sizeof(before.problem));
        app->state = before;
        return false;
    }
    input_drop(app->source);
    app->source = input_hold(input);
    app->has_stage = true;
    app->radius_base = app->state.lens.lens_radius;
    if (is_first)
        fit_window(app);
    if (!is_same)
        app->state.zoom.is_fitted = true;
    view_measure(app);
    return true;
}

static void check_reference(struct app *app)
{
    const struct reference *reference = app->reference;
    if (!reference || reference_fits(reference, app->state.width, app->state.height))
        return;
    view_say(app, "%s: is %d x %d, the picture %d x %d: no difference can be shown",
             app->reference_path, reference->picture.width, reference->picture.height,
             app->state.width, app->state.height);
}

static double aspect_of(const struct stage *stage)
{
    const double aspect = stage->source.info.pixel_aspect;
    return aspect > 0.05 && aspect < 20 ? aspect : 1;
}

/* What was being opened takes the place of what was there, or is forgotten. */
static void end_opening(struct app *app, bool is_good)
{
    if (!app->is_opening)
        return;
    if (is_good) {
        playlist_close(&app->playlist);
        app->playlist = app->opening;
        app->picture = app->play.wanted = 0;
        app->play.is_on = app->play.is_ahead = false;
        app->play.then = NULL;
        app->pull.n = 0;
        frames_free(&app->frames);
        app->misplaced = NULL;
        app->opening = (struct playlist){0};
    }
    playlist_close(&app->opening);
    app->is_opening = false;
}

/* What was read cannot be shown. Where it is the next picture of the same list, this is
 * said until another one is shown: slider and picture do not go together. */
static void give_up(struct app *app, struct stage *stage, const char *why)
{
    app->play.is_on = false;
    if (app->play.wanted == app->picture)
        app->play.then = NULL;
    if (app->play.is_ahead)
        app->state.id++; /* the picture of the stage is shown again */
    if (app->stage && stage && !app->is_opening)
        snprintf(app->unshown, sizeof(app->unshown),
                 "%.100s is not shown: %.200s; this is still %.60s",
                 last_name(stage->files->paths[0]), why,
                 last_name(app->stage->files->paths[0]));
    fail_to_show(app, why);
    drop_stage(stage);
    end_opening(app, false);
}

static void remember_file(struct app *app, const char *path)
{
    char *full = os_file_full_path(path);
    if (full)
        remembered_add(&app->remembered, full);
    free(full);
}

/* What is known of the folder, once, and of the file. */
static void say_remarks(struct app *app, const struct stage *stage)
{
    char *of_list = app->playlist.remark;
    const char *comma = of_list[0] && stage->remark[0] ? "; " : "";
    if (of_list[0] || stage->remark[0]) {
        view_say(app, "%s%s%s", of_list, comma, stage->remark);
        message("%s: %s%s%s", stage->files->paths[0], of_list, comma, stage->remark);
    }
    of_list[0] = 0;
}

void load_end(struct app *app)
{
    struct loader *loader = &app->loader;
    join(app);
    struct stage *stage = loader->stage, *old = app->stage;
    loader->stage = NULL;
    app->is_redraw_due = true;
    if (!loader->is_good) {
        give_up(app, stage, loader->error.message);
        return;
    }
    worker_drain(app->worker);
    const struct resolver resolver = {resolve_stage, stage};
    if (!show_input(app, &resolver, stage->input, aspect_of(stage))) {
        give_up(app, stage, app->state.problem);
        return;
    }
    app->stage = stage;
    app->is_missing = false;
    app->unshown[0] = 0;
    drop_stage(old);
    end_opening(app, true);
    remember_file(app, stage->files->paths[0]);
    name_window(app, stage->files->paths[0]);
    save_default_name(app);
    say_remarks(app, stage);
    check_reference(app);
    trace_text(app, "loaded", stage->files->paths[0]);
}

bool load_demo(struct app *app)
{
    struct image_error error;
    const char *path = app->operands->n > 0 ? app->operands->items[0] : NULL;
    if (!demo_open(&app->demo, app->options->demo_width, app->options->demo_height,
                   path, &error)) {
        message("%s", error.message);
        return false;
    }
    app->demo.is_stereo = app->options->is_stereo;
    app->eyes = app->demo.is_stereo ? EYES_ANAGLYPH : EYES_LEFT;
    struct input *input = demo_draw(&app->demo);
    if (!input) {
        message("view: out of memory for the scene");
        return false;
    }
    const struct resolver resolver = {resolve_demo, NULL};
    const bool is_good = show_input(app, &resolver, input, 1);
    input_drop(input);
    if (!is_good)
        message("view: %s", app->state.problem);
    name_window(app, "demo");
    save_default_name(app);
    trace_text(app, "loaded", "demo");
    app->accumulation.n = DEMO_MOST_VIEWS;
    if (is_good && app->options->demo_views > 0) {
        app->accumulation.n = app->options->demo_views;
        accumulation_switch(app, true);
        app->state.is_filter_on = app->options->benchmark_s == 0;
    }
    return is_good;
}

void load_look_for_files(struct app *app)
{
    const double now_s = os_clock_s();
    if (!app->stage || now_s - app->looked_s < 1)
        return;
    app->looked_s = now_s;
    const char *missing = stage_find_missing(app->stage);
    if (missing && !app->is_missing) {
        view_say(app, "%s has gone; what is shown stays, and can be saved", missing);
        trace_text(app, "missing", missing);
    }
    app->is_missing = missing != NULL;
}
