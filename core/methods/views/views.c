/* SPDX-License-Identifier: Apache-2.0 */
/*
 * views: several pinhole views from points of the lens, each for its part of the lens.
 *
 * A point of signed radius r at (x, y) of the lens' centre's view is seen by view j,
 * taken from (u_j, v_j) of the unit lens (u right and v up), at
 *
 *   X = x + u_j s(r),  Y = y - v_j s(r)
 *
 * - s(r) = a r + b: the shift in px per unit of the lens; s = r where the views were
 *   sheared to the plane in focus. Another focus or aperture than the views were
 *   rendered with changes a and b only, so the same views can be refocused, stopped
 *   down and opened up
 *
 * The lens is cut into the cells of points that are nearest to each view; more than
 * eight views share eight cells, each for those nearest to its middle. What view j
 * sees is moved to the centroid of its cell,
 *
 *   x = X - u_j s(r) + m_j r
 *
 * and spread as in the method layered, over that cell only; the picture is the mean of
 * the cells' pictures by area. Not the samples of a view alone in its cell are moved,
 * which stay on that view's pixels, but their footprints: these depend on r alone
 * then, and neighbours are spread together.
 *
 * A cell is narrower than the lens by the square root of the number of cells, and so is
 * what its views cannot see. Of the other views, the nearest that does shows that; what
 * none of them saw is estimated (hidden.c). Such samples only fill what the cell's own
 * leave uncovered. Those of views that share a cell have the weight
 *
 *   w = share / max(1/4, n),  n = own + sum over the other views (of the cell) of how
 *                                 much of the place is not occluded there
 *
 * own is 1 for a near part, which looks past nothing, and its share for a far one.
 * Occluded at the nearest pixel: nearer by 0.8 px and pure, 0; nearer but mixed with a
 * far part at or behind r - 0.8, 1 - its share; else 1; outside the picture 0. What
 * continues a picture beyond its border fills only what no view shows.
 *
 * A lens stopped down to the places of less than half of the views is one cell instead,
 * of which the samples of all views are the own ones, with that weight.
 *
 * Lights are taken out first and added at the end with exact visibility over the whole
 * lens (views_lights.c, highlights_add.c).
 *
 * Ours. One view gives the method layered, bit for bit. Memory: 75 to 80 bytes per
 * pixel and view; core/window.c does with less, of a part of the picture at a time.
 * Cost: 6 to 7 layered passes for 8 views at 1920x1080.
 */
#include "methods/views/views.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/highlights_add.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "compose/light_map.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "kernels/sight_kernels.h"
#include "lens/look.h"
#include "methods/layered/layered.h"
#include "methods/layered/layered_preview.h"
#include "methods/views/merge.h"
#include "methods/views/views_behind.h"
#include "methods/views/views_cell.h"
#include "methods/views/views_lens.h"
#include "methods/views/views_lights.h"
#include "methods/views/views_place.h"
#include "methods/views/views_sight.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

static struct rf_sight sight_of(const struct rf_picture *picture,
                                const struct rf_work_view *view)
{
    return (struct rf_sight){
        .radius = rf_plane_row(&picture->pixels, picture->pixels.radius, 0),
        .stride = picture->pixels.stride,
        .lens = {view->lens[0], view->lens[1]},
        .shift_scale = view->shift_scale,
        .shift_bias = view->shift_bias,
        .x0 = picture->x0,
        .y0 = picture->y0,
        .x1 = picture->x0 + picture->frame->width,
        .y1 = picture->y0 + picture->frame->height};
}

static rf_result load(struct rf_views *v, int border, struct rf_error *error)
{
    struct rf_work *work = v->work;
    for (int j = 0; j < work->n_views; j++) {
        rf_task_phase(work->task, 0.2 * (j + 1) / work->n_views,
                      work->frame->height + 2 * border);
        rf_result result =
            rf_picture_load(&v->pictures[j], work->frame, &work->views[j],
                            work->n_planes, border, RF_KEPT_PIXELS, work->task, error);
        if (result != RF_OK || rf_task_is_cancelled(work->task))
            return result;
        const struct rf_work_view *view = &work->views[j];
        const struct rf_pixels *pixels = &v->pictures[j].pixels;
        v->occluders[j] = (struct rf_occluders){
            .surfaces = &v->pictures[j].surfaces,
            .radius = rf_plane_row(pixels, pixels->radius, 0),
            .radius_stride = pixels->stride,
            .lens = {view->lens[0], view->lens[1]},
            .shift_scale = view->shift_scale,
            .shift_bias = view->shift_bias,
        };
        v->sights[j] = sight_of(&v->pictures[j], view);
    }
    return RF_OK;
}

/* Finds which views the cell asks, and in which order. */
static void rank_views(const struct rf_view_cell *cell)
{
    const struct rf_work *work = cell->v->work;
    const float *middle = work->views[cell->middle].lens;
    struct rf_cell_views *views = &cell->v->cells[cell->index];
    float distance2[RF_MAX_VIEWS];
    for (int j = 0; j < work->n_views; j++) {
        const float *lens = work->views[j].lens;
        float u = lens[0] - middle[0];
        float v = (lens[1] - middle[1]) / (float)work->frame->params.pixel_aspect;
        distance2[j] = u * u + v * v;
    }
    *views = (struct rf_cell_views){.own = cell->own};
    for (int j = 0; j < work->n_views; j++)
        for (int k = 0; k < work->n_views; k++)
            if (!(cell->own >> k & 1) && (distance2[k] < distance2[j] ||
                                          (distance2[k] == distance2[j] && k < j)))
                views->nearer[j] |= (uint64_t)1 << k;
}

static rf_result find_unseen(struct rf_views *v, const struct rf_view_cell *cells,
                             int n, struct rf_error *error)
{
    if (cells[0].is_whole)
        return RF_OK;
    v->n_cells = n;
    for (int i = 0; i < n; i++)
        rank_views(&cells[i]);
    return rf_views_find_unseen(v, error);
}

/*
 * What the cells weigh where looks take light away: each the light that
 * comes through it, and all together `total` everywhere. Where none does, all of theirs.
 */
static rf_result weigh_cells(struct rf_view_cell *cells, const double *area, int n,
                             struct rf_error *error)
{
    const struct rf_frame *f = cells->v->work->frame;
    const struct rf_look look = rf_frame_look(f);
    rf_result result = RF_OK;
    double total = 0;
    if (!rf_look_is_dark(&look) || n == 1)
        return RF_OK;
    for (int i = 0; i < n && result == RF_OK; i++) {
        result = rf_light_map_make(&cells[i].weights, f, &cells[i].frame.shape,
                                   rf_frame_bokeh_plane(f), error);
        total += area[i];
    }
    size_t n_nodes = (size_t)cells->weights.n_x * (size_t)cells->weights.n_y;
    for (size_t k = 0; k < n_nodes && result == RF_OK; k++) {
        double open = 0;
        for (int i = 0; i < n; i++)
            open += area[i] * (double)cells[i].weights.at[k];
        for (int i = 0; i < n; i++) {
            float *at = &cells[i].weights.at[k];
            *at = (float)(open > 0 ? area[i] * (double)*at * total / open : area[i]);
        }
    }
    return result;
}

/* Adds the cells' pictures by area to `sum`. */
static rf_result add_cells(struct rf_views *v, struct rf_view_cell *cells,
                           const double *area, int n, float *sum,
                           struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_context *context = work->frame->context;
    double from = work->task->to;
    rf_result result = find_unseen(v, cells, n, error);
    if (result == RF_OK)
        result = weigh_cells(cells, area, n, error);
    for (int i = 0; i < n && result == RF_OK; i++) {
        struct rf_view_cell *cell = &cells[i];
        cell->weight = (float)area[i];
        cell->sum = sum;
        result = rf_view_cell_run(cell, from + (0.9 - from) * (i + 1) / n, error);
        rf_free(context, cell->samples);
        rf_estimates_free(&cell->hidden, context);
        if (rf_task_is_cancelled(work->task))
            break;
    }
    for (int i = 0; i < n; i++)
        rf_light_map_free(&cells[i].weights, context);
    return result;
}

/* Adds the light of the lights over the whole lens to quadruples of the picture. */
static rf_result spread_lights(const struct rf_views *v, float *rgba,
                               struct rf_error *error)
{
    const struct rf_picture *picture = &v->pictures[0];
    const struct rf_look look = rf_field_look(v->work->frame);
    struct rf_scene scene = {.frame = v->work->frame,
                             .width = picture->width,
                             .height = picture->height,
                             .x0 = picture->x0,
                             .y0 = picture->y0,
                             .n_colours = v->work->n_planes == 4 ? 4 : 3,
                             .n_phases =
                                 rf_look_is_on(&look) ? RF_FINE_PHASES : RF_VIEW_PHASES,
                             .highlights = v->lights,
                             .highlight_leads = v->light_leads,
                             .occluders = v->occluders,
                             .n_views = v->work->n_views,
                             .task = v->work->task,
                             .progress_to = 1};
    struct rf_crop crop = {.x = picture->x0,
                           .y = picture->y0,
                           .width = picture->frame->width,
                           .height = picture->frame->height,
                           .stride = 4 * (ptrdiff_t)picture->frame->width,
                           .rgba = rgba};
    return rf_add_highlights(&scene, &crop, error);
}

static rf_result add_lights(const struct rf_views *v, float *rgba,
                            struct rf_error *error)
{
    const struct rf_context *context = v->work->frame->context;
    float *behind = NULL;
    if (v->lights.n == 0)
        return RF_OK;
    rf_result result = rf_views_find_behind(v, &behind, error);
    if (result == RF_OK)
        result = spread_lights(v, rgba, error);
    rf_free(context, behind);
    return result;
}

/* A row of the planes of the work and its lights, as quadruples, to plain pixels. */
static void store_row(const struct rf_work *work, int y, const float *lights)
{
    int width = work->frame->width;
    const float *rows[4];
    float *out = (float *)rf_image_at(work->out, 0, y, 0);
    for (int p = 0; p < work->n_planes; p++)
        rows[p] = work->colour[p] + (size_t)y * (size_t)width;
    work->frame->context->kernels->pack(rows, width, out);
    for (int x = 0; x < width; x++)
        *(rf_quad *)(out + 4 * x) += *(const rf_quad *)(lights + 4 * x);
}

/* Adds its lights to a row of the planes of the work. */
static void add_row(const struct rf_work *work, int y, const float *lights)
{
    int width = work->frame->width;
    for (int p = 0; p < work->n_planes; p++) {
        float *row = work->colour[p] + (size_t)y * (size_t)width;
        for (int x = 0; x < width; x++)
            row[x] += lights[4 * x + p];
    }
}

/* What the threads share that finish the picture. */
struct finishing {
    const struct rf_work *work;
    float total;
    const float *lights;
};

static void finish_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct finishing *f = data;
    const struct rf_work *work = f->work;
    int width = work->frame->width;
    for (int y = (int)begin; y < (int)end; y++) {
        const float *light = f->lights + 4 * (size_t)y * (size_t)width;
        for (int p = 0; p < work->n_planes; p++) {
            float *row = work->colour[p] + (size_t)y * (size_t)width;
            for (int x = 0; x < width; x++)
                row[x] /= f->total;
        }
        if (work->out)
            store_row(work, y, light);
        else
            add_row(work, y, light);
    }
}

/*
 * The mean of the cells, and the lights: as plain pixels where the work has room for
 * them, else in the planes of the cells' sum, which are its colours now.
 */
static void finish(const struct rf_views *v, float *sum, double total,
                   const float *lights)
{
    struct rf_work *work = v->work;
    int width = work->frame->width, height = work->frame->height;
    size_t n = (size_t)width * (size_t)height;
    work->planes = sum;
    work->stride = (size_t)width;
    for (int p = 0; p < work->n_planes; p++)
        work->colour[p] = sum + n * (size_t)p;
    struct finishing f = {work, (float)total, lights};
    rf_parallel(work->frame->context, height, RF_EQUAL_PARTS, finish_rows, &f);
    if (work->out)
        memset(work->colour, 0, sizeof work->colour);
}

/* The picture of loaded views whose lights have been taken. */
static rf_result merge(struct rf_views *v, struct rf_view_cell *cells,
                       const double *area, int n_cells, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_frame *f = work->frame;
    size_t n_pixels = (size_t)f->width * (size_t)f->height;
    size_t n = n_pixels * (size_t)work->n_planes;
    float *sum = rf_calloc(f->context, n, sizeof *sum), *lights = NULL;
    double total = 0;
    for (int i = 0; i < n_cells; i++)
        total += area[i];
    rf_result result = sum ? add_cells(v, cells, area, n_cells, sum, error)
                           : rf_fail_memory(error, n, sizeof *sum);
    if (result == RF_OK && !rf_task_is_cancelled(work->task)) {
        lights = rf_calloc(f->context, 4 * n_pixels, sizeof *lights);
        result = lights ? add_lights(v, lights, error)
                        : rf_fail_memory(error, 4 * n_pixels, sizeof *lights);
    }
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        finish(v, sum, total, lights);
    else
        rf_free(f->context, sum);
    rf_free(f->context, lights);
    return result;
}

static rf_result run(struct rf_views *v, struct rf_error *error)
{
    struct rf_work *work = v->work;
    const struct rf_context *context = work->frame->context;
    double area[RF_MAX_VIEWS];
    struct rf_view_cell *cells =
        rf_alloc(context, (size_t)work->n_views, sizeof *cells);
    if (!cells)
        return rf_fail_memory(error, (size_t)work->n_views, sizeof *cells);
    int n_cells = rf_views_make_cells(v, cells, area);
    rf_views_measure_range(v);
    int border = rf_picture_border(rf_views_border(work, cells, n_cells));
    rf_result result = load(v, border, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task)) {
        rf_free(context, cells);
        return result;
    }
    if (work->frame->params.exact_highlights)
        result = rf_views_take_lights(v, error);
    for (int j = 0; j < work->n_views && result == RF_OK; j++)
        rf_picture_drop_pixels(&v->pictures[j]);
    rf_work_drop_views(work);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = merge(v, cells, area, n_cells, error);
    rf_free(context, cells);
    return result;
}

/* A preview takes the view nearest to the lens' centre alone. */
static rf_result run_preview(struct rf_work *work, struct rf_error *error)
{
    struct rf_work one = *work;
    one.views = &work->views[rf_views_middle(work)];
    one.n_views = 1;
    one.radius = one.views->radius;
    memcpy(one.colour, one.views->colour, sizeof one.colour);
    rf_result result = rf_layered_preview_run(&one, error);
    memcpy(work->colour, one.colour, sizeof work->colour);
    work->planes = one.planes;
    return result;
}

rf_result rf_views_run(struct rf_work *work, struct rf_error *error)
{
    if (work->frame->params.quality == RF_QUALITY_PREVIEW)
        return run_preview(work, error);
    if (work->n_views == 1)
        return rf_layered_run(work, error);
    const struct rf_context *context = work->frame->context;
    size_t n = (size_t)work->n_views;
    struct rf_views v = {.work = work,
                         .pictures = rf_calloc(context, n, sizeof *v.pictures),
                         .occluders = rf_calloc(context, n, sizeof *v.occluders)};
    rf_result result = v.pictures && v.occluders
                           ? run(&v, error)
                           : rf_fail_memory(error, n, sizeof *v.pictures);
    rf_views_free_unseen(&v);
    for (size_t j = 0; j < n && v.pictures; j++)
        rf_picture_free(&v.pictures[j]);
    rf_free(context, v.light_leads);
    rf_free(context, v.lights.at);
    rf_free(context, v.occluders);
    rf_free(context, v.pictures);
    return result;
}
