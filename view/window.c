/* SPDX-License-Identifier: Apache-2.0 */
/* The window: its parts, and drawing them. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "common/report.h"
#include "console/cli.h"
#include "density.h"

#define STATUS_COLOUR 0x1a1a1eff
#define LETTER_PX 14   /* at 96 dots per inch */
#define USED_SHARE 0.9 /* of the display, by a new window */

/* ---- opening -------------------------------------------------------------------- */

static bool load_font(struct app *app)
{
    char text[MAX_PATH + 128];
    const int size_px = (int)lrint(LETTER_PX * app->scale);
    if (!font_load(&app->font, app->font_path, size_px, text, sizeof(text))) {
        message("%s; give another with --font FILE.ttf", text);
        return false;
    }
    app->mask = gl_make_mask(app->font.coverage, app->font.side, app->font.side);
    ui_init(&app->ui, &app->font);
    return true;
}

/* From the density of the display: the scale of letters that are as large as on one of
 * 96 dots per inch, in quarters. */
static double find_scale(const struct app *app)
{
    if (app->options->scale > 0)
        return app->options->scale;
    /* Where the system scales windows itself, the drawable tells. */
    const double dpi = density_find_dpi(app->window);
    const double scale = fmax(app->density, floor(dpi / 96 * 4 + 0.5) / 4);
    return fmin(fmax(scale, 1), 4);
}

static bool open_context(struct app *app)
{
    char text[512];
    app->context = SDL_GL_CreateContext(app->window);
    if (!app->context) {
        message("view: OpenGL cannot be started: %s; a driver is needed, Mesa's "
                "software driver will do (libgl1-mesa-dri)",
                SDL_GetError());
        return false;
    }
    SDL_GL_SetSwapInterval(1);
    if (!gl_load(text, sizeof(text))) {
        message("view: %s", text);
        return false;
    }
    gl_describe(app->renderer, sizeof(app->renderer));
    return true;
}

static bool create_window(struct app *app)
{
    SDL_GL_SetAttribute(SDL_GL_DOUBLEBUFFER, 1);
    SDL_GL_SetAttribute(SDL_GL_DEPTH_SIZE, 0);
    app->window = SDL_CreateWindow("Rack Focus", SDL_WINDOWPOS_CENTERED,
                                   SDL_WINDOWPOS_CENTERED, 1280, 720,
                                   SDL_WINDOW_OPENGL | SDL_WINDOW_RESIZABLE |
                                       SDL_WINDOW_ALLOW_HIGHDPI | SDL_WINDOW_HIDDEN);
    if (app->window)
        return true;
    message("view: no window with OpenGL can be made: %s; a display with OpenGL is "
            "needed, Mesa's software driver will do (libgl1-mesa-dri)",
            SDL_GetError());
    return false;
}

bool window_open(struct app *app)
{
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_VIDEO_X11_NET_WM_BYPASS_COMPOSITOR, "0");
    /* Without any display SDL may draw to memory that nobody sees. */
    const bool is_started = SDL_Init(SDL_INIT_VIDEO) == 0;
    const char *driver = is_started ? SDL_GetCurrentVideoDriver() : NULL;
    const char *chosen = getenv("SDL_VIDEODRIVER");
    const bool is_chosen = chosen && *chosen; /* set but empty names none */
    const bool is_seen = driver && (is_chosen || (strcmp(driver, "offscreen") != 0 &&
                                                  strcmp(driver, "dummy") != 0));
    if (!is_seen) {
        message("view: there is no display to open a window on: %s; run it in a "
                "graphical session, over ssh -X, or under xvfb-run",
                is_started ? "neither DISPLAY nor WAYLAND_DISPLAY leads to one"
                           : SDL_GetError());
        return false;
    }
    app->event_type = SDL_RegisterEvents(1);
    if (!create_window(app) || !open_context(app))
        return false;
    view_measure(app);
    app->scale = find_scale(app);
    if (!load_font(app))
        return false;
    SDL_StartTextInput();
    return true;
}

void window_close(struct app *app)
{
    ui_free(&app->ui);
    font_free(&app->font);
    if (app->context) {
        gl_picture_free(&app->after);
        gl_picture_free(&app->before);
        accumulation_close(app);
        demo_close(&app->demo);
        SDL_GL_DeleteContext(app->context);
    }
    if (app->window)
        SDL_DestroyWindow(app->window);
    SDL_Quit();
}

/* ---- drawing -------------------------------------------------------------------- */

static int clamp(double v, int low, int high)
{
    return v < low ? low : v > high ? high : (int)lrint(v);
}

/* The part of a picture between two shares of its width, within the area. */
static void draw_part(struct app *app, const struct gl_picture *picture, int times,
                      double from, double to)
{
    const struct zoom *zoom = &app->state.zoom;
    const struct area area = view_picture_area(app);
    const double width = app->state.width * zoom->scale * zoom->aspect;
    const int right = area.x + area.width, bottom = area.y + area.height;
    const int x0 = clamp(zoom->x + from * width, area.x, right);
    const int x1 = clamp(zoom->x + to * width, area.x, right);
    const int y0 = clamp(zoom->y, area.y, bottom);
    const int y1 = clamp(zoom->y + app->state.height * zoom->scale, area.y, bottom);
    gl_clip(x0, y0, x1 - x0, y1 - y0);
    gl_picture_draw(picture, zoom->x, zoom->y, zoom->scale * zoom->aspect * times,
                    zoom->scale * times, times > 1);
}

static void draw_picture(struct app *app)
{
    const struct state *state = &app->state;
    const bool is_plain = state->mode == MODE_PICTURE && !state->has_eye;
    const bool is_off = is_plain && !state->is_filter_on;
    const double split = state->is_split ? state->split : is_off ? 1 : 0;
    const int times = app->shot ? app->shot->times : 1;
    const struct gl_picture *views = accumulation_picture(app);
    const struct gl_picture *before = views ? views : &app->before;
    const bool has_before =
        before->width == state->width && before->height == state->height;
    if (split < 1 || !has_before)
        draw_part(app, &app->after, times, has_before ? split : 0, 1);
    if (split > 0 && has_before)
        draw_part(app, before, 1, 0, split);
}

static void draw_split(struct app *app)
{
    const struct zoom *zoom = &app->state.zoom;
    const struct area area = view_picture_area(app);
    const double at =
        zoom->x + app->state.split * app->state.width * zoom->scale * zoom->aspect;
    const struct area line = {(int)lrint(at), area.y, (int)fmax(app->scale, 1),
                              area.height};
    if (app->state.is_split && area_has(&area, at, area.y))
        ui_draw_box(&app->ui, &app->ui.above, &line, 0xffc14dff);
}

void window_draw(struct app *app)
{
    const double start_s = os_clock_s();
    app->is_redraw_due = false;
    app->drawn_s = start_s;
    if (app->width < 1 || app->height < 1)
        return;
    draw_split(app);
    overlay_draw(app);
    gl_begin(app->width, app->height);
    if (app->has_stage)
        draw_picture(app);
    const struct area panel = view_panel_area(app), status = view_status_area(app);
    gl_fill(panel.x, panel.y, panel.width, panel.height, UI_PANEL_COLOUR);
    gl_draw_quads(app->ui.flat.items, app->ui.flat.n, app->mask);
    gl_fill(status.x, status.y, status.width, status.height, STATUS_COLOUR);
    gl_clip(0, 0, app->width, app->height);
    gl_draw_quads(app->ui.above.items, app->ui.above.n, app->mask);
    if (!app->has_help && !app->has_browser)
        gl_draw_quads(app->ui.bubbles.items, app->ui.bubbles.n, app->mask);
    SDL_GL_SwapWindow(app->window);
    stats_drawn(&app->stats, 1000 * (os_clock_s() - start_s));
}
