/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light of highlights is taken out of their surfaces, to be spread with exact
 * visibility (highlights_add.c).
 */
#include "compose/highlights_find.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/system_threads.h"
#include "compose/emit.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "surfaces/bright_areas.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

/* Which highlights to take; out.at NULL: only count. */
struct lights {
    const struct rf_work_view *view;
    int n_planes;
    float factor;
    struct rf_samples out;
};

static float usual_luminance(const struct rf_picture *picture, int x, int y)
{
    return rf_usual_luminance(&picture->areas, x - picture->x0, y - picture->y0);
}

static bool is_highlight(const struct rf_picture *picture, const struct rf_surface *s,
                         int x, int y, const struct lights *lights)
{
    float luminance = rf_luminance(s->c[0], s->c[1], s->c[2]), factor = lights->factor;
    float r = rf_field_seen(picture->frame, x - picture->x0, y - picture->y0, s->r);
    return rf_is_highlight(luminance, r, factor, 0) &&
           rf_is_highlight(luminance, r, factor, usual_luminance(picture, x, y)) &&
           !rf_is_large_light(&picture->areas, lights->view, lights->n_planes,
                              x - picture->x0, y - picture->y0, luminance, r);
}

static void take_if_highlight(struct rf_picture *picture, struct rf_surface *s, int x,
                              int y, float w, struct lights *lights)
{
    if (!is_highlight(picture, s, x, y, lights))
        return;
    if (lights->out.at) {
        struct rf_sample *light = &lights->out.at[lights->out.n];
        *light = rf_sample_make(s, x, y, w);
        rf_take_light(s->c, light->c,
                      usual_luminance(picture, x, y) /
                          rf_luminance(s->c[0], s->c[1], s->c[2]));
    }
    lights->out.n++;
}

static void collect_light(struct rf_picture *picture, int x, int y, void *user)
{
    struct rf_surfaces *s = &picture->surfaces;
    size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
    float share = s->share[i];
    if (share > 0)
        take_if_highlight(picture, &s->near[i], x, y, share, user);
    if (share < 1)
        take_if_highlight(picture, rf_far_at(s, i), x, y, 1 - share, user);
}

/* What the threads share that collect the highlights. */
struct collecting {
    struct rf_picture *picture;
    const struct lights *all;
    size_t *start; /* of each row's */
};

static void count_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct collecting *c = data;
    for (int y = (int)begin; y < (int)end; y++) {
        struct lights lights = *c->all;
        rf_picture_visit_possible_highlights(c->picture, y, collect_light, &lights);
        c->start[y + 1] = lights.out.n;
    }
}

static void collect_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct collecting *c = data;
    for (int y = (int)begin; y < (int)end; y++) {
        struct lights lights = *c->all;
        lights.out.at = c->picture->highlights + c->start[y];
        if (c->start[y + 1] > c->start[y])
            rf_picture_visit_possible_highlights(c->picture, y, collect_light, &lights);
    }
}

/* Moves the light of the highlights into `picture->highlights`, in the order of rows. */
static rf_result collect_lights(struct rf_picture *picture, const struct lights *all,
                                size_t *start, struct rf_error *error)
{
    const struct rf_context *context = picture->frame->context;
    struct collecting c = {picture, all, start};
    start[0] = 0;
    rf_parallel(context, picture->height, 16, count_rows, &c);
    for (int y = 0; y < picture->height; y++)
        start[y + 1] += start[y];
    size_t n = start[picture->height];
    picture->highlights = rf_alloc(context, n, sizeof *picture->highlights);
    if (!picture->highlights)
        return rf_fail_memory(error, n, sizeof *picture->highlights);
    picture->n_highlights = n;
    rf_parallel(context, picture->height, 16, collect_rows, &c);
    return RF_OK;
}

/* What the survey of a view's lights needs and finds. */
struct tally {
    const struct rf_work_view *view;
    int n_planes;
    struct rf_survey survey;
};

static void count_light(struct rf_picture *picture, int x, int y, void *user)
{
    struct tally *tally = user;
    const struct rf_frame *f = picture->frame;
    x -= picture->x0;
    y -= picture->y0;
    if (x >= 0 && x < f->width)
        rf_survey_add_light(&tally->survey, f, tally->view, tally->n_planes,
                            &picture->areas, x, y);
}

/* What the threads share that survey a view. */
struct surveying {
    struct rf_picture *picture;
    const struct rf_work_view *view;
    int n_planes;
    bool lock; /* of the sum */
    struct rf_survey sum;
};

/* Areas are whole numbers: their sums are exact in any order. */
static void survey_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct surveying *s = data;
    struct tally own = {.view = s->view, .n_planes = s->n_planes};
    for (int64_t y = begin; y < end; y++)
        rf_picture_visit_possible_highlights(s->picture, s->picture->y0 + (int)y,
                                             count_light, &own);
    rf_spin_lock(&s->lock);
    for (int i = 0; i < RF_SURVEY_FACTORS; i++)
        s->sum.disc_area[i] += own.survey.disc_area[i];
    rf_spin_unlock(&s->lock);
}

/* Surveys the view without its border. */
static struct rf_survey survey_lights(struct rf_picture *picture,
                                      const struct rf_work_view *view, int n_planes)
{
    const struct rf_frame *f = picture->frame;
    struct surveying s = {.picture = picture,
                          .view = view,
                          .n_planes = n_planes,
                          .sum = {.n_pixels = (double)f->width * f->height}};
    rf_parallel(f->context, f->height, 16, survey_rows, &s);
    return s.sum;
}

rf_result rf_picture_take_highlights(struct rf_picture *picture,
                                     const struct rf_work_view *view, int n_planes,
                                     struct rf_error *error)
{
    const struct rf_frame *f = picture->frame;
    size_t n_rows = (size_t)picture->height;
    size_t *start = rf_alloc(f->context, n_rows + 1, sizeof *start);
    if (!start)
        return rf_fail_memory(error, n_rows + 1, sizeof *start);
    struct rf_survey survey =
        view->survey ? *view->survey : survey_lights(picture, view, n_planes);
    const struct lights lights = {
        .view = view, .n_planes = n_planes, .factor = rf_survey_factor(&survey)};
    picture->highlight_factor = lights.factor;
    rf_result result = collect_lights(picture, &lights, start, error);
    rf_free(f->context, start);
    return result;
}
