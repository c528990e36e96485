/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compositing (recipe step 6), at a cost that does not grow with the radius.
 *
 * Samples gather in fixed bins of 2 px of signed radius, near to far. For each pixel p
 * and sub-aperture c, with T(p, c) what is still uncovered,
 *
 *   w = min(coverage of the bin, T),  out += colour w / coverage,  T -= w
 *
 * a saturating sum: a continuous surface that a bin border cuts adds up to exactly 1
 * (the kernel rounds a coverage of 95 % of T or more up to T).
 *
 * Levels. |r| < 8 px (less for shapes wider than high) is spread at full resolution.
 * Level l = 1, 2, ... takes 8 2^(l-1)
 * <= |r| < 8 2^l at 1/2^l resolution, where the radius is again 4 to 8 px: the samples
 * of a block and bin become one. Each level starts from T averaged down to it, T_l, and
 * gives sums S_l with coverage W_l; at full resolution, bilinearly magnified,
 *
 *   w = T min(1, W_l / T_l),  out += S_l w / W_l,  T -= w
 *
 * The order is: near levels, coarse to fine; level 0; far levels, fine to coarse; first
 * for the visible samples and then for the hidden ones, which so fill only what is
 * left. Averaging down and magnifying widen a footprint by 4^l / 4 px^2 per axis (box
 * and tent), so its radius is shortened to keep the second moment r^2/4.
 *
 * Work is cut into tiles of 64 x 32 px of the level; a tile is one thread's from its
 * first bin to its last, and the order of sums in it is fixed.
 */
#include <stdlib.h>

#include "composer.h"

/* ---- one set of samples -------------------------------------------------------- */

static bool has_samples(const struct rf_group *g)
{
    for (int i = 0; i < g->n_x * g->n_y; i++)
        if (g->tiles[i].n > 0)
            return true;
    return false;
}

static rf_result run_groups(struct rf_composer *c, const struct rf_group *groups,
                            int n_groups, double progress_to, struct rf_error *error)
{
    struct rf_task *task = c->scene->task;
    double middle = task->to + 0.1 * (progress_to - task->to);
    rf_result result =
        rf_footprints_build(c->footprints, c->needed, task, middle, error);
    int64_t n_steps = 0;
    for (int k = 0; k < n_groups; k++)
        if (has_samples(&groups[k]))
            n_steps += groups[k].n_x * groups[k].n_y +
                       (groups[k].level ? c->scene->height : 0);
    rf_task_phase(task, progress_to, n_steps);
    for (int k = 0; k < n_groups && result == RF_OK && !rf_task_is_cancelled(task);
         k++) {
        const struct rf_group *g = &groups[k];
        int n_tiles = g->n_x * g->n_y;
        bool is_filled = has_samples(g);
        if (is_filled && g->level > 0)
            result = rf_run_level(c, g, error);
        else if (is_filled) {
#pragma omp parallel for num_threads(c->n_threads) schedule(dynamic, 1)
            for (int i = 0; i < n_tiles; i++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    rf_run_full_tile(c, g, i);
                    rf_task_step(c->scene->task);
                }
        }
    }
    return result;
}

static rf_result run_samples(struct rf_composer *c, const struct rf_samples *samples,
                             const struct rf_source *source, double progress_to,
                             struct rf_error *error)
{
    if ((samples->n == 0 && !source->survey) || rf_task_is_cancelled(c->scene->task))
        return RF_OK;
    double from = c->scene->task->to;
    struct rf_groups groups = {.n = 0};
    rf_result result = rf_groups_build(&groups, c, samples, source,
                                       from + 0.05 * (progress_to - from), error);
    if (result == RF_OK)
        result = run_groups(c, groups.at, groups.n, progress_to, error);
    rf_groups_free(&groups, c);
    return result;
}

/* ---- all ----------------------------------------------------------------------- */

/* Alpha of what is opaque: what is covered by anything is covered. */
static void fill_opaque(float *out, const float *coverage, int n)
{
    for (int x = 0; x < n; x++)
        out[x] = coverage[x] > 1e-6f ? 1 : 0;
}

static void finish(const struct rf_composer *c, const struct rf_crop *crop)
{
    const struct rf_scene *scene = c->scene;
#pragma omp parallel for num_threads(c->n_threads) schedule(static)
    for (int y = 0; y < crop->height; y++) {
        const float *sum =
            c->canvas.sum + c->canvas.stride * (size_t)(y + crop->y) + crop->x;
        const float *coverage = sum + c->canvas.plane * (size_t)scene->n_colours;
        size_t row = crop->stride * (size_t)y;
        for (int p = 0; p < scene->n_colours; p++, sum += c->canvas.plane)
            if (crop->planes[p])
                c->kernels->divide(sum, coverage, p == 3 ? 1 : INFINITY, crop->width,
                                   crop->planes[p] + row);
        if (scene->n_colours == 3 && crop->planes[3])
            fill_opaque(crop->planes[3] + row, coverage, crop->width);
    }
}

/* Where the result goes: the colours of the work, or the sums of the canvas. */
static struct rf_crop crop_of(const struct rf_composer *c, struct rf_work *work)
{
    const struct rf_scene *scene = c->scene;
    struct rf_crop crop = {
        .x = scene->x0,
        .y = scene->y0,
        .width = work->filter->width,
        .height = work->filter->height,
        .stride = (size_t)work->filter->width,
    };
    if (!work->colour[0]) {
        crop.stride = work->stride = c->canvas.stride;
        for (int p = 0; p < work->n_planes; p++)
            work->colour[p] = c->canvas.sum + c->canvas.plane * (size_t)p +
                              crop.stride * (size_t)crop.y + crop.x;
    }
    memcpy(crop.planes, work->colour, (size_t)work->n_planes * sizeof *crop.planes);
    return crop;
}

static void set_reach(struct rf_composer *c)
{
    const struct rf_footprints *f = c->footprints;
    double extent[2];
    rf_shape_extent(f->shape, extent);
    for (int k = 0; k < 2; k++) {
        c->reach[k][0] = fabs(f->drift.base[k]);
        c->reach[k][1] = fmax(extent[k], f->shape->size[k]) + fabs(f->drift.slope[k]);
    }
}

static rf_result allocate(struct rf_composer *c, struct rf_error *error)
{
    struct rf_canvas *canvas = &c->canvas;
    struct rf_group full = rf_group_make(c, 0, false);
    size_t n = full.plane;
    canvas->stride = full.stride;
    canvas->plane = full.plane;
    size_t n_acc = (size_t)rf_accumulator_slots(canvas->n_cells) * RF_TILE_H *
                   RF_ACC_STRIDE * (size_t)canvas->n_planes;
    size_t n_t = (size_t)canvas->n_cells * RF_TILE_H * RF_TILE_W;
    canvas->t = rf_alloc(c->context, n * (size_t)canvas->n_cells, sizeof(float));
    canvas->sum = rf_alloc(c->context, n * (size_t)canvas->n_planes, sizeof(float));
    canvas->is_begun = rf_calloc(c->context, (size_t)full.n_x * (size_t)full.n_y, 1);
    c->tiles = rf_alloc(c->context, n_t * (size_t)c->n_threads, sizeof(float));
    c->acc = rf_calloc(c->context, (size_t)c->n_threads, sizeof *c->acc);
    float *acc = rf_calloc(c->context, n_acc * (size_t)c->n_threads, sizeof(float));
    if (!canvas->t || !canvas->sum || !canvas->is_begun || !c->tiles || !c->acc ||
        !acc) {
        rf_free(c->context, acc);
        rf_free(c->context, c->acc);
        c->acc = NULL;
        return rf_fail_memory(error, n * (size_t)(canvas->n_cells + canvas->n_planes),
                              sizeof(float));
    }
    for (int i = 0; i < c->n_threads; i++) {
        c->acc[i] = (struct rf_accumulator){.n_cells = canvas->n_cells,
                                            .n_planes = canvas->n_planes,
                                            .at = acc + n_acc * (size_t)i,
                                            .first_row = RF_TILE_H,
                                            .last_row = -1};
        for (int cell = 0; cell < canvas->n_cells; cell++)
            c->acc[i].share[cell] = (float)c->footprints->cells.share[cell];
    }
    return RF_OK;
}

rf_result rf_composite_crop(struct rf_scene *scene, struct rf_work *work,
                            struct rf_error *error)
{
    scene->n_colours = work->n_planes == 4 && !scene->is_opaque ? 4 : 3;
    bool gives_canvas = !work->colour[0];
    const struct rf_filter *filter = scene->filter;
    struct rf_composer c = {.scene = scene,
                            .context = filter->context,
                            .kernels = filter->context->kernels,
                            .n_threads = filter->context->n_threads,
                            .canvas = {.n_cells = filter->params.sub_apertures,
                                       .n_planes = scene->n_colours + 1}};
    double from = scene->task->to;
    double room = scene->progress_to - from, kept = scene->highlights.n ? 0.2 : 0;
    c.split = rf_level_split(&filter->shape);
    struct rf_footprints own;
    struct rf_footprint_use use = {&filter->shape, scene->drift, c.canvas.n_cells,
                                   c.split + 1, scene->n_phases};
    rf_result result = rf_footprints_get(&c.footprints, &own, c.context, &use, error);
    if (result == RF_OK) {
        set_reach(&c);
        result = allocate(&c, error);
    }
    rf_task_poll(scene->task);
    if (result == RF_OK)
        result = run_samples(&c, &scene->visible, &scene->visible_source,
                             from + 0.6 * room, error);
    if (result == RF_OK)
        result = run_samples(&c, &scene->hidden, &scene->hidden_source,
                             from + (1 - kept) * room, error);
    if (result == RF_OK) {
        struct rf_crop crop = crop_of(&c, work);
        rf_begin_canvas(&c);
        finish(&c, &crop);
        result = rf_add_highlights(scene, &crop, error);
    }
    if (gives_canvas) {
        work->memory = c.canvas.sum;
        c.canvas.sum = NULL;
    }
    if (c.acc)
        rf_free(c.context, c.acc[0].at);
    rf_free(c.context, c.acc);
    rf_free(c.context, c.tiles);
    rf_free(c.context, c.canvas.is_begun);
    rf_free(c.context, c.canvas.sum);
    rf_free(c.context, c.canvas.t);
    rf_footprints_put(c.footprints, &own);
    return result;
}
