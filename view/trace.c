/* SPDX-License-Identifier: Apache-2.0 */
/* What tests need to know: a line of JSON for whatever happens. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "common/report.h"
#include "console/cli.h"
#include "console/progress.h"

bool trace_open(struct app *app)
{
    if (!app->options->trace)
        return true;
    app->trace = fopen(app->options->trace, "w");
    if (!app->trace)
        message("%s: cannot be written: %s", app->options->trace, strerror(errno));
    return app->trace != NULL;
}

static void print_text(FILE *file, const char *text)
{
    putc('"', file);
    for (; *text; text++) {
        if (*text == '"' || *text == '\\')
            putc('\\', file);
        if ((unsigned char)*text >= ' ')
            putc(*text, file);
        else if (*text == '\n')
            fputs("\\n", file);
    }
    putc('"', file);
}

void trace_text(struct app *app, const char *event, const char *text)
{
    if (!app->trace)
        return;
    fprintf(app->trace, "{\"event\": \"%s\", \"text\": ", event);
    print_text(app->trace, text);
    fprintf(app->trace, "}\n");
    fflush(app->trace);
}

static uint32_t hash(uint32_t sum, const void *data, size_t n_bytes)
{
    for (const unsigned char *at = data; n_bytes > 0; n_bytes--)
        sum = (sum ^ *at++) * 16777619u;
    return sum;
}

/* Where everything lies, when that has changed. */
void trace_layout(struct app *app)
{
    const struct zoom *zoom = &app->state.zoom;
    if (!app->trace)
        return;
    const struct area area = view_picture_area(app);
    uint32_t sum = hash(2166136261u, app->ui.controls,
                        (size_t)app->ui.n_controls * sizeof(*app->ui.controls));
    sum = hash(sum, &zoom->scale, 4 * sizeof(double));
    sum = hash(sum, &area, sizeof(area));
    const struct area list = app->ui.popup ? app->ui.popup_area : (struct area){0};
    sum = hash(sum, &list, sizeof(list));
    if (sum == app->traced_layout)
        return;
    app->traced_layout = sum;
    fprintf(app->trace,
            "{\"event\": \"layout\", \"window\": [%d, %d], \"area\": [%d, %d, %d, %d], "
            "\"scale\": %.9g, \"x\": %.9g, \"y\": %.9g, \"letters\": %d, "
            "\"controls\": {",
            app->width, app->height, area.x, area.y, area.width, area.height,
            zoom->scale, zoom->x, zoom->y, app->font.size_px);
    for (int i = 0; i < app->ui.n_controls; i++) {
        const struct ui_control *control = &app->ui.controls[i];
        fprintf(app->trace, "%s", i ? ", " : "");
        print_text(app->trace, control->label);
        fprintf(app->trace, ": [%d, %d, %d, %d]", control->area.x, control->area.y,
                control->area.width, control->area.height);
    }
    fprintf(app->trace, "}, \"off\": [");
    for (int i = 0, n = 0; i < app->ui.n_controls; i++)
        if (app->ui.controls[i].is_off) {
            fprintf(app->trace, "%s", n++ ? ", " : "");
            print_text(app->trace, app->ui.controls[i].label);
        }
    fprintf(app->trace, "], \"panel\": [%d, %d, %d, %d], \"list\": [%d, %d, %d, %d]}\n",
            app->ui.panel.x, app->ui.panel.y, app->ui.panel.width, app->ui.panel.height,
            list.x, list.y, list.width, list.height);
    fflush(app->trace);
}

void trace_tip(struct app *app)
{
    const struct ui *ui = &app->ui;
    const char *text = ui->error_id ? ui->error : ui->is_tip_shown ? ui->tip : "";
    const uint32_t sum = hash(2166136261u, text, strlen(text)) ^ (ui->error_id != 0);
    if (!app->trace || sum == app->traced_tip)
        return;
    app->traced_tip = sum;
    trace_text(app, ui->error_id ? "field error" : "tip", text);
}

void trace_once(struct app *app, uint32_t *traced, const char *event, const char *text)
{
    const uint32_t sum = hash(2166136261u, text, strlen(text));
    if (!app->trace || sum == *traced)
        return;
    *traced = sum;
    trace_text(app, event, text);
}

void trace_place(struct app *app, const char *text)
{
    if (text[0] == '(')
        trace_once(app, &app->traced_place, "place", text);
}

static void print_number(FILE *file, const char *name, double number)
{
    if (isfinite(number))
        fprintf(file, ", \"%s\": %.9g", name, number);
    else
        fprintf(file, ", \"%s\": null", name);
}

/* A new picture is on the screen. */
void trace_shown(struct app *app, bool is_pinhole)
{
    const struct shot *shot = app->shot;
    const struct state *state = &app->state;
    if (!app->trace)
        return;
    /* Asks the X server something: when it answers, it has drawn what came before. */
    SDL_GetWindowBordersSize(app->window, NULL, NULL, NULL, NULL);
    fprintf(app->trace,
            "{\"event\": \"shown\", \"pinhole\": %s, \"filter\": %s, \"split\": %s, "
            "\"eye\": %s",
            is_pinhole ? "true" : "false", state->is_filter_on ? "true" : "false",
            state->is_split ? "true" : "false", state->has_eye ? "true" : "false");
    print_number(app->trace, "focus", state->settings.params.focus_distance);
    print_number(app->trace, "f_stop", state_f_stop(state));
    print_number(app->trace, "screen", state_screen(state));
    if (shot)
        fprintf(app->trace,
                ", \"id\": %llu, \"is_newest\": %s, \"quality\": \"%s\", \"method\": "
                "\"%s\", \"mode\": %d, \"times\": %d, \"filter_ms\": %.3f, "
                "\"display_ms\": %.3f, \"eye_view\": %d",
                (unsigned long long)shot->id,
                shot->id == app->asked_id ? "true" : "false",
                shot->quality == SHOT_BEST ? "best" : "preview", shot->method,
                (int)shot->mode, shot->times, shot->filter_ms, shot->display_ms,
                shot->eye_view);
    if (shot)
        print_number(app->trace, "tpsnr", shot->tpsnr_db);
    if (shot)
        fprintf(app->trace, ", \"views\": %d", shot->n_views);
    fprintf(app->trace, "}\n");
    fflush(app->trace);
}
