/* SPDX-License-Identifier: Apache-2.0 */
/* The filter object: checks, the list of methods, and the way from views to pixels. */
#include <omp.h>

#include "distribution.h"
#include "internal.h"
#include "methods/preview.h"

enum { NORMAL_CELLS = 3 }; /* quality normal: 0.07 dB below 4 at the most */

/* One line per method, in the order of RF_LIST_METHOD. */
static const struct rf_method_entry entries[] = {
    [RF_METHOD_LAYERED] = {.run = rf_layered_run},
    [RF_METHOD_SCATTER] = {.run = rf_scatter_run},
    [RF_METHOD_BOX] = {.run = rf_box_run},
    [RF_METHOD_LOWRES] = {.run = rf_lowres_run},
    [RF_METHOD_MIPMAP] = {.run = rf_mipmap_run},
    [RF_METHOD_OFFSET] = {.run = rf_offset_run},
    [RF_METHOD_MIPMAP_OFFSET] = {.run = rf_mipmap_offset_run},
    [RF_METHOD_RECURSIVE_OFFSET] = {.run = rf_recursive_offset_run},
    [RF_METHOD_VIEWS] = {.run = rf_views_run, .max_views = RF_MAX_VIEWS},
    [RF_METHOD_ACCUMULATE] = {.run = rf_accumulate_run, .max_views = RF_MAX_VIEWS},
};

#define THESIS "thesis on depth of field in a surgical simulator: "

static const struct rf_method_info infos[] = {
    [RF_METHOD_LAYERED] = {"layered",
                           "occlusion-aware layers from one view; the default",
                           "grows with the mean area of the blur",
                           "Rack Focus; after Kosloff 2009, Lee et al. 2009"},
    [RF_METHOD_SCATTER] = {"scatter", "each pixel spread over its circle of confusion",
                           "grows with the mean radius of the blur", "Yu 2004"},
    [RF_METHOD_BOX] = {"box", "preview: running sums along rows and columns",
                       "the same for every radius", THESIS "convolution"},
    [RF_METHOD_LOWRES] = {"lowres", "preview: a small picture, magnified",
                          "the same for every radius; the cheapest",
                          THESIS "low resolution"},
    [RF_METHOD_MIPMAP] = {"mipmap", "preview: coarser levels of detail, magnified",
                          "the same for every radius", THESIS "mipmap"},
    [RF_METHOD_OFFSET] = {"offset", "preview: shifted copies, averaged",
                          "grows with the number of copies", THESIS "offset"},
    [RF_METHOD_MIPMAP_OFFSET] = {"mipmap-offset",
                                 "preview: four shifts of a coarser level of detail",
                                 "the same for every radius",
                                 THESIS "offset on mipmaps"},
    [RF_METHOD_RECURSIVE_OFFSET] =
        {"recursive-offset", "preview: four shifts in x, four in +, again and again",
         "grows with the number of recursions", THESIS "recursive offset"},
    [RF_METHOD_VIEWS] = {"views", "several views from points of the lens, merged",
                         "about the sum of the views' layered passes", "Rack Focus"},
    [RF_METHOD_ACCUMULATE] = {"accumulate", "the mean of views; needs no depth",
                              "the renders of the views",
                              "OpenGL programming guide; OpenGL wikibook"},
};

const struct rf_method_info *rf_method_list(size_t *n)
{
    if (n)
        *n = sizeof infos / sizeof infos[0];
    return infos;
}

/* ---- progress ------------------------------------------------------------------ */

static const double LEAST_STEP = 1.0 / 4096; /* callers may redraw at each report */

static void ask(struct rf_task *task)
{
    if (task->progress && task->progress->report &&
        !task->progress->report(task->progress->user, task->last))
        __atomic_store_n(&task->cancelled, 1, __ATOMIC_RELAXED);
}

static void report(struct rf_task *task, double fraction)
{
    if (task->last >= 0 && fraction < task->last + LEAST_STEP && fraction < 1)
        return;
    task->last = fraction;
    ask(task);
}

void rf_task_begin(struct rf_task *task, const struct rf_progress *progress)
{
    *task = (struct rf_task){.progress = progress, .last = -1};
    report(task, 0);
}

void rf_task_end(struct rf_task *task)
{
    report(task, 1);
}

void rf_task_phase(struct rf_task *task, double to, int64_t n_steps)
{
    task->from = task->to;
    task->to = to;
    task->n_steps = n_steps;
    task->n_done = 0;
}

bool rf_task_poll(struct rf_task *task)
{
    if (omp_get_thread_num() == 0 && !rf_task_is_cancelled(task))
        ask(task);
    return !rf_task_is_cancelled(task);
}

bool rf_task_is_cancelled(const struct rf_task *task)
{
    return __atomic_load_n(&task->cancelled, __ATOMIC_RELAXED) != 0;
}

bool rf_task_step(struct rf_task *task)
{
    int64_t done = __atomic_add_fetch(&task->n_done, 1, __ATOMIC_RELAXED);
    /* The master of a parallel region is the thread that entered it. */
    if (omp_get_thread_num() == 0 && !rf_task_is_cancelled(task))
        report(task, fmin(task->from + (task->to - task->from) * (double)done /
                                           (double)task->n_steps,
                          0.999));
    return !rf_task_is_cancelled(task);
}

/* ---- filter -------------------------------------------------------------------- */

rf_result rf_filter_create(struct rf_filter **filter, const struct rf_context *context,
                           const struct rf_params *params, int32_t width,
                           int32_t height, struct rf_error *error)
{
    if (!filter || !context || !params)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter    ? "filter"
                       : !context ? "context"
                                  : "params",
                       "a pointer is NULL");
    if (width < 1 || height < 1 || width > UINT16_MAX || height > UINT16_MAX)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       width < 1 || width > UINT16_MAX ? "width" : "height",
                       "%d x %d px: each side must lie in 1 to 65535", width, height);
    struct rf_lens lens;
    rf_result result = rf_lens_init(&lens, params, width, height, error);
    if (result != RF_OK)
        return result;
    struct rf_filter *f = rf_alloc(context, 1, sizeof *f);
    if (!f)
        return rf_fail_memory(error, 1, sizeof *f);
    *f = (struct rf_filter){
        .context = context,
        .lens = lens,
        .width = width,
        .height = height,
        .place = {0, 0, width, height},
    };
    rf_params_complete(&f->params, params);
    if (f->params.quality == RF_QUALITY_NORMAL)
        f->params.sub_apertures = rf_min_int(f->params.sub_apertures, NORMAL_CELLS);
    rf_shape_init(&f->shape, &f->params);
    *filter = f;
    return RF_OK;
}

void rf_filter_destroy(struct rf_filter *filter)
{
    if (!filter)
        return;
    rf_bokeh_free(filter);
    rf_free(filter->context, filter);
}

const struct rf_lens *rf_filter_lens(const struct rf_filter *filter)
{
    return &filter->lens;
}

/*
 * How views shift: rf_work_view.shift_*. A view moved by R u sees a point at distance z
 * moved by u R f_px (1/D - 1/z), D the plane that its shear keeps fixed (1/D = 0 for
 * parallel cameras); with the lens' r = bias + scale / z that is linear in r.
 * Orthographic: u R p (z / D - 1), r = bias + scale z.
 */
void rf_work_view_place(struct rf_work_view *w, const double lens_offset[2],
                        double shear_distance, const struct rf_lens *lens)
{
    double d = shear_distance, radius = lens->lens_radius;
    w->lens[0] = (float)(lens_offset[0] / radius);
    w->lens[1] = (float)(lens_offset[1] / radius);
    double slope, base;
    if (lens->projection == RF_PROJECTION_PERSPECTIVE) {
        slope = -radius * lens->focal_length_px;
        base = d > 0 ? -slope / d : 0;
    } else {
        slope = d > 0 ? radius * lens->px_per_unit / d : 0;
        base = -radius * lens->px_per_unit;
    }
    w->shift_scale = (float)(slope / lens->scale);
    w->shift_bias = (float)(base - slope * lens->bias_px / lens->scale);
}

/* Without sign, floats are in the order of their bits. */
static float largest_of(const struct rf_filter *f, const float *radius)
{
    size_t n = (size_t)f->width * (size_t)f->height;
    int32_t most = 0;
#pragma omp parallel for num_threads(f->context->n_threads) schedule(static)           \
    reduction(max                                                                      \
              : most)
    for (size_t i = 0; i < n; i++) {
        int32_t bits;
        memcpy(&bits, &radius[i], sizeof bits);
        bits &= INT32_MAX;
        most = bits > most ? bits : most;
    }
    float largest;
    memcpy(&largest, &most, sizeof largest);
    return largest;
}

rf_result rf_work_load(struct rf_work *work, int j, const struct rf_view *view,
                       float *memory, int64_t *n_known, const struct rf_image *out,
                       bool *is_copied, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    struct rf_work_view *w = &work->views[j];
    size_t n = (size_t)f->width * (size_t)f->height;
    for (int c = 0; c < work->n_planes; c++)
        w->colour[c] = memory + n * (size_t)(c + 1);
    float largest;
    rf_result result =
        rf_depth_to_radius(f, &view->depth, memory, NULL, n_known, &largest, error);
    if (result != RF_OK)
        return result;
    if (out && work->n_views == 1 && largest < RF_SHARP_PX &&
        rf_frame_copy(f->context, &view->colour, out)) {
        *is_copied = true;
        return RF_OK;
    }
    result = rf_frame_load(f->context, &f->params, &view->colour, &f->place, w->colour,
                           error);
    if (result != RF_OK)
        return result;
    bool is_filled = false;
    if (work->n_planes == 4)
        result = rf_film_fill(f, w->colour[3], memory, &is_filled, error);
    if (is_filled)
        largest = largest_of(f, memory);
    w->radius = memory;
    rf_work_view_place(w, view->lens_offset, view->shear_distance, &f->lens);
    work->largest_radius = rf_max_float(largest, work->largest_radius);
    return result;
}

void rf_work_drop_views(struct rf_work *work)
{
    if (!work->memory)
        return;
    rf_free(work->filter->context, work->memory);
    work->memory = NULL;
    memset(work->colour, 0, sizeof work->colour);
    work->radius = NULL;
}

/* Do two pictures share memory, other than pixel by pixel? */
static bool is_tangled(const struct rf_image *a, const struct rf_image *b)
{
    if (a->data == b->data && a->row_bytes == b->row_bytes)
        return false;
    const char *ends[2][2];
    const struct rf_image *both[] = {a, b};
    for (int i = 0; i < 2; i++) {
        const char *first = (const char *)rf_image_at(both[i], 0, 0, 0);
        const char *last =
            (const char *)rf_image_at(both[i], 0, both[i]->height - 1, 0);
        ends[i][0] = first < last ? first : last;
        ends[i][1] =
            (first < last ? last : first) + (size_t)both[i]->width * 4 * sizeof(float);
    }
    return ends[0][0] < ends[1][1] && ends[1][0] < ends[0][1];
}

/* May the preview read and write the caller's pixels by itself? */
static bool can_stream(const struct rf_work *work, const struct rf_view *view,
                       const struct rf_image *out)
{
    const struct rf_params *p = &work->filter->params;
    return p->method == RF_METHOD_LAYERED && p->quality == RF_QUALITY_PREVIEW &&
           work->n_views == 1 && rf_image_is_plain(p, &view->colour) &&
           rf_image_is_plain(p, out) && !is_tangled(&view->colour, out);
}

/* `memory` holds the radii of a view, which it fills. */
static rf_result stream(struct rf_work *work, const struct rf_view *view, float *memory,
                        const struct rf_image *out, bool *is_done,
                        struct rf_error *error)
{
    rf_result result = rf_depth_to_radius(work->filter, &view->depth, memory, NULL,
                                          NULL, &work->largest_radius, error);
    if (result != RF_OK)
        return result;
    work->radius = work->views->radius = memory;
    if (work->largest_radius < RF_SHARP_PX)
        *is_done = rf_frame_copy(work->filter->context, &view->colour, out);
    else
        result = rf_layered_preview_stream(work, &view->colour, out, is_done, error);
    return result;
}

/* May the method layered or views read the caller's pixels by itself? */
static bool can_read(const struct rf_work *work, const struct rf_view *views)
{
    const struct rf_params *p = &work->filter->params;
    bool is_layered = p->method == RF_METHOD_LAYERED && work->n_views == 1;
    bool is_able = is_layered || p->method == RF_METHOD_VIEWS;
    for (int j = 0; j < work->n_views && is_able; j++)
        is_able = rf_image_is_plain(p, &views[j].colour);
    return is_able && p->quality != RF_QUALITY_PREVIEW;
}

/* Radii and places of the views; work->memory is to hold the radii. */
static rf_result read_depths(struct rf_work *work, const struct rf_view *views,
                             struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    size_t n = (size_t)f->width * (size_t)f->height;
    for (int j = 0; j < work->n_views; j++) {
        struct rf_work_view *w = &work->views[j];
        const struct rf_view *view = &views[j];
        float *radius = work->memory + n * (size_t)j;
        float largest;
        rf_result result =
            rf_depth_to_radius(f, &view->depth, radius, NULL, NULL, &largest, error);
        if (result != RF_OK)
            return result;
        w->radius = radius;
        work->largest_radius = rf_max_float(largest, work->largest_radius);
        rf_work_view_place(w, view->lens_offset, view->shear_distance, &f->lens);
    }
    work->radius = work->memory;
    return RF_OK;
}

/*
 * The method layered or views, from the caller's pixels. *is_done is false where their
 * planes are needed.
 */
static rf_result read(struct rf_work *work, const struct rf_view *views,
                      const struct rf_image *out, bool *is_done, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    rf_result result = read_depths(work, views, error);
    if (result != RF_OK)
        return result;
    if (work->n_views == 1 && work->largest_radius < RF_SHARP_PX) {
        *is_done = rf_frame_copy(f->context, &views->colour, out);
        return RF_OK;
    }
    for (int j = 0; j < work->n_views; j++)
        work->views[j].image = &views[j].colour;
    work->out = rf_image_is_plain(&f->params, out) ? out : NULL;
    result = entries[f->params.method].run(work, error);
    *is_done = !work->needs_planes;
    if (result == RF_OK && *is_done && !work->is_stored &&
        !rf_task_is_cancelled(work->task))
        rf_frame_store(f->context, &f->params, work->colour, work->stride, out);
    for (int j = 0; j < work->n_views; j++)
        work->views[j].image = NULL;
    work->out = NULL;
    return result;
}

/* Fills radius and colour of every view and runs the method. */
static rf_result run(struct rf_work *work, const struct rf_view *views,
                     const struct rf_image *out, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    size_t n_pixels = (size_t)f->width * (size_t)f->height;
    size_t n = n_pixels * (size_t)(work->n_planes + 1);
    size_t n_all = n * (size_t)work->n_views;
    bool is_copied = false, is_done = false;
    bool streams = can_stream(work, views, out), reads = can_read(work, views);
    size_t n_first = reads ? n_pixels * (size_t)work->n_views : n_all;
    work->memory = rf_alloc(f->context, n_first, sizeof(float));
    if (!work->memory)
        return rf_fail_memory(error, n_first, sizeof(float));
    if (streams || reads) {
        rf_result result = streams
                               ? stream(work, views, work->memory, out, &is_done, error)
                               : read(work, views, out, &is_done, error);
        if (result == RF_OK && is_done && rf_task_is_cancelled(work->task))
            result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
        if (result != RF_OK || is_done)
            return result;
        work->largest_radius = 0;
    }
    if (reads) {
        rf_free(f->context, work->memory);
        work->memory = rf_alloc(f->context, n_all, sizeof(float));
        if (!work->memory)
            return rf_fail_memory(error, n_all, sizeof(float));
    }
    float *memory = work->memory;
    for (int j = 0; j < work->n_views; j++) {
        rf_result result = rf_work_load(work, j, &views[j], memory + n * (size_t)j,
                                        NULL, out, &is_copied, error);
        if (result != RF_OK || is_copied)
            return result;
    }
    memcpy(work->colour, work->views[0].colour, sizeof work->colour);
    work->radius = work->views[0].radius;
    if (work->largest_radius < RF_SHARP_PX && work->n_views == 1) {
        rf_image_copy(&views->colour, out);
        return RF_OK;
    }
    rf_result result = entries[f->params.method].run(work, error);
    if (result == RF_OK && rf_task_is_cancelled(work->task))
        result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    if (result == RF_OK)
        rf_frame_store(f->context, &f->params, work->colour, work->stride, out);
    return result;
}

rf_result rf_view_check_place(const struct rf_view *view, struct rf_error *error)
{
    if (isfinite(view->lens_offset[0]) && isfinite(view->lens_offset[1]) &&
        view->shear_distance >= 0)
        return RF_OK;
    return rf_fail(error, RF_ERROR_ARGUMENT, "lens_offset",
                   "a view's place on the lens must be finite and its shear distance 0 "
                   "or more");
}

static rf_result check_view(const struct rf_filter *f, const struct rf_view *view,
                            const struct rf_image *out, struct rf_error *error)
{
    rf_result result =
        rf_image_check(&view->colour, "colour", f->width, f->height, error);
    if (result == RF_OK)
        result = rf_image_check(&view->depth, "depth", f->width, f->height, error);
    if (result == RF_OK && out->channels != view->colour.channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, "out",
                         "out has %d channels and colour %d: give both the same",
                         out->channels, view->colour.channels);
    return result == RF_OK ? rf_view_check_place(view, error) : result;
}

static rf_result check_views(const struct rf_filter *f, const struct rf_view *views,
                             int32_t n_views, const struct rf_image *out,
                             struct rf_error *error)
{
    if (!f || !views || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !f       ? "filter"
                       : !views ? "views"
                                : "out",
                       "a pointer is NULL");
    int most = entries[f->params.method].max_views;
    if (n_views < 1 || n_views > (most ? most : 1))
        return rf_fail(error, RF_ERROR_ARGUMENT, "n_views",
                       "%d views were given; the method %s takes 1 to %d", n_views,
                       infos[f->params.method].name, most ? most : 1);
    rf_result result = rf_image_check(out, "out", f->width, f->height, error);
    for (int j = 0; j < n_views && result == RF_OK; j++)
        result = check_view(f, &views[j], out, error);
    return result;
}

rf_result rf_filter_process(const struct rf_filter *filter, const struct rf_view *views,
                            int32_t n_views, const struct rf_image *out,
                            const struct rf_progress *progress, struct rf_error *error)
{
    rf_result result = check_views(filter, views, n_views, out, error);
    if (result != RF_OK)
        return result;
    struct rf_task task;
    rf_task_begin(&task, progress);
    if (rf_task_is_cancelled(&task))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    struct rf_work_view work_views[RF_MAX_VIEWS] = {{.radius = NULL}};
    struct rf_work work = {.filter = filter,
                           .n_planes = views->colour.channels,
                           .stride = (size_t)filter->width,
                           .n_views = n_views,
                           .views = work_views,
                           .task = &task};
    result = run(&work, views, out, error);
    rf_free(filter->context, work.memory);
    if (result == RF_OK)
        rf_task_end(&task);
    return result;
}

static rf_result convert(const struct rf_filter *filter, const struct rf_image *depth,
                         const struct rf_image *out, bool is_radius,
                         struct rf_error *error)
{
    if (!filter)
        return rf_fail(error, RF_ERROR_ARGUMENT, "filter", "filter is NULL");
    int w = filter->width, h = filter->height;
    rf_result result = rf_image_check(depth, "depth", w, h, error);
    if (result == RF_OK)
        result = rf_image_check(out, "out", w, h, error);
    if (result != RF_OK)
        return result;
    const struct rf_context *context = filter->context;
    size_t n = (size_t)w * (size_t)h;
    float *memory = rf_alloc(context, n, sizeof(float));
    if (!memory)
        return rf_fail_memory(error, n, sizeof(float));
    result = rf_depth_to_radius(filter, depth, is_radius ? memory : NULL,
                                is_radius ? NULL : memory, NULL, NULL, error);
    if (result == RF_OK) {
        struct rf_image packed = rf_image_packed(memory, w, h, 1);
        struct rf_image one = *out;
        one.channels = 1;
        rf_image_copy(&packed, &one);
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
    struct rf_filter *filter;
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
