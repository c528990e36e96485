/* SPDX-License-Identifier: Apache-2.0 */
/* The filter object: checks, and the way from views to pixels. */
#include "api/filter.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "api/chroma.h"
#include "api/focuses.h"
#include "api/seen.h"
#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "base/task.h"
#include "input/depth.h"
#include "input/field.h"
#include "input/frame.h"
#include "input/highlights.h"
#include "compose/light_map.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "input/white.h"
#include "lens/aperture.h"
#include "lens/params.h"
#include "methods/methods.h"
#include "input/bokeh.h"
#include "rackfocus/rackfocus.h"

enum { NORMAL_CELLS = 3 }; /* quality normal: 0.07 dB below 4 at the most */

/* Looks of a method whose blur has no place for them come to nothing; the circles of
 * scatter are a plain lens. */
static void settle_looks(struct rf_params *params)
{
    if (params->method == RF_METHOD_ACCUMULATE) {
        params->tilt_x = params->tilt_y = params->field_curvature = 0;
        params->split_diopter = 0;
    }
    if (rf_method_find(params->method)->has_layers)
        return;
    params->astigmatism = params->swirl = params->spherical = 0;
    params->obstruction = 0;
    if (params->method == RF_METHOD_SCATTER &&
        params->distribution != RF_DISTRIBUTION_IMAGE) {
        params->aperture = RF_APERTURE_DISC;
        params->aperture_ratio = 1;
        return;
    }
    if (params->method != RF_METHOD_SCATTER)
        params->axial_chroma = params->lateral_chroma = 0;
    params->cat_eye = 0;
    params->barn_left = params->barn_right = 0;
    params->barn_top = params->barn_bottom = 0;
}

/* The weights that stages of a preview show are no light, which the white scales. */
static void settle_stage(struct rf_params *params)
{
    if (rf_method_find(params->method)->has_blend &&
        (params->stage == RF_STAGE_ALPHA || params->stage == RF_STAGE_SLICES))
        params->white = 1;
}

static void settle_params(struct rf_filter *f, const struct rf_params *params)
{
    struct rf_frame *frame = &f->frame;
    rf_params_complete(&frame->params, params);
    if (frame->params.quality == RF_QUALITY_NORMAL)
        frame->params.sub_apertures =
            rf_min_int(frame->params.sub_apertures, NORMAL_CELLS);
    settle_looks(&frame->params);
    settle_stage(&frame->params);
    rf_shape_init(&frame->shape, &frame->params);
}

/* Where the light of the aperture is not even: of its picture, of a mirror lens. */
static rf_result make_bokeh(struct rf_filter *f, const struct rf_image *distribution,
                            struct rf_error *error)
{
    struct rf_frame *frame = &f->frame;
    rf_result result = RF_OK;
    if (distribution)
        result = rf_bokeh_make(&f->bokeh, frame->context, distribution, error);
    struct rf_hollow hollow = {.n = 0};
    if (rf_method_find(frame->params.method)->has_layers)
        rf_hollow_init(&hollow, &frame->params);
    f->frame.is_hollow = hollow.n > 0;
    if (result == RF_OK && (frame->params.obstruction > 0 || hollow.n > 0))
        result = rf_bokeh_make_hollow(&f->ring, frame->context, &hollow,
                                      frame->params.obstruction, error);
    frame->bokeh = f->bokeh;
    frame->ring = f->ring;
    return result;
}

rf_result rf_params_check(const struct rf_params *params, struct rf_error *error)
{
    struct rf_params full;
    rf_result result = rf_params_check_ranges(params, error);
    if (result != RF_OK)
        return result;
    rf_params_complete(&full, params);
    if (full.stage == RF_STAGE_LEVELS && rf_method_find(full.method)->has_blend &&
        full.method != RF_METHOD_MIPMAP && full.method != RF_METHOD_MIPMAP_OFFSET)
        return rf_fail(error, RF_ERROR_PARAMETER, "stage",
                       "the stage levels is of the methods mipmap and mipmap-offset: "
                       "the method %s has no levels of detail; set stage to result",
                       rf_method_find(full.method)->name);
    return RF_OK;
}

rf_result rf_filter_create(struct rf_filter **filter, const struct rf_context *context,
                           const struct rf_params *params, int32_t width,
                           int32_t height, struct rf_error *error)
{
    return rf_filter_create_with(filter, context, params, width, height, NULL, error);
}

rf_result rf_filter_create_with(struct rf_filter **filter,
                                const struct rf_context *context,
                                const struct rf_params *params, int32_t width,
                                int32_t height, const struct rf_image *distribution,
                                struct rf_error *error)
{
    if (!filter || !context || !params)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter    ? "filter"
                       : !context ? "context"
                                  : "params",
                       "a pointer is NULL");
    struct rf_lens lens;
    rf_result result = rf_lens_init(&lens, params, width, height, error);
    if (result == RF_OK)
        result = rf_params_check(params, error);
    if (result != RF_OK)
        return result;
    if (!distribution && params->aperture == RF_APERTURE_IMAGE &&
        rf_method_find(params->method)->has_layers)
        return rf_fail(error, RF_ERROR_PARAMETER, "aperture",
                       "the aperture image needs its picture: none was given");
    struct rf_filter *f = rf_calloc(context, 1, sizeof *f);
    if (!f)
        return rf_fail_memory(error, 1, sizeof *f);
    f->frame = (struct rf_frame){.context = context,
                                 .lens = lens,
                                 .width = width,
                                 .height = height,
                                 .place = {0, 0, width, height}};
    settle_params(f, params);
    result = make_bokeh(f, distribution, error);
    if (result != RF_OK) {
        rf_filter_destroy(f);
        return result;
    }
    *filter = f;
    return RF_OK;
}

void rf_filter_destroy(struct rf_filter *filter)
{
    if (!filter)
        return;
    const struct rf_context *context = filter->frame.context;
    rf_bokeh_free(filter->bokeh, context);
    rf_bokeh_free(filter->ring, context);
    rf_free(context, filter);
}

const struct rf_lens *rf_filter_lens(const struct rf_filter *filter)
{
    return &filter->frame.lens;
}

/* The picture as it came, all of it in focus: bit for bit but for highlights. */
static rf_result copy_sharp(const struct rf_frame *f, const struct rf_image *colour,
                            const struct rf_image *out, struct rf_error *error)
{
    if (!rf_highlights_are_changed(&f->params) &&
        rf_frame_copy(f->context, colour, out))
        return RF_OK;
    rf_result result = rf_frame_check(f, colour, error);
    if (result == RF_OK)
        rf_frame_copy_light(&f->params, colour, out);
    return result;
}

/* Loads the views, runs the method and stores what it has not stored itself. */
static rf_result run(struct rf_work *work, const struct rf_view *views,
                     const struct rf_image *out, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    int64_t n_known; /* a part may be without depths, a whole picture may not */
    bool is_part = f->width < f->place.whole_width || f->height < f->place.whole_height;
    rf_result result =
        rf_work_load_depth(work, views, is_part ? &n_known : NULL, error);
    if (result == RF_OK && rf_work_is_sharp(work))
        return copy_sharp(f, &views->colour, out, error);
    if (result == RF_OK)
        result = rf_work_load_light(work, views, error);
    if (result == RF_OK)
        result = rf_method_run(f->params.method)(work, error);
    if (result == RF_OK && rf_task_is_cancelled(work->task))
        result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    if (result == RF_OK && work->colour[0])
        rf_frame_store(f->context, &f->params, work->colour, work->stride, out);
    return result;
}

static rf_result check_behind(const struct rf_frame *f, const struct rf_view *view,
                              struct rf_error *error)
{
    rf_result result = rf_image_check(&view->behind_colour, "behind_colour", f->width,
                                      f->height, error);
    if (result == RF_OK)
        result = rf_image_check_one(&view->behind_depth, "behind_depth", f->width,
                                    f->height, error);
    if (result == RF_OK && view->behind_colour.channels != view->colour.channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, "behind_colour",
                         "behind_colour has %d channels and colour %d: give both the "
                         "same",
                         view->behind_colour.channels, view->colour.channels);
    return result;
}

static rf_result check_lights(const struct rf_view *view, struct rf_error *error)
{
    if (view->n_unseen_lights > INT32_MAX / 4 ||
        (view->n_unseen_lights > 0 && !view->unseen_lights))
        return rf_fail(error, RF_ERROR_ARGUMENT, "unseen_lights",
                       "%zu unseen lights are %s", view->n_unseen_lights,
                       view->unseen_lights ? "too many" : "said to be at NULL");
    for (size_t i = 0; i < view->n_unseen_lights; i++) {
        const struct rf_unseen_light *light = &view->unseen_lights[i];
        bool is_good = isfinite(light->x) && isfinite(light->y) && light->depth > 0;
        for (int c = 0; c < view->colour.channels; c++)
            is_good &= isfinite(light->colour[c]);
        if (!is_good)
            return rf_fail(error, RF_ERROR_ARGUMENT, "unseen_lights",
                           "unseen light %zu has a place or colour that is not finite, "
                           "or no depth above 0",
                           i);
    }
    return RF_OK;
}

static rf_result check_view(const struct rf_frame *f, const struct rf_view *view,
                            const struct rf_image *out, struct rf_error *error)
{
    rf_result result =
        rf_image_check(&view->colour, "colour", f->width, f->height, error);
    if (result == RF_OK)
        result = rf_image_check_one(&view->depth, "depth", f->width, f->height, error);
    if (result == RF_OK && out->channels != view->colour.channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, "out",
                         "out has %d channels and colour %d: give both the same",
                         out->channels, view->colour.channels);
    if (result == RF_OK && (view->behind_colour.data || view->behind_depth.data))
        result = check_behind(f, view, error);
    if (result == RF_OK && view->mean_depth.data)
        result = rf_image_check_one(&view->mean_depth, "mean_depth", f->width,
                                    f->height, error);
    if (result == RF_OK)
        result = check_lights(view, error);
    return result == RF_OK ? rf_view_check_place(view, error) : result;
}

static rf_result check_views(const struct rf_filter *filter,
                             const struct rf_view *views, int32_t n_views,
                             const struct rf_image *out, struct rf_error *error)
{
    if (!filter || !views || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter  ? "filter"
                       : !views ? "views"
                                : "out",
                       "a pointer is NULL");
    const struct rf_frame *f = &filter->frame;
    const struct rf_method_info *method = rf_method_find(f->params.method);
    if (n_views < 1 || n_views > method->max_views)
        return rf_fail(error, RF_ERROR_ARGUMENT, "n_views",
                       "%d views were given; the method %s takes 1 to %d", n_views,
                       method->name, method->max_views);
    rf_result result = rf_image_check_out(out, "out", f->width, f->height, 0, error);
    if (result == RF_OK)
        result = rf_view_check_size(views, error);
    struct rf_view known[RF_MAX_VIEWS];
    if (result == RF_OK)
        rf_views_copy(known, views, n_views);
    for (int j = 0; j < n_views && result == RF_OK; j++)
        result = check_view(f, &known[j], out, error);
    return result == RF_OK ? rf_seen_check(f, known, n_views, error) : result;
}

/* Makes the picture of a frame, of views in order. */
static rf_result process(const struct rf_frame *f, const struct rf_view *views,
                         int n_views, const struct rf_image *out,
                         const struct rf_progress *progress, struct rf_error *error)
{
    struct rf_task task;
    rf_task_begin(&task, progress);
    if (rf_task_is_cancelled(&task))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    struct rf_work_view work_views[RF_MAX_VIEWS] = {{.radius = NULL}};
    struct rf_work work = {.frame = f,
                           .n_planes = views->colour.channels,
                           .out = rf_image_is_plain(&f->params, out) ? out : NULL,
                           .stride = (size_t)f->width,
                           .n_views = n_views,
                           .views = work_views,
                           .task = &task};
    rf_result result = run(&work, views, out, error);
    if (result == RF_OK)
        result = rf_take_vignette(f, 0, 0, out, error);
    rf_work_free(&work);
    if (result == RF_OK)
        rf_task_end(&task);
    return result;
}

/* Makes the picture of views that were rendered for a plane. */
static rf_result process_moved(const struct rf_frame *f, const struct rf_view *views,
                               int n_views, const struct rf_image *out,
                               const struct rf_progress *progress,
                               struct rf_error *error)
{
    if (!(n_views > 1 && rf_field_is_on(&f->params)) ||
        f->params.quality == RF_QUALITY_PREVIEW) /* of the view in the middle alone */
        return process(f, views, n_views, out, progress, error);
    struct rf_frame apart = *f;
    const struct rf_field field = rf_field_of(f);
    apart.apart = &field;
    return process(&apart, views, n_views, out, progress, error);
}

/* Makes the picture of a split diopter. */
static rf_result process_focuses(const struct rf_frame *f, const struct rf_view *views,
                                 int n_views, const struct rf_image *out,
                                 const struct rf_progress *progress,
                                 struct rf_error *error)
{
    return rf_focuses_process(f, views, n_views, out, progress, process_moved, error);
}

/* Makes the picture colour by colour where that is asked for. */
static rf_result process_colours(const struct rf_frame *f, const struct rf_view *views,
                                 int n_views, const struct rf_image *out,
                                 const struct rf_progress *progress,
                                 struct rf_error *error)
{
    rf_process_fn make = rf_focuses_are_on(f) ? process_focuses : process_moved;
    return rf_chroma_is_on(f, out->channels)
               ? rf_chroma_process(f, views, n_views, out, progress, make, error)
               : make(f, views, n_views, out, progress, error);
}

/* Makes the picture of views whose white is 1. */
static rf_result process_whitened(const struct rf_whitened *w, int n_views,
                                  const struct rf_image *out,
                                  const struct rf_progress *progress,
                                  struct rf_error *error)
{
    const struct rf_frame *f = &w->frame;
    rf_result result =
        w->views[0].n_seen > 0
            ? rf_seen_process(f, w->views, n_views, out, progress, process_colours,
                              error)
            : process_colours(f, w->views, n_views, out, progress, error);
    if (result == RF_OK)
        rf_unwhiten(f, out);
    return result;
}

rf_result rf_filter_process(const struct rf_filter *filter, const struct rf_view *views,
                            int32_t n_views, const struct rf_image *out,
                            const struct rf_progress *progress, struct rf_error *error)
{
    struct rf_view known[RF_MAX_VIEWS];
    struct rf_whitened whitened;
    struct rf_frame_progress whole;
    rf_result result = check_views(filter, views, n_views, out, error);
    if (result != RF_OK)
        return result;
    if (!rf_frame_progress_begin(&whole, progress))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    rf_views_copy(known, views, n_views);
    result = rf_whiten(&whitened, &filter->frame, known, n_views, error);
    if (result == RF_OK)
        result = process_whitened(&whitened, n_views, out,
                                  rf_frame_progress_tasks(&whole), error);
    rf_whitened_free(&whitened);
    if (result == RF_OK)
        rf_frame_progress_end(&whole);
    return result;
}

static rf_result convert(const struct rf_filter *filter, const struct rf_image *depth,
                         const struct rf_image *out, bool is_radius,
                         struct rf_error *error)
{
    if (!filter)
        return rf_fail(error, RF_ERROR_ARGUMENT, "filter", "filter is NULL");
    const struct rf_frame *f = &filter->frame;
    int w = f->width, h = f->height;
    rf_result result = rf_image_check_one(depth, "depth", w, h, error);
    if (result == RF_OK)
        result = rf_image_check_out(out, "out", w, h, 1, error);
    if (result != RF_OK)
        return result;
    const struct rf_context *context = f->context;
    size_t n = (size_t)w * (size_t)h;
    float *memory = rf_alloc(context, n, sizeof(float));
    if (!memory)
        return rf_fail_memory(error, n, sizeof(float));
    result = rf_depth_to_radius(f, depth, is_radius ? memory : NULL,
                                is_radius ? NULL : memory, NULL, NULL, error);
    float unused;
    if (result == RF_OK && is_radius)
        rf_field_apply(f, memory, &unused);
    if (result == RF_OK) {
        struct rf_image packed = rf_image_packed(memory, w, h, 1);
        rf_image_copy(&packed, out);
    }
    rf_free(context, memory);
    return result;
}

rf_result rf_filter_coc(const struct rf_filter *filter, const struct rf_image *depth,
                        const struct rf_image *out, struct rf_error *error)
{
    return convert(filter, depth, out, true, error);
}

rf_result rf_filter_planar_depth(const struct rf_filter *filter,
                                 const struct rf_image *depth,
                                 const struct rf_image *out, struct rf_error *error)
{
    return convert(filter, depth, out, false, error);
}

rf_result rf_apply(const struct rf_params *params, const struct rf_image *colour,
                   const struct rf_image *depth, const struct rf_image *out,
                   struct rf_error *error)
{
    if (!params || !colour || !depth || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT, "",
                       "params, colour, depth and out must not be NULL");
    struct rf_context *context;
    rf_result result = rf_context_create(&context, NULL, error);
    if (result != RF_OK)
        return result;
    struct rf_filter *filter = NULL;
    result = rf_filter_create(&filter, context, params, colour->width, colour->height,
                              error);
    if (result == RF_OK) {
        struct rf_view view = {.colour = *colour, .depth = *depth};
        result = rf_filter_process(filter, &view, 1, out, NULL, error);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return result;
}
