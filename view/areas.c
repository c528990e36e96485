/* SPDX-License-Identifier: Apache-2.0 */
/* Where in the window the picture, the controls and the line at the bottom lie. */
#include "app.h"

#define PANEL_EMS 23
#define LEAST_EMS 14    /* narrower, labels cannot be read */
#define MOST_SHARE 0.55 /* of the window */

int view_panel_width(const struct app *app)
{
    return PANEL_EMS * app->font.size_px;
}

static int panel_width(const struct app *app)
{
    const int width = view_panel_width(app), most = (int)(MOST_SHARE * app->width);
    const int narrow = width < most ? width : most;
    return app->has_panel && narrow >= LEAST_EMS * app->font.size_px ? narrow : 0;
}

static int status_height(const struct app *app)
{
    const int height = app->font.line + app->font.size_px / 2;
    return app->height >= 4 * height ? height : 0;
}

static int at_least_one(int px)
{
    return px > 1 ? px : 1;
}

struct area view_picture_area(const struct app *app)
{
    return (struct area){0, 0, at_least_one(app->width - panel_width(app)),
                         at_least_one(app->height - status_height(app))};
}

struct area view_panel_area(const struct app *app)
{
    const int width = panel_width(app);
    return (struct area){app->width - width, 0, width,
                         at_least_one(app->height - status_height(app))};
}

struct area view_status_area(const struct app *app)
{
    const int height = status_height(app);
    return (struct area){0, app->height - height, app->width, height};
}

bool view_depth_at(const struct app *app, double x, double y, double *depth,
                   int32_t *px, int32_t *py)
{
    const struct input *input = app->shot ? app->shot->input : NULL;
    const struct area area = view_picture_area(app);
    if (!app->has_stage || app->play.is_ahead || !input || !input->planar ||
        !area_has(&area, x, y) ||
        !zoom_pick(&app->state.zoom, input->width, input->height, x, y, px, py))
        return false;
    *depth = input->planar[(size_t)*py * (size_t)input->width + (size_t)*px];
    return true;
}

void view_measure(struct app *app)
{
    int width, height;
    SDL_GL_GetDrawableSize(app->window, &app->width, &app->height);
    SDL_GetWindowSize(app->window, &width, &height);
    app->density = width > 0 ? (double)app->width / width : 1;
    const struct area area = view_picture_area(app);
    if (app->state.width > 0 && app->state.zoom.is_fitted)
        zoom_fit(&app->state.zoom, &area, app->state.width, app->state.height);
    else if (app->state.width > 0)
        zoom_settle(&app->state.zoom, &area, app->state.width, app->state.height);
    app->is_redraw_due = true;
}
