/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The samples of a picture of surfaces: one for every visible piece, two where it is so
 * bright that negative weights would show.
 */
#include "compose/emit.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/footprint.h"
#include "compose/scene.h"
#include "kernels/data.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/*
 * What is brighter than this times its surroundings is spread without the cubic's
 * negative weights. The darkest pixel of 5 x 5 changes fast where an edge passes, and
 * with it what is spread so: a pan flickers. So the limit grows as the negative weights
 * lose their strength: beside a step they leave 0.074 of it below zero at r = 0, 0.022
 * at 1 px, 0.0085 at 2 px, 0.0011 at 8 px. Lamps, far above it, keep the limit that
 * things in focus have: no ring shows around them.
 */
static inline float bright_limit(float r)
{
    float r2 = r * r;
    return RF_BRIGHT + RF_BRIGHT * (r2 < RF_BRIGHT_R2 ? r2 : RF_BRIGHT_R2);
}

struct rf_sample rf_sample_make(const struct rf_surface *s, int x, int y, float w)
{
    struct rf_sample p = {
        .x = (float)x + 0.5f, .y = (float)y + 0.5f, .r = s->r, .w = w};
    memcpy(p.c, s->c, sizeof p.c);
    return p;
}

void rf_take_light(float surface[4], float light[4], float keep)
{
    light[3] = 0;
    for (int n = 0; n < 3; n++) {
        light[n] = surface[n] * (1 - keep);
        surface[n] -= light[n];
    }
}

void rf_picture_visit_row(struct rf_picture *picture, int y, rf_visit_fn visit,
                          void *user)
{
    struct rf_surfaces *s = &picture->surfaces;
    for (int x = 0; x < picture->width; x++) {
        size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
        if (s->share[i] > 0)
            visit(user, &s->near[i], x, y, s->share[i]);
        if (s->share[i] < 1)
            visit(user, rf_far_at(s, i), x, y, 1 - s->share[i]);
    }
}

void rf_samples_put(struct rf_samples *out, const struct rf_sample *s)
{
    if (out->at)
        out->at[out->n] = *s;
    out->n++;
}

/*
 * Luminance that a pixel of that alpha has where it is as dark as its surroundings. What
 * has none, such as the light of a sky, is compared with them as if it were opaque.
 */
static float shade_of(float alpha, float darkest)
{
    return (alpha > 0 ? alpha : 1) * rf_max_float(darkest, 0);
}

static float shade_at(const struct rf_picture *picture, float alpha, int x, int y)
{
    return shade_of(alpha, rf_plane_row(&picture->pixels, picture->darkest, y)[x]);
}

void rf_picture_emit(const struct rf_picture *picture, struct rf_sample p, int x, int y,
                     struct rf_samples *out)
{
    float lum = rf_luminance(p.c[0], p.c[1], p.c[2]);
    float shade = shade_at(picture, p.c[3], x, y);
    float bright = bright_limit(p.r) * shade;
    if (lum > bright) {
        float limit = rf_max_float(4 * bright - 3 * lum, RF_BRIGHT * shade);
        struct rf_sample light = p;
        light.kind = RF_POSITIVE;
        rf_take_light(p.c, light.c, limit / lum);
        rf_samples_put(out, &light);
    }
    rf_samples_put(out, &p);
}

void rf_picture_emit_pixel(const struct rf_picture *picture, int x, int y,
                           struct rf_samples *out)
{
    const struct rf_surfaces *s = &picture->surfaces;
    size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
    float share = s->share[i];
    if (share > 0)
        rf_picture_emit(picture, rf_sample_make(&s->near[i], x, y, share), x, y, out);
    if (share < 1)
        rf_picture_emit(picture, rf_sample_make(rf_far_at(s, i), x, y, 1 - share), x, y,
                        out);
}

static inline bool is_bright(const struct rf_surface *p, float darkest)
{
    return rf_luminance(p->c[0], p->c[1], p->c[2]) >
           bright_limit(p->r) * shade_of(p->c[3], darkest);
}

bool rf_picture_is_bright(const struct rf_picture *picture, const struct rf_surface *p,
                          int x, int y)
{
    return is_bright(p, rf_plane_row(&picture->pixels, picture->darkest, y)[x]);
}

/* Are there two samples of a pixel that is not opaque? */
static bool is_bright_film(const struct rf_picture *picture, int x, int y)
{
    const struct rf_surface *s =
        picture->surfaces.near + (size_t)y * (size_t)picture->width + (size_t)x;
    return s->c[3] != 1 && rf_luminance(s->c[0], s->c[1], s->c[2]) >
                               bright_limit(s->r) * shade_at(picture, s->c[3], x, y);
}

struct rf_emission rf_picture_emission(const struct rf_picture *picture, int x, int y,
                                       int n)
{
    uint64_t all = UINT64_MAX >> (64 - n);
    /* Highlights may be darker by now: then they are found not to be bright. */
    const uint64_t *row = picture->others + rf_row_words(picture->width) * (size_t)y;
    const uint64_t *at = row + x / 64;
    int first = x % 64;
    uint64_t other = at[0] >> first;
    if (first + n > 64)
        other |= at[1] << (64 - first);
    other &= all;
    for (int i = 0; i < n && picture->has_alpha; i++)
        other |= (uint64_t)is_bright_film(picture, x + i, y) << i;
    return (struct rf_emission){all & ~other, other};
}

/* Moves rows together that have left room between them; start[i] is where row i is. */
static void join_rows(struct rf_sample *at, size_t *start, const size_t *n, int n_rows)
{
    size_t end = 0;
    for (int i = 0; i < n_rows; i++) {
        if (end != start[i])
            memmove(at + end, at + start[i], n[i] * sizeof *at);
        start[i] = end;
        end += n[i];
    }
    start[n_rows] = end;
}

/* What the threads share that collect the samples of rows. */
struct collecting {
    rf_row_fn row;
    void *user;
    const struct rf_task *task;
    const size_t *start;
    size_t *n_of;         /* samples of each row */
    struct rf_sample *at; /* NULL: they are only counted */
};

static void collect_some(void *data, int64_t begin, int64_t end, int thread)
{
    const struct collecting *c = data;
    for (int i = (int)begin; i < (int)end; i++)
        c->n_of[i] = rf_task_is_cancelled(c->task)
                         ? 0
                         : c->row(c->user, i, c->at ? c->at + c->start[i] : NULL);
}

rf_result rf_collect_rows(struct rf_scene *scene, int n_visible, int n_rows,
                          rf_row_fn row, void *user, struct rf_sample **memory,
                          struct rf_error *error)
{
    const struct rf_context *context = scene->frame->context;
    size_t *start = rf_alloc(context, 2 * (size_t)n_rows + 1, sizeof *start);
    if (!start)
        return rf_fail_memory(error, 2 * (size_t)n_rows + 1, sizeof *start);
    size_t *n_of = start + n_rows + 1;
    struct collecting c = {row, user, scene->task, start, n_of, NULL};
    rf_parallel(context, n_rows, 16, collect_some, &c);
    start[0] = 0;
    for (int i = 0; i < n_rows; i++)
        start[i + 1] = start[i] + n_of[i];
    rf_task_poll(scene->task);
    size_t n = start[n_rows];
    struct rf_sample *at = rf_alloc(context, n, sizeof *at);
    if (at) {
        c.at = at;
        rf_parallel(context, n_rows, 16, collect_some, &c);
        join_rows(at, start, n_of, n_rows);
        size_t n_first = start[n_visible];
        scene->visible = (struct rf_samples){at, n_first};
        scene->hidden = (struct rf_samples){at + n_first, start[n_rows] - n_first};
    }
    *memory = at;
    rf_free(context, start);
    rf_task_poll(scene->task);
    return at ? RF_OK : rf_fail_memory(error, n, sizeof *at);
}
