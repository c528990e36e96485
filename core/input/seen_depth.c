/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What a mirror or a pane shows moves from view to view as a point of its own distance
 * does (docs/algorithm.md, Reflections): a view at the point (u, v) of the unit lens
 * has it at
 *
 *   (x, y) + (u, -v a) s(r),   s(r) as of all points (input/views_in.c)
 *
 * with r the radius that the lens will give it. Pictures are compared as the eye
 * tells them apart, reduced where memory is short.
 */
#include "input/seen_depth.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/depth.h"
#include "input/image.h"
#include "input/seen_match.h"
#include "input/seen_regions.h"
#include "input/views_in.h"

/*
 * Radii are tried in steps that move what the farthest view shows by this; the parabola
 * through the best three has the rest.
 */
static const double STEP_PX = 0.5;

/* Radii beyond those of the scene that are tried: of images behind infinity, and on
 * both sides for the parabola. */
static const double BEYOND_PX = 2;

/* Images before their surface are told from others by a part of the range more. */
static const double BEFORE = 0.25;

/* Bytes that comparing may take; pictures that need more are reduced. */
static const size_t MOST_BYTES = (size_t)128 << 20;

/* Light below this, times the mean luminance of the picture, is none. */
static const float LEAST_LIGHT = 0.01f;

/* Neighbours of the median: 5 x 5 of what is found. */
enum { MEDIAN_PX = 2, MEDIAN_MOST = (2 * MEDIAN_PX + 1) * (2 * MEDIAN_PX + 1) };

/* What is looked for, at a reduced size. */
struct search {
    const struct rf_frame *frame;
    int factor, width, height; /* px of the picture that are one; the size in such */
    float mean;                /* luminance of the picture */
    const float *surface;      /* radii, of the full size */
    struct rf_seen_view views[RF_MAX_VIEWS];
    struct rf_seen_problem problem;
    float *memory, *raw, *reduced_surface, *smooth;
    struct rf_seen_match match;
    uint8_t *is_edge; /* as rf_seen_mark_edges() has it */
};

/* ---- the range ----------------------------------------------------------------- */

static float mean_luminance(const struct rf_params *params,
                            const struct rf_image *colour)
{
    const float most = 4 * (float)params->white;
    double sum = 0;
    int g = colour->channels > 2 ? 1 : 0, b = colour->channels > 2 ? 2 : 0;
    for (int y = 0; y < colour->height; y++)
        for (int x = 0; x < colour->width; x++) {
            const float rgb[3] = {*rf_image_at(colour, x, y, 0),
                                  *rf_image_at(colour, x, y, g),
                                  *rf_image_at(colour, x, y, b)};
            /* One lamp must not make all else dark. */
            sum += rf_min_float(rf_max_float(rf_luminance(rgb[0], rgb[1], rgb[2]), 0),
                                most);
        }
    return (float)(sum / ((double)colour->width * colour->height));
}

/* How what has the radius r moves from the first view to another. */
static struct rf_seen_view place_view(const struct rf_frame *f,
                                      const struct rf_view *first,
                                      const struct rf_view *view)
{
    struct rf_work_view a, b;
    rf_work_view_place(&a, first->lens_offset, first->shear_distance, &f->lens,
                       f->params.pixel_aspect);
    rf_work_view_place(&b, view->lens_offset, view->shear_distance, &f->lens,
                       f->params.pixel_aspect);
    const double up = -1; /* rows are counted downwards */
    return (struct rf_seen_view){
        .slope = {(double)b.lens[0] * b.shift_scale - (double)a.lens[0] * a.shift_scale,
                  ((double)b.lens[1] * b.shift_scale -
                   (double)a.lens[1] * a.shift_scale) *
                      up},
        .base = {(double)b.lens[0] * b.shift_bias - (double)a.lens[0] * a.shift_bias,
                 ((double)b.lens[1] * b.shift_bias - (double)a.lens[1] * a.shift_bias) *
                     up}};
}

/* Sets the radii to try, and how far the picture is reduced for that. */
static rf_result find_range(struct search *s, int n_views, struct rf_error *error)
{
    const struct rf_frame *f = s->frame;
    size_t n = (size_t)f->width * (size_t)f->height;
    double least = INFINITY, most = -INFINITY, slope = 0;
    for (size_t i = 0; i < n; i++) {
        least = fmin(least, s->surface[i]);
        most = fmax(most, s->surface[i]);
    }
    if (f->lens.projection == RF_PROJECTION_PERSPECTIVE)
        most = fmax(most, f->lens.bias_px);
    for (int j = 1; j < n_views; j++)
        slope = fmax(slope, rf_length(s->views[j].slope[0], s->views[j].slope[1]));
    if (slope < 1.0 / 64)
        return rf_fail(error, RF_ERROR_ARGUMENT, "lens_offset",
                       "the views were taken from one point of the lens: what is seen "
                       "in mirrors does not move between them");
    least -= BEYOND_PX + BEFORE * (most - least);
    most += BEYOND_PX;
    for (s->factor = 1;; s->factor++) {
        s->width = (f->width + s->factor - 1) / s->factor;
        s->height = (f->height + s->factor - 1) / s->factor;
        double step = STEP_PX * s->factor / slope; /* of the picture's own px */
        double n_radii = ceil((most - least) / step) + 1;
        struct rf_seen_problem *p = &s->problem;
        *p = (struct rf_seen_problem){
            .width = s->width, .height = s->height, .n_views = n_views};
        if (n_radii > RF_SEEN_MOST_RADII)
            continue;
        p->n_radii = rf_max_int((int)n_radii, 3);
        p->first = (float)(least / s->factor);
        p->step = (float)(step / s->factor);
        if (rf_seen_match_bytes(p) <= MOST_BYTES || s->width * s->height < 64)
            return RF_OK;
    }
}

/* ---- tones --------------------------------------------------------------------- */

/* Means of the light over the pixels of each reduced one. */
struct reducing {
    const struct search *search;
    const struct rf_image *light;
    float *to;
};

static void reduce_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct reducing *r = data;
    const struct search *s = r->search;
    const struct rf_image *light = r->light;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < s->width; x++) {
            float *to = r->to + 3 * ((size_t)y * (size_t)s->width + (size_t)x);
            int x0 = x * s->factor, x1 = rf_min_int(x0 + s->factor, light->width);
            int y0 = y * s->factor, y1 = rf_min_int(y0 + s->factor, light->height);
            float n = (float)((x1 - x0) * (y1 - y0));
            for (int c = 0; c < 3; c++) {
                float sum = 0;
                for (int b = y0; b < y1; b++)
                    for (int a = x0; a < x1; a++)
                        sum += *rf_image_at(light, a, b, light->channels > 2 ? c : 0);
                to[c] = sum / n;
            }
        }
}

/*
 * As the eye tells light apart: sqrt(v / (v + m)) with m the picture's mean, somewhat
 * lifted in the dark, where grain would count most.
 */
static float tone_of(float v, float mean)
{
    v = rf_max_float(v, 0);
    return sqrtf((v + 0.02f * mean) / (v + mean));
}

struct toning {
    const struct search *search;
    const float *light;
    float *tones;
};

/* Tones of light that is smoothed by 1 2 1 along both axes; -1 where there is none. */
static void tone_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct toning *t = data;
    const struct search *s = t->search;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < s->width; x++) {
            float rgb[3] = {0}, weights = 0;
            for (int b = rf_max_int(y - 1, 0); b <= rf_min_int(y + 1, s->height - 1);
                 b++)
                for (int a = rf_max_int(x - 1, 0); a <= rf_min_int(x + 1, s->width - 1);
                     a++) {
                    const float *of =
                        t->light + 3 * ((size_t)b * (size_t)s->width + (size_t)a);
                    float w = (float)((a == x ? 2 : 1) * (b == y ? 2 : 1));
                    if (rf_luminance(of[0], of[1], of[2]) < LEAST_LIGHT * s->mean)
                        continue;
                    weights += w;
                    for (int c = 0; c < 3; c++)
                        rgb[c] += w * tone_of(of[c], s->mean);
                }
            float *to = t->tones + 3 * ((size_t)y * (size_t)s->width + (size_t)x);
            /* More dark around than light: beside the mirror. */
            for (int c = 0; c < 3; c++)
                to[c] = weights >= 8 ? rgb[c] / weights : -1;
        }
}

static void make_tones(struct search *s, const struct rf_image *light, float *tones)
{
    struct reducing reduce = {s, light, s->raw};
    struct toning tone = {s, s->raw, tones};
    rf_parallel(s->frame->context, s->height, RF_EQUAL_PARTS, reduce_rows, &reduce);
    rf_parallel(s->frame->context, s->height, RF_EQUAL_PARTS, tone_rows, &tone);
}

static void reduce_surface(struct search *s)
{
    for (int y = 0; y < s->height; y++)
        for (int x = 0; x < s->width; x++) {
            int a = rf_min_int(x * s->factor + s->factor / 2, s->frame->width - 1);
            int b = rf_min_int(y * s->factor + s->factor / 2, s->frame->height - 1);
            s->reduced_surface[(size_t)y * (size_t)s->width + (size_t)x] =
                s->surface[(size_t)b * (size_t)s->frame->width + (size_t)a] /
                (float)s->factor;
        }
}

/* ---- what was found ------------------------------------------------------------ */

/* The median of what is found around a pixel, NAN where that is less than half. */
static float median_at(const struct search *s, int x, int y)
{
    float sorted[MEDIAN_MOST];
    int n = 0, n_around = 0;
    size_t i = (size_t)y * (size_t)s->width + (size_t)x;
    for (int b = rf_max_int(y - MEDIAN_PX, 0);
         b <= rf_min_int(y + MEDIAN_PX, s->height - 1); b++)
        for (int a = rf_max_int(x - MEDIAN_PX, 0);
             a <= rf_min_int(x + MEDIAN_PX, s->width - 1); a++) {
            size_t q = (size_t)b * (size_t)s->width + (size_t)a;
            if (s->views[0].tones[3 * q] < 0 ||
                fabsf(s->reduced_surface[q] - s->reduced_surface[i]) > 1)
                continue;
            n_around++;
            float r = s->match.found[q];
            if (!isfinite(r))
                continue;
            int at = n++;
            for (; at > 0 && sorted[at - 1] > r; at--)
                sorted[at] = sorted[at - 1];
            sorted[at] = r;
        }
    return n > 0 && 2 * n >= n_around ? sorted[n / 2] : NAN;
}

static void smooth_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct search *s = data;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < s->width; x++) {
            size_t i = (size_t)y * (size_t)s->width + (size_t)x;
            s->smooth[i] = s->views[0].tones[3 * i] < 0 ? NAN : median_at(s, x, y);
        }
}

/* What is found at reduced pixel (x, y), or beside it: edges have a depth by chance. */
static float found_near(const struct search *s, int x, int y)
{
    static const int around[9][2] = {{0, 0},   {-1, 0}, {1, 0},  {0, -1}, {0, 1},
                                     {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    int n = s->is_edge[(size_t)y * (size_t)s->width + (size_t)x] ? 9 : 1;
    for (int k = 0; k < n; k++) {
        int a = x + around[k][0], b = y + around[k][1];
        if (a < 0 || b < 0 || a >= s->width || b >= s->height)
            continue;
        float r = s->smooth[(size_t)b * (size_t)s->width + (size_t)a];
        if (isfinite(r))
            return r;
    }
    return NAN;
}

/* The radius at a pixel of the full size, between reduced ones where all are known. */
static float radius_at(const struct search *s, int x, int y)
{
    float own = found_near(s, x / s->factor, y / s->factor);
    if (s->factor == 1 || !isfinite(own))
        return own;
    float u = ((float)x + 0.5f) / (float)s->factor - 0.5f;
    float v = ((float)y + 0.5f) / (float)s->factor - 0.5f;
    int a = rf_max_int(rf_min_int((int)floorf(u), s->width - 2), 0);
    int b = rf_max_int(rf_min_int((int)floorf(v), s->height - 2), 0);
    if (s->width < 2 || s->height < 2)
        return own * (float)s->factor;
    const float *at = s->smooth + (size_t)b * (size_t)s->width + (size_t)a;
    const float *below = at + s->width;
    float fu = rf_clamp01(u - (float)a), fv = rf_clamp01(v - (float)b);
    float up = at[0] + fu * (at[1] - at[0]);
    float r = up + fv * (below[0] + fu * (below[1] - below[0]) - up);
    float spread = fabsf(at[0] - own) + fabsf(at[1] - own) + fabsf(below[0] - own) +
                   fabsf(below[1] - own);
    /* Across the edge of a thing there is nothing between. */
    return (spread < 2 ? r : own) * (float)s->factor;
}

struct putting {
    const struct search *search;
    const struct rf_image *light;
    float *planar;
};

static void put_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct putting *p = data;
    const struct search *s = p->search;
    int width = s->frame->width, g = p->light->channels > 2 ? 1 : 0;
    (void)thread;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < width; x++) {
            size_t i = (size_t)y * (size_t)width + (size_t)x;
            bool has_light = *rf_image_at(p->light, x, y, 0) > 0 ||
                             *rf_image_at(p->light, x, y, g) > 0 ||
                             *rf_image_at(p->light, x, y, 2 * g) > 0;
            float r = has_light ? radius_at(s, x, y) : NAN;
            p->planar[i] =
                isfinite(r) ? (float)rf_lens_depth_at(&s->frame->lens, r) : NAN;
        }
}

/* ---- all of it ----------------------------------------------------------------- */

static rf_result make_room(struct search *s, int n_views, struct rf_error *error)
{
    size_t n = (size_t)s->width * (size_t)s->height;
    size_t n_floats = n * (3 * (size_t)n_views + 3 + 6);
    float *at = s->memory = rf_alloc(s->frame->context, n_floats, sizeof *at);
    if (!at)
        return rf_fail_memory(error, n_floats, sizeof *at);
    for (int j = 0; j < n_views; j++, at += 3 * n)
        s->views[j].tones = at;
    s->raw = at;
    s->reduced_surface = at + 3 * n;
    s->match = (struct rf_seen_match){at + 4 * n, at + 5 * n, at + 6 * n};
    s->smooth = at + 7 * n;
    s->is_edge = (uint8_t *)(at + 8 * n);
    return RF_OK;
}

static rf_result search_views(struct search *s, int n_views,
                              const struct rf_image *lights, struct rf_error *error)
{
    const struct rf_context *context = s->frame->context;
    rf_result result = make_room(s, n_views, error);
    if (result != RF_OK)
        return result;
    for (int j = 0; j < n_views; j++) {
        make_tones(s, &lights[j], (float *)s->views[j].tones);
        for (int k = 0; k < 2; k++)
            s->views[j].base[k] /= s->factor;
    }
    reduce_surface(s);
    s->problem.views = s->views;
    s->problem.surface = s->reduced_surface;
    rf_seen_mark_edges(context, &s->problem, s->is_edge);
    result =
        rf_seen_drop_curved(context, &s->problem, (float *)s->views[0].tones, error);
    if (result == RF_OK)
        result = rf_seen_match(context, &s->problem, &s->match, error);
    if (result == RF_OK)
        result = rf_seen_settle(context, &s->problem, &s->match, error);
    if (result == RF_OK)
        rf_parallel(context, s->height, RF_EQUAL_PARTS, smooth_rows, s);
    return result;
}

rf_result rf_seen_find(const struct rf_frame *frame, const struct rf_view *views,
                       int n_views, const struct rf_image *lights, float *planar,
                       struct rf_error *error)
{
    struct rf_frame f = *frame;
    f.lens.max_radius_px = INFINITY;
    struct search s = {.frame = &f,
                       .mean = mean_luminance(&f.params, &views[0].colour)};
    size_t n = (size_t)f.width * (size_t)f.height;
    float *surface = rf_alloc(f.context, n, sizeof *surface);
    if (!surface)
        return rf_fail_memory(error, n, sizeof *surface);
    s.surface = surface;
    rf_result result =
        rf_depth_to_radius(&f, &views[0].depth, surface, NULL, NULL, NULL, error);
    for (int j = 0; j < n_views; j++)
        s.views[j] = place_view(&f, &views[0], &views[j]);
    if (result == RF_OK)
        result = find_range(&s, n_views, error);
    if (result == RF_OK)
        result = search_views(&s, n_views, lights, error);
    struct putting put = {&s, &lights[0], planar};
    if (result == RF_OK)
        rf_parallel(f.context, f.height, RF_EQUAL_PARTS, put_rows, &put);
    rf_free(f.context, s.memory);
    rf_free(f.context, surface);
    return result;
}

/* Puts the radii of what lies behind its surface where pixels are lit. */
static void take_ways(struct search *s, const float *planar)
{
    static const float BEHIND_PX = 1;
    size_t n = (size_t)s->width * (size_t)s->height;
    for (size_t i = 0; i < n; i++) {
        float r = (float)rf_lens_radius_px(&s->frame->lens, planar[i]);
        bool is_behind = rf_seen_is_lit(&s->problem, i) && planar[i] > 0 &&
                         r > s->surface[i] + BEHIND_PX;
        s->match.found[i] = is_behind ? r : NAN;
    }
}

static rf_result keep_flat(struct search *s, const struct rf_image *light,
                           const float *planar, struct rf_error *error)
{
    const struct rf_context *context = s->frame->context;
    rf_result result = make_room(s, 1, error);
    if (result != RF_OK)
        return result;
    make_tones(s, light, (float *)s->views[0].tones);
    reduce_surface(s);
    s->problem.views = s->views;
    s->problem.surface = s->reduced_surface;
    rf_seen_mark_edges(context, &s->problem, s->is_edge);
    result =
        rf_seen_drop_curved(context, &s->problem, (float *)s->views[0].tones, error);
    if (result != RF_OK)
        return result;
    take_ways(s, planar);
    rf_parallel(context, s->height, RF_EQUAL_PARTS, smooth_rows, s);
    return RF_OK;
}

rf_result rf_seen_keep_flat(const struct rf_frame *frame, const struct rf_view *view,
                            const struct rf_image *light, float *planar,
                            struct rf_error *error)
{
    struct rf_frame f = *frame;
    f.lens.max_radius_px = INFINITY;
    struct search s = {.frame = &f,
                       .factor = 1,
                       .width = f.width,
                       .height = f.height,
                       .mean = mean_luminance(&f.params, &view->colour),
                       .problem = {.width = f.width, .height = f.height, .n_views = 1}};
    size_t n = (size_t)f.width * (size_t)f.height;
    float *surface = rf_alloc(f.context, n, sizeof *surface);
    if (!surface)
        return rf_fail_memory(error, n, sizeof *surface);
    s.surface = surface;
    rf_result result =
        rf_depth_to_radius(&f, &view->depth, surface, NULL, NULL, NULL, error);
    if (result == RF_OK)
        result = keep_flat(&s, light, planar, error);
    struct putting put = {&s, light, planar};
    if (result == RF_OK)
        rf_parallel(f.context, f.height, RF_EQUAL_PARTS, put_rows, &put);
    rf_free(f.context, s.memory);
    rf_free(f.context, surface);
    return result;
}
