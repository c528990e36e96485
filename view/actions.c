/* SPDX-License-Identifier: Apache-2.0 */
/* What keys and buttons do. */
#include <math.h>

#include "app.h"
#include "clock.h"
#include "common/report.h"

/* ---- what is done ---------------------------------------------------------------- */

static void focus_on_centre(struct app *app)
{
    const struct area area = view_picture_area(app);
    double depth;
    int32_t x, y;
    if (play_lacks_pixels(app))
        return;
    if (view_depth_at(app, area.x + area.width / 2.0, area.y + area.height / 2.0,
                      &depth, &x, &y))
        state_focus(&app->state, depth);
}

static void focus_nearest(struct app *app)
{
    if (play_lacks_pixels(app))
        return;
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
    const struct reference *reference = app->reference;
    if (app->accumulation.is_on ||
        reference_fits(reference, app->state.width, app->state.height))
        state_toggle_mode(&app->state, MODE_DIFFERENCE);
    else if (!reference)
        view_say(app, "there is no reference; name one under Compare, or drop a PNG");
    else
        view_say(app, "%s: is %d x %d, the picture %d x %d: no difference can be shown",
                 app->reference_path, reference->picture.width,
                 reference->picture.height, app->state.width, app->state.height);
}

static void step_picture(struct app *app, int step)
{
    const int next = app->picture + step;
    if (app->loader.is_running || next < 0 || next >= app->playlist.n)
        view_say(app, "picture %d of %d", app->picture + 1, app->playlist.n);
    else
        play_go(app, next);
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

static void toggle_stats(struct app *app)
{
    app->has_stats = !app->has_stats;
    stats_start(&app->stats, os_clock_s());
}

static void toggle_panel(struct app *app)
{
    app->has_panel = !app->has_panel;
    view_measure(app);
}

static void toggle_filter(struct app *app)
{
    state_toggle_filter(&app->state);
}

static void toggle_split(struct app *app)
{
    state_toggle_split(&app->state);
}

static void toggle_mode(struct app *app, double mode, double unused)
{
    state_toggle_mode(&app->state, (enum view_mode)mode);
}

static void scale_focus(struct app *app, double factor, double divisor)
{
    state_focus(&app->state,
                app->state.settings.params.focus_distance * factor / divisor);
}

/* Nearer by 5 %; from where the picture is that of a focus at infinity, within the limit
 * of sharpness, to the farthest thing of the scene, or that limit where it is nearer. */
static void focus_nearer(struct app *app)
{
    const double focus = app->state.settings.params.focus_distance;
    const double farthest = app->source ? app->source->farthest : INFINITY;
    const double hyperfocal = rf_lens_hyperfocal(&app->state.lens);
    const bool is_far = focus > 2 * fmax(farthest, hyperfocal);
    const double end = hyperfocal > 0 ? fmin(farthest, hyperfocal) : farthest;
    state_focus(&app->state, is_far ? end : focus / 1.05);
}

static void change_exposure(struct app *app, double stops, double unused)
{
    state_set_exposure(&app->state, app->state.exposure + stops);
}

static void zoom(struct app *app, double factor, double unused)
{
    zoom_in_window(app, factor);
}

static void turn_aperture(struct app *app, double stops, double unused)
{
    open_aperture(app, pow(2, stops / 2));
}

static void step(struct app *app, double n, double unused)
{
    step_picture(app, (int)n);
}

static void apply_look(struct app *app, const struct look *look, const char *what)
{
    if (!look)
        view_say(app, "there is nothing to %s", what);
    else if (!state_apply(&app->state, look))
        view_say(app, "%.500s", app->state.problem);
    app->ui.is_editing = false;
}

static void undo(struct app *app)
{
    view_note_change(app);
    apply_look(app, undo_back(&app->undo), "undo");
}

static void redo(struct app *app)
{
    apply_look(app, undo_forth(&app->undo), "redo");
}

void view_note_change(struct app *app)
{
    static struct look look; /* too large for the stack; of this thread alone */
    if (!app->has_stage || ui_is_dragging(&app->ui) || app->play.is_on)
        return;
    state_look(&app->state, &look);
    if (app->undo.n == 0)
        undo_start(&app->undo, &look, sizeof(look));
    else
        undo_note(&app->undo, &look);
}

static void toggle_full_screen(struct app *app)
{
    int *size = app->window_size;
    const bool was_full = size[0] > 0;
    if (!was_full)
        SDL_GetWindowSize(app->window, &size[0], &size[1]);
    if (SDL_SetWindowFullscreen(app->window,
                                was_full ? 0 : SDL_WINDOW_FULLSCREEN_DESKTOP) != 0) {
        view_say(app, "no full screen: %s", SDL_GetError());
        size[0] = was_full ? size[0] : 0;
    } else if (was_full) { /* where there is no window manager nobody else does it */
        SDL_SetWindowSize(app->window, size[0], size[1]);
        size[0] = 0;
    }
    view_measure(app);
}

void view_keep_look(struct app *app, int i)
{
    if (!app->looks[i])
        app->looks[i] = app_memory(1, sizeof(*app->looks[i]), NULL);
    if (app->looks[i])
        state_look(&app->state, app->looks[i]);
    view_say(app,
             app->looks[i] ? "kept as %d: Shift+%d sets it again"
                           : "out of memory for settings %d",
             i, i);
}

void view_set_look(struct app *app, int i)
{
    if (!app->looks[i])
        view_say(app, "nothing is kept as %d; Ctrl+%d keeps the settings", i, i);
    else if (!state_apply(&app->state, app->looks[i]))
        view_say(app, "%.500s", app->state.problem);
    else
        view_say(app, "settings %d", i);
}

/* Both have the same place. */
static void toggle_graphs(struct app *app)
{
    app->has_graphs = !app->has_graphs;
    app->has_scopes = false;
}

static void toggle_scopes(struct app *app)
{
    app->has_scopes = !app->has_scopes;
    app->has_graphs = false;
    app->state.id++; /* what is shown is counted when it comes again */
}

static void toggle_compare(struct app *app)
{
    struct state *state = &app->state;
    if (!app->reference && !app->accumulation.is_on) {
        view_say(app, "there is no reference; name one under Compare, or press K");
        return;
    }
    state->compares_reference = !state->compares_reference;
    state->id++;
    view_say(app, "F and S compare with the %s",
             state->compares_reference ? "reference" : "pinhole");
}

/* What is saved is the frame that is shown, not the one that was read last. */
static void save_shown_picture(struct app *app)
{
    if (!play_defer(app, save_shown_picture))
        save_picture(app);
}

static void save_shown_params(struct app *app)
{
    if (!play_defer(app, save_shown_params))
        save_params(app);
}

static void copy_shown_command(struct app *app)
{
    if (!play_defer(app, copy_shown_command))
        save_command(app);
}

static void keep_as_reference(struct app *app)
{
    const struct shot *shot = app->shot;
    if (play_lacks_pixels(app))
        return;
    if (!shot || !shot->pixels || shot->id != app->state.id || shot->times > 1) {
        view_say(app, "wait until the best picture is shown");
        return;
    }
    const size_t n = (size_t)shot->width * (size_t)shot->height;
    float *rgb = app_memory(n, 3 * sizeof(float), NULL);
    if (!rgb) {
        view_say(app, "out of memory for the reference");
        return;
    }
    const size_t n_channels = (size_t)shot->pixels->n_channels;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] =
                shot->pixels->values[i * n_channels + (n_channels > 1 ? c : 0)];
    const struct picture kept = {
        .samples = rgb, .width = shot->width, .height = shot->height};
    view_set_reference(app, &kept, "");
    app->state.compares_reference = true;
    app->state.id++;
    view_say(app, "kept as the reference: F flips, S wipes, X shows the difference");
}

/* ---- the table ------------------------------------------------------------------- */

/* One of the two functions, the second with its numbers. */
static const struct {
    void (*plain)(struct app *app);
    void (*with)(struct app *app, double a, double b);
    double a, b;
} table[N_ACTIONS] = {
    [ACTION_STATS] = {.plain = toggle_stats},
    [ACTION_PANEL] = {.plain = toggle_panel},
    [ACTION_FILTER] = {.plain = toggle_filter},
    [ACTION_SPLIT] = {.plain = toggle_split},
    [ACTION_DEPTH] = {.with = toggle_mode, .a = MODE_DEPTH},
    [ACTION_COC] = {.with = toggle_mode, .a = MODE_COC},
    [ACTION_BAND] = {.with = toggle_mode, .a = MODE_BAND},
    [ACTION_DIFFERENCE] = {.plain = show_difference},
    [ACTION_EXPOSURE] = {.with = toggle_mode, .a = MODE_EXPOSURE},
    [ACTION_GRAPHS] = {.plain = toggle_graphs},
    [ACTION_SCOPES] = {.plain = toggle_scopes},
    [ACTION_VIEWS] = {.plain = accumulation_toggle},
    [ACTION_COMPARE] = {.plain = toggle_compare},
    [ACTION_KEEP] = {.plain = keep_as_reference},
    [ACTION_CENTRE] = {.plain = focus_on_centre},
    [ACTION_NEARER] = {.plain = focus_nearer},
    [ACTION_FARTHER] = {.with = scale_focus, .a = 1.05, .b = 1},
    [ACTION_NEAREST] = {.plain = focus_nearest},
    [ACTION_INFINITY] = {.with = scale_focus, .a = INFINITY, .b = 1},
    [ACTION_WIDER] = {.with = turn_aperture, .a = 1.0 / 3},
    [ACTION_NARROWER] = {.with = turn_aperture, .a = -1.0 / 3},
    [ACTION_BRIGHTER] = {.with = change_exposure, .a = 0.5},
    [ACTION_DARKER] = {.with = change_exposure, .a = -0.5},
    [ACTION_FIT] = {.with = zoom, .a = 0},
    [ACTION_ACTUAL] = {.with = zoom, .a = 1},
    [ACTION_ZOOM_IN] = {.with = zoom, .a = M_SQRT2},
    [ACTION_ZOOM_OUT] = {.with = zoom, .a = M_SQRT1_2},
    [ACTION_EYE_LEFT] = {.with = move_eye, .a = -1},
    [ACTION_EYE_RIGHT] = {.with = move_eye, .a = 1},
    [ACTION_EYE_UP] = {.with = move_eye, .b = 1},
    [ACTION_EYE_DOWN] = {.with = move_eye, .b = -1},
    [ACTION_LEFT] = {.with = move, .a = -1},
    [ACTION_RIGHT] = {.with = move, .a = 1},
    [ACTION_UP] = {.with = move, .b = -1},
    [ACTION_DOWN] = {.with = move, .b = 1},
    [ACTION_HOME] = {.plain = go_home},
    [ACTION_NEXT] = {.with = step, .a = 1},
    [ACTION_PREVIOUS] = {.with = step, .a = -1},
    [ACTION_PLAY] = {.plain = play_toggle},
    [ACTION_SET_KEY] = {.plain = play_set_key},
    [ACTION_RELOAD] = {.plain = reload},
    [ACTION_UNDO] = {.plain = undo},
    [ACTION_REDO] = {.plain = redo},
    [ACTION_REDO_SHIFT] = {.plain = redo},
    [ACTION_FULL] = {.plain = toggle_full_screen},
    [ACTION_OPEN] = {.plain = open_any},
    [ACTION_OPEN_LIST] = {.plain = open_list},
    [ACTION_SAVE] = {.plain = save_shown_picture},
    [ACTION_SAVE_PARAMS] = {.plain = save_shown_params},
    [ACTION_SAVE_PASSES] = {.plain = save_passes},
    [ACTION_COPY] = {.plain = copy_shown_command},
};

void view_act(struct app *app, enum action action)
{
    if (action == ACTION_QUIT)
        app->is_ending = true;
    if (action == ACTION_HELP)
        app->has_help = !app->has_help;
    if (!app->has_stage || action >= N_ACTIONS)
        return;
    if (table[action].plain)
        table[action].plain(app);
    else if (table[action].with)
        table[action].with(app, table[action].a, table[action].b);
}
