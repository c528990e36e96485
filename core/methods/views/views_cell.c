/* SPDX-License-Identifier: Apache-2.0 */
/*
 * views: the picture through one cell of the lens, as views.c says: samples of the
 * cell's own views, those that others show of what these do not see, and estimates.
 */
#include "methods/views/views_cell.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/math.h"
#include "base/task.h"
#include "compose/composite.h"
#include "compose/emit.h"
#include "compose/footprint.h"
#include "compose/known_hidden.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "kernels/sight_kernels.h"
#include "lens/look.h"
#include "methods/views/merge.h"
#include "methods/views/views_place.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/* Of an estimated hidden sample, against those that another view shows. Ours: small;
 * half or twice changes no picture of tests/quality by 0.01 dB. */
static const float ESTIMATE_WEIGHT = 0.1f;

/* What collects the samples of one row of view `view` for a cell. */
struct collector {
    const struct rf_view_cell *cell;
    int view;
    struct rf_samples out;
};

/* Is a place along one axis in the scene, and within px of its n pixels from `first`?
 */
static inline bool reaches(float at, float px, int first, int n, int size)
{
    return at >= 0 && at < (float)size && at >= (float)first - px &&
           at < (float)(first + n) + px;
}

/* Does the footprint of a sample beside the picture reach it, and is it in the scene?
 */
static inline bool reaches_picture(const struct rf_view_cell *cell, float x, float y,
                                   float r)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    float size = fabsf(r);
    return reaches(x, size * cell->reach[0] + 8, picture->x0, picture->frame->width,
                   picture->width) &&
           reaches(y, size * cell->reach[1] + 8, picture->y0, picture->frame->height,
                   picture->height);
}

/* Does a sample's footprint reach the picture, and does it lie in the scene? */
static bool is_in_scene(const struct rf_view_cell *cell, const struct rf_sample *p)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    if (p->x >= (float)picture->x0 &&
        p->x < (float)(picture->x0 + picture->frame->width) &&
        p->y >= (float)picture->y0 &&
        p->y < (float)(picture->y0 + picture->frame->height))
        return true;
    return reaches_picture(cell, p->x, p->y, p->r);
}

/* The radius of what lies at a place where the cell's light of it falls. */
static float radius_in(const struct rf_view_cell *cell, struct rf_view_place place)
{
    enum { ROUNDS = 3 };
    const struct rf_field *apart = cell->frame.apart;
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    float r = place.r;
    for (int i = 0; i < ROUNDS && apart; i++)
        r = rf_field_radius(apart, place.x + cell->centroid[0] * r - (float)picture->x0,
                            place.y - cell->centroid[1] * r - (float)picture->y0,
                            place.r);
    return r;
}

/* What pixels of one surface differ by less from each other, px of radius. */
static const float SAME_SURFACE_PX = 1;

/* Adds so many px along a row, or a column, of what the picture shows at pixel i, if it
 * is one surface there. */
static void add_slope(const struct rf_surfaces *s, size_t i, size_t step, float px,
                      float c[4])
{
    const struct rf_surface *before = &s->near[i - step], *after = &s->near[i + step];
    bool is_one = !rf_is_mixed(s, i - step) && !rf_is_mixed(s, i + step) &&
                  fabsf(after->r - s->near[i].r) < SAME_SURFACE_PX &&
                  fabsf(before->r - s->near[i].r) < SAME_SURFACE_PX;
    for (int k = 0; k < 4 && is_one; k++)
        c[k] += px * 0.5f * (after->c[k] - before->c[k]);
}

/*
 * Samples lie in one of the phases of their pixel. What is near the focus shows that it
 * is moved there: its phases are finer, and it takes the colour that its surface has
 * there. Finer phases for all are 0.02 dB better and take twice as long.
 */
static void follow_texture(const struct rf_picture *picture, int n_phases, int x, int y,
                           struct rf_sample *p)
{
    static const float SHARP_PX = 2;
    const struct rf_surfaces *s = &picture->surfaces;
    size_t width = (size_t)s->width, i = (size_t)y * width + (size_t)x;
    bool is_sharp = fabsf(p->r) < SHARP_PX;
    const float n =
        is_sharp || n_phases < RF_VIEW_PHASES ? (float)n_phases : RF_VIEW_PHASES;
    float at_x = (floorf(p->x * n) + 0.5f) / n, at_y = (floorf(p->y * n) + 0.5f) / n;
    if (is_sharp && !rf_is_mixed(s, i) && x >= 1 && y >= 1 && x + 1 < s->width &&
        y + 1 < s->height) {
        add_slope(s, i, 1, at_x - p->x, p->c);
        add_slope(s, i, width, at_y - p->y, p->c);
    }
    p->x = at_x;
    p->y = at_y;
}

static void put(struct collector *c, struct rf_sample p, int x, int y)
{
    const struct rf_view_cell *cell = c->cell;
    const struct rf_picture *picture = &cell->v->pictures[c->view];
    struct rf_view_place place = rf_view_place_of(cell->v, c->view, p.x, p.y, p.r);
    p.r = radius_in(cell, place);
    p.x = place.x + rf_snap_px(cell->centroid[0] * p.r);
    p.y = place.y - rf_snap_px(cell->centroid[1] * p.r);
    if (cell->frame.apart)
        follow_texture(picture, cell->n_phases, x, y, &p);
    if (is_in_scene(cell, &p))
        rf_picture_emit(picture, p, x, y, &c->out);
}

/* Of what continues a picture, where other views show what is there. */
static const float CONTINUED_WEIGHT = 1e-6f;

static void collect_own(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_views *v = c->cell->v;
    struct rf_sample p = rf_sample_make(s, x, y, w);
    if (c->out.at && !rf_view_is_rendered(&v->pictures[c->view], x, y)) {
        struct rf_view_place place = rf_view_place_of(v, c->view, p.x, p.y, p.r);
        p.w *= rf_views_leave(v, c->view, place, CONTINUED_WEIGHT);
    }
    put(c, p, x, y);
}

/* What view c->view adds to the cell of several views. */
static void collect_shared(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    const struct rf_views *v = c->cell->v;
    const struct rf_picture *picture = &v->pictures[c->view];
    struct rf_sample p = rf_sample_make(s, x, y, w);
    if (c->out.at) {
        bool is_far =
            s !=
            &picture->surfaces.near[(size_t)y * (size_t)picture->width + (size_t)x];
        p.w = rf_view_weight(v, c->cell->own, c->view,
                             rf_view_place_of(v, c->view, p.x, p.y, p.r), p.w, is_far,
                             rf_view_is_rendered(picture, x, y));
    }
    put(c, p, x, y);
}

/* How much the cell's own views show of a place in what was rendered. */
static float seen_by_own(const struct rf_view_cell *cell, struct rf_view_place place)
{
    float most = 0;
    for (uint64_t left = cell->own; left; left &= left - 1) {
        bool is_true;
        float seen = rf_view_sees(cell->v, __builtin_ctzll(left), place, &is_true);
        most = is_true ? rf_max_float(seen, most) : most;
    }
    return most;
}

/* What the cell's own views do not see, in row y of view c->view. */
static void collect_others(struct collector *c, int y)
{
    const struct rf_view_cell *cell = c->cell;
    const struct rf_views *v = cell->v;
    const struct rf_picture *picture = &v->pictures[c->view];
    const struct rf_unseen_row *row =
        &v->unseen[(size_t)c->view * (size_t)picture->height + (size_t)y];
    for (int k = row->first[cell->index]; k < row->first[cell->index + 1]; k++) {
        const struct rf_unseen *u = &row->at[k];
        int x = u->part / 4;
        size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
        const struct rf_surface *s =
            u->part & 1 ? rf_far_at(&picture->surfaces, i) : &picture->surfaces.near[i];
        struct rf_sample p = rf_sample_make(s, x, y, u->weight);
        if (c->out.at) {
            struct rf_view_place place = rf_view_place_of(v, c->view, p.x, p.y, p.r);
            p.w *= 1 - seen_by_own(cell, place);
        }
        put(c, p, x, y);
    }
}

/* Estimates count little where a view shows what they stand for. */
static void collect_hidden(struct collector *c, int y)
{
    const struct rf_view_cell *cell = c->cell;
    int width = cell->v->pictures[c->view].width;
    for (int x = 0; x < width; x++) {
        size_t i = (size_t)y * (size_t)width + (size_t)x;
        if (!rf_found_at(&cell->hidden, x, y, 1))
            continue;
        struct rf_sample p = rf_sample_make(&cell->hidden.at[i], x, y, 1);
        if (c->out.at && !cell->is_whole) {
            struct rf_view_place place =
                rf_view_place_of(cell->v, c->view, p.x, p.y, p.r);
            p.w *= rf_views_leave(cell->v, c->view, place, ESTIMATE_WEIGHT);
        }
        put(c, p, x, y);
    }
}

/* The own views come first, then the others. */
static int view_of_block(const struct rf_view_cell *cell, int block)
{
    bool is_own = block < rf_view_cell_n_own(cell);
    int left = is_own ? block : block - rf_view_cell_n_own(cell), j = 0;
    for (;; j++)
        if ((cell->own >> j & 1) == is_own && left-- == 0)
            return j;
}

/*
 * Row i of the visible samples, then of those of the other views, then of the
 * estimates.
 */
static size_t collect_row(void *user, int i, struct rf_sample *at)
{
    struct rf_view_cell *cell = user;
    struct rf_views *v = cell->v;
    int height = v->pictures[0].height, block = i / height, y = i % height;
    struct collector c = {.cell = cell, .out = {at, 0}};
    if (block == v->work->n_views) {
        c.view = cell->middle;
        collect_hidden(&c, y);
        return c.out.n;
    }
    c.view = view_of_block(cell, block);
    if (!(cell->own >> c.view & 1))
        collect_others(&c, y);
    else
        rf_picture_visit_row(
            &v->pictures[c.view], y,
            rf_view_cell_n_own(cell) > 1 ? collect_shared : collect_own, &c);
    return c.out.n;
}

/* ---- cells of one view ---------------------------------------------------------- */

/* Pixels of the scene to those of the view, and the part of n that the view has. */
struct run {
    int x, y, first, end;
};

static struct run run_of(const struct rf_view_cell *cell, int x, int y, int n)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    struct run r = {.x = x - cell->shift[0], .y = y - cell->shift[1]};
    r.first = rf_min_int(rf_max_int(-r.x, 0), n);
    r.end = rf_max_int(rf_min_int(picture->width - r.x, n), r.first);
    if (r.y < 0 || r.y >= picture->height)
        r.end = r.first;
    return r;
}

/* Those of a run's pixels that were rendered. */
static uint64_t find_rendered(const struct rf_picture *picture, const struct run *r)
{
    int first = rf_max_int(r->first, picture->x0 - r->x);
    int end = rf_min_int(r->end, picture->x0 + picture->frame->width - r->x);
    if (r->y < picture->y0 || r->y >= picture->y0 + picture->frame->height ||
        first >= end)
        return 0;
    return UINT64_MAX >> (64 - (end - first)) << first;
}

/* How many of n pixels from the first one on have its radius. */
static int count_level(const float *radius, int n)
{
    int i = 1;
    while (i < n && radius[i] == radius[0])
        i++;
    return i;
}

/* Of up to eight pixels, what emission_continued() says. */
static struct rf_emission emission_of_eight(const struct rf_view_cell *cell, int x,
                                            int y, unsigned asked)
{
    struct rf_emission e = {0, 0};
    float left[8];
    rf_views_leave_eight(cell->v, cell->middle, x, y, asked, left);
    for (; asked; asked &= asked - 1) {
        int k = __builtin_ctz(asked);
        e.plain |= (uint64_t)(left[k] == 1) << k;
        e.other |= (uint64_t)(left[k] < 1 && left[k] > CONTINUED_WEIGHT) << k;
    }
    return e;
}

/*
 * Of pixels that continue the picture, of one surface each: those that no view shows
 * are plain, and those that other views show are none.
 */
static struct rf_emission emission_continued(const struct rf_view_cell *cell,
                                             const struct run *r, uint64_t continued)
{
    const struct rf_sight *own = &cell->v->sights[cell->middle];
    const float *radius = own->radius + own->stride * (size_t)r->y + r->x;
    struct rf_emission all = {0, 0};
    for (int i = r->first, n; i < r->end; i += n) {
        n = count_level(radius + i, r->end - i);
        bool is_level = n >= 8;
        n = is_level ? n : rf_min_int(8, r->end - i);
        uint64_t asked = continued >> i & UINT64_MAX >> (64 - n);
        if (!asked)
            continue;
        struct rf_emission e =
            is_level ? rf_views_leave_run(cell->v, cell->middle, r->x + i, r->y, n,
                                          asked, CONTINUED_WEIGHT)
                     : emission_of_eight(cell, r->x + i, r->y, (unsigned)asked);
        all.plain |= e.plain << i;
        all.other |= e.other << i;
    }
    return all;
}

static struct rf_emission own_emission(void *user, int x, int y, int n)
{
    const struct rf_view_cell *cell = user;
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    struct run r = run_of(cell, x, y, n);
    if (r.first == r.end)
        return (struct rf_emission){0, 0};
    uint64_t all = UINT64_MAX >> (64 - (r.end - r.first)) << r.first;
    uint64_t plain =
        rf_picture_emission(picture, r.x + r.first, r.y, r.end - r.first).plain
        << r.first;
    uint64_t continued = plain & ~find_rendered(picture, &r);
    if (!continued)
        return (struct rf_emission){plain, all & ~plain};
    struct rf_emission e = emission_continued(cell, &r, continued);
    return (struct rf_emission){(plain & ~continued) | e.plain,
                                (all & ~plain) | e.other};
}

/* Emits a sample of the view's pixel (x, y), moved by whole px. */
static void emit_moved(const struct rf_view_cell *cell, struct rf_sample p, int x,
                       int y, struct rf_samples *out)
{
    p.x += (float)cell->shift[0];
    p.y += (float)cell->shift[1];
    rf_picture_emit(&cell->v->pictures[cell->middle], p, x, y, out);
}

static int emit_own(void *user, int x, int y, struct rf_sample *at)
{
    const struct rf_view_cell *cell = user;
    const struct rf_views *v = cell->v;
    const struct rf_picture *picture = &v->pictures[cell->middle];
    const struct rf_surfaces *s = &picture->surfaces;
    struct rf_samples out = {at, 0};
    x -= cell->shift[0];
    y -= cell->shift[1];
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    const float shares[2] = {s->share[i], 1 - s->share[i]};
    for (int part = 0; part < 2; part++) {
        if (!(shares[part] > 0))
            continue;
        struct rf_sample p =
            rf_sample_make(part ? rf_far_at(s, i) : &s->near[i], x, y, shares[part]);
        if (!rf_view_is_rendered(picture, x, y)) {
            struct rf_view_place place =
                rf_view_place_of(v, cell->middle, p.x, p.y, p.r);
            float left = rf_views_leave(v, cell->middle, place, CONTINUED_WEIGHT);
            if (left <= CONTINUED_WEIGHT)
                continue;
            p.w *= left;
        }
        emit_moved(cell, p, x, y, &out);
    }
    return (int)out.n;
}

static struct rf_emission estimates_emission(void *user, int x, int y, int n)
{
    const struct rf_view_cell *cell = user;
    struct run r = run_of(cell, x, y, n);
    if (r.first == r.end)
        return (struct rf_emission){0, 0};
    uint64_t found = rf_found_at(&cell->hidden, r.x + r.first, r.y, r.end - r.first);
    return (struct rf_emission){0, found << r.first};
}

static int emit_estimate(void *user, int x, int y, struct rf_sample *at)
{
    const struct rf_view_cell *cell = user;
    struct rf_samples out = {at, 0};
    x -= cell->shift[0];
    y -= cell->shift[1];
    size_t i = (size_t)y * (size_t)cell->v->pictures[cell->middle].width + (size_t)x;
    struct rf_sample p = rf_sample_make(&cell->hidden.at[i], x, y, 1);
    emit_moved(cell, p, x, y, &out);
    return (int)out.n;
}

/* Some of what a view shows in one of its rows, for a cell. */
struct batch {
    int view, y, n;
    const struct rf_unseen *at[RF_SIGHT_PARTS];
    const struct rf_surface *surface[RF_SIGHT_PARTS];
    struct rf_sight_places places;
};

static void add_to_batch(const struct rf_view_cell *cell, const struct rf_unseen *u,
                         struct batch *b)
{
    const struct rf_surfaces *s = &cell->v->pictures[b->view].surfaces;
    int x = u->part / 4;
    size_t i = (size_t)b->y * (size_t)s->width + (size_t)x;
    b->at[b->n] = u;
    b->surface[b->n] = u->part & 1 ? rf_far_at(s, i) : &s->near[i];
    b->places.x[b->n] = (float)x + 0.5f;
    b->places.y[b->n] = (float)b->y + 0.5f;
    b->places.r[b->n] = b->surface[b->n]->r;
    b->n++;
}

/* Moves a batch to the nearest pixels of the cell's view, as far as that does not show
 * it, and emits it. */
static void emit_batch(const struct rf_view_cell *cell, struct batch *b,
                       struct rf_samples *out)
{
    const struct rf_views *v = cell->v;
    const struct rf_picture *own = &v->pictures[cell->middle];
    const struct rf_kernels *kernels = own->frame->context->kernels;
    struct rf_sight_found found;
    for (int i = b->n; i % 8; i++) /* vectors are whole */
        b->places.x[i] = b->places.y[i] = b->places.r[i] = 0;
    kernels->place_parts(&v->sights[b->view], b->n, &b->places);
    kernels->find_pixels(&v->sights[cell->middle], &b->places, b->n, &found);
    for (int i = 0; i < b->n; i++) {
        const struct rf_unseen *u = b->at[i];
        int x = found.x[i] + cell->shift[0], y = found.y[i] + cell->shift[1];
        float at_x = (float)x + 0.5f, at_y = (float)y + 0.5f, r = b->places.r[i];
        if (!rf_view_is_rendered(own, x, y) && !reaches_picture(cell, at_x, at_y, r))
            continue;
        size_t pixel = (size_t)found.y[i] * (size_t)own->width + (size_t)found.x[i];
        struct rf_sample *p = &out->at[out->n];
        *p = (struct rf_sample){
            .x = at_x, .y = at_y, .r = r, .w = u->weight, .kind = RF_SHARP};
        memcpy(p->c, b->surface[i]->c, sizeof p->c);
        /* Nothing of it is listed that a pixel of one surface sees. */
        if ((found.rendered >> i & 1) && rf_is_mixed(&own->surfaces, pixel))
            p->w *= 1 - rf_view_pixel_sees(own, found.x[i], found.y[i], r);
        if (u->part & 2)
            rf_picture_emit(&v->pictures[b->view], *p, u->part / 4, b->y, out);
        else
            out->n++;
    }
    b->n = 0;
}

/* Pieces ahead whose surfaces are asked for: they lie apart. */
enum { AHEAD = 16 };

static void prefetch_piece(const struct rf_view_cell *cell, int view, int y,
                           const struct rf_unseen *u)
{
    const struct rf_surfaces *s = &cell->v->pictures[view].surfaces;
    const char *at =
        (const char *)&s->near[(size_t)y * (size_t)s->width + (size_t)(u->part / 4)];
    __builtin_prefetch(at);
    __builtin_prefetch(at + sizeof *s->near - 1);
}

/* Samples of the other views, row by row of all of them, so that those of one place
 * come together; counted are those out of reach, too. */
static size_t collect_others_row(void *user, int i, struct rf_sample *at)
{
    struct rf_view_cell *cell = user;
    int height = cell->v->pictures[0].height, n_others = cell->v->work->n_views - 1;
    int y = i / n_others, block = i % n_others;
    int view = block < cell->middle ? block : block + 1;
    const struct rf_unseen_row *row =
        &cell->v->unseen[(size_t)view * (size_t)height + (size_t)y];
    int first = row->first[cell->index], end = row->first[cell->index + 1];
    if (!at)
        return (size_t)(end - first + row->n_bright[cell->index]);
    struct rf_samples out = {at, 0};
    struct batch batch = {.view = view, .y = y, .n = 0};
    for (int k = first; k < end; k++) {
        if (k + AHEAD < end)
            prefetch_piece(cell, view, y, &row->at[k + AHEAD]);
        add_to_batch(cell, &row->at[k], &batch);
        if (batch.n == RF_SIGHT_PARTS)
            emit_batch(cell, &batch, &out);
    }
    emit_batch(cell, &batch, &out);
    return out.n;
}

/* The samples of a cell that is on its view's grid. */
static rf_result set_sources(struct rf_view_cell *cell, struct rf_scene *scene,
                             struct rf_error *error)
{
    const struct rf_views *v = cell->v;
    const struct rf_picture *picture = &v->pictures[cell->middle];
    const struct rf_pixels *pixels = &picture->pixels;
    struct rf_source source = {.emission = own_emission,
                               .emit = emit_own,
                               .user = cell,
                               .surfaces = picture->surfaces.near,
                               .x = cell->shift[0],
                               .y = cell->shift[1],
                               .radius = rf_plane_row(pixels, pixels->radius, 0),
                               .radius_stride = pixels->stride,
                               .most_per_pixel = 4,
                               .largest_radius = v->work->largest_radius};
    scene->drift = cell->drift;
    scene->visible_source = source;
    if (cell->hidden.at) {
        source.emission = estimates_emission;
        source.emit = emit_estimate;
        source.most_per_pixel = 2;
        scene->hidden_source = source;
    }
    return rf_collect_rows(scene, 0, (v->work->n_views - 1) * picture->height,
                           collect_others_row, cell, &cell->samples, error);
}

/* ---- all cells ------------------------------------------------------------------ */

/* Do other views show what may lie behind a pixel of the middle one? */
static bool is_shown(void *user, int x, int y, float r)
{
    const struct rf_view_cell *cell = user;
    struct rf_view_place place =
        rf_view_place_of(cell->v, cell->middle, (float)x + 0.5f, (float)y + 0.5f, r);
    return rf_views_leave(cell->v, cell->middle, place, ESTIMATE_WEIGHT) <=
           ESTIMATE_WEIGHT;
}

static rf_result find_hidden(struct rf_view_cell *cell, double progress_to,
                             struct rf_error *error)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    rf_task_phase(cell->v->work->task, progress_to, rf_hidden_steps(picture->height));
    struct rf_known known = {is_shown, cell};
    const struct rf_pixels *pixels = &picture->pixels;
    /* The other views are asked what they show, not this one, while its radii change.
     */
    struct rf_radii radii = {rf_plane_row(pixels, pixels->radius, 0), pixels->stride};
    rf_result result = rf_find_hidden(&cell->frame, &picture->surfaces, &radii,
                                      cell->is_whole ? NULL : &known, &cell->hidden,
                                      cell->v->work->task, error);
    if (result == RF_OK && !rf_task_is_cancelled(cell->v->work->task))
        result = rf_known_hidden_put(&cell->v->pictures[cell->middle],
                                     &cell->v->work->views[cell->middle], &cell->hidden,
                                     error);
    return result;
}

static bool is_opaque(const struct rf_views *v)
{
    for (int j = 0; j < v->work->n_views; j++) {
        const struct rf_survey *survey = v->work->views[j].survey;
        if (survey ? survey->n_transparent > 0 : v->pictures[j].has_alpha)
            return false;
    }
    return true;
}

/* The least of what any view has. */
static void find_least(const struct rf_views *v, float least[3])
{
    for (int j = 0; j < v->work->n_views; j++) {
        const struct rf_survey *survey = v->work->views[j].survey;
        const float *own = survey ? survey->least : v->pictures[j].least;
        for (int c = 0; c < 3; c++)
            least[c] = rf_min_float(least[c], own[c]);
    }
}

static int find_phases(const struct rf_view_cell *cell)
{
    const struct rf_look look = rf_frame_look(&cell->frame);
    if (cell->is_on_grid)
        return 1;
    if (!cell->frame.apart)
        return RF_VIEW_PHASES;
    return rf_look_is_on(&look) ? RF_COARSE_PHASES : RF_FINE_PHASES;
}

/*
 * Where rays through the cell meet what its middle view j shows: at the depth of radius r
 * (u - alpha u_j) r from their pixel. NULL where their places shift by more than that, as
 * when another distance is in focus than the views' shear holds.
 */
static const struct rf_insides *find_insides(struct rf_view_cell *cell)
{
    static const float NOTHING_PX = 1.0f / 256; /* half a step of rf_snap_px() */
    const struct rf_work_view *view = &cell->v->work->views[cell->middle];
    struct rf_insides *insides = &cell->hidden.insides;
    double from[2];
    if (!insides->blocks || cell->frame.apart || fabsf(view->shift_bias) >= NOTHING_PX)
        return NULL;
    for (int k = 0; k < 2; k++)
        from[k] = (double)view->lens[k] * view->shift_scale - cell->centroid[k];
    insides->reach = rf_shape_reach(&cell->frame.shape, from);
    insides->extent = INFINITY; /* of blocks nothing is known */
    insides->border = cell->v->pictures[cell->middle].x0;
    return insides;
}

/* What its middle view shows whole, but for what continues it beyond its border, where
 * other views may show something else. */
static void set_whole(const struct rf_view_cell *cell, struct rf_scene *scene)
{
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    const int first[] = {picture->x0, picture->y0};
    const int size[] = {picture->frame->width, picture->frame->height};
    const int most[] = {picture->width, picture->height};
    scene->whole_radius = rf_plane_row(&picture->pixels, picture->pixels.radius, 0);
    scene->whole_stride = picture->pixels.stride;
    for (int k = 0; k < 2; k++) {
        const int from = cell->shift[k] + first[k];
        scene->whole_at[k] = cell->shift[k];
        scene->whole_from[k] = rf_max_int(from + 1, 1);
        scene->whole_to[k] = rf_min_int(from + size[k], most[k]) - 1;
    }
}

rf_result rf_view_cell_run(struct rf_view_cell *cell, double progress_to,
                           struct rf_error *error)
{
    struct rf_work *work = cell->v->work;
    const struct rf_picture *picture = &cell->v->pictures[cell->middle];
    double from = work->task->to;
    rf_result result = RF_OK;
    for (int k = 0; k < 2; k++) /* coarse levels reach farther than footprints do */
        cell->reach[k] = 1.5f * cell->extent[k] + fabsf((float)cell->drift.slope[k]);
    cell->n_phases = find_phases(cell);
    if (work->frame->params.fill_hidden)
        result = find_hidden(cell, from + 0.2 * (progress_to - from), error);
    struct rf_occluders occluders = {.surfaces = &picture->surfaces};
    struct rf_scene scene = {.frame = &cell->frame,
                             .width = picture->width,
                             .height = picture->height,
                             .x0 = picture->x0,
                             .y0 = picture->y0,
                             .n_phases = cell->n_phases,
                             .is_opaque = is_opaque(cell->v),
                             .insides = find_insides(cell),
                             .occluders = &occluders,
                             .n_views = 1,
                             .sum = cell->sum,
                             .weight = cell->weight,
                             .weights = cell->weights.at ? &cell->weights : NULL,
                             .task = work->task,
                             .progress_to = progress_to};
    find_least(cell->v, scene.least);
    if (work->frame->params.fill_hidden && cell->is_beside_view)
        set_whole(cell, &scene);
    int height = picture->height, n_views = work->n_views;
    int n_visible = rf_view_cell_n_own(cell) * height;
    int n_others = (n_views + (cell->hidden.at ? 1 : 0)) * height - n_visible;
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = cell->is_on_grid
                     ? set_sources(cell, &scene, error)
                     : rf_collect_rows(&scene, n_visible, n_visible + n_others,
                                       collect_row, cell, &cell->samples, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = rf_composite_crop(&scene, work, error);
    return result;
}
