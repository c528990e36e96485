/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A view becomes surfaces: the picture is continued beyond its border (border.c), mixed
 * pixels are split (split.c).
 */
#include "surfaces/picture.h"

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
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "surfaces/border.h"
#include "surfaces/bright_areas.h"
#include "surfaces/split.h"
#include "surfaces/split_pixels.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

enum { MAX_BORDER = 256 };

static size_t padded_size(const struct rf_picture *picture)
{
    return (size_t)picture->width * (size_t)picture->height;
}

/* ---- rows ---------------------------------------------------------------------- */

/* Repeats the ends of a plane's row in its margins. */
static void fill_margins(const struct rf_pixels *p, float *row)
{
    for (int x = -RF_ROW_MARGIN; x < 0; x++)
        row[x] = row[0];
    for (size_t x = (size_t)p->width; x < p->stride - RF_ROW_MARGIN; x++)
        row[x] = row[p->width - 1];
}

/*
 * The surfaces of row y of a view: enum rf_row_kind of what is found, of planes only
 * film.
 */
static unsigned fetch_row(const struct rf_frame *f, const struct rf_work_view *view,
                          int n_planes, int y, struct rf_surface *at, float *luminance)
{
    const struct rf_kernels *kernels = f->context->kernels;
    size_t row = (size_t)y * (size_t)f->width;
    const float *radius = view->radius + row, *planes[4] = {NULL};
    if (view->image)
        return kernels->load_rgba(rf_image_at(view->image, 0, y, 0), radius, f->width,
                                  at, luminance);
    for (int n = 0; n < 3; n++)
        planes[n] = view->colour[n_planes == 1 ? 0 : n] + row;
    planes[3] = n_planes == 4 ? view->colour[3] + row : NULL;
    return kernels->load_row(planes, radius, f->width, at, luminance);
}

/* Row y of the view, of what fetch_row() says. */
static unsigned load_row(const struct rf_picture *picture,
                         const struct rf_work_view *view, int n_planes, int y)
{
    const struct rf_frame *f = picture->frame;
    const struct rf_pixels *p = &picture->pixels;
    int to = picture->y0 + y;
    struct rf_surface *at = p->at + (size_t)to * (size_t)picture->width + picture->x0;
    float *luminance = rf_plane_row(p, p->luminance, to) + picture->x0;
    float *radius = rf_plane_row(p, p->radius, to) + picture->x0;
    memcpy(radius, view->radius + (size_t)y * (size_t)f->width,
           (size_t)f->width * sizeof *radius);
    return fetch_row(f, view, n_planes, y, at, luminance);
}

/* Notes which pixels of a row are mixed or bright, while all about them is at hand. */
static void note_others(const struct rf_picture *picture, int y)
{
    const float *share = picture->surfaces.share + (size_t)y * (size_t)picture->width;
    const float *luminance =
        rf_plane_row(&picture->pixels, picture->pixels.luminance, y);
    const float *radius = rf_plane_row(&picture->pixels, picture->pixels.radius, y);
    const float *darkest = rf_plane_row(&picture->pixels, picture->darkest, y);
    uint64_t *others = picture->others + rf_row_words(picture->width) * (size_t)y;
    picture->frame->context->kernels->find_others(share, luminance, radius, darkest,
                                                  RF_BRIGHT, RF_BRIGHT_R2,
                                                  picture->width, others);
}

/*
 * Luminance with the premultiplication undone; what is transparent has no colour that
 * others could stand out from.
 */
static void undo_alpha_row(const struct rf_picture *picture, int y, float *out)
{
    const struct rf_surface *s =
        picture->pixels.at + (size_t)y * (size_t)picture->width;
    const float *luminance =
        rf_plane_row(&picture->pixels, picture->pixels.luminance, y);
    for (int x = 0; x < picture->width; x++)
        out[x] = s[x].c[3] == 1  ? luminance[x]
                 : s[x].c[3] > 0 ? luminance[x] / s[x].c[3]
                                 : INFINITY;
    fill_margins(&picture->pixels, out);
}

/* What the threads share that look for the darkest pixels. */
struct darkening {
    struct rf_picture *picture;
    float *shade, *scratch; /* what is compared, and a row per thread */
};

static void undo_alpha(void *data, int64_t begin, int64_t end, int thread)
{
    const struct darkening *d = data;
    for (int y = (int)begin; y < (int)end; y++)
        undo_alpha_row(d->picture, y, rf_plane_row(&d->picture->pixels, d->shade, y));
}

static void darken(void *data, int64_t begin, int64_t end, int thread)
{
    const struct darkening *d = data;
    struct rf_picture *picture = d->picture;
    const struct rf_pixels *p = &picture->pixels;
    for (int y = (int)begin; y < (int)end; y++) {
        const float *rows[5];
        rf_plane_rows(p, d->shade, y, 2, rows);
        picture->frame->context->kernels->extremes(
            rows, 5, 2, picture->width, d->scratch + p->stride * (size_t)thread,
            rf_plane_row(p, picture->darkest, y), NULL);
        note_others(picture, y);
    }
}

/* The darkest pixels around each, and what is mixed or bright by them. */
static rf_result find_darkest(struct rf_picture *picture, struct rf_error *error)
{
    const struct rf_context *context = picture->frame->context;
    const struct rf_pixels *p = &picture->pixels;
    size_t n = p->stride * (size_t)picture->height;
    size_t n_scratch = p->stride * (size_t)context->n_threads;
    struct darkening d = {.picture = picture};
    d.shade = picture->has_alpha ? rf_alloc(context, n, sizeof *d.shade) : p->luminance;
    d.scratch = rf_alloc(context, n_scratch, sizeof *d.scratch);
    rf_result result = d.shade && d.scratch
                           ? RF_OK
                           : rf_fail_memory(error, n + n_scratch, sizeof *d.shade);
    if (result == RF_OK && picture->has_alpha)
        rf_parallel(context, picture->height, RF_EQUAL_PARTS, undo_alpha, &d);
    if (result == RF_OK)
        rf_parallel(context, picture->height, RF_EQUAL_PARTS, darken, &d);
    rf_free(context, d.scratch);
    if (picture->has_alpha)
        rf_free(context, d.shade);
    return result;
}

/* ---- areas of what may be highlights -------------------------------------------- */

void rf_picture_visit_possible_highlights(struct rf_picture *picture, int y,
                                          rf_visit_pixel_fn visit, void *user)
{
    const uint64_t *row =
        picture->possible_highlights + rf_row_words(picture->width) * (size_t)y;
    for (int x = 0; x < picture->width; x += 64)
        for (uint64_t bits = row[x / 64]; bits; bits &= bits - 1)
            visit(picture, x + __builtin_ctzll(bits), y, user);
}

static void want_area(struct rf_picture *picture, int x, int y, void *wanted)
{
    ((unsigned char *)
         wanted)[rf_area_of(&picture->areas, x - picture->x0, y - picture->y0)] = 1;
}

/* ---- one walk over the rows ----------------------------------------------------- */

/* Rows that a thread splits in turn, so that what splitting looks at is in its cache. */
enum { BAND_ROWS = 32 };

struct walk {
    struct rf_picture *picture;
    const struct rf_work_view *view;
    int n_planes;
    struct rf_splitter splitter;
    struct rf_task *task;
    bool is_short;               /* of memory; atomic, as all flags */
    bool has_alpha, is_infinite; /* pixels that are not opaque, not finite */
    bool is_negative;            /* values below 0 */
};

static void set_flag(bool *flag)
{
    __atomic_store_n(flag, true, __ATOMIC_RELAXED);
}

static bool is_set(const bool *flag)
{
    return __atomic_load_n(flag, __ATOMIC_RELAXED);
}

/* Is there no use in going on? */
static bool is_over(const struct walk *walk)
{
    return is_set(&walk->is_short) || is_set(&walk->is_infinite) ||
           rf_task_is_cancelled(walk->task);
}

/* Splits a row, and of opaque pixels notes what is known by then. */
static void end_row(struct walk *walk, int y, int thread)
{
    if (!rf_split_row(&walk->splitter, y, thread))
        set_flag(&walk->is_short);
    else if (walk->picture->frame->params.split_edges)
        note_others(walk->picture, y);
    rf_task_step(walk->task);
}

static void load_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct walk *walk = data;
    for (int y = (int)begin; y < (int)end && !is_over(walk); y++) {
        unsigned found = load_row(walk->picture, walk->view, walk->n_planes, y);
        if (found & RF_ROW_FILM)
            set_flag(&walk->has_alpha);
        if (found & RF_ROW_INFINITE)
            set_flag(&walk->is_infinite);
        if (found & RF_ROW_NEGATIVE)
            set_flag(&walk->is_negative);
    }
}

/* The least values of the colours, not of what continues them. */
static void find_least(struct rf_picture *picture)
{
    const struct rf_frame *f = picture->frame;
    for (int y = picture->y0; y < picture->y0 + f->height; y++) {
        const struct rf_surface *at =
            picture->pixels.at + (size_t)y * (size_t)picture->width + picture->x0;
        for (int x = 0; x < f->width; x++)
            for (int c = 0; c < 3; c++)
                picture->least[c] = rf_min_float(picture->least[c], at[x].c[c]);
    }
}

static void fill_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct rf_pixels *p = data;
    for (int y = (int)begin; y < (int)end; y++) {
        fill_margins(p, rf_plane_row(p, p->luminance, y));
        fill_margins(p, rf_plane_row(p, p->radius, y));
    }
}

static void split_rows(void *data, int64_t begin, int64_t end, int thread)
{
    struct walk *walk = data;
    for (int y = (int)begin; y < (int)end && !is_over(walk); y++)
        end_row(walk, y, thread);
}

/* Loads all rows, continues them and splits them. */
static rf_result walk_rows(struct walk *walk, struct rf_error *error)
{
    struct rf_picture *picture = walk->picture;
    const struct rf_frame *f = picture->frame;
    struct rf_pixels *p = &picture->pixels;
    rf_result result = RF_OK;
    rf_parallel(f->context, f->height, RF_EQUAL_PARTS, load_rows, walk);
    picture->has_alpha = walk->has_alpha;
    if (walk->is_negative && !is_over(walk))
        find_least(picture);
    if (!is_over(walk))
        result =
            rf_border_continue(f, p, picture->x0, picture->y0, picture->border, error);
    if (result != RF_OK || is_over(walk))
        return result;
    rf_parallel(f->context, p->height, RF_EQUAL_PARTS, fill_rows, p);
    rf_parallel(f->context, p->height, BAND_ROWS, split_rows, walk);
    return RF_OK;
}

/* Measures the areas that tell what is a highlight. */
static rf_result measure_areas(struct rf_picture *picture, struct rf_error *error)
{
    const struct rf_context *context = picture->frame->context;
    size_t n = (size_t)picture->areas.n_x * (size_t)picture->areas.n_y;
    unsigned char *wanted = rf_calloc(context, n, 1);
    if (!wanted)
        return rf_fail_memory(error, n, 1);
    for (int y = 0; y < picture->height; y++)
        rf_picture_visit_possible_highlights(picture, y, want_area, wanted);
    rf_areas_measure_some(
        &picture->areas, context, wanted,
        rf_plane_row(&picture->pixels, picture->pixels.luminance, picture->y0) +
            picture->x0,
        picture->pixels.stride);
    rf_free(context, wanted);
    return RF_OK;
}

/* Loads and splits the pixels, measures the areas; the walk is over after it. */
static rf_result run_walk(struct walk *walk, struct rf_error *error)
{
    struct rf_picture *picture = walk->picture;
    rf_result result = rf_split_begin(&walk->splitter, error);
    if (result == RF_OK)
        result = walk_rows(walk, error);
    if (walk->is_short)
        result =
            rf_fail_memory(error, (size_t)picture->width, sizeof *picture->pixels.at);
    else if (walk->is_infinite)
        result = rf_frame_check(picture->frame, walk->view->image, error);
    if (result == RF_OK && !is_over(walk))
        result = measure_areas(picture, error);
    /* Of opaque pixels splitting has looked for the same. */
    if (result == RF_OK && !is_over(walk) &&
        (picture->has_alpha || !picture->frame->params.split_edges))
        result = find_darkest(picture, error);
    rf_task_poll(walk->task);
    if (result == RF_OK && !is_over(walk))
        result = rf_split_end(&walk->splitter, error);
    rf_split_free(&walk->splitter);
    return result;
}

/* ---- all ----------------------------------------------------------------------- */

static rf_result allocate(struct rf_picture *picture, enum rf_picture_kept kept,
                          struct rf_error *error)
{
    const struct rf_context *context = picture->frame->context;
    size_t n = padded_size(picture);
    size_t stride =
        ((size_t)picture->width + RF_ROW_MARGIN - 1) / RF_ROW_MARGIN * RF_ROW_MARGIN +
        2 * RF_ROW_MARGIN;
    size_t n_plane = stride * (size_t)picture->height;
    picture->pixels = (struct rf_pixels){
        .width = picture->width,
        .height = picture->height,
        .at = rf_alloc(context, n, sizeof *picture->pixels.at),
        .stride = stride,
        .luminance = rf_alloc(context, n_plane, sizeof(float)),
        .radius = rf_alloc(context, n_plane, sizeof(float)),
        .source = kept == RF_KEPT_SOURCES
                      ? rf_alloc(context, n, sizeof *picture->pixels.source)
                      : NULL,
    };
    picture->darkest = rf_alloc(context, n_plane, sizeof *picture->darkest);
    size_t n_words = rf_row_words(picture->width) * (size_t)picture->height;
    picture->others = rf_alloc(context, n_words, sizeof *picture->others);
    picture->possible_highlights =
        rf_alloc(context, n_words, sizeof *picture->possible_highlights);
    const struct rf_place *place = &picture->frame->place;
    picture->surfaces = (struct rf_surfaces){
        .width = picture->width,
        .height = picture->height,
        .x = place->x + picture->border - picture->x0,
        .y = place->y + picture->border - picture->y0,
        .share = rf_alloc(context, n, sizeof *picture->surfaces.share),
    };
    bool has_sources = picture->pixels.source || kept != RF_KEPT_SOURCES;
    bool is_complete = has_sources && picture->pixels.at && picture->pixels.luminance &&
                       picture->pixels.radius && picture->darkest && picture->others &&
                       picture->surfaces.share && picture->possible_highlights;
    return is_complete ? RF_OK
                       : rf_fail_memory(error, n * 3, sizeof *picture->pixels.at);
}

int rf_picture_border(float largest_radius)
{
    return largest_radius < MAX_BORDER ? (int)ceilf(largest_radius) : MAX_BORDER;
}

rf_result rf_picture_load(struct rf_picture *picture, const struct rf_frame *frame,
                          const struct rf_work_view *view, int n_planes, int border,
                          enum rf_picture_kept kept, struct rf_task *task,
                          struct rf_error *error)
{
    const struct rf_place *at = &frame->place;
    int x1 = at->x + frame->width, y1 = at->y + frame->height;
    *picture = (struct rf_picture){
        .frame = frame,
        .border = border,
        .x0 = at->x == 0 ? border : 0,
        .y0 = at->y == 0 ? border : 0,
    };
    picture->width = picture->x0 + frame->width + (x1 == at->whole_width ? border : 0);
    picture->height =
        picture->y0 + frame->height + (y1 == at->whole_height ? border : 0);
    rf_result result = allocate(picture, kept, error);
    if (result != RF_OK)
        return result;
    result = rf_areas_begin(&picture->areas, frame, error);
    struct walk walk = {
        .picture = picture,
        .view = view,
        .n_planes = n_planes,
        .splitter = {.frame = frame,
                     .keeps_radii = kept != RF_KEPT_RADII,
                     .is_alone = kept == RF_KEPT_RADII,
                     .mean_depth = view->mean_depth,
                     .x0 = picture->x0,
                     .y0 = picture->y0,
                     .pixels = &picture->pixels,
                     .out = &picture->surfaces,
                     .darkest = picture->darkest,
                     .possible_highlights = picture->possible_highlights,
                     .bright = rf_least_highlight()},
        .task = task};
    if (result == RF_OK)
        result = run_walk(&walk, error);
    if (kept == RF_KEPT_RADII) {
        rf_free(frame->context, picture->pixels.luminance);
        picture->pixels.luminance = NULL;
    }
    return result;
}

void rf_picture_drop_pixels(struct rf_picture *picture)
{
    const struct rf_context *context = picture->frame->context;
    rf_free(context, picture->pixels.luminance);
    rf_free(context, picture->pixels.at);
    rf_free(context, picture->pixels.source);
    rf_free(context, picture->pixels.split);
    rf_free(context, picture->pixels.split_row);
    picture->pixels.luminance = NULL;
    picture->pixels.at = NULL;
    picture->pixels.source = NULL;
    picture->pixels.split = NULL;
    picture->pixels.split_row = NULL;
}

void rf_picture_free(struct rf_picture *picture)
{
    if (!picture->frame)
        return;
    const struct rf_context *context = picture->frame->context;
    rf_picture_drop_pixels(picture);
    rf_free(context, picture->pixels.radius);
    rf_free(context, picture->others);
    rf_free(context, picture->possible_highlights);
    rf_free(context, picture->darkest);
    rf_free(context, picture->highlights);
    rf_free(context, picture->behind);
    rf_free(context, picture->surfaces.share);
    rf_far_free(&picture->surfaces, context);
    rf_free(context, picture->surfaces.near);
    rf_areas_free(&picture->areas, context);
}
