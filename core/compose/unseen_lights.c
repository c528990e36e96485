/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lamps behind things and beyond the border, which other pictures of the scene show,
 * such as the frames before and after. The lens sees a part of a lamp long before its
 * centre does: without them the whole disc of a lamp comes at once, when it enters the
 * picture or comes out behind something.
 *
 * A light becomes a highlight of its pixel's part that something nearer covers; where
 * the picture shows surfaces as far as the light, it shows the light itself. What stands
 * before it blocks it as any other (highlights_add.c). Cost: the lights.
 */
#include "compose/unseen_lights.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "compose/emit.h"
#include "compose/scene.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/pixels.h"
#include "surfaces/bright_areas.h"
#include "rackfocus/rackfocus.h"

/* Something is nearer by this, px of radius, as of what is known hidden. */
static const float BEHIND_PX = 0.8f;

struct putting {
    struct rf_picture *picture;
    const struct rf_estimates *estimates;
    float *planes[4]; /* of the lights' colours */
    int n_planes;
    float *shift; /* that a row's places add to radii; NULL: nothing */
    int shift_y;  /* the row that it is of; -1: none yet */
    struct rf_lens lens;
    float most; /* magnitude of a radius */
};

/* The radius at a place of the scene; beyond the border as at the picture's edge. */
static float radius_at(struct putting *p, double depth, int x, int y)
{
    const struct rf_picture *picture = p->picture;
    const struct rf_frame *f = picture->frame;
    float r = (float)rf_lens_radius_px(&p->lens, depth);
    if (p->shift) {
        int column = rf_min_int(rf_max_int(x - picture->x0, 0), f->width - 1);
        int row = rf_min_int(rf_max_int(y - picture->y0, 0), f->height - 1);
        if (row != p->shift_y)
            rf_field_row(f, row, p->shift);
        p->shift_y = row;
        r += p->shift[column];
    }
    return rf_min_float(rf_max_float(r, -p->most), p->most);
}

/* How much of pixel (x, y) of the scene hides a light of radius r. */
static float hiding_share(const struct rf_picture *picture, float r, int x, int y)
{
    const struct rf_frame *f = picture->frame;
    size_t i = (size_t)y * (size_t)picture->width + (size_t)x;
    if (x < picture->x0 || x >= picture->x0 + f->width || y < picture->y0 ||
        y >= picture->y0 + f->height)
        return 1;
    return r < picture->surfaces.near[i].r + BEHIND_PX ? 0 : picture->surfaces.share[i];
}

static float luminance_of(const struct rf_surface *s)
{
    return rf_luminance(s->c[0], s->c[1], s->c[2]);
}

/* Makes light i a highlight; false: the picture shows it, or it is none. */
static bool put_light(struct putting *p, const struct rf_unseen_light *light, size_t i,
                      struct rf_sample *out)
{
    const struct rf_picture *picture = p->picture;
    double at_x = floor(light->x) + picture->x0, at_y = floor(light->y) + picture->y0;
    if (!(at_x >= 0 && at_x < picture->width && at_y >= 0 && at_y < picture->height))
        return false;
    int x = (int)at_x, y = (int)at_y;
    struct rf_surface s = {.r = radius_at(p, light->depth, x, y)};
    for (int n = 0; n < 3; n++)
        s.c[n] = p->planes[p->n_planes == 1 ? 0 : n][i];
    size_t pixel = (size_t)y * (size_t)picture->width + (size_t)x;
    bool is_estimated = p->estimates->at && rf_found_at(p->estimates, x, y, 1);
    float luminance = luminance_of(&s), share = hiding_share(picture, s.r, x, y);
    float usual = luminance_of(is_estimated ? &p->estimates->at[pixel]
                                            : &picture->surfaces.near[pixel]);
    usual = rf_max_float(usual, 0);
    if (!(share > 0) || !rf_is_highlight(luminance,
                                         rf_field_seen(picture->frame, x - picture->x0,
                                                       y - picture->y0, s.r),
                                         picture->highlight_factor, usual))
        return false;
    *out = rf_sample_make(&s, x, y, share);
    rf_take_light(s.c, out->c, usual / luminance);
    return true;
}

/* Room for the highlights there are and n more. */
static rf_result grow(struct rf_picture *picture, size_t n, struct rf_error *error)
{
    const struct rf_context *context = picture->frame->context;
    size_t n_all = picture->n_highlights + n;
    struct rf_sample *all = rf_alloc(context, n_all, sizeof *all);
    if (!all)
        return rf_fail_memory(error, n_all, sizeof *all);
    if (picture->n_highlights)
        memcpy(all, picture->highlights, picture->n_highlights * sizeof *all);
    rf_free(context, picture->highlights);
    picture->highlights = all;
    return RF_OK;
}

rf_result rf_unseen_lights_put(struct rf_picture *picture,
                               const struct rf_work_view *view,
                               const struct rf_estimates *estimates,
                               struct rf_error *error)
{
    const struct rf_frame *f = picture->frame;
    if (!view->behind || view->behind->n_unseen_lights == 0 ||
        !(picture->highlight_factor > 0))
        return RF_OK;
    const struct rf_unseen_light *lights = view->behind->unseen_lights;
    size_t n = view->behind->n_unseen_lights;
    int n_planes = view->behind->colour.channels;
    size_t n_shift = rf_field_is_used(f) && !f->apart ? (size_t)f->width : 0;
    size_t n_all = n * (size_t)n_planes + n_shift;
    float *memory = rf_alloc(f->context, n_all, sizeof *memory);
    if (!memory)
        return rf_fail_memory(error, n_all, sizeof *memory);
    struct putting p = {.picture = picture,
                        .estimates = estimates,
                        .n_planes = n_planes,
                        .shift = n_shift ? memory + n * (size_t)n_planes : NULL,
                        .shift_y = -1,
                        .lens = rf_field_lens(f),
                        .most = view->largest_radius};
    for (int c = 0; c < n_planes; c++)
        p.planes[c] = memory + n * (size_t)c;
    const struct rf_image colours = {.data = (float *)lights->colour,
                                     .width = (int32_t)n,
                                     .height = 1,
                                     .channels = n_planes,
                                     .channel_bytes = sizeof(float),
                                     .pixel_bytes = sizeof *lights};
    rf_result result = rf_frame_load(f, &colours, p.planes, error);
    if (result == RF_OK)
        result = grow(picture, n, error);
    for (size_t i = 0; i < n && result == RF_OK; i++)
        picture->n_highlights +=
            put_light(&p, &lights[i], i, &picture->highlights[picture->n_highlights]);
    rf_free(f->context, memory);
    return result;
}
