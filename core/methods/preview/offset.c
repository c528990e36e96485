/* SPDX-License-Identifier: Apache-2.0 */
/*
 * offset: N shifted copies of the picture, averaged.
 *
 *   out(p) = 1/N sum over i of c(p + r o_i),   bilinear between pixels
 *   o_i    Vogel's points, radius sqrt((i + 1/2) / N), angle i (3 - sqrt 5) pi,
 *          stretched to the outline of the aperture along their own direction
 *
 *   c   the picture     r   signed radius of the pixel, px     N   --copies
 *
 * A shift s = k + g (k whole) is split between k and k + 1 by (s^2 - k^2) / (2 k + 1)
 * instead of g: that keeps the mean square distance, where g would blur small radii too
 * much.
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "offset": the same texture 4 or 8 times with equal weight. The pattern is open there;
 * a disc of points, and the shape of the aperture, are ours.
 *
 * Known artefacts: N separate transparent copies where the radius is large; like an
 * accumulation of N views that all see the same; gathers by the pixel's own radius.
 *
 * Cost: N bilinear taps per pixel, whatever the radius.
 */
#include "methods/preview/offset.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
#include "input/frame.h"
#include "lens/aperture.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

enum { MAX_COPIES = 64 };

struct offset {
    const struct rf_blur *blur;
    int n;
    float at[MAX_COPIES][2]; /* px per px of radius, x right and y down */
};

/* How far the outline of the shape is from its centre along (u, v), a unit vector. */
static double outline(const struct rf_shape *shape, bool is_hollow, double u, double v)
{
    double least = INFINITY;
    if (shape->is_disc)
        return 1 / rf_length(u * shape->ratio, v);
    for (int i = 0; i < shape->n_corners; i++) {
        const double *a = shape->corner[i];
        const double *b = shape->corner[(i + 1) % shape->n_corners];
        double nx = b[1] - a[1], ny = a[0] - b[0]; /* outwards */
        double along = u * nx + v * ny;
        bool is_there = a[0] * v - a[1] * u >= 0 && b[0] * v - b[1] * u <= 0;
        if (along > 0 && (is_there || !is_hollow))
            least = fmin(least, (a[0] * nx + a[1] * ny) / along);
    }
    return least;
}

static void place_copies(struct offset *o, const struct rf_frame *f)
{
    struct rf_shape shape = f->shape;
    bool is_hollow = rf_shape_hollow_out(&shape, &f->params);
    o->n = f->params.copies;
    for (int i = 0; i < o->n; i++) {
        double angle = i * RF_PI * (3 - sqrt(5)), u = cos(angle), v = sin(angle);
        double rho = sqrt((i + 0.5) / o->n) * outline(&shape, is_hollow, u, v);
        o->at[i][0] = (float)(rho * u);
        o->at[i][1] = (float)(-rho * v * f->shape.pixel_aspect);
    }
}

/* The two neighbours of a place `shift` from pixel i, and the second one's weight. */
static inline float neighbours(float shift, int i, int n, int *first, int *second)
{
    float s = fabsf(shift), k = floorf(s), g = (s * s - k * k) / (2 * k + 1);
    int step = shift < 0 ? -1 : 1, whole = (int)k;
    *first = rf_clamp_int(i + step * whole, 0, n - 1);
    *second = rf_clamp_int(i + step * (whole + 1), 0, n - 1);
    return g;
}

static rf_f4 average(const struct offset *o, int x, int y, float r)
{
    const struct rf_grid *from = o->blur->source;
    rf_f4 sum = {0};
    for (int i = 0; i < o->n; i++) {
        int x0, x1, y0, y1;
        rf_f4 fx = rf_f4_of(neighbours(o->at[i][0] * r, x, from->width, &x0, &x1));
        rf_f4 fy = rf_f4_of(neighbours(o->at[i][1] * r, y, from->height, &y0, &y1));
        const rf_f4 *top = from->at + (size_t)y0 * (size_t)from->width;
        const rf_f4 *low = from->at + (size_t)y1 * (size_t)from->width;
        rf_f4 a = top[x0] + fy * (low[x0] - top[x0]);
        rf_f4 b = top[x1] + fy * (low[x1] - top[x1]);
        sum += a + fx * (b - a);
    }
    return sum * rf_f4_of(1 / (float)o->n);
}

static void offset_band(void *user, int from, int to, int thread)
{
    const struct offset *o = user;
    const struct rf_blur *blur = o->blur;
    int width = blur->source->width;
    for (int y = from; y < to; y++)
        for (int x = 0; x < width; x += RF_PIECE) {
            rf_f4 out[RF_PIECE];
            int n = rf_min_int(RF_PIECE, width - x);
            const float *map =
                blur->radius_map
                    ? blur->radius_map + (size_t)y * (size_t)width + (size_t)x
                    : NULL;
            for (int k = 0; k < n; k++)
                out[k] = average(o, x + k, y, map ? map[k] : blur->radius_px);
            blur->put(blur, x, y, n, out);
        }
}

rf_result rf_generate_offset(const struct rf_blur *blur, struct rf_error *error)
{
    struct offset o = {.blur = blur};
    place_copies(&o, blur->frame);
    rf_blur_pass(blur, 0, 1, blur->source->height, RF_BAND_ROWS, offset_band, &o);
    return RF_OK;
}
