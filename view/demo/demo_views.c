/* SPDX-License-Identifier: Apache-2.0 */
#include "demo/demo_views.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "common/report.h"
#include "parallel.h"
#include "pixels/input.h"

bool demo_views_make(struct demo_views *views, const struct demo *demo)
{
    const size_t n = (size_t)demo->width * (size_t)demo->height;
    if (!views->sum)
        views->sum = app_memory(n, 3 * sizeof(float), NULL);
    if (!views->rgba)
        views->rgba = app_memory(n, 4, NULL);
    return views->sum && views->rgba;
}

void demo_views_free(struct demo_views *views)
{
    free(views->sum);
    free(views->rgba);
    *views = (struct demo_views){0};
}

/* ---- where the views are ---------------------------------------------------------- */

static int common_divisor(int a, int b)
{
    return b == 0 ? a : common_divisor(b, a % b);
}

/* Steps of the golden section go through all of n points, and any number of steps is
 * spread evenly over them. */
static int step_through(int n)
{
    int step = (int)lrint(n * 0.618033988749895);
    while (step > 1 && common_divisor(n, step) != 1)
        step--;
    return step > 0 ? step : 1;
}

/*
 * The radius of the lens that blurs as the formula of the circle of confusion does: r =
 * bias + scale / z px, and an eye at distance R from the middle moves a point at z by
 * R f_px (1/F - 1/z). A real lens, whose picture grows with the focus, has a somewhat
 * larger one than its aperture.
 */
static double effective_radius(const struct demo *demo, const struct rf_lens *lens)
{
    return -lens->scale / demo_focal_px(demo);
}

static bool find_eyes(const struct demo *demo, int n, enum demo_move move,
                      const struct rf_params *params, const struct rf_lens *lens,
                      struct demo_eye *eyes, struct rf_error *error)
{
    struct rf_lens_point points[DEMO_MOST_VIEWS] = {{0}};
    struct rf_params of_views = *params;
    const double radius = effective_radius(demo, lens);
    of_views.method = RF_METHOD_ACCUMULATE;
    if (lens->projection != RF_PROJECTION_PERSPECTIVE) {
        *error = (struct rf_error){.code = RF_ERROR_PARAMETER};
        snprintf(error->message, sizeof(error->message),
                 "the views of the demo are drawn in perspective: set projection "
                 "perspective");
        return false;
    }
    if (n > 1 && rf_lens_points(&of_views, n, 0, points, error) != RF_OK)
        return false;
    const int step = step_through(n);
    for (int i = 0, at = 0; i < n; i++, at = (at + step) % n)
        eyes[i] = (struct demo_eye){.x = radius * points[at].u,
                                    .y = radius * points[at].v,
                                    .focus = lens->focus_distance,
                                    .move = move};
    return true;
}

static bool are_eyes_same(const struct demo_eye *a, const struct demo_eye *b, int n)
{
    for (int i = 0; i < n; i++)
        if (a[i].x != b[i].x || a[i].y != b[i].y || a[i].focus != b[i].focus ||
            a[i].move != b[i].move)
            return false;
    return true;
}

bool demo_views_aim(struct demo_views *views, struct demo *demo, int n,
                    enum demo_move move, const struct rf_params *params,
                    const struct rf_lens *lens, bool *is_new, struct rf_error *error)
{
    struct demo_eye eyes[DEMO_MOST_VIEWS];
    if (!find_eyes(demo, n, move, params, lens, eyes, error))
        return false;
    *is_new = views->n != n || views->yaw != demo->yaw || views->pitch != demo->pitch ||
              !are_eyes_same(views->eyes, eyes, n);
    if (!*is_new)
        return true;
    views->n = n;
    views->n_done = 0;
    views->drawn_ms = 0;
    views->yaw = demo->yaw;
    views->pitch = demo->pitch;
    memcpy(views->eyes, eyes, (size_t)n * sizeof(eyes[0]));
    demo_lay(demo);
    return true;
}

/* ---- adding them up --------------------------------------------------------------- */

/* What the threads share that add a view. */
struct adding {
    float decoder[256];
    const uint8_t *rgba; /* rows from the bottom */
    float *sum;
    int32_t width, height;
    bool is_first;
};

static void add_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct adding *a = data;
    const size_t w = (size_t)a->width;
    for (int64_t y = begin; y < end; y++) {
        const uint8_t *from = a->rgba + 4 * w * (size_t)(a->height - 1 - y);
        float *to = a->sum + 3 * w * (size_t)y;
        for (size_t x = 0; x < w; x++, from += 4, to += 3)
            for (size_t c = 0; c < 3; c++)
                to[c] = (a->is_first ? 0 : to[c]) + a->decoder[from[c]];
    }
}

/* While one view is added up, OpenGL draws the next one. */
void demo_views_step(struct demo_views *views, const struct demo *demo, double until_s)
{
    struct adding adding = {.rgba = views->rgba,
                            .sum = views->sum,
                            .width = demo->width,
                            .height = demo->height};
    const double start_s = os_clock_s();
    input_fill_decoder(adding.decoder);
    bool is_drawn = false; /* the view n_done is, or is being */
    while (views->n_done < views->n) {
        const int at = views->n_done, next = at + 1;
        const bool goes_on = next < views->n && os_clock_s() < until_s;
        if (!is_drawn)
            demo_begin_view(demo, &views->eyes[at], at % 2);
        if (goes_on)
            demo_begin_view(demo, &views->eyes[next], next % 2);
        demo_read_view(demo, at % 2, views->rgba);
        adding.is_first = at == 0;
        os_parallel(0, demo->height, 0, add_rows, &adding);
        views->n_done = next;
        is_drawn = goes_on;
        if (!goes_on)
            break;
    }
    views->drawn_ms += 1000 * (os_clock_s() - start_s);
}

void demo_views_mean(const struct demo_views *views, const struct demo *demo,
                     float *rgb)
{
    const size_t n = 3 * (size_t)demo->width * (size_t)demo->height;
    const float share = 1.0f / (float)views->n_done;
    for (size_t i = 0; i < n; i++)
        rgb[i] = views->sum[i] * share;
}
