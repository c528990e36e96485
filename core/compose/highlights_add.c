/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Highlights with exact visibility (docs/algorithm.md, "Highlights").
 *
 * A highlight at x with radius r0 sends light to the footprint pixel p through the lens
 * point u = (p - x) / r0. On its way the ray passes the place x + u (r0 - q) of the
 * picture at the depth of radius q. A pixel o that shows a surface of radius q nearer
 * than the highlight therefore blocks the footprint pixels
 *
 *   p - x = (o - x +- 1/2) r0 / (r0 - q)
 *
 * a square, which is drawn into a mask with the pixel's coverage: thin things cut a
 * bokeh disc exactly as they do in the renderer. Where the next pixel shows the same
 * surface their common edge has the mean of their radii: squares of different radii
 * would leave cracks (worth 0.4 dB on macro with one and with eight views, less than
 * 0.1 on three other scenes); squares of one radius and height side by side are drawn
 * as one. What is left, light times footprint times visibility, is added to the
 * finished picture: the caller has left the usual luminance of the place in the
 * ordinary samples and gives only what is above it, so no coverage has to be kept and
 * the light's energy is exact.
 *
 * With several views each footprint pixel asks the view whose place on the lens is
 * nearest to u. In view j, at u_j, everything of radius q is moved by u_j s(q), s(q) =
 * a q + b (a = 1 for the lens it was rendered for), so o becomes o - u_j s(q) above;
 * seen from the highlight's own place in that view, the cone of rays is only as wide as
 * u - a u_j is. What that view's near surfaces hide, and others show, blocks as well
 * (rf_occluders.behind).
 *
 * The light of a lamp's rim comes from farther inside it (compose/lamp_rims.h): what
 * stands before that place hides it. Where discs are bent, so are masks (bent_masks.h).
 *
 * The largest gain with several views (+3.0, +1.3 dB). Cost per highlight: the
 * occluders in its cone plus the area of its disc; blocks of pixels that know their
 * nearest radius skip the empty cones.
 */
#include "compose/highlights_add.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/fetch.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/bent_masks.h"
#include "compose/common.h"
#include "compose/footprint.h"
#include "compose/footprint_shelf.h"
#include "compose/lamp_rims.h"
#include "compose/light_list.h"
#include "compose/light_map.h"
#include "compose/lone_lights.h"
#include "compose/occluder_layers.h"
#include "compose/rims.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

enum { BAND_ROWS = 32, LENS_GRID = RF_LENS_GRID, N_UNDARKENED = 64 };

/*
 * Ours. Behind each: tPSNR in dB of scenes of tests/quality with half of it and with
 * twice (docs/notebook/thresholds.md).
 */
static const float NEARER_PX = 0.6f; /* an occluder is nearer by this much. 0; 0 */
/* Pixels of one surface differ by less. Macro -0.23; macro +0.03. */
static const float JOIN_PX = 1;
static const size_t BATCH_BYTES = 64u << 20;

/* The highlights from `first` to end - 1, which share the mask of the first. */
struct shade {
    size_t first, end;
    int left, top, width, height; /* of the mask: the box of all, from the first's px */
    float *blocked;               /* what is blocked goes; NULL: nothing is */
};

struct highlights {
    const struct rf_scene *scene;
    const struct rf_crop *out;
    struct rf_footprints *footprints;
    struct rf_footprints *of_points; /* for those that are lone */
    struct rf_lone_lights lone;
    struct rf_lamp_rims rims;
    const struct rf_samples *samples;
    struct rf_light_list list; /* of their footprints, where each place has its own */
    struct rf_light_map open;  /* where looks take light; .at NULL: they do not */
    struct shade *shades;
    size_t n_shades;
    struct rf_occluder_layers layers;
};

static size_t slot_of(const struct highlights *h, const struct rf_sample *s)
{
    if (h->list.slot)
        return h->list.slot[s - h->samples->at];
    return rf_footprint_slot(
        h->footprints, 0,
        rf_radius_index(h->footprints, rf_scene_disc_radius(h->scene, s)),
        rf_phase_of(h->footprints, s->x, s->y), RF_POSITIVE, 0);
}

static const struct rf_footprint *footprint_of(const struct highlights *h,
                                               const struct rf_sample *s)
{
    bool is_point = h->lone.are && h->lone.are[s - h->samples->at];
    const struct rf_footprints *f = is_point ? h->of_points : h->footprints;
    return rf_footprint_at(f->table, slot_of(h, s));
}

/* ---- what stands in the way ---------------------------------------------------- */

/* Distance in px from v to block b. */
static float block_gap(float v, int b)
{
    float low = (float)(b * RF_OCCLUDER_BLOCK), high = low + RF_OCCLUDER_BLOCK;
    return v < low ? low - v : v > high ? v - high : 0;
}

/* How far beside a cone of light a pixel's middle may lie that casts a shadow in it:
 * its edge, and as far as lights at rims of lamps move. */
static float reach_beside(const float inward[2])
{
    return 1 + rf_max_float(fabsf(inward[0]), fabsf(inward[1]));
}

/* Is the pixel's surface inside the cone of light from l to the view's part of the
 * lens? */
static bool is_in_cone(const struct rf_shadows *m, float dx, float dy, float q)
{
    float room = m->light_r - q;
    return room >= NEARER_PX && fabsf(dx) <= room * m->extent_x + m->beside &&
           fabsf(dy) <= room * m->extent_y + m->beside;
}

/* The blocks that lie within `reach` px of v. */
static void blocks_within(float v, float reach, int n, int *first, int *last)
{
    *first = (int)rf_max_float(floorf((v - reach) / RF_OCCLUDER_BLOCK), 0);
    *last = (int)rf_min_float(floorf((v + reach) / RF_OCCLUDER_BLOCK), (float)(n - 1));
}

static bool is_block_in_cone(const struct highlights *h,
                             const struct rf_occluder_layer *view,
                             const struct rf_shadows *m, int bx, int by)
{
    return is_in_cone(m, block_gap(m->seen_x, bx), block_gap(m->seen_y, by),
                      view->nearest[by * h->layers.n_x + bx]);
}

/* Rows ahead whose radii and shares are asked for, as rows lie far apart. */
enum { ROWS_AHEAD = 6 };

static inline __attribute__((always_inline)) void
prefetch_row(const struct rf_occluder_layer *view, int x0, int x1, int y)
{
    const struct rf_surfaces *s = view->occluders->surfaces;
    const float *radius = view->radius + view->stride * (size_t)y;
    rf_fetch(radius + x0, x1 - x0);
    if (view->share)
        rf_fetch(view->share + (size_t)s->width * (size_t)y + x0, x1 - x0);
}

/* Draws the occluders of the blocks from bx to end - 1 of a row of blocks, or asks. */
static bool cast_blocks(const struct highlights *h,
                        const struct rf_occluder_layer *view, struct rf_shadows *m,
                        int bx, int end, int by)
{
    const struct rf_surfaces *s = view->occluders->surfaces;
    const struct rf_kernels *kernels = h->scene->frame->context->kernels;
    int x1 = rf_min_int(end * RF_OCCLUDER_BLOCK, s->width);
    int y1 = rf_min_int((by + 1) * RF_OCCLUDER_BLOCK, s->height);
    bool is_found = false;
    for (int y = by * RF_OCCLUDER_BLOCK; y < y1; y++) {
        const float *row = view->radius + view->stride * (size_t)y;
        m->above = y > 0 ? row - view->stride : NULL;
        m->below = y + 1 < s->height ? row + view->stride : NULL;
        m->row = s->width;
        if (y + ROWS_AHEAD < s->height)
            prefetch_row(view, bx * RF_OCCLUDER_BLOCK, x1, y + ROWS_AHEAD);
        const float *share =
            view->share ? view->share + (size_t)s->width * (size_t)y : h->layers.whole;
        is_found |= kernels->cast_shadows(m, row, share, y, bx * RF_OCCLUDER_BLOCK, x1);
        if (is_found && !m->blocked)
            return true;
    }
    return is_found;
}

/* Draws the occluders of view j into the mask's box; without a mask only asks whether
 * there is one. */
static bool draw_occluders(const struct highlights *h, const struct rf_sample *light,
                           int j, struct rf_shadows *m)
{
    const struct rf_occluder_layer *view = &h->layers.at[j];
    const struct rf_occluders *o = view->occluders;
    float shift = o->shift_scale * light->r + o->shift_bias;
    float lx = light->x + rf_snap_px(o->lens[0] * shift);
    float ly = light->y - rf_snap_px(o->lens[1] * shift);
    float room = light->r - view->least;
    int first[2], last[2];
    if (room < NEARER_PX)
        return false;
    m->seen_x = lx;
    m->seen_y = ly;
    m->extent_x = (float)view->extent[0];
    m->extent_y = (float)view->extent[1];
    m->lens_x = o->lens[0];
    m->lens_y = o->lens[1];
    m->shift_scale = o->shift_scale;
    m->shift_bias = o->shift_bias;
    m->view = view->view;
    blocks_within(lx, room * m->extent_x + m->beside, h->layers.n_x, &first[0],
                  &last[0]);
    blocks_within(ly, room * m->extent_y + m->beside, h->layers.n_y, &first[1],
                  &last[1]);
    bool is_found = false;
    for (int by = first[1]; by <= last[1]; by++)
        for (int bx = first[0], end; bx <= last[0]; bx = end) {
            end = bx;
            while (end <= last[0] && is_block_in_cone(h, view, m, end, by))
                end++;
            if (end > bx)
                is_found |= cast_blocks(h, view, m, bx, end, by);
            end += end == bx;
            if (is_found && !m->blocked)
                return true;
        }
    return is_found;
}

static bool is_free(const struct highlights *h, const struct rf_sample *light,
                    struct rf_shadows *m)
{
    for (int j = 0; j < h->layers.n; j++)
        if (draw_occluders(h, light, j, m))
            return false;
    return true;
}

/* Cells of the lens grid that the centres of n footprint pixels look through. */
static void find_cells(float offset, float r, float extent, int n, unsigned char *cell)
{
    for (int i = 0; i < n; i++) {
        float at = (offset + (float)i) / r / extent;
        int c = (int)((at + 1) * (LENS_GRID / 2.0f));
        cell[i] = (unsigned char)rf_min_int(rf_max_int(c, 0), LENS_GRID - 1);
    }
}

/* Floats for which views a mask asks. */
static size_t views_size(int width, int height)
{
    size_t n_rows = (size_t)rf_min_int(height, LENS_GRID);
    size_t n_bytes =
        n_rows * ((size_t)width + RF_SHADOW_MARGIN) + (size_t)width + (size_t)height;
    return n_bytes / sizeof(float) + 1;
}

/* Writes which views the pixels of a mask's box ask: rows that differ, then which. */
static void find_views(const struct highlights *h, float r, struct rf_shadows *m,
                       unsigned char *at)
{
    size_t stride = (size_t)m->width + RF_SHADOW_MARGIN;
    unsigned char *rows = at + stride * (size_t)rf_min_int(m->height, LENS_GRID);
    unsigned char *columns = rows + m->height;
    m->views = at;
    m->views_row = rows;
    find_cells((float)m->left + 0.5f - m->light_x, r, (float)h->layers.lens_extent[0],
               m->width, columns);
    find_cells((float)m->top + 0.5f - m->light_y, r, (float)h->layers.lens_extent[1],
               m->height, rows);
    for (int y = 0, n = 0, last = -1; y < m->height; y++) {
        if (rows[y] != last) {
            last = rows[y];
            for (int x = 0; x < m->width; x++)
                at[stride * (size_t)n + (size_t)x] =
                    h->layers.view_at[last][columns[x]];
            n++;
        }
        rows[y] = (unsigned char)(n - 1);
    }
}

/* Of a mask, what vectors touch after it, and which views it asks, floats. */
static size_t plain_size(const struct highlights *h, const struct shade *s)
{
    return (size_t)s->width * (size_t)s->height + RF_SHADOW_MARGIN +
           (h->scene->n_views > 1 ? views_size(s->width, s->height) : 0);
}

/* Is a mask drawn otherwise than where its light falls? */
static bool is_bent(const struct highlights *h)
{
    return h->scene->frame->params.spherical != 0 || h->scene->frame->apart;
}

/* A pixel, and the box around it that a footprint covers. */
struct box {
    int x, y, min_x, max_x, min_y, max_y;
};

static struct box box_of(const struct highlights *h, const struct rf_sample *light)
{
    const struct rf_footprint *f = footprint_of(h, light);
    int x = (int)floorf(light->x), y = (int)floorf(light->y);
    struct box box = {x, y, x + f->min_dx, x + f->max_dx, y + f->min_dy, y + f->max_dy};
    if (is_bent(h)) { /* and the disc of one radius */
        float r = rf_scene_disc_radius(h->scene, light);
        int half_x = (int)ceil(fabs((double)r) * h->layers.lens_extent[0]) + 1;
        int half_y = (int)ceil(fabs((double)r) * h->layers.lens_extent[1]) + 1;
        box.min_x = rf_min_int(box.min_x, x - half_x);
        box.max_x = rf_max_int(box.max_x, x + half_x);
        box.min_y = rf_min_int(box.min_y, y - half_y);
        box.max_y = rf_max_int(box.max_y, y + half_y);
    }
    return box;
}

/* The highlights from `first` on that share a mask, which covers what all of them do.
 */
static struct shade shade_from(const struct highlights *h, size_t first)
{
    const uint32_t *leads = h->scene->highlight_leads;
    struct box all = box_of(h, &h->samples->at[first]);
    size_t end = first + 1;
    for (; leads && end < h->samples->n && leads[end] == first; end++) {
        struct box next = box_of(h, &h->samples->at[end]);
        all.min_x = rf_min_int(next.min_x, all.min_x);
        all.max_x = rf_max_int(next.max_x, all.max_x);
        all.min_y = rf_min_int(next.min_y, all.min_y);
        all.max_y = rf_max_int(next.max_y, all.max_y);
    }
    return (struct shade){.first = first,
                          .end = end,
                          .left = all.min_x - all.x,
                          .top = all.min_y - all.y,
                          .width = all.max_x - all.min_x + 1,
                          .height = all.max_y - all.min_y + 1};
}

/* ---- masks -------------------------------------------------------------------------- */

/* Writes the mask of some highlights; false where nothing stands before them. */
static bool build_mask(const struct highlights *h, const struct shade *shade)
{
    const struct rf_sample *light = &h->samples->at[shade->first];
    const float *inward = h->rims.inward[shade->first];
    int x = (int)floorf(light->x), y = (int)floorf(light->y);
    struct rf_shadows m = {.light_x = light->x - (float)x,
                           .light_y = light->y - (float)y,
                           .light_r = light->r,
                           .disc_r = rf_scene_disc_radius(h->scene, light),
                           .x = x,
                           .y = y,
                           .inward_x = inward[0],
                           .inward_y = inward[1],
                           .beside = reach_beside(inward),
                           .nearer = NEARER_PX,
                           .join = JOIN_PX,
                           .left = shade->left,
                           .top = shade->top,
                           .width = shade->width,
                           .height = shade->height};
    if (is_free(h, light, &m))
        return false;
    size_t n = (size_t)m.width * (size_t)m.height;
    m.blocked = memset(shade->blocked, 0, n * sizeof *m.blocked);
    if (h->scene->n_views > 1)
        find_views(h, m.disc_r, &m,
                   (unsigned char *)(m.blocked + n + RF_SHADOW_MARGIN));
    for (int j = 0; j < h->layers.n; j++)
        draw_occluders(h, light, j, &m);
    if (is_bent(h))
        rf_mask_bend(h->scene, &m, shade->blocked + plain_size(h, shade));
    rf_rims_darken(&h->layers, &m);
    return true;
}

/* ---- light --------------------------------------------------------------------- */

/* The share of a light that is seen where so much of it is blocked. */
static inline float seen_of(float blocked)
{
    return 1 - blocked;
}

/* Adds n weights of a light's colour, less what is blocked if not NULL, to pixels. */
static void add_to_rgba(float *out, const float colour[4], const float *weight,
                        const float *blocked, int n)
{
    const rf_quad c = *(const rf_quad *)colour;
    for (int i = 0; i < n; i++) {
        float w = weight[i], seen = blocked ? seen_of(blocked[i]) : 1;
        rf_quad *at = (rf_quad *)(out + 4 * i);
        *at += c * (rf_quad){w, w, w, w} * (rf_quad){seen, seen, seen, seen};
    }
}

/* What of a shade's mask stands before pixel (x, y) of the scene; NULL: nothing. */
static const float *blocked_at(const struct highlights *h, const struct shade *s, int x,
                               int y)
{
    const struct rf_sample *first = &h->samples->at[s->first];
    ptrdiff_t row = y - (int)floorf(first->y) - s->top;
    return s->blocked
               ? s->blocked + row * s->width + (x - (int)floorf(first->x) - s->left)
               : NULL;
}

/*
 * What a finished picture loses to cat's eyes and doors, it loses at each pixel
 * (compose/light_map.h); a lamp keeps what its own footprint keeps. So weights are
 * divided by the former here: `own` receives n of them, of pixels from (x, y) of the
 * scene on. The lens is not dark where a lamp lights it: LEAST bounds what is rounded.
 */
static const float *undarkened(const struct highlights *h, const float *weight, int x,
                               int y, int n, float *own)
{
    static const float LEAST = 1e-3f;
    rf_light_map_row(&h->open, x - h->scene->x0, y - h->scene->y0, n, own);
    for (int i = 0; i < n; i++)
        own[i] = weight[i] / rf_max_float(own[i], LEAST);
    return own;
}

/* Adds n weights of a light, less what is blocked if not NULL, from column x of the
 * crop's row y on. */
static void add_row(const struct highlights *h, const struct rf_sample *light,
                    const float *weight, const float *blocked, int x, int y, int n)
{
    const struct rf_crop *crop = h->out;
    const int first = h->scene->first_colour, end = first + h->scene->n_colours;
    float colour[4] = {0};
    float share = h->list.share ? h->list.share[light - h->samples->at] : 1;
    for (int p = first; p < end; p++)
        colour[p] = light->c[p] * light->w * share;
    if (crop->rgba)
        add_to_rgba(crop->rgba + y * crop->stride + 4 * x, colour, weight, blocked, n);
    for (int p = first; p < end; p++) {
        if (!crop->planes[p])
            continue;
        float *out = crop->planes[p] + y * crop->stride + x;
        for (int i = 0; i < n; i++)
            out[i] += colour[p] * weight[i] * (blocked ? seen_of(blocked[i]) : 1);
    }
}

/* Adds the light of the rows y0 to y1 - 1 of the scene. */
static void add_light(const struct highlights *h, const struct rf_sample *light,
                      const struct shade *shade, int y0, int y1)
{
    const struct rf_crop *crop = h->out;
    const struct rf_footprint *f = footprint_of(h, light);
    int x = (int)floorf(light->x) - crop->x, y = (int)floorf(light->y);
    const bool is_dark = h->open.at && !f->is_shut;
    for (int k = 0; k < f->n_segments; k++) {
        const struct rf_segment *g = &f->segments[k];
        int row = y + g->dy;
        if (row < y0 || row >= y1)
            continue;
        const float *weight = f->weights + g->weight;
        const float *blocked = blocked_at(h, shade, x + crop->x + g->dx, row);
        int from = rf_max_int(0, -(x + g->dx));
        int to = rf_min_int(rf_min_int(g->n, f->max_dx - g->dx + 1),
                            crop->width - x - g->dx);
        if (crop->rgba && from < to && row + 1 < y1)
            rf_fetch(crop->rgba + (row + 1 - crop->y) * crop->stride +
                         4 * (x + g->dx + from),
                     4 * (to - from));
        for (int i = from, n; i < to; i += n) {
            float own[N_UNDARKENED];
            n = is_dark ? rf_min_int(to - i, N_UNDARKENED) : to - i;
            const float *w = weight + i;
            if (is_dark)
                w = undarkened(h, w, x + crop->x + g->dx + i, row, n, own);
            add_row(h, light, w, blocked ? blocked + i : NULL, x + g->dx + i,
                    row - crop->y, n);
        }
    }
}

static void add_band(const struct highlights *h, size_t from, size_t to, int band)
{
    int y0 = rf_max_int(band * BAND_ROWS, h->out->y);
    int y1 = rf_min_int((band + 1) * BAND_ROWS, h->out->y + h->out->height);
    for (const struct shade *s = h->shades + from; s < h->shades + to; s++)
        for (size_t i = s->first; i < s->end; i++) {
            const struct rf_sample *light = &h->samples->at[i];
            const struct rf_footprint *f = footprint_of(h, light);
            int y = (int)floorf(light->y);
            if (y + f->max_dy >= y0 && y + f->min_dy < y1)
                add_light(h, light, s, y0, y1);
        }
}

/* The same, and room to bend it. */
static size_t mask_size(const struct highlights *h, const struct shade *s)
{
    return plain_size(h, s) + (is_bent(h) ? (size_t)s->width * (size_t)s->height : 0);
}

/* How many shades from `from` on fit into one batch of masks. */
static size_t batch_end(const struct highlights *h, size_t from)
{
    size_t n_bytes = 0, i = from;
    for (; i < h->n_shades && (i == from || n_bytes < BATCH_BYTES); i++)
        n_bytes += mask_size(h, &h->shades[i]) * sizeof(float);
    return i;
}

/* Shades whose masks are in memory at once. */
struct batch {
    struct highlights *h;
    size_t from, to;
};

static void build_masks(void *data, int64_t begin, int64_t end, int thread)
{
    const struct batch *batch = data;
    struct highlights *h = batch->h;
    struct rf_task *task = h->scene->task;
    for (int64_t i = begin; i < end; i++) {
        struct shade *shade = &h->shades[batch->from + (size_t)i];
        if (rf_task_is_cancelled(task) || !build_mask(h, shade))
            shade->blocked = NULL;
        rf_task_step(task);
    }
}

static void add_bands(void *data, int64_t begin, int64_t end, int thread)
{
    const struct batch *batch = data;
    struct rf_task *task = batch->h->scene->task;
    for (int64_t band = begin; band < end && !rf_task_is_cancelled(task); band++) {
        add_band(batch->h, batch->from, batch->to, (int)band);
        rf_task_step(task);
    }
}

/* Adds a batch; all masks lie in one block, as each by itself would crowd the pool. */
static rf_result run_batch(struct highlights *h, size_t from, size_t to,
                           struct rf_error *error)
{
    const struct rf_scene *scene = h->scene;
    const struct rf_context *context = scene->frame->context;
    int n_bands = (scene->height + BAND_ROWS - 1) / BAND_ROWS;
    size_t n = 0;
    for (size_t i = from; i < to; i++)
        n += mask_size(h, &h->shades[i]);
    float *memory = rf_alloc(context, n, sizeof *memory);
    if (!memory)
        return rf_fail_memory(error, n, sizeof *memory);
    n = 0;
    for (size_t i = from; i < to; i++) {
        h->shades[i].blocked = memory + n;
        n += mask_size(h, &h->shades[i]);
    }
    struct batch batch = {h, from, to};
    rf_parallel(context, (int64_t)(to - from), 4, build_masks, &batch);
    rf_parallel(context, n_bands, 1, add_bands, &batch);
    rf_free(context, memory);
    return RF_OK;
}

/* Builds the footprints of the lone highlights, or of the others. */
static rf_result build_footprints(struct highlights *h, struct rf_footprints *f,
                                  double progress_to, struct rf_error *error)
{
    const struct rf_context *context = h->scene->frame->context;
    const unsigned char *are_lone = h->lone.are;
    size_t n_slots = rf_footprint_count(f);
    unsigned char *needed = rf_calloc(context, n_slots, 1);
    if (!needed)
        return rf_fail_memory(error, n_slots, 1);
    for (size_t i = 0; i < h->samples->n; i++)
        if ((are_lone && are_lone[i]) == (f == h->of_points))
            needed[slot_of(h, &h->samples->at[i])] = 1;
    rf_result result =
        rf_footprints_build(f, needed, h->scene->task, progress_to, error);
    rf_free(context, needed);
    return result;
}

/* What stands before lights is the same in all colours: the first one builds it. */
static rf_result build_layers(struct highlights *h, struct rf_error *error)
{
    struct rf_common *common = h->scene->common;
    if (common && common->layers.at) {
        h->layers = common->layers;
        h->layers.scene = h->scene;
        return RF_OK;
    }
    rf_result result = rf_occluder_layers_build(&h->layers, error);
    if (common)
        common->layers = h->layers;
    return result;
}

static rf_result run(struct highlights *h, struct rf_error *error)
{
    struct rf_task *task = h->scene->task;
    double progress_to = h->scene->progress_to;
    rf_result result = build_layers(h, error);
    rf_task_poll(task);
    double built_at = task->to + 0.2 * (progress_to - task->to);
    if (result == RF_OK && h->lone.are)
        result = build_footprints(h, h->of_points, (task->to + built_at) / 2, error);
    if (result == RF_OK)
        result = build_footprints(h, h->footprints, built_at, error);
    if (result != RF_OK || rf_task_is_cancelled(task))
        return result;
    for (size_t from = 0; from < h->samples->n; from = h->shades[h->n_shades++].end)
        h->shades[h->n_shades] = shade_from(h, from);
    int64_t n_steps = (int64_t)h->n_shades;
    for (size_t from = 0; from < h->n_shades; from = batch_end(h, from))
        n_steps += (h->scene->height + BAND_ROWS - 1) / BAND_ROWS;
    rf_task_phase(task, progress_to, n_steps);
    for (size_t from = 0, to; from < h->n_shades && result == RF_OK; from = to) {
        to = batch_end(h, from);
        result = run_batch(h, from, to, error);
    }
    return result;
}

rf_result rf_add_highlights(const struct rf_scene *scene, const struct rf_crop *out,
                            struct rf_error *error)
{
    const struct rf_samples *samples = &scene->highlights;
    if (samples->n == 0)
        return RF_OK;
    const struct rf_context *context = scene->frame->context;
    const struct rf_shape *shape = &scene->frame->shape;
    struct highlights h = {.scene = scene, .out = out, .samples = samples};
    struct rf_occluder_layers *layers = &h.layers;
    layers->scene = scene;
    layers->n_x = (scene->width + RF_OCCLUDER_BLOCK - 1) / RF_OCCLUDER_BLOCK;
    layers->n_y = (scene->height + RF_OCCLUDER_BLOCK - 1) / RF_OCCLUDER_BLOCK;
    layers->stride = (size_t)layers->n_x * RF_OCCLUDER_BLOCK;
    rf_shape_extent(shape, layers->lens_extent);
    float most = 0;
    for (size_t i = 0; i < samples->n; i++)
        most = rf_max_float(most, fabsf(rf_scene_disc_radius(scene, &samples->at[i])));
    struct rf_footprints own = {.table = NULL}, own_of_points = own;
    struct rf_footprint_use use = {.shape = shape,
                                   .look = rf_field_look(scene->frame),
                                   .bokeh = rf_frame_bokeh(scene->frame),
                                   .bokeh_plane = rf_frame_bokeh_plane(scene->frame),
                                   .obstruction = rf_frame_obstruction(scene->frame),
                                   .spherical = scene->frame->params.spherical,
                                   .is_boundless = scene->frame->params.spherical != 0,
                                   .n_cells = 1,
                                   .max_radius = most,
                                   .n_phases = scene->n_phases};
    h.footprints = &own;
    h.of_points = &own_of_points;
    rf_result result = rf_light_list_make(&h.list, scene, &use, error);
    if (result == RF_OK)
        result = rf_footprints_get(&h.footprints, &own, context, &use, error);
    if (result == RF_OK)
        result = rf_lone_lights_find(&h.lone, scene, error);
    if (result == RF_OK)
        result = rf_lamp_rims_find(&h.rims, scene, error);
    if (result == RF_OK && rf_look_is_dark(&use.look))
        result =
            rf_light_map_make(&h.open, scene->frame, shape, use.bokeh_plane, error);
    use.is_of_points = true;
    if (result == RF_OK && h.lone.are)
        result = rf_footprints_get(&h.of_points, &own_of_points, context, &use, error);
    h.shades = rf_alloc(context, samples->n, sizeof *h.shades);
    if (result == RF_OK && !h.shades)
        result = rf_fail_memory(error, samples->n, sizeof *h.shades);
    if (result == RF_OK)
        result = run(&h, error);
    if (!scene->common)
        rf_occluder_layers_free(layers, context);
    rf_free(context, h.shades);
    rf_footprints_put(h.footprints, &own);
    rf_footprints_put(h.of_points, &own_of_points);
    rf_lone_lights_free(&h.lone, context);
    rf_lamp_rims_free(&h.rims, context);
    rf_light_list_free(&h.list, context);
    rf_light_map_free(&h.open, context);
    return result;
}
