/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compositing, at a cost that does not grow with the radius (docs/algorithm.md,
 * "Samples, bins and tiles" to "The saturating sum").
 *
 * Samples gather in fixed bins of signed radius (2 px, in focus 0.5 px), near to far. For
 * each pixel p and sub-aperture c, with T(p, c) what is still uncovered,
 *
 *   w = min(coverage of the bin, T),  out += colour w / coverage,  T -= w
 *
 * a saturating sum: a continuous surface that a bin border cuts adds up to exactly 1
 * (the kernel rounds a coverage of 95 % of T or more up to T).
 *
 * Levels. |r| < 8 px (less for shapes wider than high) is spread at full resolution.
 * Level l = 1, 2, ... takes 8 2^(l-1) <= |r| < 8 2^l at 1/2^l resolution, where the
 * radius is again 4 to 8 px: the samples of a block and bin become one. Each level
 * starts from T averaged down to it, T_l, and gives sums S_l with coverage W_l; at full
 * resolution, bilinearly magnified,
 *
 *   w = T min(1, W_l / T_l),  out += S_l w / W_l,  T -= w
 *
 * The order is: near levels, coarse to fine; level 0; far levels, fine to coarse.
 * Hidden samples come once what is visible is done up to one level behind theirs: they
 * fill only what is left, and what is far behind shows through no gap that they close.
 * Averaging down and magnifying widen a footprint by 4^l / 4 px^2 per axis (box and
 * tent), so its radius is shortened to keep the second moment r^2/4.
 *
 * Work is cut into tiles of 64 x 32 px of the level; a tile is one thread's from its
 * first bin to its last, and the order of sums in it is fixed.
 */
#include "compose/composite.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/coarse_levels.h"
#include "compose/common.h"
#include "compose/composer.h"
#include "compose/composite_tiles.h"
#include "compose/footprint.h"
#include "compose/footprint_shelf.h"
#include "compose/gaps.h"
#include "compose/highlights_add.h"
#include "compose/levels.h"
#include "compose/sample_lists.h"
#include "compose/scene.h"
#include "compose/slants.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

/*
 * Levels of visible samples behind a hidden one that come before it. Last of all, as it
 * was once, a bright sky drew lines along every little step of a dark house before it:
 * 28.7 and 35.2 dB. 0: posts -0.07; 2: 0.
 */
enum { LEVELS_BEHIND = 1 };

/* ---- one set of samples -------------------------------------------------------- */

static bool has_samples(const struct rf_group *g)
{
    for (int i = 0; i < g->n_x * g->n_y; i++)
        if (g->tiles[i].n > 0)
            return true;
    return false;
}

/* A group whose tiles, or the canvas' after it, the threads share. */
struct group_tiles {
    const struct rf_composer *c;
    const struct rf_group *g;
};

static void run_full_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct group_tiles *t = data;
    struct rf_task *task = t->c->scene->task;
    for (int i = (int)begin; i < (int)end && !rf_task_is_cancelled(task); i++) {
        rf_run_full_tile(t->c, t->g, i, thread);
        rf_task_step(task);
    }
}

static rf_result run_group(struct rf_composer *c, const struct rf_group *g,
                           bool is_visible, double progress_to, struct rf_error *error)
{
    struct rf_task *task = c->scene->task;
    const struct rf_group full = rf_group_make(c, 0, false);
    const int64_t n_tiles = (int64_t)g->n_x * g->n_y;
    struct group_tiles tiles = {c, g};
    if (rf_task_is_cancelled(task) || !has_samples(g))
        return RF_OK;
    rf_task_phase(task, progress_to,
                  n_tiles + (g->level ? (int64_t)full.n_x * full.n_y : 0));
    if (g->level > 0) {
        return rf_run_level(c, g, is_visible, error);
    }
    rf_parallel(c->context, n_tiles, 1, run_full_tiles, &tiles);
    return RF_OK;
}

/* A set of samples, and its lists once there are some. */
struct set {
    const struct rf_samples *samples;
    const struct rf_source *source;
    struct rf_groups *groups;
    unsigned char **needed; /* footprints, once they are built */
};

/* Builds the lists of a set, if another colour has not, and the footprints that they
 * need. */
static rf_result build_set(struct rf_composer *c, const struct set *set,
                           double lists_to, double footprints_to,
                           struct rf_error *error)
{
    struct rf_task *task = c->scene->task;
    rf_result result = RF_OK;
    if ((set->samples->n == 0 && !set->source->emission) || rf_task_is_cancelled(task))
        return RF_OK;
    if (!*set->needed) {
        result =
            rf_groups_build(set->groups, c, set->samples, set->source, lists_to, error);
        *set->needed = c->needed;
        c->needed = NULL;
    }
    if (result == RF_OK)
        result = rf_footprints_build(c->footprints, *set->needed, task, footprints_to,
                                     error);
    return result;
}

/* The same of both sets, in a fifth of the time up to progress_to. */
static rf_result build_sets(struct rf_composer *c, const struct set sets[2],
                            double progress_to, struct rf_error *error)
{
    double from = c->scene->task->to, room = progress_to - from;
    rf_result result = RF_OK;
    for (int k = 0; k < 2 && result == RF_OK; k++) {
        double lists_to = from + (0.1 * k + 0.05) * room;
        result = build_set(c, &sets[k], lists_to, lists_to + 0.05 * room, error);
    }
    return result;
}

/* Frees the lists unless the next colour will ask for them. */
static void free_sets(const struct rf_composer *c, struct rf_lists *lists)
{
    if (!c->scene->common || !c->scene->common->has_lists)
        rf_lists_free(lists, c->context);
}

/* Drops lists whose slots are others than this composer's: footprints that stayed with a
 * context may be for more radii than they were asked for. */
static void check_lists(const struct rf_composer *c, struct rf_lists *lists)
{
    size_t n = rf_footprint_count(c->footprints);
    if (lists->n_footprints != n)
        rf_lists_free(lists, c->context);
    lists->n_footprints = n;
}

static int order_of(const struct rf_group *g)
{
    return g->is_near ? -g->level : g->level;
}

/* The set whose next group is composited; at[k] of set k are. */
static int next_set(const struct set sets[2], const int at[2])
{
    if (at[0] == sets[0].groups->n || at[1] == sets[1].groups->n)
        return at[0] == sets[0].groups->n;
    return order_of(&sets[1].groups->at[at[1]]) + LEVELS_BEHIND <
           order_of(&sets[0].groups->at[at[0]]);
}

/* Both sets, whose lists are built. */
static rf_result run_sets(struct rf_composer *c, const struct set sets[2],
                          double progress_to, struct rf_error *error)
{
    const int n = sets[0].groups->n + sets[1].groups->n;
    double from = c->scene->task->to, room = progress_to - from;
    int at[2] = {0, 0};
    rf_result result = RF_OK;
    for (int i = 0; i < n && result == RF_OK; i++) {
        int k = next_set(sets, at);
        result = run_group(c, &sets[k].groups->at[at[k]++], k == 0,
                           from + (i + 1) * room / n, error);
    }
    return result;
}

/* ---- all ----------------------------------------------------------------------- */

/* Alpha of what is opaque: what is covered by anything is covered. */
static void fill_opaque(float *out, const float *coverage, int n)
{
    for (int x = 0; x < n; x++)
        out[x] = coverage[x] > 1e-6f ? 1 : 0;
}

/* Colour p of n pixels; of p = 3 without sums, alpha. */
static void finish_plane(const struct rf_composer *c, int p, const float *sum,
                         const float *coverage, int n, float *out)
{
    if (sum)
        c->kernels->divide(sum, coverage, p == 3 ? 0 : c->scene->least[p],
                           p == 3 ? 1 : INFINITY, n, out);
    else
        fill_opaque(out, coverage, n);
}

/* Adds n <= RF_TILE_W finished pixels, each times the weight of its place. */
static void add_weighted(const struct rf_composer *c, const struct rf_crop *crop, int x,
                         int y, int n, const float *const sums[4],
                         const float *coverage)
{
    float colour[4][RF_TILE_W] = {{0}}, weight[RF_TILE_W];
    float *planes[4] = {colour[0], colour[1], colour[2], colour[3]};
    for (int p = 0; p < 4; p++)
        planes[p] = crop->planes[p] ? planes[p] : NULL;
    rf_light_map_row(crop->weights, x, y, n, weight);
    c->kernels->divide_add(sums, coverage, c->scene->least, 1, n, planes);
    for (int p = 0; p < 4; p++) {
        if (!planes[p])
            continue;
        float *out = crop->planes[p] + crop->stride * y + x;
        for (int i = 0; i < n; i++)
            out[i] += weight[i] * colour[p][i];
    }
}

/* Finished pixels of row y of the part, n from x on. */
static void finish_row(const struct rf_composer *c, const struct rf_crop *crop, int x,
                       int y, int n, const float *sum, size_t plane)
{
    int n_colours = c->scene->n_colours;
    const float *coverage = sum + plane * (size_t)n_colours, *sums[4] = {NULL};
    ptrdiff_t at = crop->stride * y + x;
    for (int p = 0; p < n_colours; p++)
        sums[c->scene->first_colour + p] = sum + plane * (size_t)p;
    if (c->gaps)
        rf_gaps_note(c->gaps + (size_t)crop->width * (size_t)y + (size_t)x, coverage,
                     n);
    if (crop->rgba) {
        c->kernels->divide_rgba(sums, coverage, c->scene->least, n,
                                crop->rgba + at + 3 * x);
        return;
    }
    float *planes[4];
    for (int p = 0; p < 4; p++)
        planes[p] = crop->planes[p] ? crop->planes[p] + at : NULL;
    if (crop->weights) {
        add_weighted(c, crop, x, y, n, sums, coverage);
        return;
    }
    if (crop->weight != 0) {
        c->kernels->divide_add(sums, coverage, c->scene->least, crop->weight, n,
                               planes);
        return;
    }
    for (int p = 0; p < 4; p++)
        if (planes[p])
            finish_plane(c, p, sums[p], coverage, n, planes[p]);
}

/* The part of a tile at (x0, y0) of the scene that is wanted. */
static void finish_tile(const struct rf_composer *c, const struct rf_crop *crop,
                        const struct rf_tile_state *s, int x0, int y0)
{
    int from = rf_max_int(x0, crop->x);
    int to = rf_min_int(x0 + RF_TILE_W, crop->x + crop->width);
    int end = rf_min_int(y0 + RF_TILE_H, crop->y + crop->height);
    for (int y = rf_max_int(y0, crop->y); y < end && from < to; y++)
        finish_row(c, crop, from - crop->x, y - crop->y, to - from,
                   s->sum + s->row * (size_t)(y - y0) + (from - x0), s->plane);
    __atomic_thread_fence(__ATOMIC_SEQ_CST); /* see divide_rgba() */
}

/* What the threads share that finish tiles. */
struct finishing {
    const struct rf_composer *c;
    const struct rf_crop *crop;
    const struct rf_group *const *sets; /* both, of tiles that are run and finished */
    struct rf_group full;
};

static void finish_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct finishing *f = data;
    int n_x = f->full.n_x;
    for (int i = (int)begin; i < (int)end; i++) {
        struct rf_tile_state state = rf_canvas_tile(f->c, i);
        finish_tile(f->c, f->crop, &state, i % n_x * RF_TILE_W, i / n_x * RF_TILE_H);
    }
}

static void finish(const struct rf_composer *c, const struct rf_crop *crop)
{
    struct finishing f = {c, crop, NULL, rf_group_make(c, 0, false)};
    rf_parallel(c->context, (int64_t)f.full.n_x * f.full.n_y, RF_EQUAL_PARTS,
                finish_tiles, &f);
}

static bool has_planes(const struct rf_work *work)
{
    bool any = false;
    for (int p = 0; p < 4; p++)
        any |= work->colour[p] != NULL;
    return any;
}

/* Where the result goes: the image or colours of the work, or the canvas' sums. */
static struct rf_crop crop_of(const struct rf_composer *c, struct rf_work *work)
{
    const struct rf_scene *scene = c->scene;
    struct rf_crop crop = {
        .x = scene->x0,
        .y = scene->y0,
        .width = work->frame->width,
        .height = work->frame->height,
        .stride = work->frame->width,
    };
    if (scene->sum) {
        crop.weight = scene->weight;
        crop.weights = scene->weights;
        for (int p = 0; p < work->n_planes; p++)
            crop.planes[p] =
                scene->sum + (size_t)crop.width * (size_t)crop.height * (size_t)p;
        return crop;
    }
    if (work->out) {
        crop.rgba = (float *)rf_image_at(work->out, 0, 0, 0);
        crop.stride = work->out->row_bytes / (ptrdiff_t)sizeof(float);
        return crop;
    }
    if (!has_planes(work)) {
        crop.stride = (ptrdiff_t)c->canvas.stride;
        work->stride = c->canvas.stride;
        for (int p = 0; p < work->n_planes; p++)
            work->colour[p] = c->canvas.sum + c->canvas.plane * (size_t)p +
                              crop.stride * crop.y + crop.x;
    }
    memcpy(crop.planes, work->colour, (size_t)work->n_planes * sizeof *crop.planes);
    return crop;
}

/* Is none of a set's samples of a coarse level? */
static bool is_fine(const struct rf_composer *c, const struct set *set)
{
    return set->source->emission
               ? rf_level_up_to(&c->levels, set->source->largest_radius) == 0
               : set->samples->n == 0;
}

static void run_lone_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct finishing *f = data;
    struct rf_task *task = f->c->scene->task;
    int n_x = f->full.n_x;
    for (int i = (int)begin; i < (int)end && !rf_task_is_cancelled(task); i++) {
        struct rf_tile_state state = rf_run_lone_tile(f->c, f->sets, i, thread);
        finish_tile(f->c, f->crop, &state, i % n_x * RF_TILE_W, i / n_x * RF_TILE_H);
        rf_task_step(task);
    }
}

/* Sets without coarse levels: every tile is finished at once, without a canvas. */
static rf_result run_tiles(struct rf_composer *c, const struct set sets[2],
                           struct rf_lists *lists, const struct rf_crop *crop,
                           double progress_to, struct rf_error *error)
{
    struct rf_task *task = c->scene->task;
    const struct rf_group *at[2], g = rf_group_make(c, 0, false);
    rf_result result = build_sets(c, sets, progress_to, error);
    for (int k = 0; k < 2; k++)
        at[k] = sets[k].groups->n > 0 ? sets[k].groups->at : NULL;
    rf_task_phase(task, progress_to, (int64_t)g.n_x * g.n_y);
    struct finishing f = {c, crop, at, g};
    if (result == RF_OK)
        rf_parallel(c->context, (int64_t)g.n_x * g.n_y, 1, run_lone_tiles, &f);
    free_sets(c, lists);
    return result;
}

/* Planes of the whole scene. */
static rf_result allocate_canvas(struct rf_composer *c, struct rf_error *error)
{
    struct rf_canvas *canvas = &c->canvas;
    struct rf_group full = rf_group_make(c, 0, false);
    size_t n = full.plane;
    canvas->n_x = full.n_x;
    canvas->stride = full.stride;
    canvas->plane = full.plane;
    canvas->t = rf_alloc(c->context, n * (size_t)canvas->n_cells, sizeof(float));
    canvas->sum = rf_alloc(c->context, n * (size_t)canvas->n_planes, sizeof(float));
    canvas->is_begun = rf_calloc(c->context, (size_t)full.n_x * (size_t)full.n_y, 1);
    return canvas->t && canvas->sum && canvas->is_begun
               ? RF_OK
               : rf_fail_memory(error, n * (size_t)(canvas->n_cells + canvas->n_planes),
                                sizeof(float));
}

/* What the threads work with. */
static rf_result allocate(struct rf_composer *c, struct rf_error *error)
{
    const struct rf_canvas *canvas = &c->canvas;
    size_t n_acc = (size_t)rf_spread_sums_slots(canvas->n_cells) * RF_TILE_H *
                   RF_ACC_STRIDE * (size_t)canvas->n_planes;
    c->n_tile = (size_t)(canvas->n_cells + canvas->n_planes) * RF_TILE_H * RF_TILE_W;
    c->tiles = rf_alloc(c->context, c->n_tile * (size_t)c->n_threads, sizeof(float));
    c->acc = rf_calloc(c->context, (size_t)c->n_threads, sizeof *c->acc);
    bool has_slants = rf_slants_init(c);
    float *acc = rf_calloc(c->context, n_acc * (size_t)c->n_threads, sizeof(float));
    if (!c->tiles || !c->acc || !has_slants || !acc) {
        rf_free(c->context, acc);
        rf_free(c->context, c->acc);
        c->acc = NULL;
        return rf_fail_memory(error, n_acc * (size_t)c->n_threads, sizeof(float));
    }
    for (int i = 0; i < c->n_threads; i++) {
        c->acc[i] = (struct rf_spread_sums){.n_cells = canvas->n_cells,
                                            .n_planes = canvas->n_planes,
                                            .first_colour = c->scene->first_colour,
                                            .at = acc + n_acc * (size_t)i,
                                            .factors = c->factors,
                                            .first_row = RF_TILE_H,
                                            .last_row = -1};
        for (int p = 0; p < 3 && c->scene->first_colour + p < 3; p++)
            if (c->scene->least[c->scene->first_colour + p] < 0)
                c->acc[i].least[p] = -INFINITY;
        for (int cell = 0; cell < canvas->n_cells; cell++)
            c->acc[i].share[cell] = (float)c->footprints->zones.at->cells.share[cell];
    }
    return RF_OK;
}

/* Notes no gaps for a part. */
static rf_result begin_gaps(struct rf_composer *c, const struct rf_crop *crop,
                            struct rf_error *error)
{
    size_t n = (size_t)crop->width * (size_t)crop->height;
    c->gaps = rf_calloc(c->context, n, sizeof *c->gaps);
    return c->gaps ? RF_OK : rf_fail_memory(error, n, sizeof *c->gaps);
}

/* Both sets, on a canvas. */
static rf_result run_canvas(struct rf_composer *c, const struct set sets[2],
                            struct rf_lists *lists, double progress_to,
                            struct rf_error *error)
{
    rf_result result = allocate_canvas(c, error);
    if (result == RF_OK)
        result = build_sets(c, sets, progress_to, error);
    if (result == RF_OK)
        result = run_sets(c, sets, progress_to, error);
    free_sets(c, lists);
    if (result == RF_OK)
        rf_begin_canvas(c);
    return result;
}

rf_result rf_composite_crop(struct rf_scene *scene, struct rf_work *work,
                            struct rf_error *error)
{
    bool has_alpha = work->n_planes == 4 && !scene->is_opaque;
    bool is_lone = scene->colour > 0 && !has_alpha;
    scene->n_colours = is_lone ? 1 : has_alpha ? 4 : 3;
    scene->first_colour = is_lone ? scene->colour - 1 : 0;
    bool gives_canvas = !has_planes(work) && !work->out && !scene->sum;
    const struct rf_frame *frame = scene->frame;
    struct rf_composer c = {.scene = scene,
                            .context = frame->context,
                            .kernels = frame->context->kernels,
                            .n_threads = frame->context->n_threads,
                            .canvas = {.n_cells = frame->params.sub_apertures,
                                       .n_planes = scene->n_colours + 1,
                                       .is_planar = gives_canvas}};
    double from = scene->task->to;
    double room = scene->progress_to - from, kept = scene->highlights.n ? 0.2 : 0;
    c.levels = rf_levels_of(&frame->shape);
    struct rf_footprints own;
    struct rf_footprint_use use = {.shape = &frame->shape,
                                   .drift = scene->drift,
                                   .look = rf_frame_look(frame),
                                   .bokeh = rf_frame_bokeh(frame),
                                   .bokeh_plane = rf_frame_bokeh_plane(frame),
                                   .obstruction = rf_frame_obstruction(frame),
                                   .spherical = frame->params.spherical,
                                   .n_cells = c.canvas.n_cells,
                                   .max_radius = rf_levels_most(&c.levels) + 1,
                                   .n_phases = scene->n_phases};
    rf_result result = rf_footprints_get(&c.footprints, &own, c.context, &use, error);
    if (result == RF_OK) {
        result = allocate(&c, error);
    }
    rf_task_poll(scene->task);
    struct rf_lists own_lists = {.n_footprints = 0};
    struct rf_lists *lists = scene->common ? &scene->common->lists : &own_lists;
    const struct set sets[2] = {
        {&scene->visible, &scene->visible_source, &lists->groups[0], &lists->needed[0]},
        {&scene->hidden, &scene->hidden_source, &lists->groups[1], &lists->needed[1]}};
    if (result == RF_OK)
        check_lists(&c, lists);
    bool is_local = !gives_canvas && is_fine(&c, &sets[0]) && is_fine(&c, &sets[1]);
    double most = from + (1 - kept) * room;
    if (result == RF_OK && !is_local)
        result = run_canvas(&c, sets, lists, most, error);
    struct rf_crop crop = {.x = 0};
    if (result == RF_OK)
        crop = crop_of(&c, work);
    if (result == RF_OK && scene->fills_gaps)
        result = begin_gaps(&c, &crop, error);
    if (result == RF_OK && is_local)
        result = run_tiles(&c, sets, lists, &crop, most, error);
    else if (result == RF_OK)
        finish(&c, &crop);
    if (result == RF_OK && c.gaps)
        rf_gaps_fill(&crop, c.gaps, c.context);
    if (result == RF_OK)
        result = rf_add_highlights(scene, &crop, error);
    if (gives_canvas) {
        work->planes = c.canvas.sum;
        c.canvas.sum = NULL;
    }
    rf_free(c.context, c.gaps);
    if (c.acc)
        rf_free(c.context, c.acc[0].at);
    rf_free(c.context, c.acc);
    rf_free(c.context, c.factors);
    rf_free(c.context, c.tiles);
    rf_free(c.context, c.canvas.is_begun);
    rf_free(c.context, c.canvas.sum);
    rf_free(c.context, c.canvas.t);
    rf_footprints_put(c.footprints, &own);
    return result;
}
