/* SPDX-License-Identifier: Apache-2.0 */
#include "demo/demo_picture.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "parallel.h"

enum { SIDE = DEMO_PICTURE_SIDE };

struct colour {
    double r, g, b;
};

static struct colour mix(struct colour a, struct colour b, double t)
{
    t = fmin(fmax(t, 0), 1);
    return (struct colour){a.r + t * (b.r - a.r), a.g + t * (b.g - a.g),
                           a.b + t * (b.b - a.b)};
}

/* 1 inside (d < 0), 0 outside, a soft px in between; d in px. */
static double inside(double d)
{
    return fmin(fmax(0.5 - d, 0), 1);
}

static struct colour paint_sky(double x, double y)
{
    const struct colour top = {0.10, 0.16, 0.34}, low = {0.95, 0.58, 0.30};
    const struct colour sun = {1, 0.93, 0.70};
    const struct colour sky = mix(top, low, pow(y / 330, 1.5));
    return mix(sky, sun, inside(hypot(x - 350, y - 235) - 46));
}

static struct colour paint_hills(struct colour under, double x, double y)
{
    static const struct {
        double height, swing, length, phase;
        struct colour colour;
    } hills[] = {{285, 34, 118, 0.4, {0.38, 0.30, 0.42}},
                 {330, 26, 84, 2.1, {0.24, 0.27, 0.30}},
                 {385, 18, 61, 4.4, {0.14, 0.22, 0.16}}};
    for (int i = 0; i < 3; i++) {
        const double at = hills[i].height -
                          hills[i].swing * sin(x / hills[i].length + hills[i].phase);
        under = mix(under, hills[i].colour, inside(at - y));
    }
    return under;
}

/* A tree: a trunk and branches as thin lines, which show small blurs. */
static struct colour paint_tree(struct colour under, double x, double y)
{
    const struct colour bark = {0.05, 0.04, 0.04};
    under = mix(under, bark, inside(fmax(fabs(x - 128) - 5, fmax(y - 470, 150 - y))));
    for (int i = 0; i < 7; i++) {
        const double root = 190 + 34 * i, reach = 92 - 9 * i;
        const double side = i % 2 ? 1 : -1;
        const double along = (x - 128) * side;
        const double line = fabs(y - root + 0.75 * along) * 0.8 - 1.6;
        under = mix(under, bark, inside(fmax(line, fmax(-along, along - reach))));
    }
    return under;
}

/* Lamps in a row, the brightest things of the picture, and their posts. */
static struct colour paint_lamps(struct colour under, double x, double y)
{
    const struct colour lamp = {1, 0.95, 0.78}, post = {0.06, 0.06, 0.07};
    for (int i = 0; i < 6; i++) {
        const double at = 206 + 46 * i;
        under =
            mix(under, post, inside(fmax(fabs(x - at) - 1, fmax(400 - y, y - 452))));
        under = mix(under, lamp, inside(hypot(x - at, y - 398) - 4.5));
    }
    return under;
}

/* Spokes of black and white, finer and finer towards the middle. */
static struct colour paint_star(struct colour under, double x, double y)
{
    const double dx = x - 90, dy = y - 90, r = hypot(dx, dy);
    const double wave = sin(24 * atan2(dy, dx)) * r / 24;
    const double white = fmin(fmax(0.5 + wave, 0), 1);
    const struct colour star = {white, white, white};
    return mix(under, star, inside(r - 52));
}

static struct colour paint_frame(struct colour under, double x, double y)
{
    const struct colour dark = {0.32, 0.07, 0.07}, light = {0.93, 0.88, 0.76};
    const double border = fmin(fmin(x, y), fmin(SIDE - x, SIDE - y));
    const bool is_dark = fmod(x + y, 32) < 16;
    return border < 18 ? (is_dark ? dark : light) : under;
}

static uint8_t code_of(double v)
{
    return (uint8_t)lrint(255 * fmin(fmax(v, 0), 1));
}

static void paint_rows(void *data, int64_t begin, int64_t end, int thread)
{
    uint8_t *rgba = data;
    for (int j = (int)begin; j < (int)end; j++)
        for (int i = 0; i < SIDE; i++) {
            const double x = i + 0.5, y = j + 0.5;
            struct colour colour = paint_hills(paint_sky(x, y), x, y);
            colour = paint_lamps(paint_tree(colour, x, y), x, y);
            colour = paint_frame(paint_star(colour, x, y), x, y);
            uint8_t *out = rgba + 4 * ((size_t)j * SIDE + (size_t)i);
            out[0] = code_of(colour.r);
            out[1] = code_of(colour.g);
            out[2] = code_of(colour.b);
            out[3] = 255;
        }
}

void demo_picture_paint(uint8_t *rgba)
{
    os_parallel(0, SIDE, 0, paint_rows, rgba);
}
