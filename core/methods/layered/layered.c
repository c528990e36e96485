/* SPDX-License-Identifier: Apache-2.0 */
/*
 * layered: occlusion-aware depth of field from one view; the default.
 *
 * Every pixel is a small emitter that spreads over its aperture's footprint. The steps,
 * each in a module of its own:
 *
 * - border: the surfaces there go on beyond it (border.c)
 * - split: edge pixels become their two surfaces (split.c)
 * - highlights, but for parts of something large: their light is taken out and added
 * at the end, each with the exact shape that things before it leave (highlights_add.c)
 * - hidden: background that only the lens can see is estimated (hidden.c)
 * - composite: samples near to far, then the hidden ones (composite.c); slanted
 * surfaces as each cell of the lens sees them (slants.c)
 * - smooth: a smooth surface near the focus has no holes (smooth.c)
 * - gaps: what is still open looks like the pixels around (gaps.c)
 *
 * Ours; reading: Kosloff 2009 (spreading), Lee, Eisemann and Seidel 2009 (layers), the
 * coverage partition of deep compositing. Approximates: one hidden surface behind each
 * pixel; surfaces without slope within a cell of the lens; bins of 2 px of radius;
 * radii above 8 px at a reduced resolution. Mirrors and glass are blurred by the depth
 * of their surface.
 */
#include "methods/layered/layered.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/common.h"
#include "compose/composite.h"
#include "compose/emit.h"
#include "compose/highlights_find.h"
#include "compose/known_hidden.h"
#include "compose/scene.h"
#include "compose/unseen_lights.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

struct layered {
    struct rf_picture picture;
    struct rf_estimates hidden;
};

static struct rf_emission visible_emission(void *user, int x, int y, int n)
{
    const struct layered *state = user;
    return rf_picture_emission(&state->picture, x, y, n);
}

static int emit_visible(void *user, int x, int y, struct rf_sample *at)
{
    const struct layered *state = user;
    struct rf_samples out = {at, 0};
    rf_picture_emit_pixel(&state->picture, x, y, &out);
    return (int)out.n;
}

static struct rf_emission hidden_emission(void *user, int x, int y, int n)
{
    const struct layered *state = user;
    return (struct rf_emission){rf_found_at(&state->hidden, x, y, n), 0};
}

static rf_result find_hidden(struct layered *state, struct rf_task *task,
                             struct rf_error *error)
{
    const struct rf_pixels *pixels = &state->picture.pixels;
    struct rf_radii radii = {rf_plane_row(pixels, pixels->radius, 0), pixels->stride};
    rf_task_phase(task, 0.4, rf_hidden_steps(state->picture.height));
    return rf_find_hidden(state->picture.frame, &state->picture.surfaces, &radii, NULL,
                          &state->hidden, task, error);
}

/*
 * The colours one by one, of the same surfaces: radii that are larger by as much
 * everywhere stand as far before each other. Alpha is that of green.
 */
static rf_result composite_colours(const struct rf_scene *scene, struct rf_work *work,
                                   struct rf_error *error)
{
    const struct rf_frame *f = scene->frame;
    const size_t n = (size_t)f->width * (size_t)f->height;
    const double from = scene->task->to, room = scene->progress_to - from;
    work->planes = rf_alloc(f->context, n * (size_t)work->n_planes, sizeof(float));
    if (!work->planes)
        return rf_fail_memory(error, n * (size_t)work->n_planes, sizeof(float));
    for (int p = 0; p < work->n_planes; p++)
        work->colour[p] = work->planes + n * (size_t)p;
    work->stride = (size_t)f->width;
    work->out = NULL;
    struct rf_common common = {.has_lists = f->params.axial_chroma == 0};
    rf_result result = RF_OK;
    for (int i = 0; i < RF_N_COLOURS && result == RF_OK; i++) {
        struct rf_frame frame = *f;
        struct rf_scene one = *scene;
        struct rf_work to = *work;
        frame.colour = one.colour = 1 + i;
        one.radius_shift = (float)rf_frame_colour_shift(f, i);
        one.common = &common;
        one.frame = &frame;
        one.progress_to = from + (i + 1) * room / RF_N_COLOURS;
        for (int p = 0; p < work->n_planes; p++)
            if (p != i && !(i == 1 && p == RF_N_COLOURS))
                to.colour[p] = NULL;
        if (!rf_task_is_cancelled(scene->task))
            result = rf_composite_crop(&one, &to, error);
    }
    rf_common_free(&common, f->context);
    return result;
}

static rf_result run(struct layered *state, struct rf_work *work,
                     struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    const struct rf_params *params = &f->params;
    struct rf_work_view *view = &work->views[0];
    float largest = work->largest_radius;
    if (f->by_colour)
        largest += fabsf((float)params->axial_chroma);
    int border = rf_picture_border(largest);
    rf_task_phase(work->task, 0.15, work->frame->height + 2 * border);
    rf_result result =
        rf_picture_load(&state->picture, work->frame, view, work->n_planes, border,
                        RF_KEPT_RADII, work->task, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task))
        return result;
    if (params->exact_highlights)
        result =
            rf_picture_take_highlights(&state->picture, view, work->n_planes, error);
    rf_work_drop_views(work);
    rf_task_poll(work->task);
    if (result == RF_OK && params->fill_hidden)
        result = find_hidden(state, work->task, error);
    if (result == RF_OK && state->hidden.at && !rf_task_is_cancelled(work->task))
        result = rf_known_hidden_put(&state->picture, view, &state->hidden, error);
    if (result == RF_OK && !rf_task_is_cancelled(work->task))
        result = rf_unseen_lights_put(&state->picture, view, &state->hidden, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task))
        return result;
    const struct rf_pixels *pixels = &state->picture.pixels;
    const float *radius = rf_plane_row(pixels, pixels->radius, 0);
    struct rf_occluders occluders = {.surfaces = &state->picture.surfaces,
                                     .radius = radius,
                                     .radius_stride = pixels->stride,
                                     .behind = state->picture.behind,
                                     .behind_stride = state->picture.behind_stride,
                                     .estimates =
                                         state->hidden.at ? &state->hidden : NULL};
    struct rf_scene scene = {
        .frame = work->frame,
        .width = state->picture.width,
        .height = state->picture.height,
        .x0 = state->picture.x0,
        .y0 = state->picture.y0,
        .n_phases = 1,
        .is_opaque =
            view->survey ? view->survey->n_transparent == 0 : !state->picture.has_alpha,
        .insides = state->hidden.insides.blocks ? &state->hidden.insides : NULL,
        .fills_gaps = params->fill_hidden,
        .highlights = {state->picture.highlights, state->picture.n_highlights},
        .n_views = 1,
        .occluders = &occluders,
        .whole_radius = params->fill_hidden ? radius : NULL,
        .whole_stride = pixels->stride,
        .whole_from = {1, 1},
        .whole_to = {state->picture.width - 1, state->picture.height - 1},
        .task = work->task,
        .progress_to = 1};
    scene.visible_source = (struct rf_source){.emission = visible_emission,
                                              .emit = emit_visible,
                                              .user = state,
                                              .surfaces = state->picture.surfaces.near,
                                              .radius = radius,
                                              .radius_stride = pixels->stride,
                                              .most_per_pixel = 4,
                                              .largest_radius = largest};
    memcpy(scene.least, view->survey ? view->survey->least : state->picture.least,
           sizeof scene.least);
    if (state->hidden.at)
        scene.hidden_source = (struct rf_source){.emission = hidden_emission,
                                                 .user = state,
                                                 .surfaces = state->hidden.at,
                                                 .most_per_pixel = 1,
                                                 .largest_radius = largest};
    return f->by_colour ? composite_colours(&scene, work, error)
                        : rf_composite_crop(&scene, work, error);
}

rf_result rf_layered_run(struct rf_work *work, struct rf_error *error)
{
    const struct rf_context *context = work->frame->context;
    struct layered state = {.hidden = {.width = 0}};
    rf_result result = run(&state, work, error);
    rf_estimates_free(&state.hidden, context);
    rf_picture_free(&state.picture);
    return result;
}
