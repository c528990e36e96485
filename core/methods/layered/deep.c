/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Deep frames: the samples that the renderer kept per pixel, hidden ones included,
 * spread by the compositor of the method layered.
 *
 * The compositor takes a saturating sum near to far (composite.c): weights that add up
 * to more than 1 fill what is left and no more. A deep pixel composites with "over",
 * so a sample of opacity a gets the weight
 *
 *   v = 1                                 opaque (a >= 0.999): fills whatever is left,
 *                                         also where the lens sees round what hides it
 *   v = a prod (1 - a_j)                  else, over the nearer samples j of its pixel
 *                                         that are not opaque
 *
 * Where nothing moves apart the sum of min(v, what is left) is "over" exactly, for any
 * stack of panes, volumes and a surface behind them; behind an opaque sample the stack
 * goes on as if that were not there, ready to be seen past its edge. What is left of a
 * pixel without an opaque end is an empty sample at infinity with weight 1, without
 * colour and alpha, so that the alpha of the result is right.
 *
 * - colour of a piece: premultiplied colour / a, alpha / a; a holdout has neither
 * - volume from z0 to z1: cut into n slices of equal thickness, each a' = 1 - (1 -
 *   a)^(1/n), colour times a'/a (as "Interpreting OpenEXR Deep Pixels" has it)
 * - a sample of opacity 0 with a colour: light without coverage, times the product
 *
 * Ours. Approximates: a transparent piece keeps the attenuation that it has in the
 * pinhole view where the lens sees past the things before it; surfaces without slope.
 * Behind pixels that end opaque the background is estimated as in layered (hidden.c),
 * and used where no sample fills. Memory: 40 bytes per sample or slice.
 */
#include "methods/layered/deep.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/system_threads.h"
#include "base/task.h"
#include "compose/composite.h"
#include "compose/emit.h"
#include "compose/footprint.h"
#include "compose/scene.h"
#include "input/depth.h"
#include "input/frame.h"
#include "input/image.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "methods/layered/deep_pieces.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/* ---- the flat picture ---------------------------------------------------------- */

/* The number that says "nothing was hit" in the depth channel. */
static float no_hit_value(const struct rf_params *p)
{
    double v;
    switch (p->depth) {
    case RF_DEPTH_PLANAR:
    case RF_DEPTH_RADIAL:
        return INFINITY;
    case RF_DEPTH_BUFFER:
    case RF_DEPTH_BUFFER_INFINITE:
    case RF_DEPTH_NORMALISED:
        v = 1;
        break;
    default:
        v = 0;
    }
    return p->depth_scale != 0 ? (float)((v - p->depth_offset) / p->depth_scale) : 0;
}

struct flat {
    float c[4];
    float value, r; /* depth as in the channel, and radius */
};

static struct flat flatten(const struct rf_deep_work *d,
                           const struct rf_deep_piece *pieces, int n)
{
    struct flat flat = {{0}, no_hit_value(&d->frame->params), d->empty_radius};
    float left = 1;
    bool is_found = false;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 4; k++)
            flat.c[k] += left * pieces[i].c[k];
        if (pieces[i].a > 0 && !is_found) {
            flat.value = pieces[i].value;
            flat.r = pieces[i].r;
        }
        left *= 1 - pieces[i].a;
        is_found |= left <= 0.5f;
    }
    return flat;
}

static rf_result allocate_scratch(struct rf_deep_work *d, struct rf_error *error)
{
    const struct rf_context *context = d->frame->context;
    size_t n = (d->most_samples * RF_DEEP_SLICES + 1) * (size_t)context->n_threads;
    d->scratch = rf_alloc(context, n, sizeof *d->scratch);
    return d->scratch ? RF_OK : rf_fail_memory(error, n, sizeof *d->scratch);
}

/* What the threads share that flatten pixels. */
struct flattening {
    struct rf_deep_work *d;
    bool lock; /* of the largest radius, without sign, of any sample */
    float largest;
};

static void flatten_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct flattening *f = data;
    struct rf_deep_work *d = f->d;
    const struct rf_deep *deep = d->deep;
    struct rf_deep_piece *pieces = rf_deep_scratch(d, thread);
    float largest = 0;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < deep->width; x++) {
            size_t i = (size_t)y * (size_t)deep->width + (size_t)x;
            int n = rf_deep_pieces_of(d, x, y, pieces);
            struct flat flat = flatten(d, pieces, n);
            for (int k = 0; k < d->n_planes; k++)
                d->planes[k][i] = flat.c[k];
            d->radius[i] = flat.r;
            for (int k = 0; k < n; k++)
                largest = fmaxf(largest, fabsf(pieces[k].r));
            bool is_open = n == 0 || pieces[n - 1].a < RF_OPAQUE_ALPHA;
            if (is_open && n > 0)
                largest = fmaxf(largest, fabsf(d->empty_radius));
        }
    rf_spin_lock(&f->lock);
    f->largest = fmaxf(f->largest, largest);
    rf_spin_unlock(&f->lock);
}

/* Fills planes and radius; returns the largest radius, without sign, of any sample. */
static float flatten_all(struct rf_deep_work *d)
{
    struct flattening f = {.d = d};
    rf_parallel(d->frame->context, d->deep->height, 8, flatten_rows, &f);
    return f.largest;
}

/* ---- samples ------------------------------------------------------------------- */

struct collector {
    struct rf_deep_work *d;
    struct rf_samples out;
};

static struct rf_sample sample_of(const struct rf_deep_piece *p, float left, int x,
                                  int y)
{
    struct rf_surface s = {.r = p->r};
    if (p->a <= 0) {
        for (int n = 0; n < 3; n++)
            s.c[n] = p->c[n] * left;
        struct rf_sample light = rf_sample_make(&s, x, y, 1);
        light.kind = RF_POSITIVE;
        return light;
    }
    for (int n = 0; n < 4; n++)
        s.c[n] = p->c[n] / p->a;
    return rf_sample_make(&s, x, y, p->a >= RF_OPAQUE_ALPHA ? 1 : p->a * left);
}

/* Whose samples a pixel of the picture has: beyond the border those beside it. */
struct source {
    int x, y;
    bool is_beyond;
};

static struct source source_of(const struct rf_deep_work *d, int x, int y)
{
    int border = d->picture.border;
    bool is_inside = x >= border && x < border + d->deep->width && y >= border &&
                     y < border + d->deep->height;
    size_t width = (size_t)d->picture.width, i = (size_t)y * width + (size_t)x;
    if (!is_inside)
        i = d->picture.pixels.source[i];
    return (struct source){(int)(i % width) - border, (int)(i / width) - border,
                           !is_inside};
}

/*
 * Is it continued as flat pictures are (border.c), of which it has the surface? So are
 * pixels of one opaque sample.
 */
static bool is_continued(const struct source *source,
                         const struct rf_deep_piece *pieces, int n)
{
    return source->is_beyond && n == 1 && pieces[0].a >= RF_OPAQUE_ALPHA;
}

static float flat_luminance(const struct rf_deep_work *d, int x, int y)
{
    const struct rf_pixels *p = &d->picture.pixels;
    return rf_plane_row(p, p->luminance, y)[x];
}

/*
 * Beyond the border go the samples beside it, dimmed as the flat picture is there: a lamp
 * that is cut by the border is no bar of light. Half as bright is still its texture.
 */
static float dimming(const struct rf_deep_work *d, const struct source *source, int x,
                     int y)
{
    int border = d->picture.border;
    float beside = flat_luminance(d, source->x + border, source->y + border);
    float beyond = 2 * flat_luminance(d, x, y);
    return beyond < beside && beside > 0 ? fmaxf(beyond, 0) / beside : 1;
}

static void collect_pixel(struct collector *c, int x, int y,
                          struct rf_deep_piece *pieces)
{
    struct rf_deep_work *d = c->d;
    struct source source = source_of(d, x, y);
    int n = rf_deep_pieces_of(d, source.x, source.y, pieces);
    bool is_open = true;
    float left = 1;
    if (is_continued(&source, pieces, n)) {
        const struct rf_surfaces *all = &d->picture.surfaces;
        size_t i = (size_t)y * (size_t)all->width + (size_t)x;
        rf_picture_emit(&d->picture, rf_sample_make(&all->near[i], x, y, 1), x, y,
                        &c->out);
        return;
    }
    float factor = source.is_beyond ? dimming(d, &source, x, y) : 1;
    for (int i = 0; i < n; i++) {
        const struct rf_deep_piece *p = &pieces[i];
        struct rf_sample s = sample_of(p, left, x, y);
        for (int k = 0; k < 3; k++)
            s.c[k] *= factor;
        if (s.kind == RF_POSITIVE)
            rf_samples_put(&c->out, &s);
        else if (s.w > 0)
            rf_picture_emit(&d->picture, s, x, y, &c->out);
        if (p->a < RF_OPAQUE_ALPHA)
            left *= 1 - p->a;
        is_open = p->a < RF_OPAQUE_ALPHA;
    }
    if (is_open) {
        struct rf_surface nothing = {.r = d->empty_radius};
        struct rf_sample s = rf_sample_make(&nothing, x, y, 1);
        rf_samples_put(&c->out, &s);
    }
}

/* What the threads share that collect samples. */
struct collecting {
    struct rf_deep_work *d;
    struct rf_task *task;
    bool is_counted; /* how many each row has */
};

static void collect_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct collecting *all = data;
    struct rf_deep_work *d = all->d;
    for (int y = (int)begin; y < (int)end && !rf_task_is_cancelled(all->task); y++) {
        struct collector c = {.d = d};
        if (all->is_counted)
            c.out.at = d->samples.at + d->row_start[y];
        for (int x = 0; x < d->picture.width; x++)
            collect_pixel(&c, x, y, rf_deep_scratch(d, thread));
        if (!all->is_counted)
            d->row_start[y + 1] = c.out.n;
        rf_task_step(all->task);
    }
}

static rf_result collect_samples(struct rf_deep_work *d, struct rf_task *task,
                                 struct rf_error *error)
{
    const struct rf_context *context = d->frame->context;
    int height = d->picture.height;
    d->row_start = rf_alloc(context, (size_t)height + 1, sizeof *d->row_start);
    if (!d->row_start)
        return rf_fail_memory(error, (size_t)height + 1, sizeof *d->row_start);
    for (int pass = 0; pass < 2; pass++) {
        rf_task_phase(task, pass ? 0.5 : 0.45, height);
        struct collecting c = {d, task, pass > 0};
        rf_parallel(context, height, 8, collect_rows, &c);
        if (pass || rf_task_is_cancelled(task))
            break;
        d->row_start[0] = 0;
        for (int y = 0; y < height; y++)
            d->row_start[y + 1] += d->row_start[y];
        d->samples.n = d->row_start[height];
        d->samples.at = rf_alloc(context, d->samples.n, sizeof *d->samples.at);
        if (!d->samples.at)
            return rf_fail_memory(error, d->samples.n, sizeof *d->samples.at);
    }
    return RF_OK;
}

/* ---- behind opaque pixels ------------------------------------------------------ */

/* A pixel of the picture, and the thread that looks at it. */
struct pixel {
    int x, y, thread;
    size_t i;
};

/* The nearest and the next sample of a pixel; returns the share of the nearest. */
static float find_parts(struct rf_deep_work *d, struct pixel at,
                        struct rf_surface found[2])
{
    struct rf_deep_piece *pieces = rf_deep_scratch(d, at.thread);
    struct source source = source_of(d, at.x, at.y);
    int n = rf_deep_pieces_of(d, source.x, source.y, pieces);
    float share = 1;
    int n_found = 0;
    found[0] = found[1] = (struct rf_surface){.r = d->empty_radius};
    if (is_continued(&source, pieces, n)) {
        found[0] = d->picture.surfaces.near[at.i];
        return 1;
    }
    for (int i = 0; i < n && n_found < 2; i++) {
        if (pieces[i].a <= 0)
            continue;
        for (int k = 0; k < 4; k++)
            found[n_found].c[k] = pieces[i].c[k] / pieces[i].a;
        found[n_found].r = pieces[i].r;
        if (n_found++ == 0)
            share = pieces[i].a >= RF_OPAQUE_ALPHA ? 1 : pieces[i].a;
    }
    return share;
}

/* Notes the nearest sample of a pixel and whether there is a farther part. */
static void set_nearest(struct rf_deep_work *d, struct pixel at)
{
    struct rf_surfaces *s = &d->picture.surfaces;
    struct rf_surface found[2];
    s->share[at.i] = find_parts(d, at, found);
    s->near[at.i] = found[0];
    if (s->share[at.i] < 1)
        rf_far_mark(s, at.i);
}

static void set_next(struct rf_deep_work *d, struct pixel at)
{
    struct rf_surfaces *s = &d->picture.surfaces;
    struct rf_surface found[2];
    if (s->share[at.i] == 1)
        return;
    find_parts(d, at, found);
    *rf_far_at(s, at.i) = found[1];
}

/* What the threads share that visit pixels. */
struct visiting {
    struct rf_deep_work *d;
    void (*visit)(struct rf_deep_work *d, struct pixel at);
};

static void visit_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct visiting *v = data;
    int width = v->d->picture.surfaces.width;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < width; x++)
            v->visit(v->d, (struct pixel){x, y, thread,
                                          (size_t)y * (size_t)width + (size_t)x});
}

static void visit_pixels(struct rf_deep_work *d,
                         void (*visit)(struct rf_deep_work *d, struct pixel at))
{
    struct visiting v = {d, visit};
    rf_parallel(d->frame->context, d->picture.surfaces.height, 8, visit_rows, &v);
}

/* The pixels' nearest and next samples take the place of split edges. */
static rf_result set_surfaces(struct rf_deep_work *d, struct rf_error *error)
{
    const struct rf_context *context = d->frame->context;
    struct rf_surfaces *s = &d->picture.surfaces;
    rf_far_free(s, context);
    rf_result result = rf_far_begin(s, context, error);
    if (result != RF_OK)
        return result;
    visit_pixels(d, set_nearest);
    result = rf_far_allocate(s, context, error);
    if (result == RF_OK)
        visit_pixels(d, set_next);
    return result;
}

static rf_result find_hidden(struct rf_deep_work *d, struct rf_task *task,
                             struct rf_error *error)
{
    rf_result result = set_surfaces(d, error);
    if (result != RF_OK)
        return result;
    rf_task_phase(task, 0.4, rf_hidden_steps(d->picture.height));
    return rf_find_hidden(d->frame, &d->picture.surfaces, NULL, NULL, &d->hidden, task,
                          error);
}

/* The estimates as samples; the array has room for one per pixel. */
static void collect_hidden(const struct rf_deep_work *d, struct rf_samples *out)
{
    const struct rf_surface *at = d->hidden.at;
    for (int y = 0; y < d->picture.height; y++)
        for (int x = 0; x < d->picture.width; x++, at++)
            if (rf_found_at(&d->hidden, x, y, 1))
                out->at[out->n++] = rf_sample_make(at, x, y, 1);
}

/* The radii of pixels that one sample covers, INFINITY elsewhere; NULL: no memory. */
static float *find_whole(const struct rf_deep_work *d)
{
    size_t width = (size_t)d->picture.width, n = width * (size_t)d->picture.height;
    float *radius = rf_alloc(d->frame->context, n, sizeof *radius);
    for (size_t i = 0; radius && i < n; i++)
        radius[i] = INFINITY;
    for (size_t i = 0; radius && i < d->samples.n; i++) {
        const struct rf_sample *p = &d->samples.at[i];
        if (p->kind == RF_SHARP && p->w >= 1)
            radius[width * (size_t)p->y + (size_t)p->x] = p->r;
    }
    return radius;
}

/* ---- all ----------------------------------------------------------------------- */

static rf_result composite(struct rf_deep_work *d, struct rf_work *work,
                           struct rf_error *error)
{
    const struct rf_context *context = d->frame->context;
    struct rf_samples hidden = {0};
    size_t n = (size_t)d->picture.width * (size_t)d->picture.height;
    if (d->hidden.at) {
        hidden.at = rf_alloc(context, n, sizeof *hidden.at);
        if (!hidden.at)
            return rf_fail_memory(error, n, sizeof *hidden.at);
        collect_hidden(d, &hidden);
    }
    float *whole = find_whole(d);
    if (!whole) {
        rf_free(context, hidden.at);
        return rf_fail_memory(error, n, sizeof *whole);
    }
    struct rf_occluders occluders = {.surfaces = &d->picture.surfaces};
    struct rf_scene scene = {.frame = d->frame,
                             .width = d->picture.width,
                             .height = d->picture.height,
                             .x0 = d->picture.x0,
                             .y0 = d->picture.y0,
                             .n_phases = 1,
                             .fills_gaps = d->frame->params.fill_hidden,
                             .visible = d->samples,
                             .hidden = hidden,
                             .occluders = &occluders,
                             .n_views = 1,
                             .whole_radius =
                                 d->frame->params.fill_hidden ? whole : NULL,
                             .whole_stride = (size_t)d->picture.width,
                             .whole_from = {1, 1},
                             .whole_to = {d->picture.width - 1, d->picture.height - 1},
                             .task = work->task,
                             .progress_to = 1};
    memcpy(scene.least, d->picture.least, sizeof scene.least);
    rf_result result = rf_composite_crop(&scene, work, error);
    rf_free(context, whole);
    rf_free(context, hidden.at);
    return result;
}

static rf_result run(struct rf_deep_work *d, struct rf_work *work,
                     const struct rf_image *out, struct rf_error *error)
{
    const struct rf_frame *f = d->frame;
    work->largest_radius = flatten_all(d);
    if (rf_frame_is_sharp(f, work->largest_radius)) {
        rf_frame_store(f->context, &f->params, d->planes, (size_t)f->width, out);
        return RF_OK;
    }
    struct rf_work_view view = {.radius = d->radius};
    memcpy(view.colour, d->planes, sizeof view.colour);
    struct rf_frame whole = *f; /* edges come as samples */
    whole.params.split_edges = 0;
    int border = rf_picture_border(work->largest_radius);
    rf_task_phase(work->task, 0.15, f->height + 2 * border);
    rf_result result = rf_picture_load(&d->picture, &whole, &view, d->n_planes, border,
                                       RF_KEPT_SOURCES, work->task, error);
    if (result == RF_OK && f->params.fill_hidden && !rf_task_is_cancelled(work->task))
        result = find_hidden(d, work->task, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = collect_samples(d, work->task, error);
    rf_picture_drop_pixels(&d->picture);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = composite(d, work, error);
    if (result == RF_OK && rf_task_is_cancelled(work->task))
        result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    if (result == RF_OK)
        rf_frame_store(f->context, &f->params, work->colour, (size_t)f->width, out);
    d->picture.frame = f;
    rf_picture_free(&d->picture);
    return result;
}

/* Checks, and takes the memory that flattening needs. */
static rf_result begin(struct rf_deep_work *d, struct rf_error *error)
{
    const struct rf_frame *f = d->frame;
    d->empty_radius = (float)rf_lens_radius_px(&f->lens, INFINITY);
    rf_result result = rf_deep_check(d, error);
    if (result == RF_OK)
        result = allocate_scratch(d, error);
    if (result != RF_OK)
        return result;
    size_t n = (size_t)f->width * (size_t)f->height;
    d->radius = rf_alloc(f->context, n * (size_t)(d->n_planes + 1), sizeof(float));
    if (!d->radius)
        return rf_fail_memory(error, n * (size_t)(d->n_planes + 1), sizeof(float));
    for (int k = 0; k < d->n_planes; k++)
        d->planes[k] = d->radius + n * (size_t)(k + 1);
    return RF_OK;
}

static void end(struct rf_deep_work *d)
{
    const struct rf_context *context = d->frame->context;
    rf_free(context, d->samples.at);
    rf_free(context, d->row_start);
    rf_estimates_free(&d->hidden, context);
    rf_free(context, d->radius);
    rf_free(context, d->scratch);
}

rf_result rf_deep_run(const struct rf_frame *frame, const struct rf_deep *deep,
                      const struct rf_image *out, struct rf_task *task,
                      struct rf_error *error)
{
    struct rf_deep_work d = {.frame = frame, .deep = deep, .n_planes = out->channels};
    struct rf_work work = {
        .frame = frame, .n_planes = d.n_planes, .n_views = 1, .task = task};
    rf_result result = begin(&d, error);
    if (result == RF_OK) {
        memcpy(work.colour, d.planes, sizeof work.colour);
        result = run(&d, &work, out, error);
    }
    end(&d);
    return result;
}

rf_result rf_deep_flatten_to(const struct rf_frame *frame, const struct rf_deep *deep,
                             const struct rf_image *colour,
                             const struct rf_image *depth, struct rf_error *error)
{
    /* Light is flattened as it is, whatever a lens would make of it. */
    struct rf_frame linear = *frame;
    linear.params.blend_gamma = 1;
    linear.params.highlight_clamp = 0;
    linear.params.highlight_gain = linear.params.highlight_saturation = 1;
    struct rf_deep_work d = {
        .frame = &linear, .deep = deep, .n_planes = colour->channels};
    rf_result result = begin(&d, error);
    for (int y = 0; y < frame->height && result == RF_OK; y++)
        for (int x = 0; x < frame->width; x++) {
            int n = rf_deep_pieces_of(&d, x, y, d.scratch);
            struct flat flat = flatten(&d, d.scratch, n);
            for (int k = 0; k < d.n_planes; k++)
                *(float *)rf_image_at(colour, x, y, k) = flat.c[k];
            if (depth)
                *(float *)rf_image_at(depth, x, y, 0) = flat.value;
        }
    end(&d);
    return result;
}
