/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What stands before a light is asked of one view for each part of the lens. Where that
 * view shows a wire before a head, the head behind the wire blocks the light all the
 * same: without it the light of a lamp behind the head is drawn over the head, in the
 * shape of the wire (plant: 34.3 dB without, 38.8 with).
 *
 * The radius of what is behind comes from the pieces that other views show and this one
 * does not (views_sight.c), each on the nearest pixel, if they are whole pixels: parts
 * would let the outlines of leaves grow (soft + 0.2, portrait + 0.3 dB). Beside them the
 * far parts of mixed pixels count where they go on the same surface (plant + 1.5 dB; of
 * all mixed pixels the same, but portrait - 0.4). What no view shows stays open.
 * Cost: the pieces once more, and 4 bytes per pixel and view, both only where there are
 * lights.
 */
#include "methods/views/views_behind.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "kernels/data.h"
#include "methods/views/merge.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

/* How far away a far part looks for what it goes on, px (1: plant - 0.2 dB). */
enum { FAR_REACH = 2, FAR_ROWS = FAR_REACH + 1 };

/* A far part that goes on what is behind its neighbours. */
struct far_part {
    int x;
    float r;
};

/* The radii behind the surfaces of one view, while they are found. */
struct plane {
    const struct rf_views *v;
    int view;
    float *radius;
    size_t stride;
    /* Of FAR_ROWS rows the far parts, until all who look at those rows have asked. */
    struct far_part *parts; /* of each row as many as it has pixels, at most */
};

/* Radii of one surface differ by less from pixel to pixel. */
static const float SAME_SURFACE_PX = 1;

static void begin_plane(const struct plane *p)
{
    size_t n = p->stride * (size_t)p->v->pictures[p->view].height;
    for (size_t i = 0; i < n; i++)
        p->radius[i] = INFINITY;
}

/* Does a surface of radius r lie behind a pixel near (x, y)? */
static bool goes_on(const struct plane *p, int x, int y, float r)
{
    const struct rf_surfaces *s = &p->v->pictures[p->view].surfaces;
    int x0 = rf_max_int(x - FAR_REACH, 0), y0 = rf_max_int(y - FAR_REACH, 0);
    int x1 = rf_min_int(x + FAR_REACH, s->width - 1);
    int y1 = rf_min_int(y + FAR_REACH, s->height - 1);
    for (int j = y0; j <= y1; j++)
        for (int i = x0; i <= x1; i++)
            if (fabsf(p->radius[p->stride * (size_t)j + (size_t)i] - r) <
                SAME_SURFACE_PX)
                return true;
    return false;
}

/* Finds the far parts of a row that go on what is behind their neighbours. */
static int find_far_parts(const struct plane *p, int y, struct far_part *found)
{
    const struct rf_surfaces *s = &p->v->pictures[p->view].surfaces;
    const float *row = p->radius + p->stride * (size_t)y;
    size_t i = (size_t)y * (size_t)s->width;
    int n = 0;
    for (int x = 0, step; x < s->width; x += step, i += (size_t)step) {
        /* Most words of the marks are empty. */
        step = i % 64 == 0 && s->mixed[i / 64].bits == 0 ? 64 : 1;
        if (step > 1 || !rf_is_mixed(s, i) || s->share[i] >= 1)
            continue;
        float r = rf_far_at(s, i)->r;
        if (r < row[x] && goes_on(p, x, y, r))
            found[n++] = (struct far_part){x, r};
    }
    return n;
}

/* Rows change when all that look at them have: a far part counts beside pieces alone. */
static void add_far_parts(const struct plane *p)
{
    int height = p->v->pictures[p->view].height, n[FAR_ROWS] = {0};
    for (int y = 0; y < height + FAR_REACH; y++) {
        int done = y - FAR_REACH;
        if (y < height)
            n[y % FAR_ROWS] =
                find_far_parts(p, y, p->parts + p->stride * (size_t)(y % FAR_ROWS));
        if (done < 0)
            continue;
        const struct far_part *of = p->parts + p->stride * (size_t)(done % FAR_ROWS);
        float *row = p->radius + p->stride * (size_t)done;
        for (int i = 0; i < n[done % FAR_ROWS]; i++)
            row[of[i].x] = of[i].r;
    }
}

/* Pieces ahead that are asked for: their pixels are seldom in a cache. */
enum { AHEAD = 12 };

/* Asks for what a piece in row y of a view has, and for the pixel that is as far to the
 * right of `at` as the piece is of column x. */
static void fetch_piece(const struct rf_surfaces *s, int y, int x,
                        const struct rf_unseen *piece, const float *at)
{
    int next = piece->part / 4;
    __builtin_prefetch(&s->near[(size_t)y * (size_t)s->width + (size_t)next].r);
    __builtin_prefetch((const void *)((uintptr_t)at + sizeof *at * (size_t)(next - x)),
                       1);
}

/* Puts a piece that view k shows in row y, if it is a whole pixel, on the plane's
 * nearest one; `ahead` is asked for, if not NULL. */
static void put_piece(const struct plane *p, int k, int y,
                      const struct rf_unseen *piece, const struct rf_unseen *ahead)
{
    const struct rf_surfaces *s = &p->v->pictures[k].surfaces;
    if (piece->weight < 1)
        return;
    int x = piece->part / 4, px, py;
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    float r = piece->part & 1 ? rf_far_at(s, i)->r : s->near[i].r;
    struct rf_view_place place =
        rf_view_place_of(p->v, k, (float)x + 0.5f, (float)y + 0.5f, r);
    if (!rf_view_pixel_at(p->v, p->view, place, &px, &py))
        return;
    float *at = &p->radius[p->stride * (size_t)py + (size_t)px];
    if (ahead)
        fetch_piece(s, y, x, ahead, at);
    *at = rf_min_float(*at, r);
}

/* Puts the pieces of all views that the cell's views do not see on the plane. */
static void put_pieces(const struct plane *p, int cell)
{
    const struct rf_views *v = p->v;
    int height = v->pictures[0].height;
    for (int k = 0; k < v->work->n_views; k++)
        for (int y = 0; y < height; y++) {
            const struct rf_unseen_row *row =
                &v->unseen[(size_t)k * (size_t)height + (size_t)y];
            for (int i = row->first[cell], end = row->first[cell + 1]; i < end; i++)
                put_piece(p, k, y, &row->at[i],
                          i + AHEAD < end ? &row->at[i + AHEAD] : NULL);
        }
}

/* What the threads share that fill the views' planes. */
struct filling {
    const struct rf_views *v;
    float *planes;
    size_t stride, n;       /* floats of a row and of a plane */
    struct far_part *parts; /* FAR_ROWS rows for each thread */
};

static void fill_planes(void *data, int64_t begin, int64_t end, int thread)
{
    const struct filling *f = data;
    const struct rf_views *v = f->v;
    for (int j = (int)begin; j < (int)end; j++) {
        struct plane p = {v, j, f->planes + f->n * (size_t)j, f->stride,
                          f->parts + FAR_ROWS * f->stride * (size_t)thread};
        begin_plane(&p);
        for (int i = 0; i < v->n_cells && v->unseen; i++)
            if (v->cells[i].own >> j & 1)
                put_pieces(&p, i);
        add_far_parts(&p);
        v->occluders[j].behind = p.radius;
        v->occluders[j].behind_stride = f->stride;
    }
}

rf_result rf_views_find_behind(const struct rf_views *v, float **planes,
                               struct rf_error *error)
{
    const struct rf_context *context = v->work->frame->context;
    const struct rf_picture *picture = &v->pictures[0];
    size_t stride = (size_t)picture->width + RF_ROW_MARGIN;
    size_t n = stride * (size_t)picture->height, n_views = (size_t)v->work->n_views;
    size_t n_parts = FAR_ROWS * stride * (size_t)context->n_threads;
    struct far_part *parts = rf_alloc(context, n_parts, sizeof *parts);
    *planes = rf_alloc(context, n * n_views, sizeof **planes);
    struct filling filling = {v, *planes, stride, n, parts};
    if (*planes && parts)
        rf_parallel(context, v->work->n_views, 1, fill_planes, &filling);
    rf_free(context, parts);
    return *planes && parts ? RF_OK
                            : rf_fail_memory(error, n * n_views, sizeof **planes);
}
