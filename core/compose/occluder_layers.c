/* SPDX-License-Identifier: Apache-2.0 */
#include "compose/occluder_layers.h"

#include <math.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/frame.h"
#include "surfaces/surfaces.h"

/* The radii of a row's occluders, where they are not at hand. */
static void find_occluders(const struct rf_occluder_layers *l,
                           const struct rf_occluder_layer *view, int y)
{
    const struct rf_surfaces *s = view->occluders->surfaces;
    const struct rf_surface *near = s->near + (size_t)y * (size_t)s->width;
    const float *share = s->share + (size_t)y * (size_t)s->width;
    float *radius = view->own + l->stride * (size_t)y;
    for (int x = 0; x < s->width; x++)
        radius[x] = share[x] > RF_OCCLUDER_SHARE ? near[x].r : INFINITY;
    for (size_t x = (size_t)s->width; x < l->stride; x++)
        radius[x] = INFINITY;
}

static void build_blocks(const struct rf_occluder_layers *l,
                         const struct rf_occluder_layer *view, int row)
{
    const struct rf_surfaces *s = view->occluders->surfaces;
    float *nearest = view->nearest + (size_t)row * (size_t)l->n_x;
    for (int i = 0; i < l->n_x; i++)
        nearest[i] = INFINITY;
    for (int y = row * RF_OCCLUDER_BLOCK;
         y < rf_min_int((row + 1) * RF_OCCLUDER_BLOCK, s->height); y++) {
        if (view->own)
            find_occluders(l, view, y);
        const float *radius = view->radius + view->stride * (size_t)y;
        int n_whole = s->width / RF_OCCLUDER_BLOCK;
        for (int b = 0; b < n_whole; b++, radius += RF_OCCLUDER_BLOCK) {
            float least[4] = {INFINITY, INFINITY, INFINITY, INFINITY};
            for (int i = 0; i < RF_OCCLUDER_BLOCK; i++)
                least[i % 4] = rf_min_float(radius[i], least[i % 4]);
            nearest[b] = rf_min_float(rf_min_float(least[0], least[1]), nearest[b]);
            nearest[b] = rf_min_float(rf_min_float(least[2], least[3]), nearest[b]);
        }
        for (int i = 0; i < s->width % RF_OCCLUDER_BLOCK; i++)
            nearest[n_whole] = rf_min_float(radius[i], nearest[n_whole]);
    }
}

/* Which view answers for which part of the lens, and how wide its cones are. */
static void assign_lens(struct rf_occluder_layers *l)
{
    const double *e = l->lens_extent;
    for (int row = 0; row < RF_LENS_GRID; row++)
        for (int column = 0; column < RF_LENS_GRID; column++) {
            double u = ((column + 0.5) / RF_LENS_GRID * 2 - 1) * e[0];
            double v = ((row + 0.5) / RF_LENS_GRID * 2 - 1) * e[1]; /* down */
            int best = 0;
            double least = INFINITY;
            for (int j = 0; j < l->scene->n_views; j++) {
                const float *lens = l->scene->occluders[j].lens;
                double d = rf_length(u - lens[0], v + lens[1]);
                if (d < least) {
                    least = d;
                    best = j;
                }
            }
            l->view_at[row][column] = (unsigned char)best;
            struct rf_occluder_layer *view = &l->at[best];
            const struct rf_occluders *o = view->occluders;
            view->extent[0] =
                fmax(view->extent[0], fabs(u - o->shift_scale * o->lens[0]));
            view->extent[1] =
                fmax(view->extent[1], fabs(v + o->shift_scale * o->lens[1]));
        }
    for (int j = 0; j < l->scene->n_views; j++)
        for (int k = 0; k < 2; k++)
            l->at[j].extent[k] += 2 * e[k] / RF_LENS_GRID;
    for (int j = l->scene->n_views; j < l->n; j++)
        memcpy(l->at[j].extent, l->at[l->at[j].view].extent, sizeof l->at[j].extent);
}

/* The near surfaces of the views; `own` has room for their radii or is NULL. */
static void set_near_layers(struct rf_occluder_layers *l, float *nearest, float *own)
{
    size_t n_blocks = (size_t)l->n_x * (size_t)l->n_y;
    for (int j = 0; j < l->scene->n_views; j++) {
        const struct rf_occluders *o = &l->scene->occluders[j];
        struct rf_occluder_layer *layer = &l->at[l->n++];
        *layer = (struct rf_occluder_layer){.occluders = o,
                                            .view = j,
                                            .share = o->surfaces->share,
                                            .radius = o->radius,
                                            .stride = o->radius_stride,
                                            .nearest = nearest + n_blocks * (size_t)j};
        if (!own)
            continue;
        layer->radius = layer->own =
            own + n_blocks * RF_OCCLUDER_BLOCK * RF_OCCLUDER_BLOCK * (size_t)j;
        layer->stride = l->stride;
    }
}

/* What lies behind them, where that is known. */
static void set_layers_behind(struct rf_occluder_layers *l, float *nearest)
{
    size_t n_blocks = (size_t)l->n_x * (size_t)l->n_y;
    for (int j = 0; j < l->scene->n_views; j++) {
        const struct rf_occluders *o = &l->scene->occluders[j];
        if (o->behind)
            l->at[l->n++] =
                (struct rf_occluder_layer){.occluders = o,
                                           .view = j,
                                           .radius = o->behind,
                                           .stride = o->behind_stride,
                                           .nearest = nearest + n_blocks * (size_t)j};
    }
}

/* Memory of the layers: nearest radii of blocks, a row of shares, radii not at hand. */
static rf_result set_layers(struct rf_occluder_layers *l, struct rf_error *error)
{
    const struct rf_context *context = l->scene->frame->context;
    size_t n_views = (size_t)l->scene->n_views;
    size_t n_blocks = (size_t)l->n_x * (size_t)l->n_y * n_views;
    bool has_radii = l->scene->occluders->radius != NULL;
    size_t n = 2 * n_blocks + l->stride +
               (has_radii ? 0 : n_blocks * RF_OCCLUDER_BLOCK * RF_OCCLUDER_BLOCK);
    l->at = rf_calloc(context, 2 * n_views, sizeof *l->at);
    l->memory = rf_alloc(context, n, sizeof *l->memory);
    if (!l->at || !l->memory)
        return rf_fail_memory(error, n, sizeof *l->memory);
    l->whole = l->memory + 2 * n_blocks;
    for (size_t i = 0; i < l->stride; i++)
        l->whole[i] = 1;
    set_near_layers(l, l->memory, has_radii ? NULL : l->whole + l->stride);
    set_layers_behind(l, l->memory + n_blocks);
    return RF_OK;
}

static void build_some_blocks(void *data, int64_t begin, int64_t end, int thread)
{
    struct rf_occluder_layers *l = data;
    for (int i = (int)begin; i < (int)end; i++)
        build_blocks(l, &l->at[i / l->n_y], i % l->n_y);
}

rf_result rf_occluder_layers_build(struct rf_occluder_layers *l, struct rf_error *error)
{
    size_t n_blocks = (size_t)l->n_x * (size_t)l->n_y;
    rf_result result = set_layers(l, error);
    if (result != RF_OK)
        return result;
    rf_parallel(l->scene->frame->context, (int64_t)l->n * l->n_y, 4, build_some_blocks,
                l);
    for (int j = 0; j < l->n; j++) {
        struct rf_occluder_layer *layer = &l->at[j];
        layer->least = INFINITY;
        for (size_t i = 0; i < n_blocks; i++)
            layer->least = rf_min_float(layer->nearest[i], layer->least);
    }
    assign_lens(l);
    return RF_OK;
}

void rf_occluder_layers_free(struct rf_occluder_layers *l)
{
    const struct rf_context *context = l->scene->frame->context;
    rf_free(context, l->memory);
    rf_free(context, l->at);
}
