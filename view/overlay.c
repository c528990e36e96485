/* SPDX-License-Identifier: Apache-2.0 */
/* The line at the bottom, and what lies above the picture. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"

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

/* A line of the help; a subject where `text` is NULL. */
struct help_line {
    const char *key, *text;
};

enum { MOST_HELP = N_ACTIONS + 24 };

static int add_subject(struct help_line *lines, int n, const char *subject)
{
#define ACTION_ROW(name, subject, key, modifiers, shown, help) {subject, shown, help},
    static const char *const actions[][3] = {ACTIONS(ACTION_ROW)};
#undef ACTION_ROW
    lines[n++] = (struct help_line){subject, NULL};
    for (int i = 0; i < N_ACTIONS; i++)
        if (strcmp(actions[i][0], subject) == 0 && *actions[i][1])
            lines[n++] = (struct help_line){actions[i][1], actions[i][2]};
    return n;
}

static int list_help(const struct app *app, struct help_line *lines)
{
    static const char *const subjects[] = {"Lens",     "Show",  "Place",
                                           "Settings", "Files", "Window"};
    const struct help_line mouse[] = {
        {"Mouse", NULL},
        {"click", "focus there"},
        {"wheel", "zoom"},
        {"drag", app->options->is_demo ? "turn the scene" : "pan"},
        {"middle drag", "pan"},
        {"right drag", "move the eye on the lens"},
        {"Controls", NULL},
        {"drag, click", "change a number; type it: 2*3, 85mm, 3 m, inf"},
        {"double click", "back to what it was at first"},
        {"Tab, arrows", "next control; change it"},
        {"Ctrl+1 to 9", "keep the settings as 1 to 9"},
        {"Shift+1 to 9", "set them again"}};
    int n = sizeof(mouse) / sizeof(mouse[0]);
    memcpy(lines, mouse, sizeof(mouse));
    for (size_t i = 0; i < sizeof(subjects) / sizeof(subjects[0]); i++)
        n = add_subject(lines, n, subjects[i]);
    return n;
}

static void draw_help_line(struct app *app, const struct help_line *line, int x, int y,
                           int width)
{
    struct ui *ui = &app->ui;
    const int key_width = width * 5 / 16;
    if (!line->text) {
        ui_draw_text(ui, &ui->above, x, y, width, line->key, WARN);
        return;
    }
    ui_draw_text(ui, &ui->above, x, y, key_width, line->key, DIM);
    ui_draw_text(ui, &ui->above, x + key_width, y, width - key_width, line->text, TEXT);
}

void overlay_scroll_help(struct app *app, double lines)
{
    const struct area area = view_picture_area(app);
    const int most = app->help_height - area.height;
    app->help_scroll += (int)(lines * app->font.line);
    app->help_scroll = app->help_scroll > most ? most : app->help_scroll;
    app->help_scroll = app->help_scroll < 0 ? 0 : app->help_scroll;
    app->is_redraw_due = true;
}

/* As many columns as there is room for; the rest is reached by the wheel. */
static void draw_help(struct app *app)
{
    struct help_line lines[MOST_HELP];
    struct ui *ui = &app->ui;
    const int n = list_help(app, lines), em = app->font.size_px;
    struct area area = view_picture_area(app);
    area.width = area.width < 30 * em ? app->width : area.width;
    const int columns = area.width >= 90 * em ? 3 : area.width >= 60 * em ? 2 : 1;
    const int step = app->font.line * 6 / 5, share = (area.width - 2 * em) / columns;
    const int width = share < 36 * em ? share : 36 * em;
    const int n_rows = (n + columns - 1) / columns + 2;
    app->help_height = n_rows * step + 2 * em;
    overlay_scroll_help(app, 0);
    ui_draw_box(ui, &ui->above, &area, GROUND);
    int column = 0, in_column = 0;
    for (int i = 0; i < n; i++, in_column++) {
        /* A subject begins a column where the one before is as good as full. */
        if (in_column >= n_rows || (!lines[i].text && in_column >= n_rows - 2)) {
            column++;
            in_column = 0;
        }
        const int y = area.y + em + in_column * step - app->help_scroll;
        if (y > area.y - step && y + app->font.line < area.y + area.height)
            draw_help_line(app, &lines[i], area.x + em + column * width, y, width - em);
    }
    const struct area hint = {area.x + area.width - 14 * em, area.y, 14 * em, 2 * em};
    if (app->help_height >
        area.height) { /* over the lines that are scrolled below it */
        ui_draw_box(ui, &ui->above, &hint, GROUND | 0xff);
        ui_draw_text(ui, &ui->above, area.x + area.width - 14 * em, area.y + em / 3,
                     14 * em, "wheel: more below", WARN);
    }
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
    if (s->n == 0)
        snprintf(values[1], 96, "no update yet");
    else
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

/* What is shown in place of the filtered picture. */
static void describe_off(const struct app *app, char *text, size_t n_bytes)
{
    const struct demo_views *views = &app->accumulation.views;
    if (accumulation_picture(app))
        snprintf(text, n_bytes, "%d of %d views, %.0f ms  ", views->n_done, views->n,
                 views->drawn_ms);
    else
        snprintf(text, n_bytes, "filter off  ");
}

/* "picture best layered 320 ms" at the right of the line at the bottom. */
static void describe_shot(const struct app *app, char *text, size_t n_bytes)
{
    const struct shot *shot = app->shot;
    struct worker_state worker;
    char size[48] = "", views[48] = "";
    *text = 0;
    if (!shot || !app->has_stage)
        return;
    worker_state(app->worker, &worker);
    if (shot->n_views > 0)
        snprintf(views, sizeof(views), " of %d view%s", shot->n_views,
                 shot->n_views > 1 ? "s" : "");
    if (shot->times > 1)
        snprintf(size, sizeof(size), " at 1/%d", shot->times);
    if (worker.is_best && worker.fraction > 0.02)
        snprintf(text, n_bytes, "best: %.0f %%  ", 100 * worker.fraction);
    else if (!app->state.is_filter_on && app->state.mode == MODE_PICTURE)
        describe_off(app, text, n_bytes);
    else if (strcmp(shot->method, "none") == 0)
        *text = 0; /* a map: no method made it */
    else if (app->state.mode == MODE_DIFFERENCE)
        snprintf(text, n_bytes, "%s tPSNR %.2f dB%s  ", shot->method, shot->tpsnr_db,
                 views);
    else if (!isnan(shot->tpsnr_db))
        snprintf(text, n_bytes, "%s %.0f ms, %.2f dB%s  ", shot->method,
                 shot->filter_ms, shot->tpsnr_db, views);
    else
        snprintf(text, n_bytes, "%s %s%s %.0f ms  ",
                 shot->quality == SHOT_BEST ? "best" : "preview", shot->method, size,
                 shot->filter_ms);
    const size_t used = strlen(text);
    snprintf(text + used, n_bytes - used, "%.4g %%", 100 * app->state.zoom.scale);
}

/* Linear light of the filtered picture, or of the pinhole's before that is there. */
static void describe_colour(const struct app *app, int32_t x, int32_t y, char *text,
                            size_t n_bytes)
{
    const struct shot *shot = app->shot;
    const struct input *input = shot->input;
    const bool is_filtered = shot->pixels && app->state.is_filter_on;
    const float *pixels = is_filtered ? shot->pixels->values : input->colour;
    if (!pixels || (is_filtered && (shot->width != input->width)))
        return;
    const size_t n = (size_t)input->n_channels;
    const float *at = pixels + ((size_t)y * (size_t)input->width + (size_t)x) * n;
    snprintf(text, n_bytes, "RGB %.3f %.3f %.3f  ", at[0], at[n > 1 ? 1 : 0],
             at[n > 1 ? 2 : 0]);
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
    const double radius = rf_lens_radius_px(&app->state.lens, depth);
    const char *where = fabs(radius) <= app->state.params.coc_limit ? "in focus"
                        : radius < 0                                ? "before"
                                                                    : "behind";
    char rgb[96] = "";
    describe_colour(app, x, y, rgb, sizeof(rgb));
    snprintf(text, n_bytes, "(%d, %d)  %sdepth %s  blur %.2f px, %s", x, y, rgb, number,
             fabs(radius), where);
}

/* A warning that is wider than its line, over the picture in as many as it takes, at its
 * top or its bottom. Returns the height, px. */
static int draw_long(struct app *app, bool is_top, const char *text)
{
    struct ui *ui = &app->ui;
    const struct area picture = view_picture_area(app);
    const int pad = app->font.size_px / 2;
    struct area at = {picture.x + pad, 0, picture.width - 2 * pad, 0};
    const int height = ui_draw_wrapped(ui, NULL, &at, text, WARN);
    at.y = is_top ? picture.y + pad : picture.y + picture.height - height - pad;
    ui_draw_box(ui, &ui->above,
                &(struct area){picture.x, at.y - pad, picture.width, height + 2 * pad},
                GROUND);
    ui_draw_wrapped(ui, &ui->above, &at, text, WARN);
    return height + 2 * pad;
}

/* Tips and errors of controls lie above what covers this much of the picture's end. */
static void leave_free(struct app *app, int covered)
{
    app->is_redraw_due |= app->ui.covered != covered;
    app->ui.covered = covered;
}

static void draw_status(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct area area = view_status_area(app);
    const int pad = app->font.size_px / 2,
              top = area.y + (area.height - app->font.line) / 2;
    char left[2400] = "", right[128];
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
    trace_place(app, left);
    const int right_width = font_width(&app->font, right, SIZE_MAX);
    const int left_width = area.width - right_width - 3 * pad;
    const bool is_long =
        colour == WARN && font_width(&app->font, left, SIZE_MAX) > left_width;
    leave_free(app, is_long ? draw_long(app, false, left) : 0);
    if (!is_long)
        ui_draw_text(ui, &ui->above, area.x + pad, top, left_width, left, colour);
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

/* A line in a box over the picture, `y` from the window's top. */
static void draw_line(struct app *app, int y, const char *text, uint32_t colour)
{
    struct ui *ui = &app->ui;
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px, room = area.width - 2 * em;
    const int width = font_width(&app->font, text, SIZE_MAX) + em;
    const struct area ground = {area.x + em, y, width < room ? width : room, 2 * em};
    ui_draw_box(ui, &ui->above, &ground, GROUND);
    ui_draw_text(ui, &ui->above, ground.x + em / 2,
                 ground.y + (ground.height - app->font.line) / 2, ground.width - em,
                 text, colour);
}

static void draw_eye(struct app *app)
{
    char text[128];
    const struct area area = view_picture_area(app);
    const bool has_views = app->source && app->source->n_views > 1;
    snprintf(text, sizeof(text), "eye at (%.2f, %.2f) of the lens, %s",
             app->state.eye[0], app->state.eye[1],
             has_views ? "from the views" : "relief from depth");
    draw_line(app, area.y + area.height - 3 * app->font.size_px, text, TEXT);
}

void overlay_draw(struct app *app)
{
    draw_status(app);
    if (app->loader.is_running)
        draw_loading(app);
    if (app->state.has_eye)
        draw_eye(app);
    if (app->unshown[0])
        draw_long(app, true, app->unshown);
    trace_once(app, &app->traced_unshown, "unshown", app->unshown);
    if (app->has_stage)
        legend_draw(app);
    open_list_draw(app);
    if (app->has_help)
        draw_help(app);
    else if (app->has_stats)
        draw_stats(app);
}
