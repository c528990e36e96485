/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A frame continued beyond its border by what the frames beside it show there, so that
 * the light that the lens brings in from there need not be guessed. The picture of the
 * larger frame is made with alpha: where nothing is known it is 0, and what there is of
 * a pixel's light counts for all of it, as without a border,
 *
 *   out = C / A   of the premultiplied colour C and alpha A that the lens makes
 *
 * Worth: with three frames on each side 0.3 to 0.6 dB of all of a shot's frames
 * (docs/notebook/farm.md). Two surfaces told apart at a pixel are worth nothing more.
 */
#include "filter/temporal_border.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "filter/filter_private.h"
#include "filter/temporal.h"
#include "interrupt.h"

/* Of a pixel, to be known: 0.1 loses 0.25 dB with two frames on each side. */
static const float LEAST_COVER = 0.5f;
/* Below it nothing of the lens's light is known. */
static const float LEAST_ALPHA = 1e-4f;

struct border_pixel {
    float r, weight; /* of the first of the surface that counts, px; sums of the rest */
    float z, colour[3];
};

enum { LEFT, TOP, RIGHT, BELOW, RGBA = 4 };

/* ---- which frames ---------------------------------------------------------------- */

/* What depends on the place in the picture would see another picture. */
static bool depends_on_place(const struct rf_params *p)
{
    return p->cat_eye != 0 || p->field_curvature != 0 || p->split_diopter != 0 ||
           p->astigmatism != 0 || p->swirl != 0 || p->lateral_chroma != 0 ||
           p->barn_left != 0 || p->barn_right != 0 || p->barn_top != 0 ||
           p->barn_bottom != 0;
}

/* Does the frame cover its pixels? */
static bool is_opaque(const struct run *run)
{
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    for (size_t i = 0; i < n && source->n_channels == RGBA; i++)
        if (run->colour[RGBA * i + 3] != 1)
            return false;
    return true;
}

bool temporal_border_is_of(const struct run *run)
{
    const struct rf_params *p = &run->params;
    return !run->has_views && !run->is_deep && !run->tool->aperture_image &&
           !run->tool->distribution_image && !depends_on_place(p) &&
           (p->depth == RF_DEPTH_PLANAR || p->depth == RF_DEPTH_RADIAL) &&
           p->blend_gamma == 1 && is_opaque(run);
}

struct temporal_border *temporal_border_make(const struct run *run, int32_t margin,
                                             struct image_error *error)
{
    const struct source *source = &run->source;
    struct temporal_border *border = app_memory(1, sizeof(*border), error);
    if (!border)
        return NULL;
    *border = (struct temporal_border){
        .width = source->width,
        .height = source->height,
        .margin = margin,
    };
    const size_t n = (size_t)(border->width + 2 * border->margin) *
                     (size_t)(border->height + 2 * border->margin);
    border->pixels = app_memory(n, sizeof(*border->pixels), error);
    if (border->pixels)
        return border;
    free(border);
    return NULL;
}

void temporal_border_free(struct temporal_border *border)
{
    if (border)
        free(border->pixels);
    free(border);
}

/* ---- what is known --------------------------------------------------------------- */

static struct border_pixel *pixel_at(const struct temporal_border *b, int32_t x,
                                     int32_t y)
{
    const size_t width = (size_t)(b->width + 2 * b->margin);
    return &b->pixels[(size_t)(y + b->margin) * width + (size_t)(x + b->margin)];
}

static bool is_inside(const struct temporal_border *b, int32_t x, int32_t y)
{
    return x >= 0 && x < b->width && y >= 0 && y < b->height;
}

void temporal_border_add(struct temporal_border *b, int32_t x, int32_t y, float weight,
                         float r, float z, const float *colour, int n_channels)
{
    if (is_inside(b, x, y) || x < -b->margin || x >= b->width + b->margin ||
        y < -b->margin || y >= b->height + b->margin)
        return;
    struct border_pixel *pixel = pixel_at(b, x, y);
    if (pixel->weight > 0 && r > pixel->r + TEMPORAL_SAME_PX)
        return;
    if (pixel->weight == 0 || r < pixel->r - TEMPORAL_SAME_PX)
        *pixel = (struct border_pixel){.r = r};
    pixel->weight += weight;
    pixel->z += weight * z;
    for (int c = 0; c < 3; c++)
        pixel->colour[c] += weight * colour[n_channels >= 3 ? c : 0];
}

static int32_t most(int32_t a, int32_t b)
{
    return a > b ? a : b;
}

bool temporal_border_finish(struct temporal_border *b)
{
    for (int32_t y = -b->margin; y < b->height + b->margin; y++)
        for (int32_t x = -b->margin; x < b->width + b->margin; x++) {
            if (is_inside(b, x, y) || pixel_at(b, x, y)->weight < LEAST_COVER)
                continue;
            b->sides[LEFT] = most(b->sides[LEFT], -x);
            b->sides[TOP] = most(b->sides[TOP], -y);
            b->sides[RIGHT] = most(b->sides[RIGHT], x - b->width + 1);
            b->sides[BELOW] = most(b->sides[BELOW], y - b->height + 1);
        }
    return b->sides[LEFT] || b->sides[TOP] || b->sides[RIGHT] || b->sides[BELOW];
}

/* ---- the larger frame ------------------------------------------------------------ */

/* Its pictures, packed; colours are RGBA. */
struct larger {
    int32_t width, height;
    float *colour, *depth, *behind_colour, *behind_depth, *out;
    struct rf_unseen_light *lights;
    size_t n_lights;
    struct rf_filter *filter;
};

static void larger_free(struct larger *l)
{
    rf_filter_destroy(l->filter);
    free(l->colour);
    free(l->depth);
    free(l->behind_colour);
    free(l->behind_depth);
    free(l->out);
    free(l->lights);
}

static bool larger_allocate(struct larger *l, const struct rf_view *view,
                            struct image_error *error)
{
    const size_t n = (size_t)l->width * (size_t)l->height;
    l->colour = app_memory(n, RGBA * sizeof(float), error);
    l->depth = app_memory(n, sizeof(float), error);
    l->behind_colour = app_memory(n, RGBA * sizeof(float), error);
    l->behind_depth = app_memory(n, sizeof(float), error);
    l->out = app_memory(n, RGBA * sizeof(float), error);
    l->lights = app_memory(view->n_unseen_lights + 1, sizeof(*l->lights), error);
    return l->colour && l->depth && l->behind_colour && l->behind_depth && l->out &&
           l->lights;
}

/* The lens of the larger frame, whose depth is planar. */
static int make_filter(struct run *run, const struct temporal_border *b,
                       struct larger *l)
{
    struct rf_error error;
    struct rf_params fitted, params = run->params;
    struct image_part_info info = run->source.info;
    info.data_window.min_x -= b->sides[LEFT];
    info.data_window.min_y -= b->sides[TOP];
    info.data_window.max_x += b->sides[RIGHT];
    info.data_window.max_y += b->sides[BELOW];
    rf_result result = settings_fit_window(run->settings, &info, &fitted, &error);
    params.shift_x = fitted.shift_x;
    params.shift_y = fitted.shift_y;
    params.focal_length_px = fitted.focal_length_px;
    params.ortho_scale = fitted.ortho_scale;
    params.max_radius = fitted.max_radius;
    params.depth = RF_DEPTH_PLANAR;
    if (result == RF_OK)
        result = rf_filter_create(&l->filter, run->context, &params, l->width,
                                  l->height, &error);
    return result == RF_OK ? APP_DONE : filter_fail_core(run, &error);
}

/* A pixel of a frame of n channels as RGBA. */
static void copy_colour(const float *from, int n, float alpha, float to[RGBA])
{
    for (int c = 0; c < 3; c++)
        to[c] = from[n >= 3 ? c : 0];
    to[3] = alpha;
}

/* The frame's own pixel i to pixel k of the larger one; its depth is there already. */
static void copy_pixel(const struct rf_view *view, size_t i, struct larger *l, size_t k)
{
    const int n = view->colour.channels;
    const float *colour = view->colour.data, *behind = view->behind_colour.data,
                *z = view->behind_depth.data;
    copy_colour(colour + (size_t)n * i, n, 1, l->colour + RGBA * k);
    l->behind_depth[k] = z ? z[i] : NAN;
    if (z)
        copy_colour(behind + (size_t)n * i, n, 1, l->behind_colour + RGBA * k);
}

static void copy_border(const struct border_pixel *from, struct larger *l, size_t k)
{
    const bool is_known = from->weight >= LEAST_COVER;
    float *to = l->colour + RGBA * k;
    l->depth[k] = is_known ? from->z / from->weight : INFINITY;
    l->behind_depth[k] = NAN;
    for (int c = 0; c < 3; c++)
        to[c] = is_known ? from->colour[c] / from->weight : 0;
    to[3] = is_known;
}

/* Adds a light to its pixel of the border, or hands it on where that hides it. */
static void place_light(const struct run *run, const struct rf_view *view,
                        const struct rf_unseen_light *light, struct larger *l)
{
    const struct temporal_border *b = run->border;
    const struct rf_lens *lens = rf_filter_lens(run->filter);
    const int32_t x = (int32_t)floor(light->x), y = (int32_t)floor(light->y);
    const int32_t column = x + b->sides[LEFT], row = y + b->sides[TOP];
    float colour[RGBA];
    copy_colour(light->colour, view->colour.channels, 1, colour);
    if (!is_inside(b, x, y) && column >= 0 && column < l->width && row >= 0 &&
        row < l->height) {
        const size_t k = (size_t)row * (size_t)l->width + (size_t)column;
        float *to = l->colour + RGBA * k;
        const double r = rf_lens_radius_px(lens, light->depth);
        if (to[3] == 0)
            l->depth[k] = (float)light->depth;
        if (to[3] == 0 || r < rf_lens_radius_px(lens, (double)l->depth[k]) +
                                  (double)TEMPORAL_SAME_PX) {
            for (int c = 0; c < 3; c++)
                to[c] += colour[c];
            to[3] = 1;
            return;
        }
    }
    struct rf_unseen_light *to = &l->lights[l->n_lights++];
    *to = *light;
    to->x += b->sides[LEFT];
    to->y += b->sides[TOP];
    memcpy(to->colour, colour, sizeof(colour));
}

static int fill(struct run *run, const struct rf_view *view, struct larger *l)
{
    const struct temporal_border *b = run->border;
    struct rf_error error;
    float *inner = l->depth + (size_t)b->sides[TOP] * (size_t)l->width + b->sides[LEFT];
    struct rf_image planar = rf_image_packed(inner, b->width, b->height, 1);
    planar.row_bytes = (ptrdiff_t)l->width * (ptrdiff_t)sizeof(float);
    if (rf_filter_planar_depth(run->filter, &view->depth, &planar, &error) != RF_OK)
        return filter_fail_core(run, &error);
    for (int32_t y = -b->sides[TOP]; y < b->height + b->sides[BELOW]; y++)
        for (int32_t x = -b->sides[LEFT]; x < b->width + b->sides[RIGHT]; x++) {
            const size_t k = (size_t)(y + b->sides[TOP]) * (size_t)l->width +
                             (size_t)(x + b->sides[LEFT]);
            if (is_inside(b, x, y))
                copy_pixel(view, (size_t)y * (size_t)b->width + (size_t)x, l, k);
            else
                copy_border(pixel_at(b, x, y), l, k);
        }
    for (size_t i = 0; i < view->n_unseen_lights; i++)
        place_light(run, view, &view->unseen_lights[i], l);
    return APP_DONE;
}

/* The frame's part of the larger one's picture. */
static void crop(const struct temporal_border *b, const struct larger *l, int n,
                 float *samples)
{
    for (int32_t y = 0; y < b->height; y++)
        for (int32_t x = 0; x < b->width; x++) {
            const size_t k = (size_t)(y + b->sides[TOP]) * (size_t)l->width +
                             (size_t)(x + b->sides[LEFT]);
            const float *from = l->out + RGBA * k;
            float *to =
                samples + (size_t)n * ((size_t)y * (size_t)b->width + (size_t)x);
            const float alpha = fmaxf(from[3], LEAST_ALPHA);
            for (int c = 0; c < n; c++)
                to[c] = c == 3 ? 1 : from[c] / alpha;
        }
}

int temporal_border_filter(struct run *run, const struct rf_view *view, float *samples)
{
    const struct temporal_border *b = run->border;
    const struct app_host *host = run->tool->host;
    const struct rf_progress progress = {app_progress, (void *)host};
    struct rf_error error;
    struct larger l = {.width = b->sides[LEFT] + b->width + b->sides[RIGHT],
                       .height = b->sides[TOP] + b->height + b->sides[BELOW]};
    int code =
        larger_allocate(&l, view, run->error) ? make_filter(run, b, &l) : APP_NO_MEMORY;
    if (code == APP_DONE)
        code = fill(run, view, &l);
    if (code == APP_DONE) {
        const struct rf_view larger = {
            .size = sizeof(larger),
            .colour = rf_image_packed(l.colour, l.width, l.height, RGBA),
            .depth = rf_image_packed(l.depth, l.width, l.height, 1),
            .behind_colour = rf_image_packed(l.behind_colour, l.width, l.height, RGBA),
            .behind_depth = rf_image_packed(l.behind_depth, l.width, l.height, 1),
            .unseen_lights = l.n_lights ? l.lights : NULL,
            .n_unseen_lights = l.n_lights};
        const struct rf_image out = rf_image_packed(l.out, l.width, l.height, RGBA);
        app_begin(host, "filtering");
        if (rf_filter_process(l.filter, &larger, 1, &out, &progress, &error) != RF_OK)
            code = filter_fail_core(run, &error);
        app_end(host);
    }
    if (code == APP_DONE)
        crop(b, &l, view->colour.channels, samples);
    larger_free(&l);
    return code == APP_DONE && os_is_interrupted() ? APP_INTERRUPTED : code;
}
