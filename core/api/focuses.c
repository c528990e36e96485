/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A split diopter. The pixel that is lit has the focus, not the one that its light
 * comes from: what lies beside the border is blurred by one radius on one side of it
 * and by another on the other. With S(P) the share of the diopter at the pixel P and
 * B_s the picture whose focus is that of the share s everywhere,
 *
 *   out(P) = B_S(P)(P)   ~   sum over i of max(0, 1 - |n S(P) - i|) B_(i / n)(P)
 *
 * Ours; exact where the border is hard, with two pictures, each of its own side. A soft
 * one needs those between, of the stripe that they are for. Of each picture no more is
 * made than its pixels can see; a picture of several views moves its views for its own
 * focus. Cost: what the pictures' parts cost (docs/looks.md).
 */
#include "api/focuses.h"

#include <math.h>
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
#include "input/depth.h"
#include "input/diopter.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/image.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "methods/methods.h"
#include "rackfocus/rackfocus.h"

/*
 * Steps of a soft border: what the radius changes by in one of them, how wide it is,
 * and how many there are. The scene of tests/quality/test_looks.py, a change of 16 px
 * within 27 px: 35.2 dB of 2 steps, 36.1 of 3, 36.3 of 4, 36.6 of 5, 36.7 of 6, 36.8 of
 * 8 and of 24 (docs/notebook/looks.md).
 */
static const double STEP_PX = 3, STEP_WIDTH_PX = 2;
enum { MOST_STEPS = 5 };

/*
 * What the pixels of a part of a picture see beyond it: in radii, the light that reaches
 * them; in px, what surfaces look at: 32 px fail halves_of_a_split_diopter
 * (tests/physics/test_split_diopter.c). Twice the radii are no nearer to pictures made
 * whole: 57.7 dB instead of 57.9 at 1920 x 1080 (docs/notebook/looks.md).
 */
enum { REACH_RADII = 1, REACH_PX = 64 };

/* Parts begin on the grid of the coarse levels' pixels, so that these average alike. */
enum { GRID_PX = 32 };

/* The pictures of one focus. */
struct focuses {
    const struct rf_frame *frame;
    struct rf_diopter diopter;
    const struct rf_view *views;
    int n_views, n_steps;
    double range[2];          /* radii of the views where the share is 0 */
    double moved;             /* how far views are moved, px */
    struct rf_image sum;      /* the picture: the caller's, or room of our own */
    float *made;              /* room for a part */
    struct rf_image made_out; /* the part that was made */
    int step, x, y;           /* whose it is, and where */
    bool is_begun;            /* is anything in `sum`? The first part is made there */
    double from, to;          /* beyond the line: where that picture has a weight */
};

bool rf_focuses_are_on(const struct rf_frame *frame)
{
    static const double LEAST_PX = 1.0 / 64;
    const struct rf_method_info *method = rf_method_find(frame->params.method);
    bool is_preview = method->has_layers && frame->params.quality == RF_QUALITY_PREVIEW;
    return (method->has_layers || frame->params.method == RF_METHOD_SCATTER) &&
           !is_preview && fabs(rf_diopter_of(frame).px) >= LEAST_PX;
}

static int steps_of(const struct rf_diopter *d)
{
    double soft_px = d->softness * d->places.half_px;
    double n = fmin(fabs(d->px) / STEP_PX, soft_px / STEP_WIDTH_PX);
    return (int)fmin(fmax(ceil(n), 1), MOST_STEPS);
}

/*
 * The weight of this step's picture at a pixel; of all steps they sum up to 1. Sets
 * *is_first where no step before it has one there.
 */
static float weight_at(const struct focuses *s, int x, int y, bool *is_first)
{
    double at = rf_diopter_share(&s->diopter, x, y) * s->n_steps;
    int below = rf_min_int((int)at, s->n_steps - 1);
    float above = (float)(at - below);
    *is_first = s->step == below || above >= 1;
    return s->step == below ? 1 - above : s->step == below + 1 ? above : 0;
}

/* How far a view of radii up to `largest` is moved, px. */
static double move_of(const struct focuses *s, const struct rf_view *view,
                      double largest)
{
    struct rf_work_view w;
    if (s->n_views == 1)
        return 0;
    rf_work_view_place(&w, view->lens_offset, view->shear_distance, &s->frame->lens,
                       s->frame->params.pixel_aspect);
    double px = fabs(w.shift_scale) * (largest + fabs(s->diopter.px));
    return rf_length(w.lens[0], w.lens[1]) * (px + fabs(w.shift_bias));
}

/* Widens a range so that n radii lie within it. */
static void widen_range(double range[2], const float *radius, size_t n)
{
    enum { LANES = 16 }; /* one chain of comparisons would wait for each */
    float least[LANES], most[LANES];
    for (int k = 0; k < LANES; k++) {
        least[k] = INFINITY;
        most[k] = -INFINITY;
    }
    for (size_t i = 0; i + LANES <= n; i += LANES)
        for (size_t k = 0; k < LANES; k++) {
            least[k] = rf_min_float(radius[i + k], least[k]);
            most[k] = rf_max_float(radius[i + k], most[k]);
        }
    for (size_t i = n - n % LANES; i < n; i++) {
        least[0] = rf_min_float(radius[i], least[0]);
        most[0] = rf_max_float(radius[i], most[0]);
    }
    for (int k = 0; k < LANES; k++) {
        range[0] = fmin(range[0], (double)least[k]);
        range[1] = fmax(range[1], (double)most[k]);
    }
}

/* Finds `range` and `moved`, in room for the radii of a view. */
static rf_result find_range(struct focuses *s, float *radius, struct rf_error *error)
{
    struct rf_frame f = *s->frame;
    f.params.split_diopter = 0;
    f.lens.max_radius_px = INFINITY;
    float largest;
    s->range[0] = INFINITY;
    s->range[1] = -INFINITY;
    for (int j = 0; j < s->n_views; j++) {
        rf_result result = rf_depth_to_radius(&f, &s->views[j].depth, radius, NULL,
                                              NULL, &largest, error);
        if (result != RF_OK)
            return result;
        rf_field_apply(&f, radius, &largest);
        widen_range(s->range, radius, (size_t)f.width * (size_t)f.height);
        s->moved = fmax(s->moved, move_of(s, &s->views[j], largest));
    }
    return RF_OK;
}

/* How far the pixels of this step's picture see. */
static int reach_of(const struct focuses *s)
{
    const struct rf_frame *f = s->frame;
    const struct rf_look look = rf_frame_look(f);
    double extent[2], shift = s->diopter.px * s->step / s->n_steps;
    double radius = fmax(fabs(s->range[0] + shift), fabs(s->range[1] + shift));
    rf_shape_extent(&f->shape, extent);
    radius = fmin(radius, f->lens.max_radius_px) * fmax(fmax(extent[0], extent[1]), 1) *
             rf_look_growth(&look);
    double beyond = f->shape.glow_px + fabs(f->params.axial_chroma);
    double px = REACH_RADII * (radius + beyond) + 2 * s->moved + REACH_PX;
    return (int)fmin(ceil(px), f->width + f->height);
}

/* Sets the step, and where its picture has a weight. */
static void begin_step(struct focuses *s, int step)
{
    const struct rf_diopter *d = &s->diopter;
    s->step = step;
    s->from = rf_diopter_beyond(d, (step - 1.0) / s->n_steps);
    s->to = rf_diopter_beyond(d, (step + 1.0) / s->n_steps);
    if (step == 0)
        s->from = -INFINITY;
    if (step == s->n_steps)
        s->to = INFINITY;
}

/* The part of the picture that the picture of this step is for; may be empty. */
static struct rf_window part_of(const struct focuses *s)
{
    const struct rf_frame *f = s->frame;
    int x0 = f->width, x1 = 0, y0 = f->height, y1 = 0;
    for (int y = 0; y < f->height; y++) {
        int span[2];
        rf_diopter_span(&s->diopter, s->from, s->to, y, f->width, span);
        if (span[0] >= span[1])
            continue;
        x0 = rf_min_int(x0, span[0]);
        x1 = rf_max_int(x1, span[1]);
        y0 = rf_min_int(y0, y);
        y1 = y + 1;
    }
    return (struct rf_window){x0, y0, x1 - x0, y1 - y0};
}

static struct rf_window grown(const struct rf_window *part, int px,
                              const struct rf_frame *f)
{
    int x0 = rf_max_int(part->x - px, 0) / GRID_PX * GRID_PX;
    int y0 = rf_max_int(part->y - px, 0) / GRID_PX * GRID_PX;
    int x1 = rf_min_int(part->x + part->width + px, f->width);
    int y1 = rf_min_int(part->y + part->height + px, f->height);
    return (struct rf_window){x0, y0, x1 - x0, y1 - y0};
}

static struct rf_image image_part(const struct rf_image *image,
                                  const struct rf_window *part)
{
    struct rf_image of = *image;
    if (!image->data)
        return of;
    of.data = (void *)rf_image_at(image, part->x, part->y, 0);
    of.width = part->width;
    of.height = part->height;
    return of;
}

static bool is_packed_row(const struct rf_image *row)
{
    return row->channel_bytes == sizeof(float) &&
           row->pixel_bytes == row->channels * (ptrdiff_t)sizeof(float);
}

/* Adds the columns from x0 to x1 - 1 of a row within the soft border. */
static void add_soft(const struct focuses *s, int y, int x0, int x1)
{
    for (int x = x0; x < x1; x++) {
        bool is_first;
        float weight = weight_at(s, x, y, &is_first);
        for (int c = 0; c < s->sum.channels && weight > 0; c++) {
            float *to = (float *)rf_image_at(&s->sum, x, y, c);
            float of = weight * *rf_image_at(&s->made_out, x - s->x, y - s->y, c);
            *to = is_first ? of : *to + of;
        }
    }
}

/* Copies the columns from x0 to x1 - 1 of a row, which have one share, 0 or 1. */
static void add_hard(const struct focuses *s, int y, int x0, int x1)
{
    bool is_first;
    if (x1 <= x0 || weight_at(s, x0, y, &is_first) <= 0)
        return;
    const struct rf_window of = {x0 - s->x, y - s->y, x1 - x0, 1};
    const struct rf_window in = {x0, y, x1 - x0, 1};
    const struct rf_image from = image_part(&s->made_out, &of);
    const struct rf_image to = image_part(&s->sum, &in);
    if (from.data == to.data)
        return;
    if (is_packed_row(&from) && is_packed_row(&to))
        memcpy(to.data, from.data, (size_t)to.width * (size_t)to.pixel_bytes);
    else
        rf_image_copy(&from, &to);
}

/* Adds rows of a picture of one focus to the whole. */
static void add_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct focuses *s = data;
    int width = s->frame->width;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++) {
        int soft[2];
        rf_diopter_span(&s->diopter, -s->diopter.softness / 2, s->diopter.softness / 2,
                        y, width, soft);
        add_hard(s, y, 0, soft[0]);
        add_soft(s, y, soft[0], soft[1]);
        add_hard(s, y, soft[1], width);
    }
}

/*
 * The frame of this step's picture. A single view has another lens, as if it had no
 * split diopter; several views were rendered for the lens that they have.
 */
static struct rf_frame frame_of(const struct focuses *s)
{
    struct rf_frame one = *s->frame;
    double share = (double)s->step / s->n_steps, shift = s->diopter.px * share;
    if (s->n_views > 1) {
        one.has_even_share = true;
        one.even_share = share;
        return one;
    }
    one.params.split_diopter = 0;
    one.lens.bias_px += shift;
    one.lens.buffer_bias_px += shift;
    return one;
}

/* Makes the picture of one focus, or what of it is needed, and adds it. */
static rf_result add_focus(struct focuses *s, const struct rf_progress *progress,
                           rf_process_fn process, struct rf_error *error)
{
    struct rf_frame one = frame_of(s);
    const struct rf_window part = part_of(s);
    if (part.width <= 0 || part.height <= 0)
        return RF_OK;
    struct rf_window given = grown(&part, reach_of(s), &one);
    if (!rf_method_find(one.params.method)->can_window)
        given = (struct rf_window){0, 0, one.width, one.height};
    struct rf_view views[RF_MAX_VIEWS];
    for (int j = 0; j < s->n_views; j++) {
        const struct rf_view *view = &s->views[j];
        views[j] = *view;
        views[j].colour = image_part(&view->colour, &given);
        views[j].depth = image_part(&view->depth, &given);
        views[j].behind_colour = image_part(&view->behind_colour, &given);
        views[j].behind_depth = image_part(&view->behind_depth, &given);
        views[j].mean_depth = image_part(&view->mean_depth, &given);
    }
    one.place.x += given.x;
    one.place.y += given.y;
    one.width = given.width;
    one.height = given.height;
    s->made_out = s->is_begun
                      ? rf_image_packed(s->made, one.width, one.height, s->sum.channels)
                      : image_part(&s->sum, &given);
    s->is_begun = true;
    rf_result result = process(&one, views, s->n_views, &s->made_out, progress, error);
    s->x = given.x;
    s->y = given.y;
    if (result == RF_OK)
        rf_parallel(one.context, s->frame->height, RF_EQUAL_PARTS, add_rows, s);
    return result;
}

struct copying {
    struct rf_image from, to;
};

static void copy_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct copying *c = data;
    struct rf_window rows = {0, (int)begin, c->to.width, (int)(end - begin)};
    const struct rf_image from = image_part(&c->from, &rows);
    const struct rf_image to = image_part(&c->to, &rows);
    (void)thread;
    rf_image_copy(&from, &to);
}

/* The bytes that an image's floats lie in. */
static void bytes_of(const struct rf_image *image, uintptr_t bytes[2])
{
    const ptrdiff_t far[] = {(image->width - 1) * (ptrdiff_t)image->pixel_bytes,
                             (image->height - 1) * (ptrdiff_t)image->row_bytes,
                             (image->channels - 1) * (ptrdiff_t)image->channel_bytes};
    ptrdiff_t first = 0, last = (ptrdiff_t)sizeof(float);
    for (int i = 0; i < 3; i++) {
        first += far[i] < 0 ? far[i] : 0;
        last += far[i] > 0 ? far[i] : 0;
    }
    bytes[0] = (uintptr_t)image->data + (uintptr_t)first;
    bytes[1] = (uintptr_t)image->data + (uintptr_t)last;
}

static bool share_memory(const struct rf_image *a, const struct rf_image *b)
{
    uintptr_t of_a[2], of_b[2];
    if (!a->data || !b->data)
        return false;
    bytes_of(a, of_a);
    bytes_of(b, of_b);
    return of_a[0] < of_b[1] && of_b[0] < of_a[1];
}

/* May the caller's image be written to before the last focus has read the views? */
static bool is_apart(const struct rf_image *out, const struct rf_view *views, int n)
{
    bool shares = false;
    for (int j = 0; j < n; j++)
        shares |= share_memory(out, &views[j].colour) ||
                  share_memory(out, &views[j].depth) ||
                  share_memory(out, &views[j].behind_colour) ||
                  share_memory(out, &views[j].behind_depth) ||
                  share_memory(out, &views[j].mean_depth);
    return !shares;
}

rf_result rf_focuses_process(const struct rf_frame *frame, const struct rf_view *views,
                             int n_views, const struct rf_image *out,
                             const struct rf_progress *progress, rf_process_fn process,
                             struct rf_error *error)
{
    struct focuses s = {.frame = frame,
                        .diopter = rf_diopter_of(frame),
                        .views = views,
                        .n_views = n_views,
                        .sum = *out};
    s.n_steps = steps_of(&s.diopter);
    size_t n = (size_t)frame->width * (size_t)frame->height;
    size_t n_values = n * (size_t)out->channels;
    float *own = NULL;
    s.made = rf_alloc(frame->context, n_values, sizeof *s.made);
    if (!is_apart(out, views, n_views)) {
        own = rf_alloc(frame->context, n_values, sizeof *own);
        s.sum = rf_image_packed(own, frame->width, frame->height, out->channels);
    }
    rf_result result = s.made && s.sum.data
                           ? find_range(&s, s.made, error)
                           : rf_fail_memory(error, 2 * n_values, sizeof *s.made);
    for (int i = 0; i <= s.n_steps && result == RF_OK; i++) {
        struct rf_progress_part part = {progress, i, s.n_steps + 1};
        begin_step(&s, i);
        const struct rf_progress own_part = {rf_progress_report_part, &part};
        result = add_focus(&s, progress ? &own_part : NULL, process, error);
    }
    struct copying copy = {s.sum, *out};
    if (result == RF_OK && own)
        rf_parallel(frame->context, frame->height, RF_EQUAL_PARTS, copy_rows, &copy);
    rf_free(frame->context, s.made);
    rf_free(frame->context, own);
    return result;
}
