/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Windows of a picture, with the bits of the whole.
 *
 * Everything is local but for two facts of the whole, which a survey finds: the largest
 * radius, by which the picture is continued beyond its edges, and the threshold of
 * highlights (survey.c). What remains is how far a pixel of the result looks. With R
 * the largest radius in px along the longer axis of the aperture, 2^L the pixel of the
 * coarsest level that R needs, and lengths in px:
 *
 *   S = 80                        a surface: 5 x 5 and 7 x 7 pixels (split.c), squares
 *                                 of 32 px and their neighbours (survey.c)
 *   H = min(120, 5 R + 3)         hidden background (hidden.c): candidates lie within
 *                                 2 R, the window reaches 2.5 times as far
 *   F = R + 4 2^l                 a footprint, in blocks of the level
 *   4 (2^L - 1)                   T once through the levels, 2 2^l at each of them
 *
 * T passes the levels four times: visible and hidden samples, near and far. A pixel so
 * depends on surfaces within 16 2^L + F + S, on those behind hidden samples within
 * 8 2^L + F + H + S, and on those that stand before highlights within 3 R + S. Tiles of
 * the levels must be those of the whole picture, since sums are in their order: windows
 * begin at multiples of the coarsest one. They may end anywhere.
 */
#include "composer.h"
#include "picture.h"

enum {
    SURFACE = 80,      /* S */
    HIDDEN_MOST = 128, /* H at most, with the pixels that share an answer */
};

static rf_result check_method(const struct rf_filter *f, struct rf_error *error)
{
    size_t n;
    if (f->params.method != RF_METHOD_LAYERED)
        return rf_fail(error, RF_ERROR_PARAMETER, "method",
                       "%s needs the whole picture at once; windows of it are for "
                       "layered",
                       rf_method_list(&n)[f->params.method].name);
    if (f->params.quality == RF_QUALITY_PREVIEW)
        return rf_fail(error, RF_ERROR_PARAMETER, "quality",
                       "preview needs the whole picture at once; take normal or best");
    return RF_OK;
}

static bool is_within(const struct rf_window *w, const struct rf_window *outer)
{
    return w->width >= 1 && w->height >= 1 && w->x >= outer->x && w->y >= outer->y &&
           w->width <= outer->width && w->height <= outer->height &&
           w->x - outer->x <= outer->width - w->width &&
           w->y - outer->y <= outer->height - w->height;
}

/* Is `window` within the picture, or within `outer` where that is not NULL? */
static rf_result check_window(const struct rf_filter *f, const struct rf_window *window,
                              const struct rf_window *outer, const char *name,
                              struct rf_error *error)
{
    struct rf_window whole = {0, 0, f->width, f->height};
    if (!window)
        return rf_fail(error, RF_ERROR_ARGUMENT, name, "%s is NULL", name);
    if (is_within(window, outer ? outer : &whole))
        return RF_OK;
    return rf_fail(error, RF_ERROR_ARGUMENT, name,
                   "%s, %d x %d px from (%d, %d), is empty or not within the %s", name,
                   window->width, window->height, window->x, window->y,
                   outer ? "window given" : "picture");
}

static rf_result check_view(const struct rf_filter *f, const struct rf_view *view,
                            const struct rf_window *given, struct rf_error *error)
{
    rf_result result = check_method(f, error);
    if (result == RF_OK)
        result = check_window(f, given, NULL, "given", error);
    if (result == RF_OK)
        result =
            rf_image_check(&view->colour, "colour", given->width, given->height, error);
    if (result == RF_OK)
        result =
            rf_image_check(&view->depth, "depth", given->width, given->height, error);
    return result;
}

/* The filter of the pixels of a window. */
static struct rf_filter filter_of(const struct rf_filter *f,
                                  const struct rf_window *given,
                                  const struct rf_survey *survey)
{
    struct rf_filter part = *f;
    part.place = (struct rf_place){given->x, given->y, f->width, f->height};
    part.width = given->width;
    part.height = given->height;
    part.survey = survey;
    return part;
}

/* Loads the pixels of a window; `memory` is to be freed in any case. */
static rf_result load(struct rf_work *work, const struct rf_view *view, float **memory,
                      int64_t *n_hit, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    size_t n = (size_t)f->width * (size_t)f->height * (size_t)(work->n_planes + 1);
    *memory = rf_alloc(f->context, n, sizeof **memory);
    if (!*memory)
        return rf_fail_memory(error, n, sizeof **memory);
    return rf_work_load(work, 0, view, *memory, n_hit, NULL, NULL, error);
}

rf_result rf_filter_survey(const struct rf_filter *filter, const struct rf_view *view,
                           const struct rf_window *given,
                           const struct rf_window *counted, struct rf_survey *survey,
                           struct rf_error *error)
{
    if (!filter || !view || !survey)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter ? "filter"
                       : !view ? "view"
                               : "survey",
                       "a pointer is NULL");
    if (survey->size != sizeof *survey)
        return rf_fail(error, RF_ERROR_ARGUMENT, "size",
                       "set rf_survey.size to its sizeof");
    rf_result result = check_view(filter, view, given, error);
    if (result == RF_OK)
        result = check_window(filter, counted, given, "counted", error);
    if (result != RF_OK)
        return result;
    struct rf_filter part = filter_of(filter, given, NULL);
    struct rf_work_view work_view = {.radius = NULL};
    struct rf_work work = {.filter = &part,
                           .n_planes = view->colour.channels,
                           .n_views = 1,
                           .views = &work_view};
    struct rf_areas areas = {.mean = NULL};
    float *memory;
    int64_t n_hit = 0;
    result = load(&work, view, &memory, &n_hit, error);
    if (result == RF_OK)
        result = rf_areas_measure(&areas, &part, &work_view, work.n_planes, error);
    if (result == RF_OK) {
        struct rf_window inner = *counted;
        inner.x -= given->x;
        inner.y -= given->y;
        rf_survey_add(survey, &part, &work_view, work.n_planes, &areas, &inner);
        survey->n_hit += (double)n_hit;
    }
    rf_areas_free(&areas, filter->context);
    rf_free(filter->context, memory);
    return result;
}

static rf_result check_survey(const struct rf_filter *f, const struct rf_survey *survey,
                              struct rf_error *error)
{
    if (!survey || survey->size != sizeof *survey)
        return rf_fail(error, RF_ERROR_ARGUMENT, "survey",
                       "there is no survey: count the picture with rf_filter_survey()");
    if (survey->n_pixels != (double)f->width * f->height)
        return rf_fail(error, RF_ERROR_ARGUMENT, "survey",
                       "the survey has counted %.0f pixels of %.0f", survey->n_pixels,
                       (double)f->width * f->height);
    if (!(survey->n_hit > 0))
        return rf_fail(error, RF_ERROR_DEPTH, "depth",
                       "nothing was hit: every depth is infinite; check the depth "
                       "channel and its kind");
    return RF_OK;
}

/* How far a pixel of the result looks, px; *level receives the coarsest level. */
static int margin_of(const struct rf_filter *f, float largest_radius, int *level)
{
    double extent[2];
    rf_shape_extent(&f->shape, extent);
    float reach = largest_radius * (float)fmax(fmax(extent[0], extent[1]), 1);
    /* Radii are averaged: a sum may round up beyond the largest. */
    *level = rf_level_of(rf_level_split(&f->shape), largest_radius * 1.0001f);
    int size = 1 << *level, passes = *level ? 16 * size : 0;
    int r = (int)ceilf(reach), spread = r + 4 * size;
    int hidden = rf_min_int(5 * r + 16, HIDDEN_MOST);
    int visible = rf_max_int(passes, passes / 2 + hidden) + spread;
    return rf_max_int(visible, 3 * r) + SURFACE;
}

/* Where the window that begins at `first` must begin to have the whole's tiles. */
static int first_on_grid(int first, int border, int tile)
{
    int at = (first + border) / tile * tile - border;
    return first <= 0 || at <= 0 ? 0 : at;
}

rf_result rf_filter_window(const struct rf_filter *filter,
                           const struct rf_survey *survey, const struct rf_window *kept,
                           struct rf_window *given, struct rf_error *error)
{
    if (!filter || !given)
        return rf_fail(error, RF_ERROR_ARGUMENT, !filter ? "filter" : "given",
                       "a pointer is NULL");
    rf_result result = check_method(filter, error);
    if (result == RF_OK)
        result = check_survey(filter, survey, error);
    if (result == RF_OK)
        result = check_window(filter, kept, NULL, "kept", error);
    if (result != RF_OK)
        return result;
    if (survey->largest_radius < RF_SHARP_PX) {
        *given = *kept;
        return RF_OK;
    }
    int level, margin = margin_of(filter, survey->largest_radius, &level);
    int border = rf_picture_border(survey->largest_radius);
    int x0 = first_on_grid(kept->x - margin, border, RF_TILE_W << level);
    int y0 = first_on_grid(kept->y - margin, border, RF_TILE_H << level);
    int x1 = rf_min_int(kept->x + kept->width + margin, filter->width);
    int y1 = rf_min_int(kept->y + kept->height + margin, filter->height);
    *given = (struct rf_window){x0, y0, x1 - x0, y1 - y0};
    return RF_OK;
}

size_t rf_window_bytes(const struct rf_filter *filter, const struct rf_survey *survey,
                       const struct rf_window *given)
{
    int border = 2 * rf_picture_border(survey->largest_radius);
    int width = given->width + (given->width < filter->width ? border / 2 : border);
    int height = given->height + (given->height < filter->height ? border / 2 : border);
    return (size_t)width * (size_t)height * RF_WINDOW_BYTES_PER_PIXEL + RF_WINDOW_BYTES;
}

static rf_result check_process(const struct rf_filter *f,
                               const struct rf_survey *survey,
                               const struct rf_view *view,
                               const struct rf_window *given,
                               const struct rf_window *kept, const struct rf_image *out,
                               struct rf_error *error)
{
    struct rf_window needed;
    rf_result result = check_view(f, view, given, error);
    if (result == RF_OK)
        result = check_window(f, kept, given, "kept", error);
    if (result == RF_OK)
        result = rf_filter_window(f, survey, kept, &needed, error);
    if (result != RF_OK)
        return result;
    if (memcmp(&needed, given, sizeof needed) != 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "given",
                       "%d x %d px from (%d, %d) are given; rf_filter_window() asks "
                       "for %d x %d px from (%d, %d)",
                       given->width, given->height, given->x, given->y, needed.width,
                       needed.height, needed.x, needed.y);
    result = rf_image_check(out, "out", kept->width, kept->height, error);
    if (result == RF_OK && out->channels != view->colour.channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, "out",
                         "out has %d channels and colour %d: give both the same",
                         out->channels, view->colour.channels);
    return result;
}

static rf_result run(struct rf_work *work, const struct rf_view *view,
                     const struct rf_window *given, const struct rf_window *kept,
                     const struct rf_image *out, struct rf_error *error)
{
    const struct rf_filter *f = work->filter;
    int x = kept->x - given->x, y = kept->y - given->y;
    if (work->largest_radius < RF_SHARP_PX) {
        struct rf_image from = view->colour;
        from.data = (void *)rf_image_at(&view->colour, x, y, 0);
        rf_image_copy(&from, out);
        return RF_OK;
    }
    memcpy(work->colour, work->views[0].colour, sizeof work->colour);
    work->radius = work->views[0].radius;
    rf_result result = rf_layered_run(work, error);
    if (result == RF_OK && rf_task_is_cancelled(work->task))
        result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    if (result != RF_OK)
        return result;
    float *planes[4] = {NULL};
    for (int p = 0; p < work->n_planes; p++)
        planes[p] = work->colour[p] + (size_t)y * (size_t)f->width + (size_t)x;
    rf_frame_store(f->context, &f->params, planes, (size_t)f->width, out);
    return RF_OK;
}

rf_result
rf_filter_process_window(const struct rf_filter *filter, const struct rf_survey *survey,
                         const struct rf_view *view, const struct rf_window *given,
                         const struct rf_window *kept, const struct rf_image *out,
                         const struct rf_progress *progress, struct rf_error *error)
{
    if (!filter || !view || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter ? "filter"
                       : !view ? "view"
                               : "out",
                       "a pointer is NULL");
    rf_result result = check_process(filter, survey, view, given, kept, out, error);
    if (result != RF_OK)
        return result;
    struct rf_task task;
    rf_task_begin(&task, progress);
    if (rf_task_is_cancelled(&task))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    struct rf_filter part = filter_of(filter, given, survey);
    struct rf_work_view work_view = {.radius = NULL};
    struct rf_work work = {.filter = &part,
                           .n_planes = view->colour.channels,
                           .n_views = 1,
                           .views = &work_view,
                           .largest_radius = survey->largest_radius,
                           .task = &task};
    float *memory;
    int64_t n_hit;
    result = load(&work, view, &memory, &n_hit, error);
    if (result == RF_OK)
        result = run(&work, view, given, kept, out, error);
    rf_free(filter->context, memory);
    if (result == RF_OK)
        rf_task_end(&task);
    return result;
}
