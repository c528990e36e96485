/* SPDX-License-Identifier: Apache-2.0 */
/* What the colours mean, histogram and waveform, the mark of the focus. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "measure/measure.h"
#include "pixels/display.h"

#define GROUND 0x101014e6
#define TEXT 0xecececff
#define MARK 0xffc14dff

enum { STEPS = 96 };

/* A bar of colours with three numbers below it. */
struct legend {
    uint8_t rgba[STEPS][4];
    char title[64], ticks[3][40];
};

static void format_depth(double depth, char *text, size_t n_bytes)
{
    ui_format(depth >= 1e9 ? INFINITY : depth, text, n_bytes);
}

/* Equal steps of grey are equal steps of 1 / depth. */
static void make_depth(const struct input *input, struct legend *legend)
{
    const double near = 1 / input->nearest, far = 1 / input->farthest;
    float depth[STEPS];
    for (int i = 0; i < STEPS; i++)
        depth[i] = (float)(1 / (near + (far - near) * i / (STEPS - 1)));
    display_depth(depth, STEPS, input->nearest, input->farthest, legend->rgba[0]);
    snprintf(legend->title, sizeof(legend->title), "depth, scene units");
    for (int i = 0; i < 3; i++)
        format_depth(2 / ((2 - i) * near + i * far), legend->ticks[i],
                     sizeof(legend->ticks[i]));
}

static void make_coc(double full_px, struct legend *legend)
{
    float radius[STEPS];
    for (int i = 0; i < STEPS; i++)
        radius[i] = (float)(full_px * (2.0 * i / (STEPS - 1) - 1));
    display_coc(radius, STEPS, full_px, legend->rgba[0]);
    snprintf(legend->title, sizeof(legend->title), "radius of the blur, px");
    snprintf(legend->ticks[0], sizeof(legend->ticks[0]), "%.3g before", full_px);
    snprintf(legend->ticks[1], sizeof(legend->ticks[1]), "0");
    snprintf(legend->ticks[2], sizeof(legend->ticks[2]), "%.3g behind", full_px);
}

/* The light whose tone mapped value this is. */
static double of_tone(double tone)
{
    double low = 0, high = 1e6;
    for (int i = 0; i < 100; i++) {
        const double middle = (low + high) / 2;
        if (measure_tone(middle) - measure_tone(0) < tone)
            low = middle;
        else
            high = middle;
    }
    return low;
}

static void make_difference(double gain, struct legend *legend)
{
    const double full_scale = HEAT_FULL_SCALE / gain;
    float zero[3 * STEPS] = {0}, error[3 * STEPS], rgb[3 * STEPS];
    for (int i = 0; i < 3 * STEPS; i++)
        error[i] = (float)of_tone(full_scale * (i / 3) / (STEPS - 1.0));
    measure_heatmap_to(error, zero, STEPS, 1, full_scale, rgb);
    display_encoded(rgb, STEPS, legend->rgba[0]);
    snprintf(legend->title, sizeof(legend->title), "difference x%.3g, tone mapped",
             gain);
    for (int i = 0; i < 3; i++)
        snprintf(legend->ticks[i], sizeof(legend->ticks[i]), "%.3g",
                 full_scale * i / 2);
}

static void make_exposure(struct legend *legend)
{
    const double least = -7.5, most = 3;
    for (int i = 0; i < STEPS; i++) {
        display_exposure_colour(least + (most - least) * i / (STEPS - 1.0),
                                legend->rgba[i]);
        legend->rgba[i][3] = 255;
    }
    snprintf(legend->title, sizeof(legend->title), "stops from middle grey");
    for (int i = 0; i < 3; i++)
        snprintf(legend->ticks[i], sizeof(legend->ticks[i]), "%+.3g",
                 least + (most - least) * i / 2);
}

static bool make_legend(const struct app *app, struct legend *legend)
{
    const struct shot *shot = app->shot;
    const struct input *input = shot ? shot->input : NULL;
    if (!shot || shot->mode != app->state.mode)
        return false;
    if (shot->mode == MODE_DEPTH && input && input->nearest < input->farthest)
        make_depth(input, legend);
    else if (shot->mode == MODE_COC && shot->full_px > 0)
        make_coc(shot->full_px, legend);
    else if (shot->mode == MODE_DIFFERENCE)
        make_difference(app->state.gain, legend);
    else if (shot->mode == MODE_EXPOSURE)
        make_exposure(legend);
    else
        return false;
    return true;
}

static uint32_t code_of(const uint8_t *rgba)
{
    return (uint32_t)rgba[0] << 24 | (uint32_t)rgba[1] << 16 | (uint32_t)rgba[2] << 8 |
           rgba[3];
}

/* At the bottom left of the picture's area. */
static void draw_legend(struct app *app, const struct legend *legend)
{
    struct ui *ui = &app->ui;
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px, line = app->font.line;
    const int most = area.width - 3 * em, width = most < 22 * em ? most : 22 * em;
    const struct area ground = {area.x + em / 2, area.y + area.height - 3 * line - em,
                                width + em, 3 * line + em / 2};
    const int x = ground.x + em / 2, y = ground.y + em / 4;
    if (width < 8 * em)
        return;
    ui_draw_box(ui, &ui->above, &ground, GROUND);
    ui_draw_text(ui, &ui->above, x, y, width, legend->title, TEXT);
    for (int i = 0; i < STEPS; i++) {
        const int from = i * width / STEPS, to = (i + 1) * width / STEPS;
        const struct area step = {x + from, y + line, to - from, line - 2};
        ui_draw_box(ui, &ui->above, &step, code_of(legend->rgba[i]));
    }
    for (int i = 0; i < 3; i++) {
        const int text_width = font_width(&app->font, legend->ticks[i], SIZE_MAX);
        const int at = x + (width - text_width) * i / 2;
        ui_draw_text(ui, &ui->above, at, y + 2 * line, text_width, legend->ticks[i],
                     TEXT);
    }
}

/* ---- histogram and waveform ------------------------------------------------------- */

static void draw_histogram(struct app *app, const struct area *at)
{
    static const uint32_t colours[3] = {0xff5050b0, 0x50ff50b0, 0x5080ffb0};
    struct ui *ui = &app->ui;
    const struct scopes *s = &app->scopes;
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < 256; i++) {
            const double share =
                s->most > 0 ? sqrt((double)s->histogram[c][i] / s->most) : 0;
            const int height = (int)(fmin(share, 1) * at->height);
            const int from = i * at->width / 256, to = (i + 1) * at->width / 256;
            const struct area bar = {at->x + from, at->y + at->height - height,
                                     to > from ? to - from : 1, height};
            ui_draw_box(ui, &ui->above, &bar, colours[c]);
        }
}

static void draw_waveform(struct app *app, const struct area *at)
{
    struct ui *ui = &app->ui;
    const struct scopes *s = &app->scopes;
    for (int x = 0; x < SCOPES_COLUMNS; x++)
        for (int y = 0; y < SCOPES_LEVELS; y++) {
            if (s->waveform[x][y] == 0)
                continue;
            const double share = sqrt((double)s->waveform[x][y] / s->most_waveform);
            const int left = x * at->width / SCOPES_COLUMNS;
            const int right = (x + 1) * at->width / SCOPES_COLUMNS;
            const int low = y * at->height / SCOPES_LEVELS;
            const int high = (y + 1) * at->height / SCOPES_LEVELS;
            const struct area cell = {at->x + left, at->y + at->height - high,
                                      right - left, high - low};
            ui_draw_box(ui, &ui->above, &cell,
                        0x90ffa000u | (uint32_t)lrint(40 + 215 * share));
        }
}

/* At the top left of the picture's area. */
static void draw_scopes(struct app *app)
{
    struct ui *ui = &app->ui;
    char text[96];
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px, line = app->font.line;
    const int most = area.width - 3 * em, width = most < 19 * em ? most : 19 * em;
    const struct area ground = {area.x + em / 2, area.y + em / 2, width + em,
                                17 * em + 3 * line};
    if (width < 8 * em || ground.height > area.height)
        return;
    ui_draw_box(ui, &ui->above, &ground, GROUND);
    struct area at = {ground.x + em / 2, ground.y + em / 4 + line, width, 8 * em};
    ui_draw_text(ui, &ui->above, at.x, at.y - line, width, "histogram of what is shown",
                 TEXT);
    draw_histogram(app, &at);
    at.y += at.height;
    snprintf(text, sizeof(text), "%.2f %% black, %.2f %% white",
             100 * app->scopes.black, 100 * app->scopes.white);
    ui_draw_text(ui, &ui->above, at.x, at.y, width, text, TEXT);
    at.y += 2 * line;
    ui_draw_text(ui, &ui->above, at.x, at.y - line, width, "waveform of its luma",
                 TEXT);
    draw_waveform(app, &at);
}

/* ---- the mark of the focus -------------------------------------------------------- */

static void draw_mark(struct app *app)
{
    struct ui *ui = &app->ui;
    const struct zoom *zoom = &app->state.zoom;
    const struct area area = view_picture_area(app);
    const double focus = app->state.settings.params.focus_distance;
    if (!app->mark.is_set || app->mark.focus != focus ||
        os_clock_s() > app->mark.until_s)
        return;
    const int x = (int)(zoom->x + (app->mark.x + 0.5) * zoom->scale * zoom->aspect);
    const int y = (int)(zoom->y + (app->mark.y + 0.5) * zoom->scale);
    const int em = app->font.size_px, px = em / 10 + 1;
    if (!area_has(&area, x - em, y - em) || !area_has(&area, x + em, y + em))
        return;
    const struct area arms[4] = {{x - em, y, em / 2, px},
                                 {x + em / 2, y, em / 2, px},
                                 {x, y - em, px, em / 2},
                                 {x, y + em / 2, px, em / 2}};
    for (int i = 0; i < 4; i++)
        ui_draw_box(ui, &ui->above, &arms[i], MARK);
}

void legend_draw(struct app *app)
{
    static struct legend legend;
    draw_mark(app);
    memset(&legend, 0, sizeof(legend));
    if (make_legend(app, &legend))
        draw_legend(app, &legend);
    if (app->has_scopes)
        draw_scopes(app);
    if (app->has_graphs)
        graphs_draw(app);
}
