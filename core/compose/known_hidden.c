/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Known hidden background: other pictures of the scene, such as the frames before and
 * after, show what this one hides. Where an estimate was made (hidden.c finds where the
 * lens looks behind something) and the caller knows the surface, that takes its place
 * if it lies behind the near surface of its pixel. It stands for itself alone, so its
 * colour is not limited as that of an estimate is: a lamp behind a wire is as bright as
 * beside it. Lamps are taken out as the visible ones are (highlights_find.c); what is
 * usual at their place is what the estimate says. Without, they come and go from frame
 * to frame. Cost: two passes over the picture.
 */
#include "compose/known_hidden.h"

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
#include "compose/emit.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "kernels/data.h"
#include "surfaces/bright_areas.h"
#include "rackfocus/rackfocus.h"

/* Behind by this, px of radius, as another view's surfaces are (methods/views). */
static const float BEHIND_PX = 0.8f;

/* What the threads share that put what is known in its place. */
struct putting {
    const struct rf_picture *picture;
    const struct rf_image *depth;
    struct rf_lens lens;
    float *radius, *planes[4]; /* of the view, packed */
    int n_planes;
    float most;          /* magnitude of a radius */
    bool are_lights_own; /* the caller lists them (unseen_lights.c) */
    struct rf_estimates *estimates;
    size_t *start; /* of each row's lights */
    struct rf_sample *lights;
};

/* Radii of what is known; NAN of what is not. */
static void measure_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct putting *p = data;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < p->depth->width; x++) {
            float z = *rf_image_at(p->depth, x, y, 0);
            p->radius[(size_t)y * (size_t)p->depth->width + (size_t)x] =
                z > 0 ? (float)rf_lens_radius_px(&p->lens, (double)z) : NAN;
        }
}

/* The known surface at pixel (x, y) of the view; false where there is none. */
static bool find_known(const struct putting *p, int x, int y, struct rf_surface *known)
{
    size_t i = (size_t)y * (size_t)p->depth->width + (size_t)x;
    if (isnan(p->radius[i]))
        return false;
    known->r = rf_min_float(rf_max_float(p->radius[i], -p->most), p->most);
    for (int n = 0; n < 3; n++)
        known->c[n] = p->planes[p->n_planes == 1 ? 0 : n][i];
    known->c[3] = p->n_planes == 4 ? p->planes[3][i] : 1;
    return true;
}

static float luminance_of(const struct rf_surface *s)
{
    return rf_luminance(s->c[0], s->c[1], s->c[2]);
}

/* Where a pixel is mixed, its far part may be known too: the colour that other pictures
 * show unmixed is better than the one that was split off. */
static void mend_far_part(const struct putting *p, size_t i,
                          const struct rf_surface *known)
{
    const struct rf_surfaces *s = &p->picture->surfaces;
    if (!rf_is_mixed(s, i))
        return;
    struct rf_surface *far = (struct rf_surface *)rf_far_at(s, i);
    if (fabsf(far->r - known->r) < BEHIND_PX &&
        luminance_of(known) < rf_least_highlight())
        memcpy(far->c, known->c, sizeof far->c);
}

static bool is_lamp(const struct putting *p, const struct rf_surface *known,
                    float usual)
{
    float factor = p->picture->highlight_factor;
    return factor > 0 && rf_is_highlight(luminance_of(known), known->r, factor, usual);
}

/* Row y of the view; returns how many lamps it has. They are put to `lights`, NULL: all
 * is only counted. */
static size_t put_row(const struct putting *p, int y, struct rf_sample *lights)
{
    const struct rf_picture *picture = p->picture;
    int py = picture->y0 + y;
    const float *near = rf_plane_row(&picture->pixels, picture->pixels.radius, py);
    size_t n = 0;
    for (int x = 0; x < picture->frame->width; x++) {
        struct rf_surface known;
        int px = picture->x0 + x;
        size_t i = (size_t)py * (size_t)picture->width + (size_t)px;
        struct rf_surface *at = &p->estimates->at[i];
        if (!find_known(p, x, y, &known))
            continue;
        if (lights)
            mend_far_part(p, i, &known);
        if (known.r < near[px] + BEHIND_PX)
            continue;
        if (lights && picture->behind)
            picture->behind[picture->behind_stride * (size_t)py + (size_t)px] = known.r;
        if (!rf_found_at(p->estimates, px, py, 1))
            continue;
        float usual = luminance_of(at), share = picture->surfaces.share[i];
        if (share > 0 && is_lamp(p, &known, usual)) {
            struct rf_sample light = rf_sample_make(&known, px, py, share);
            rf_take_light(known.c, light.c, usual / luminance_of(&known));
            if (lights && !p->are_lights_own)
                lights[n] = light;
            n += !p->are_lights_own;
        }
        if (lights)
            *at = known;
    }
    return n;
}

static void count_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct putting *p = data;
    for (int y = (int)begin; y < (int)end; y++)
        p->start[y + 1] = put_row(p, y, NULL);
}

static void put_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct putting *p = data;
    for (int y = (int)begin; y < (int)end; y++)
        put_row(p, y, p->lights + p->start[y]);
}

/* A plane of radii behind the near surfaces, of which none is known yet. */
static rf_result begin_behind(struct rf_picture *picture, struct rf_error *error)
{
    if (!(picture->highlight_factor > 0))
        return RF_OK;
    picture->behind_stride = (size_t)picture->width + RF_ROW_MARGIN;
    size_t n = picture->behind_stride * (size_t)picture->height;
    picture->behind = rf_alloc(picture->frame->context, n, sizeof *picture->behind);
    if (!picture->behind)
        return rf_fail_memory(error, n, sizeof *picture->behind);
    for (size_t i = 0; i < n; i++)
        picture->behind[i] = INFINITY;
    return RF_OK;
}

/* Puts surfaces and lamps, those after the ones that are seen. */
static rf_result put(struct rf_picture *picture, struct putting *p,
                     struct rf_error *error)
{
    const struct rf_frame *f = picture->frame;
    p->start[0] = picture->n_highlights;
    rf_parallel(f->context, f->height, RF_EQUAL_PARTS, count_rows, p);
    for (int y = 0; y < f->height; y++)
        p->start[y + 1] += p->start[y];
    size_t n = p->start[f->height];
    p->lights = rf_alloc(f->context, n, sizeof *p->lights);
    if (!p->lights)
        return rf_fail_memory(error, n, sizeof *p->lights);
    if (picture->n_highlights)
        memcpy(p->lights, picture->highlights,
               picture->n_highlights * sizeof *p->lights);
    rf_parallel(f->context, f->height, RF_EQUAL_PARTS, put_rows, p);
    rf_free(f->context, picture->highlights);
    picture->highlights = p->lights;
    picture->n_highlights = n;
    return RF_OK;
}

rf_result rf_known_hidden_put(struct rf_picture *picture,
                              const struct rf_work_view *view,
                              struct rf_estimates *estimates, struct rf_error *error)
{
    const struct rf_frame *f = picture->frame;
    if (!view->behind || !view->behind->behind_colour.data)
        return RF_OK;
    const struct rf_image *colour = &view->behind->behind_colour;
    size_t n = (size_t)f->width * (size_t)f->height;
    size_t n_all = n * (size_t)(colour->channels + 1);
    float *memory = rf_alloc(f->context, n_all, sizeof *memory), largest;
    size_t *start = rf_alloc(f->context, (size_t)f->height + 1, sizeof *start);
    struct putting p = {.picture = picture,
                        .depth = &view->behind->behind_depth,
                        .lens = rf_field_lens(f),
                        .radius = memory,
                        .n_planes = colour->channels,
                        .most = view->largest_radius,
                        .are_lights_own = view->behind->n_unseen_lights > 0,
                        .estimates = estimates,
                        .start = start};
    rf_result result =
        memory && start ? RF_OK : rf_fail_memory(error, n_all, sizeof *memory);
    for (int c = 0; c < colour->channels && result == RF_OK; c++)
        p.planes[c] = memory + n * (size_t)(c + 1);
    if (result == RF_OK) {
        rf_parallel(f->context, f->height, RF_EQUAL_PARTS, measure_rows, &p);
        rf_field_apply(f, p.radius, &largest);
        result = rf_frame_load(f, colour, p.planes, error);
    }
    if (result == RF_OK)
        result = begin_behind(picture, error);
    if (result == RF_OK)
        result = put(picture, &p, error);
    rf_free(f->context, start);
    rf_free(f->context, memory);
    return result;
}
