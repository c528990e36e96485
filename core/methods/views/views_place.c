/* SPDX-License-Identifier: Apache-2.0 */
/* Which of several views see a place, and what they leave of it to the others. */
#include "methods/views/views_place.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/math.h"
#include "compose/scene.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "kernels/sight_kernels.h"
#include "methods/views/merge.h"
#include "surfaces/picture.h"

/* The least n of a weight share / n (views.c). Ours: with half portrait's eight views
 * lose 0.13 dB, with twice they win 0.05 (docs/notebook/thresholds.md). */
static const float LEAST_COUNT = 0.25f;

float rf_view_sees(const struct rf_views *v, int j, struct rf_view_place p,
                   bool *is_rendered)
{
    int px, py;
    *is_rendered = false;
    if (!rf_view_pixel_at(v, j, p, &px, &py))
        return 0;
    *is_rendered = rf_view_is_rendered(&v->pictures[j], px, py);
    return rf_view_pixel_sees(&v->pictures[j], px, py, p.r);
}

/* The same, of what was rendered. */
static inline float shows(const struct rf_views *v, int j, struct rf_view_place p)
{
    const struct rf_picture *picture = &v->pictures[j];
    int px, py;
    if (!rf_view_pixel_at(v, j, p, &px, &py) || !rf_view_is_rendered(picture, px, py))
        return 0;
    return rf_view_pixel_sees(picture, px, py, p.r);
}

float rf_views_show(const struct rf_views *v, uint64_t views, int j,
                    struct rf_view_place p, float *continued)
{
    float shown = 0;
    *continued = 0;
    for (int k = 0; k < v->work->n_views; k++) {
        bool is_rendered;
        if (k == j || !(views >> k & 1))
            continue;
        float seen = rf_view_sees(v, k, p, &is_rendered);
        *(is_rendered ? &shown : continued) += seen;
    }
    return shown;
}

void rf_views_measure_range(struct rf_views *v)
{
    for (int k = 0; k < 2; k++) {
        v->range.slope[0][k] = v->range.base[0][k] = INFINITY;
        v->range.slope[1][k] = v->range.base[1][k] = -INFINITY;
    }
    for (int j = 0; j < v->work->n_views; j++)
        for (int k = 0; k < 2; k++) {
            const struct rf_work_view *view = &v->work->views[j];
            float lens = k ? -view->lens[k] : view->lens[k];
            float slope = lens * view->shift_scale, base = lens * view->shift_bias;
            struct rf_view_range *r = &v->range;
            r->slope[0][k] = rf_min_float(slope, r->slope[0][k]);
            r->slope[1][k] = rf_max_float(slope, r->slope[1][k]);
            r->base[0][k] = rf_min_float(base, r->base[0][k]);
            r->base[1][k] = rf_max_float(base, r->base[1][k]);
        }
}

bool rf_views_are_beside(const struct rf_views *v, struct rf_view_place p)
{
    static const float ROUNDED_PX = 1;
    const struct rf_picture *picture = &v->pictures[0];
    const float at[2] = {p.x, p.y};
    const int first[2] = {picture->x0, picture->y0};
    const int size[2] = {picture->frame->width, picture->frame->height};
    int low = p.r < 0; /* whose slope shifts least */
    for (int k = 0; k < 2; k++) {
        float least = v->range.slope[low][k] * p.r + v->range.base[0][k];
        float most = v->range.slope[!low][k] * p.r + v->range.base[1][k];
        if (at[k] + most < (float)first[k] - ROUNDED_PX ||
            at[k] + least > (float)(first[k] + size[k]) + ROUNDED_PX)
            return true;
    }
    return false;
}

float rf_views_leave(const struct rf_views *v, int j, struct rf_view_place p,
                     float least)
{
    float left = 1;
    if (rf_views_are_beside(v, p))
        return left;
    for (int k = 0; k < v->work->n_views && left > least; k++)
        if (k != j)
            left -= shows(v, k, p);
    return rf_max_float(left, least);
}

/* Takes from eight places, those in `asked`, what view k shows of them. */
static void take_shown(const struct rf_views *v, int k, const struct rf_sight_places *p,
                       unsigned asked, float left[8])
{
    const struct rf_picture *picture = &v->pictures[k];
    const struct rf_kernels *kernels = picture->frame->context->kernels;
    struct rf_sight_found found;
    kernels->look_for_parts(&v->sights[k], p, 8, RF_OCCLUDED_PX, &found);
    for (unsigned rest = found.rendered & asked; rest; rest &= rest - 1) {
        int i = __builtin_ctz(rest);
        left[i] -= found.clear >> i & 1
                       ? 1
                       : rf_view_pixel_sees(picture, found.x[i], found.y[i], p->r[i]);
    }
}

void rf_views_leave_eight(const struct rf_views *v, int j, int x, int y, unsigned asked,
                          float left[8])
{
    struct rf_sight_places p;
    for (int i = 0; i < 8; i++)
        left[i] = 1;
    v->pictures[j].frame->context->kernels->place_row(&v->sights[j], x, y, &p);
    for (int k = 0; k < v->work->n_views && asked; k++) {
        if (k == j)
            continue;
        take_shown(v, k, &p, asked, left);
        for (unsigned rest = asked; rest; rest &= rest - 1)
            if (left[__builtin_ctz(rest)] <= 0)
                asked &= ~(rest & -rest);
    }
}

/* ---- runs of one radius --------------------------------------------------------- */

/* Where a view shows pixels of one radius: from (x, y) on, of which it has rendered
 * some. */
struct shown_run {
    int x, y;
    float r;
    uint64_t rendered;
};

/* Places side by side stay so in every view, if their radius is one. */
static struct shown_run show_run(const struct rf_views *v, int k,
                                 struct rf_view_place first, int n)
{
    const struct rf_sight *s = &v->sights[k];
    struct shown_run run = {.r = first.r, .rendered = 0};
    rf_view_pixel_at(v, k, first, &run.x, &run.y);
    if (run.y < s->y0 || run.y >= s->y1 || run.x >= s->x1 || run.x + n <= s->x0)
        return run;
    int from = rf_max_int(s->x0 - run.x, 0), to = rf_min_int(s->x1 - run.x, n);
    run.rendered = UINT64_MAX >> (64 - (to - from)) << from;
    return run;
}

/* Which of them view k surely shows whole. */
static uint64_t find_clear(const struct rf_views *v, int k, const struct shown_run *run)
{
    const struct rf_sight *s = &v->sights[k];
    if (!run->rendered)
        return 0;
    int from = __builtin_ctzll(run->rendered);
    int n = 64 - __builtin_clzll(run->rendered) - from;
    const float *radius = s->radius + s->stride * (size_t)run->y + (run->x + from);
    return v->work->frame->context->kernels->find_finite_from(
               radius, run->r - RF_OCCLUDED_PX, n)
           << from;
}

/* How far a place lies within what a view has rendered, px; below 0 beside it. */
static float depth_within(const struct rf_sight *s, struct rf_view_place p)
{
    float shift = s->shift_scale * p.r + s->shift_bias;
    float x = p.x + s->lens[0] * shift, y = p.y - s->lens[1] * shift;
    return rf_min_float(rf_min_float(x - (float)s->x0, (float)s->x1 - x),
                        rf_min_float(y - (float)s->y0, (float)s->y1 - y));
}

/* Of the views other than j, the one in which a place lies farthest from the border. */
static int likeliest_view(const struct rf_views *v, int j, struct rf_view_place p)
{
    int best = j;
    float most = -INFINITY;
    for (int k = 0; k < v->work->n_views; k++) {
        float depth = k == j ? -INFINITY : depth_within(&v->sights[k], p);
        if (depth > most) {
            most = depth;
            best = k;
        }
    }
    return best;
}

/* Takes from those of a run in `asked` what view k shows of them in part. */
static void take_parts(const struct rf_views *v, int k, const struct shown_run *run,
                       uint64_t asked, float left[64])
{
    const struct rf_picture *picture = &v->pictures[k];
    size_t row = (size_t)run->y * (size_t)picture->width;
    for (uint64_t rest = asked & run->rendered; rest; rest &= rest - 1) {
        int i = __builtin_ctzll(rest), x = run->x + i;
        if (rf_is_mixed(&picture->surfaces, row + (size_t)x))
            left[i] -= rf_view_pixel_sees(picture, x, run->y, run->r);
    }
}

struct rf_emission rf_views_leave_run(const struct rf_views *v, int j, int x, int y,
                                      int n, uint64_t asked, float least)
{
    float r = v->sights[j].radius[v->sights[j].stride * (size_t)y + (size_t)x];
    const struct rf_view_place first = rf_view_place_of(v, j, (float)x + 0.5f,
                                                        (float)y + 0.5f, r),
                               last = {first.x + (float)(n - 1), first.y, r};
    struct rf_emission e = {asked, 0};
    float left[64];
    if (rf_views_are_beside(v, first) && rf_views_are_beside(v, last))
        return e;
    for (int i = 0; i < n; i++)
        left[i] = 1;
    /* What one view shows whole is not left, in whichever order views are asked. */
    int likeliest = likeliest_view(v, j, first);
    struct shown_run run = show_run(v, likeliest, first, n);
    e.plain &= ~find_clear(v, likeliest, &run);
    for (int k = 0; k < v->work->n_views && e.plain; k++) {
        if (k == j)
            continue;
        run = show_run(v, k, first, n);
        e.plain &= ~find_clear(v, k, &run);
        take_parts(v, k, &run, e.plain, left);
    }
    for (uint64_t rest = e.plain; rest; rest &= rest - 1) {
        int i = __builtin_ctzll(rest);
        if (left[i] == 1)
            continue;
        e.plain &= ~((uint64_t)1 << i);
        e.other |= (uint64_t)(left[i] > least) << i;
    }
    return e;
}

/* ---- weights -------------------------------------------------------------------- */

/* What rf_view_weight() says where the others show so much. */
static float weight_of(float share, float own, float shown, float continued,
                       bool is_rendered)
{
    if (is_rendered)
        return share / rf_max_float(own + shown, LEAST_COUNT);
    return share * rf_max_float(1 - shown, 1e-6f) /
           rf_max_float(own + continued, LEAST_COUNT);
}

float rf_view_weight(const struct rf_views *v, uint64_t views, int j,
                     struct rf_view_place p, float share, bool is_far, bool is_rendered)
{
    float continued, shown = rf_views_show(v, views, j, p, &continued);
    return weight_of(share, is_far ? share : 1, shown, continued, is_rendered);
}
