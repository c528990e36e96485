/* SPDX-License-Identifier: Apache-2.0 */
/*
 * layered: occlusion-aware depth of field from one view; the default.
 *
 * Every pixel is a small emitter that spreads over its aperture's footprint. The steps,
 * each in a module of its own:
 *
 * - border: the picture is continued by its edge pixels, bright ones dimmed to white
 * - split: edge pixels become their two surfaces (split.c)
 * - highlights: their light is taken out and added at the end, each with the exact
 * shape that things before it leave (highlight.c)
 * - hidden: background that only the lens can see is estimated (hidden.c)
 * - composite: samples near to far, then the hidden ones (composite.c)
 *
 * Ours; reading: Kosloff 2009 (spreading), Lee, Eisemann and Seidel 2009 (layers), the
 * coverage partition of deep compositing. Approximates: one hidden surface behind each
 * pixel; surfaces without slope; bins of 2 px of radius; radii above 8 px at a reduced
 * resolution. Mirrors and glass are blurred by the depth of their surface.
 */
#include "../picture.h"

struct layered {
    struct rf_picture picture;
    struct rf_surface *hidden;
    float *hidden_weight;
    struct rf_sample *samples;
};

struct collector {
    const struct layered *l;
    struct rf_samples out;
};

static void collect(void *user, struct rf_surface *s, int x, int y, float w)
{
    struct collector *c = user;
    rf_picture_emit(&c->l->picture, rf_sample_make(s, x, y, w), x, y, &c->out);
}

static void collect_hidden(const struct layered *l, int y, struct rf_samples *out)
{
    int width = l->picture.width;
    for (int x = 0; x < width; x++) {
        size_t i = (size_t)y * (size_t)width + (size_t)x;
        if (!(l->hidden_weight[i] > 0))
            continue;
        if (out->at)
            out->at[out->n] = rf_sample_make(&l->hidden[i], x, y, l->hidden_weight[i]);
        out->n++;
    }
}

/* Row y of the visible samples or, from `height` on, of the hidden ones. */
static size_t collect_row(void *user, int y, struct rf_sample *at)
{
    struct layered *l = user;
    struct collector c = {.l = l, .out = {at, 0}};
    if (y < l->picture.height)
        rf_picture_visit_row(&l->picture, y, collect, &c);
    else
        collect_hidden(l, y - l->picture.height, &c.out);
    return c.out.n;
}

static rf_result find_hidden(struct layered *l, struct rf_task *task,
                             struct rf_error *error)
{
    const struct rf_filter *f = l->picture.filter;
    size_t n = (size_t)l->picture.width * (size_t)l->picture.height;
    l->hidden = rf_alloc(f->context, n, sizeof *l->hidden);
    l->hidden_weight = rf_alloc(f->context, n, sizeof *l->hidden_weight);
    if (!l->hidden || !l->hidden_weight)
        return rf_fail_memory(error, n, sizeof *l->hidden);
    rf_task_phase(task, 0.4, rf_hidden_steps(l->picture.height));
    return rf_find_hidden(f, &l->picture.surfaces, l->hidden, l->hidden_weight, task,
                          error);
}

static rf_result run(struct layered *l, struct rf_work *work, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    const struct rf_params *params = &f->params;
    struct rf_work_view *view = &work->views[0];
    int border = rf_picture_border(work->largest_radius);
    rf_task_phase(work->task, 0.15, work->filter->height + 2 * border);
    rf_result result = rf_picture_load(&l->picture, work->filter, view, work->n_planes,
                                       border, work->task, error);
    if (result == RF_OK && params->exact_highlights)
        result = rf_picture_take_highlights(&l->picture, view, work->n_planes, error);
    rf_task_poll(work->task);
    if (result == RF_OK && params->fill_hidden)
        result = find_hidden(l, work->task, error);
    if (result != RF_OK || rf_task_is_cancelled(work->task))
        return result;
    struct rf_occluders occluders = {.surfaces = &l->picture.surfaces};
    struct rf_scene scene = {.filter = work->filter,
                             .width = l->picture.width,
                             .height = l->picture.height,
                             .x0 = l->picture.x0,
                             .y0 = l->picture.y0,
                             .n_phases = 1,
                             .is_opaque = f->survey ? f->survey->n_transparent == 0
                                                    : !l->picture.has_alpha,
                             .highlights = l->picture.highlights,
                             .n_views = 1,
                             .occluders = &occluders,
                             .task = work->task,
                             .progress_to = 1};
    int height = l->picture.height;
    result = rf_collect_rows(&scene, height, l->hidden ? 2 * height : height,
                             collect_row, l, &l->samples, error);
    if (result == RF_OK)
        result = rf_composite_crop(&scene, work, error);
    return result;
}

rf_result rf_layered_run(struct rf_work *work, struct rf_error *error)
{
    if (work->filter->params.quality == RF_QUALITY_PREVIEW)
        return rf_layered_preview_run(work, error);
    const struct rf_context *context = work->filter->context;
    struct layered l = {.hidden = NULL};
    rf_result result = run(&l, work, error);
    rf_free(context, l.samples);
    rf_free(context, l.hidden_weight);
    rf_free(context, l.hidden);
    rf_picture_free(&l.picture);
    return result;
}
