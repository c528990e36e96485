/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/zoom.h"

#include <math.h>

#define MAX_SCALE 64.0
#define SEEN_PX 24.0 /* of the picture that panning leaves in the area */

bool area_has(const struct area *area, double x, double y)
{
    return x >= area->x && y >= area->y && x < area->x + area->width &&
           y < area->y + area->height;
}

void zoom_fit(struct zoom *zoom, const struct area *area, int32_t width, int32_t height)
{
    const double across = area->width / (width * zoom->aspect);
    const double down = area->height / (double)height;
    const double whole = fmin(across, down);
    zoom->scale = whole > 1 ? fmin(floor(2 * whole) / 2, MAX_SCALE) : whole;
    zoom->scale = fmax(zoom->scale, 1e-6);
    zoom->x = area->x + (area->width - width * zoom->aspect * zoom->scale) / 2;
    zoom->y = area->y + (area->height - height * zoom->scale) / 2;
    zoom->is_fitted = true;
    zoom_settle(zoom, area, width, height);
}

void zoom_to_actual(struct zoom *zoom, double x, double y)
{
    zoom_by(zoom, 1 / zoom->scale, x, y);
    zoom->scale = 1;
}

void zoom_by(struct zoom *zoom, double factor, double x, double y)
{
    double scale = zoom->scale * factor;
    scale = fmin(fmax(scale, 1 / MAX_SCALE), MAX_SCALE);
    /* Steps of a wheel must come back to the px as they are. */
    if (fabs(scale - 1) < 1e-3)
        scale = 1;
    const double ratio = scale / zoom->scale;
    zoom->x = x + (zoom->x - x) * ratio;
    zoom->y = y + (zoom->y - y) * ratio;
    zoom->scale = scale;
    zoom->is_fitted = false;
}

void zoom_pan(struct zoom *zoom, double dx, double dy)
{
    zoom->x += dx;
    zoom->y += dy;
    zoom->is_fitted = false;
}

static double hold(double at, double size, double from, double extent)
{
    const double seen = fmin(SEEN_PX, fmin(size, extent));
    return fmin(fmax(at, from + seen - size), from + extent - seen);
}

void zoom_settle(struct zoom *zoom, const struct area *area, int32_t width,
                 int32_t height)
{
    zoom->x = hold(zoom->x, width * zoom->aspect * zoom->scale, area->x, area->width);
    zoom->y = hold(zoom->y, height * zoom->scale, area->y, area->height);
    if (zoom->scale == floor(zoom->scale) && zoom->aspect == 1) {
        zoom->x = floor(zoom->x + 0.5);
        zoom->y = floor(zoom->y + 0.5);
    }
}

void zoom_to_picture(const struct zoom *zoom, double window_x, double window_y,
                     double *x, double *y)
{
    *x = (window_x - zoom->x) / (zoom->scale * zoom->aspect);
    *y = (window_y - zoom->y) / zoom->scale;
}

bool zoom_pick(const struct zoom *zoom, int32_t width, int32_t height, double window_x,
               double window_y, int32_t *x, int32_t *y)
{
    double px, py;
    /* The middle of the window's px, as the screen shows it. */
    zoom_to_picture(zoom, window_x + 0.5, window_y + 0.5, &px, &py);
    if (px < 0 || py < 0 || px >= width || py >= height)
        return false;
    *x = (int32_t)px;
    *y = (int32_t)py;
    return true;
}
