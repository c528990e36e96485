/* SPDX-License-Identifier: Apache-2.0 */
/*
 * --benchmark: drags the slider of the focus distance to and fro, or the demo's scene
 * around, as a mouse would, with 60 events a second through SDL's queue, and prints how
 * soon the pictures followed.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "app.h"
#include "clock.h"
#include "process.h"

#define EVENTS_A_SECOND 60
#define PERIOD_S 4.0 /* to and fro */
/* Nobody drags before there is a picture; OpenGL makes its shaders for the first one.
 */
#define LOOK_S 0.5

static void push_mouse(const struct app *app, Uint32 type, double x, double y)
{
    SDL_Event event = {.type = type};
    const int at_x = (int)lrint(x / app->density), at_y = (int)lrint(y / app->density);
    if (type == SDL_MOUSEMOTION) {
        event.motion.x = at_x;
        event.motion.y = at_y;
    } else {
        event.button.button = SDL_BUTTON_LEFT;
        event.button.x = at_x;
        event.button.y = at_y;
    }
    SDL_PushEvent(&event);
}

/* Where the mouse is held; false while there is no such place. */
static bool find_handle(const struct app *app, struct area *area)
{
    if (app->options->is_benchmark_turn) {
        *area = view_picture_area(app);
        return true;
    }
    for (int i = 0; i < app->ui.n_controls; i++)
        if (strcmp(app->ui.controls[i].label, "Focus distance") == 0) {
            *area = app->ui.controls[i].area;
            return true;
        }
    return false;
}

/* The end, as soon as the best picture of what was set last is on the screen. */
static void wait_for_best(struct app *app, double now_s)
{
    struct bench *bench = &app->bench;
    const struct shot *shot = app->shot;
    const bool is_best = shot->quality == SHOT_BEST && shot->id == app->state.id;
    const bool is_off = !app->state.is_filter_on; /* then none is made */
    if (!is_best && !is_off)
        return;
    bench->best_ms = is_off ? NAN : 1000 * (now_s - bench->released_s);
    bench->is_over = true;
    app->is_ending = true;
}

void bench_step(struct app *app)
{
    struct area handle;
    const double now_s = os_clock_s();
    struct bench *bench = &app->bench;
    if (!find_handle(app, &handle) || !app->shot || bench->is_over)
        return;
    const double y = handle.y + handle.height / 2.0;
    if (bench->ready_s == 0)
        bench->ready_s = now_s;
    if (now_s < bench->ready_s + LOOK_S)
        return;
    if (bench->started_s == 0) {
        bench->started_s = now_s;
        bench->cpu_s = os_process_cpu_s();
        app->accumulation.n_drawn = app->accumulation.n_complete = 0;
        stats_start(&app->stats, now_s);
        push_mouse(app, SDL_MOUSEBUTTONDOWN, handle.x + handle.width * 0.5, y);
    }
    const double t = now_s - bench->started_s;
    if (bench->released_s > 0) {
        wait_for_best(app, now_s);
        return;
    }
    if (now_s - bench->moved_s < 1.0 / EVENTS_A_SECOND)
        return;
    bench->moved_s = now_s;
    if (t > app->options->benchmark_s) {
        bench->cpu_s = os_process_cpu_s() - bench->cpu_s;
        bench->wall_s = t;
        bench->stats = app->stats;
        bench->released_s = now_s;
        push_mouse(app, SDL_MOUSEBUTTONUP, handle.x + handle.width * 0.5, y);
        return;
    }
    const double swing = 0.45 * sin(2 * acos(-1) * t / PERIOD_S);
    push_mouse(app, SDL_MOUSEMOTION, handle.x + handle.width * (0.5 + swing), y);
}

void bench_print(const struct app *app)
{
    const struct stats *s = &app->bench.stats;
    const struct bench *bench = &app->bench;
    const double wall_ms = 1000 * bench->wall_s;
    printf("picture %d x %d px, window %d x %d px, %s\n", app->state.width,
           app->state.height, app->width, app->height, app->renderer);
    printf("updates %d, %.1f a second\n", s->n, stats_rate(s));
    if (s->n > 0)
        printf(
            "input to picture: median %.1f ms, 95 %% within %.1f ms, longest %.1f ms\n",
            stats_latency_ms(s, 0.5), stats_latency_ms(s, 0.95),
            stats_latency_ms(s, 1));
    printf("frames drawn %d, %.1f ms each\n", s->n_draws,
           s->n_draws ? s->draw_ms / s->n_draws : 0);
    if (!isnan(bench->best_ms))
        printf("release to best picture: %.0f ms\n", bench->best_ms);
    const struct accumulation *views = &app->accumulation;
    if (views->is_on)
        printf("views drawn %d, %.1f a second; %d means of %d views, %.1f a second\n",
               views->n_drawn, views->n_drawn / bench->wall_s, views->n_complete,
               views->n, views->n_complete / bench->wall_s);
    printf("previews %d, %d of them made smaller\n", s->n_previews, s->n_small);
    printf("share of the time: filter %.1f %%, to 8 bit %.1f %%, drawing %.1f %%\n",
           100 * s->filter_ms / wall_ms, 100 * s->display_ms / wall_ms,
           100 * s->draw_ms / wall_ms);
    printf("processor time %.2f s in %.2f s, %.1f ms an update\n", bench->cpu_s,
           bench->wall_s, s->n ? 1000 * bench->cpu_s / s->n : 0);
}
