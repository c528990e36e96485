/* SPDX-License-Identifier: Apache-2.0 */
/* The column of controls, the line at the bottom, and what lies above the picture. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"

/* ---- parameters ----------------------------------------------------------------- */

static double number_of(const struct app *app, const char *key)
{
    const struct rf_param_info *info = rf_param_find(key);
    const char *member = (const char *)&app->state.settings.params + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

/* A slider of a parameter, from min to max; typing goes as far as the table allows. */
static void number_row(struct app *app, const char *key, const char *label,
                       const char *unit, double min, double max, bool is_log)
{
    const struct rf_param_info *info = rf_param_find(key);
    const struct ui_number number = {.label = label,
                                     .unit = unit,
                                     .min = min,
                                     .max = max,
                                     .min_limit = info->min,
                                     .max_limit = info->max,
                                     .is_log = is_log,
                                     .is_whole = info->type == RF_TYPE_INT};
    double value = number_of(app, key);
    if (ui_number(&app->ui, &number, &value))
        state_set(&app->state, key, value);
}

static void choice_row(struct app *app, const char *key, const char *label)
{
    const struct rf_param_info *info = rf_param_find(key);
    const char *names[32];
    for (int i = 0; i < info->n_choices; i++)
        names[i] = info->choices[i].name;
    int index = (int)number_of(app, key);
    if (ui_choice(&app->ui, label, names, info->n_choices, &index))
        state_set(&app->state, key, index);
}

/* From somewhat before the nearest thing to beyond the farthest. */
static void focus_row(struct app *app)
{
    const struct input *input = app->shot ? app->shot->input : NULL;
    const double near = input ? input->nearest : 1, far = input ? input->farthest : 100;
    number_row(app, "focus-distance", "Focus distance", "", near * 0.7,
               fmin(far, near * 1e5) * 1.4, true);
}

static void screen_row(struct app *app)
{
    double position = state_screen(&app->state);
    const double f = app->state.lens.focal_length;
    if (isnan(position)) {
        ui_readout(&app->ui, "Screen position", "needs a focal length");
        return;
    }
    const struct ui_number number = {.label = "Screen position",
                                     .unit = "",
                                     .min = f * (1 + 1e-6),
                                     .max = f * 1.1,
                                     .min_limit = f * (1 + 1e-9),
                                     .max_limit = 1e9};
    if (ui_number(&app->ui, &number, &position))
        state_set_screen(&app->state, position);
}

static void f_stop_row(struct app *app)
{
    double f_stop = state_f_stop(&app->state);
    const struct rf_param_info *info = rf_param_find("f-stop");
    const struct ui_number number = {.label = "f-stop",
                                     .unit = "",
                                     .min = 0.5,
                                     .max = 64,
                                     .min_limit = info->min,
                                     .max_limit = info->max,
                                     .is_log = true};
    if (isnan(f_stop))
        return;
    if (ui_number(&app->ui, &number, &f_stop))
        state_set(&app->state, "f-stop", f_stop);
}

static void radius_row(struct app *app)
{
    double radius = app->state.lens.lens_radius;
    const double base = fmax(app->radius_base, 1e-9);
    const struct ui_number number = {.label = "Lens radius",
                                     .unit = "",
                                     .min = base / 32,
                                     .max = base * 32,
                                     .min_limit = 0,
                                     .max_limit = 1e9,
                                     .is_log = true};
    if (ui_number(&app->ui, &number, &radius))
        state_set(&app->state, "lens-radius", radius);
}

static void focal_length_row(struct app *app)
{
    number_row(app, "focal-length", "Focal length", "mm", 8, 400, true);
}

static void lens_rows(struct app *app)
{
    ui_heading(&app->ui, "Lens");
    focus_row(app);
    screen_row(app);
    f_stop_row(app);
    radius_row(app);
    focal_length_row(app);
    choice_row(app, "optics", "Optics");
}

static void limits_rows(struct app *app)
{
    const struct rf_lens *lens = &app->state.lens;
    double near, far;
    char text[128], a[32], b[32];
    rf_lens_depth_of_field(lens, &near, &far);
    ui_format(near, a, sizeof(a));
    ui_format(far, b, sizeof(b));
    snprintf(text, sizeof(text), "%s to %s", a, b);
    ui_readout(&app->ui, "In focus", text);
    ui_format(rf_lens_hyperfocal(lens), text, sizeof(text));
    ui_readout(&app->ui, "Hyperfocal", text);
    ui_format(rf_lens_radius_px(lens, INFINITY), a, sizeof(a));
    snprintf(text, sizeof(text), "%s px at infinity", a);
    ui_readout(&app->ui, "Radius", text);
}

static void aperture_rows(struct app *app)
{
    ui_heading(&app->ui, "Aperture");
    number_row(app, "blades", "Blades", "", 0, 16, false);
    number_row(app, "blade-rotation", "Rotation", "°", -180, 180, false);
    number_row(app, "aperture-ratio", "Ratio", "", 0.25, 4, true);
}

static void method_rows(struct app *app)
{
    ui_heading(&app->ui, "Method");
    choice_row(app, "method", "Method");
    if (rf_param_find("quality"))
        choice_row(app, "quality", "Quality");
    if (app->state.params.method == RF_METHOD_SCATTER)
        choice_row(app, "distribution", "Light");
}

/* ---- the view ------------------------------------------------------------------- */

static void view_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    struct state *state = &app->state;
#define MODE_NAME(constant, name, help) name,
    static const char *const names[] = {VIEW_MODES(MODE_NAME)};
#undef MODE_NAME
    ui_heading(ui, "View");
    bool is_on = state->is_filter_on;
    bool is_split = state->is_split;
    ui_columns(ui, 2);
    if (ui_toggle(ui, "Filter (F)", &is_on))
        state_toggle_filter(state);
    if (ui_toggle(ui, "Split (S)", &is_split))
        state_toggle_split(state);
    int mode = (int)state->mode;
    if (ui_choice(ui, "Show", names, N_MODES, &mode)) {
        static const enum action actions[] = {ACTION_HELP, ACTION_DEPTH, ACTION_COC,
                                              ACTION_BAND, ACTION_DIFFERENCE};
        if (mode == MODE_PICTURE)
            state_toggle_mode(state, state->mode);
        else
            view_act(app, actions[mode]);
    }
    const struct ui_number exposure = {.label = "Exposure",
                                       .unit = "stops",
                                       .min = -6,
                                       .max = 6,
                                       .min_limit = -20,
                                       .max_limit = 20};
    double stops = state->exposure;
    if (ui_number(ui, &exposure, &stops))
        state_set_exposure(state, stops);
}

static void demo_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    ui_heading(ui, "Demo");
    ui_columns(ui, 2);
    if (ui_button(ui, "Focus near (N)"))
        view_act(app, ACTION_NEAREST);
    if (ui_button(ui, "At infinity (I)"))
        view_act(app, ACTION_INFINITY);
    if (ui_button(ui, "Save colour and depth (Ctrl+E)"))
        view_act(app, ACTION_SAVE_PASSES);
}

static void save_rows(struct app *app)
{
    struct ui *ui = &app->ui;
    ui_heading(ui, "Save");
    ui_text_field(ui, "File", app->output, sizeof(app->output));
    if (ui_button(ui, "Save picture (Ctrl+S)"))
        view_act(app, ACTION_SAVE);
    if (ui_button(ui, "Save parameters (Ctrl+P)"))
        view_act(app, ACTION_SAVE_PARAMS);
    if (ui_button(ui, "Copy command line (Ctrl+C)"))
        view_act(app, ACTION_COPY);
    ui_space(ui);
    if (ui_button(ui, "Keys (F1)"))
        view_act(app, ACTION_HELP);
}

/* Names the controls, does what they ask. */
static void panel_build(struct app *app)
{
    const struct area panel = view_panel_area(app);
    ui_begin(&app->ui, &app->input, &panel);
    if (panel.width > 0 && app->has_stage && app->state.is_valid) {
        lens_rows(app);
        limits_rows(app);
        aperture_rows(app);
        method_rows(app);
        view_rows(app);
        if (app->options->is_demo)
            demo_rows(app);
        save_rows(app);
    }
    ui_end(&app->ui);
}

/* ---- overlays ------------------------------------------------------------------- */

#define GROUND 0x101014e6
#define TEXT 0xecececff
#define DIM 0xb8b8beff
#define WARN 0xffc14dff

static void draw_lines(struct app *app, int x, int y, const char *const (*lines)[2],
                       int n, int left_width, int width)
{
    struct ui *ui = &app->ui;
    const int line = app->font.line, pad = app->font.size_px / 2;
    const struct area ground = {x, y, width + 2 * pad, n * line + 2 * pad};
    ui_draw_box(ui, &ui->above, &ground, GROUND);
    for (int i = 0; i < n; i++) {
        const int top = y + pad + i * line;
        ui_draw_text(ui, &ui->above, x + pad, top, left_width, lines[i][0], WARN);
        ui_draw_text(ui, &ui->above, x + pad + left_width, top, width - left_width,
                     lines[i][1], TEXT);
    }
}

static void draw_help(struct app *app)
{
#define ACTION_ROW(name, key, modifiers, shown, help) {shown, help},
    static const char *const actions[][2] = {ACTIONS(ACTION_ROW)};
#undef ACTION_ROW
    const char *lines[N_ACTIONS + 8][2];
    int n = 0;
    const char *const mouse[][2] = {
        {"click", "focus there"},
        {"wheel", "zoom"},
        {"drag", app->options->is_demo ? "turn the scene" : "pan"},
        {"middle drag", "pan"},
        {"right drag", "move the eye on the lens"},
        {"Tab", "go to the next control; arrows change, Enter types"}};
    for (size_t i = 0; i < sizeof(mouse) / sizeof(mouse[0]); i++, n++)
        memcpy(lines[n], mouse[i], sizeof(lines[n]));
    for (int i = 0; i < N_ACTIONS; i++)
        if (*actions[i][0]) {
            memcpy(lines[n], actions[i], sizeof(lines[n]));
            n++;
        }
    const int em = app->font.size_px;
    draw_lines(app, em, em, (const char *const(*)[2])lines, n, 8 * em, 32 * em);
}

static void draw_stats(struct app *app)
{
    const struct stats *s = &app->stats;
    struct worker_state worker;
    char values[7][96];
    const char *lines[7][2] = {{"updates"}, {"latency"},   {"filter"}, {"to 8 bit"},
                               {"drawing"}, {"cancelled"}, {"shown"}};
    worker_state(app->worker, &worker);
    const int n = s->n > 0 ? s->n : 1, n_draws = s->n_draws > 0 ? s->n_draws : 1;
    snprintf(values[0], 96, "%d, %.1f a second", s->n, stats_rate(s));
    snprintf(values[1], 96, "%.0f ms in the middle, %.0f ms for 95 of 100",
             stats_latency_ms(s, 0.5), stats_latency_ms(s, 0.95));
    snprintf(values[2], 96, "%.1f ms an update", s->filter_ms / n);
    snprintf(values[3], 96, "%.1f ms an update", s->display_ms / n);
    snprintf(values[4], 96, "%.1f ms a frame", s->draw_ms / n_draws);
    snprintf(values[5], 96, "%d, the slowest in %.0f ms", (int)worker.n_cancelled,
             worker.cancel_ms);
    snprintf(values[6], 96, "%s, %.1f ms, 1/%d", app->shot ? app->shot->method : "-",
             app->shot ? app->shot->filter_ms : 0, app->shot ? app->shot->times : 1);
    for (int i = 0; i < 7; i++)
        lines[i][1] = values[i];
    const int em = app->font.size_px;
    draw_lines(app, em, em, (const char *const(*)[2])lines, 7, 6 * em, 30 * em);
}

/* "picture best layered 320 ms" at the right of the line at the bottom. */
static void describe_shot(const struct app *app, char *text, size_t n_bytes)
{
    const struct shot *shot = app->shot;
    struct worker_state worker;
    char size[48] = "";
    *text = 0;
    if (!shot || !app->has_stage)
        return;
    worker_state(app->worker, &worker);
    if (shot->times > 1)
        snprintf(size, sizeof(size), " at 1/%d", shot->times);
    if (worker.is_best && worker.fraction > 0.02)
        snprintf(text, n_bytes, "best: %.0f %%  ", 100 * worker.fraction);
    else if (!app->state.is_filter_on && app->state.mode == MODE_PICTURE)
        snprintf(text, n_bytes, "filter off  ");
    else if (app->state.mode == MODE_DIFFERENCE)
        snprintf(text, n_bytes, "tPSNR %.2f dB  ", shot->tpsnr_db);
    else
        snprintf(text, n_bytes, "%s %s%s %.0f ms  ",
                 shot->quality == SHOT_BEST ? "best" : "preview", shot->method, size,
                 shot->filter_ms);
    const size_t used = strlen(text);
    snprintf(text + used, n_bytes - used, "%.4g %%", 100 * app->state.zoom.scale);
}

/* What lies below the mouse. */
static void describe_place(const struct app *app, char *text, size_t n_bytes)
{
    double depth;
    int32_t x, y;
    char number[32];
    *text = 0;
    if (!view_depth_at(app, app->input.x, app->input.y, &depth, &x, &y))
        return;
    ui_format(depth, number, sizeof(number));
    snprintf(text, n_bytes, "(%d, %d)  depth %s  blur %.2f px", x, y, number,
             rf_lens_radius_px(&app->state.lens, depth));
}

static void draw_status(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct area area = view_status_area(app);
    const int pad = app->font.size_px / 2,
              top = area.y + (area.height - app->font.line) / 2;
    char left[1200] = "", right[128];
    uint32_t colour = TEXT;
    describe_shot(app, right, sizeof(right));
    if (app->loader.is_running)
        snprintf(left, sizeof(left), "%s  %.0f %%", app->loader.stage->label,
                 100 * app->loader.stage->fraction);
    else if (app->state.problem[0])
        snprintf(left, sizeof(left), "%s", app->state.problem);
    else if (os_clock_s() < app->status_until_s)
        snprintf(left, sizeof(left), "%s", app->status);
    else if (app->has_stage)
        describe_place(app, left, sizeof(left));
    if (app->state.problem[0] || os_clock_s() < app->status_until_s)
        colour = WARN;
    const int right_width = font_width(&app->font, right, SIZE_MAX);
    ui_draw_text(ui, &ui->above, area.x + pad, top, area.width - right_width - 3 * pad,
                 left, colour);
    if (right_width + 2 * pad < area.width)
        ui_draw_text(ui, &ui->above, area.x + area.width - pad - right_width, top,
                     right_width, right, DIM);
}

/* A bar across the picture while files are read or rendered. */
static void draw_loading(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px;
    const struct area whole = {area.x + area.width / 4, area.y + area.height / 2,
                               area.width / 2, em};
    struct area done = whole;
    done.width = (int)(whole.width * app->loader.stage->fraction);
    ui_draw_box(ui, &ui->above, &whole, GROUND);
    ui_draw_box(ui, &ui->above, &done, 0x5a86c4ff);
    ui_draw_text(ui, &ui->above, whole.x, whole.y - 2 * em, whole.width,
                 app->loader.stage->label, TEXT);
}

static void draw_eye(struct app *app)
{
    char text[128];
    struct ui *ui = &app->ui;
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px;
    const bool has_views = app->source && app->source->n_views > 1;
    snprintf(text, sizeof(text), "eye at (%.2f, %.2f) of the lens, %s",
             app->state.eye[0], app->state.eye[1],
             has_views ? "from the views" : "relief from depth");
    const int width = font_width(&app->font, text, SIZE_MAX) + em;
    const struct area ground = {area.x + em, area.y + area.height - 3 * em, width,
                                2 * em};
    ui_draw_box(ui, &ui->above, &ground, GROUND);
    ui_draw_text(ui, &ui->above, ground.x + em / 2,
                 ground.y + (ground.height - app->font.line) / 2, width, text, TEXT);
}

void panel_overlay(struct app *app)
{
    draw_status(app);
    if (app->loader.is_running)
        draw_loading(app);
    if (app->state.has_eye)
        draw_eye(app);
    if (app->has_help)
        draw_help(app);
    else if (app->has_stats)
        draw_stats(app);
}

void panel_pass(struct app *app)
{
    panel_build(app);
    struct ui_input *input = &app->input;
    input->is_pressed = input->is_released = false;
    input->key = UI_KEY_NONE;
    input->text[0] = 0;
    input->wheel = 0;
    app->is_redraw_due = true;
}
