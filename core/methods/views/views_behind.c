/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What stands before a light is asked of one view for each part of the lens. Where that
 * view shows a wire before a head, the head behind the wire blocks the light all the
 * same: without it the light of a lamp behind the head is drawn over the head, in the
 * shape of the wire (plant: 34.3 dB without, 38.8 with).
 *
 * The radius of what is behind comes from the far part of mixed pixels (worth 1.5 dB of
 * plant) and from the pieces that other views show and this one does not
 * (views_sight.c), each on the nearest pixel. What no view shows stays open. Cost: the
 * pieces once more, and 4 bytes per pixel and view, both only where there are lights.
 */
#include "methods/views/views_behind.h"

#include <math.h>
#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "kernels/data.h"
#include "methods/views/merge.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

/* The radii behind the surfaces of one view, while they are found. */
struct plane {
    const struct rf_views *v;
    int view;
    float *radius;
    size_t stride;
};

static void begin_plane(const struct plane *p)
{
    const struct rf_surfaces *s = &p->v->pictures[p->view].surfaces;
    for (int y = 0; y < s->height; y++) {
        float *row = p->radius + p->stride * (size_t)y;
        size_t i = (size_t)y * (size_t)s->width;
        for (size_t x = 0; x < p->stride; x++)
            row[x] = INFINITY;
        for (int x = 0; x < s->width; x++, i++)
            if (rf_is_mixed(s, i) && s->share[i] < 1)
                row[x] = rf_far_at(s, i)->r;
    }
}

/* Puts a piece that view k shows in row y on the plane's nearest pixel. */
static void put_piece(const struct plane *p, int k, int y,
                      const struct rf_unseen *piece)
{
    const struct rf_surfaces *s = &p->v->pictures[k].surfaces;
    int x = piece->part / 4, px, py;
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    float r = piece->part & 1 ? rf_far_at(s, i)->r : s->near[i].r;
    struct rf_view_place place =
        rf_view_place_of(p->v, k, (float)x + 0.5f, (float)y + 0.5f, r);
    if (!rf_view_pixel_at(p->v, p->view, place, &px, &py))
        return;
    float *at = &p->radius[p->stride * (size_t)py + (size_t)px];
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
            for (int i = row->first[cell]; i < row->first[cell + 1]; i++)
                put_piece(p, k, y, &row->at[i]);
        }
}

rf_result rf_views_find_behind(const struct rf_views *v, float **planes,
                               struct rf_error *error)
{
    const struct rf_context *context = v->work->frame->context;
    const struct rf_picture *picture = &v->pictures[0];
    size_t stride = (size_t)picture->width + RF_ROW_MARGIN;
    size_t n = stride * (size_t)picture->height, n_views = (size_t)v->work->n_views;
    *planes = rf_alloc(context, n * n_views, sizeof **planes);
    if (!*planes)
        return rf_fail_memory(error, n * n_views, sizeof **planes);
#pragma omp parallel for num_threads(context->n_threads) schedule(dynamic, 1)
    for (int j = 0; j < v->work->n_views; j++) {
        struct plane p = {v, j, *planes + n * (size_t)j, stride};
        begin_plane(&p);
        for (int i = 0; i < v->n_cells && v->unseen; i++)
            if (v->cells[i].own >> j & 1)
                put_pieces(&p, i);
        v->occluders[j].behind = p.radius;
        v->occluders[j].behind_stride = stride;
    }
    return RF_OK;
}
