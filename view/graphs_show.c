/* SPDX-License-Identifier: Apache-2.0 */
/* The four graphs of the circle of confusion above the picture. */
#include <math.h>
#include <stdio.h>

#include "app.h"
#include "pixels/graphs.h"

#define GROUND 0x101014e6
#define TEXT 0xecececff
#define DIM 0xb8b8beff
#define GRID 0x48484eff
#define CURVE 0x7fb4ffff
#define NOW 0xffc14dff
#define SHARP 0x6fd08cff

enum { WIDTH_EMS = 17, HEIGHT_EMS = 7, LEAST_EMS = 10 };

/* The thing that the graphs are of: below the mouse, or the farthest that there is. */
static double find_distance(struct app *app)
{
    double depth;
    int32_t x, y;
    const struct input *input = app->shot ? app->shot->input : NULL;
    if (view_depth_at(app, app->input.x, app->input.y, &depth, &x, &y) &&
        isfinite(depth) && depth > 0)
        app->graph_distance = depth;
    if (app->graph_distance > 0)
        return app->graph_distance;
    return input && input->farthest > 0 ? input->farthest : 1;
}

static int place(double value, double from, double to, int px)
{
    return (int)lrint((value - from) / (to - from) * (px - 1));
}

/* An upright line through the whole graph. */
static void draw_mark(struct app *app, const struct graph *graph, const struct area *at,
                      double value, uint32_t rgba)
{
    if (isnan(value) || value < graph->from || value > graph->to)
        return;
    const int px = app->font.size_px / 14 + 1;
    const struct area line = {at->x + place(value, graph->from, graph->to, at->width),
                              at->y, px, at->height};
    ui_draw_box(&app->ui, &app->ui.above, &line, rgba);
}

static void draw_ticks(struct app *app, const struct graph *graph,
                       const struct area *at)
{
    struct ui *ui = &app->ui;
    char text[32];
    for (int i = 0; i < graph->n_ticks_px; i++) {
        const int y = at->y + at->height - 1 -
                      place(graph->ticks_px[i], 0, graph->top_px, at->height);
        ui_format(graph->ticks_px[i], text, sizeof(text));
        const int width = font_width(&app->font, text, SIZE_MAX);
        ui_draw_box(ui, &ui->above, &(struct area){at->x, y, at->width, 1}, GRID);
        ui_draw_text(ui, &ui->above, at->x - width - app->font.size_px / 3,
                     y - app->font.line / 2, width, text, DIM);
    }
    int last = 0; /* where the number before ends */
    for (int i = 0; i < graph->n_ticks; i++) {
        const int x = at->x + place(graph->ticks[i], graph->from, graph->to, at->width);
        ui_format(graph->ticks[i], text, sizeof(text));
        const int width = font_width(&app->font, text, SIZE_MAX);
        ui_draw_box(ui, &ui->above, &(struct area){x, at->y, 1, at->height}, GRID);
        if (x - width / 2 < last || x + width / 2 > at->x + at->width + width / 2)
            continue;
        ui_draw_text(ui, &ui->above, x - width / 2, at->y + at->height, width, text,
                     DIM);
        last = x + width / 2 + app->font.size_px / 3;
    }
}

/* One upright piece for each px of the width, from this place to the next. */
static void draw_curve(struct app *app, const struct graph *graph,
                       const struct area *at)
{
    const int thick = app->font.size_px / 10 + 1;
    int before = -1;
    for (int x = 0; x < at->width; x++) {
        const double step = (double)x * (GRAPH_STEPS - 1) / (at->width - 1);
        const int i = step < GRAPH_STEPS - 1 ? (int)step : GRAPH_STEPS - 2;
        const double px = graph->px[i] + (step - i) * (graph->px[i + 1] - graph->px[i]);
        const int y = at->y + at->height - 1 - place(px, 0, graph->top_px, at->height);
        const int from = before < 0 || before > y ? y : before;
        const int to = before > y ? before : y;
        const struct area piece = {at->x + x, from, 1, to - from + thick};
        ui_draw_box(&app->ui, &app->ui.above, &piece, CURVE);
        before = y;
    }
}

static void draw_graph(struct app *app, const struct graph *graph,
                       const struct area *all)
{
    struct ui *ui = &app->ui;
    char text[96];
    const int em = app->font.size_px, line = app->font.line;
    const struct area at = {all->x + 3 * em, all->y + line, all->width - 4 * em,
                            all->height - 2 * line - em / 2};
    snprintf(text, sizeof(text), "%s: %.4g", graph->label, graph->now);
    ui_draw_text(ui, &ui->above, all->x + em / 2, all->y, all->width - em, text, TEXT);
    draw_ticks(app, graph, &at);
    draw_mark(app, graph, &at, graph->sharp, SHARP);
    draw_curve(app, graph, &at);
    draw_mark(app, graph, &at, graph->now, NOW);
    const int x = at.x + place(graph->now, graph->from, graph->to, at.width);
    const int y =
        at.y + at.height - 1 - place(graph->now_px, 0, graph->top_px, at.height);
    if (graph->now >= graph->from && graph->now <= graph->to &&
        graph->now_px <= graph->top_px)
        ui_draw_box(ui, &ui->above,
                    &(struct area){x - em / 4, y - em / 4, em / 2, em / 2}, NOW);
}

static void trace_graphs(struct app *app, double distance,
                         const struct graph graphs[N_GRAPHS])
{
    char text[256];
    snprintf(text, sizeof(text), "distance %.6g, now %.6g %.6g %.6g %.6g, c %.6g px",
             distance, graphs[0].now, graphs[1].now, graphs[2].now, graphs[3].now,
             graphs[0].now_px);
    trace_once(app, &app->traced_graphs, "graphs", text);
}

/* What rounding leaves of the radius in focus. */
#define NOTHING_PX 1e-6

/* Two beside each other, or all below each other where there is no room. */
void graphs_draw(struct app *app)
{
    static struct graph graphs[N_GRAPHS];
    struct ui *ui = &app->ui;
    char why_not[256], text[320];
    const double distance = find_distance(app);
    const struct area area = view_picture_area(app);
    const int em = app->font.size_px, line = app->font.line;
    const int wide =
        area.width / 2 - em < WIDTH_EMS * em ? area.width / 2 - em : WIDTH_EMS * em;
    const int tall = HEIGHT_EMS * em + 2 * line;
    const struct area ground = {area.x + em / 2, area.y + em / 2, 2 * wide + em / 2,
                                2 * tall + line + em / 2};
    if (wide < LEAST_EMS * em || ground.height > area.height)
        return;
    ui_draw_box(ui, &ui->above, &ground, GROUND);
    bool is_good = true;
    for (int i = 0; i < N_GRAPHS && is_good; i++)
        is_good = graph_make((enum graph_axis)i, &app->state.settings.params,
                             app->state.width, app->state.height, distance, &graphs[i],
                             why_not, sizeof(why_not));
    if (is_good)
        snprintf(text, sizeof(text), "circle of confusion of a thing at %.4g: %.4g px",
                 distance, graphs[0].now_px < NOTHING_PX ? 0 : graphs[0].now_px);
    else
        snprintf(text, sizeof(text), "no graphs: %s", why_not);
    ui_draw_text(ui, &ui->above, ground.x + em / 2, ground.y, ground.width - em, text,
                 is_good ? TEXT : NOW);
    for (int i = 0; i < N_GRAPHS && is_good; i++) {
        const struct area at = {ground.x + i % 2 * wide, ground.y + line + i / 2 * tall,
                                wide, tall};
        draw_graph(app, &graphs[i], &at);
    }
    if (is_good)
        trace_graphs(app, distance, graphs);
}
