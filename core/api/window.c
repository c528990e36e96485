/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Windows of a picture, with the bits of the whole.
 *
 * Everything is local but for two facts of the whole, which a survey finds: the largest
 * radius, by which the picture is continued beyond its edges, and the threshold of
 * highlights (bright_areas.c). What remains is how far a pixel of the result looks.
 * With R the largest radius in px along the longer axis of the aperture, 2^L the pixel
 * of the coarsest level that R needs, and lengths in px:
 *
 *   S = 99                a surface: 5 x 5 and 7 x 7 pixels (split.c), squares of 32 px
 *                         and their neighbours (bright_areas.c); 16 px that are spread
 *                         together (kernels_tmpl.c); 3 px around gaps (gaps.c);
 *                         8 px of film (film.c), which may be 64 (surface_reach())
 *   H = min(120, 5 R + 3) hidden background (hidden.c): candidates lie within 2 R, the
 *                         window reaches 2.5 times as far
 *   B = R, 256 at most    what is continued beyond the border
 *   F = R + 4 2^l         a footprint, in blocks of the level
 *   4 (2^L - 1)           T once through the levels, 2 2^l at each of them
 *
 * T passes the levels four times: visible and hidden samples, near and far. A pixel so
 * depends on surfaces within 16 2^L + F + S, on those behind hidden samples within
 * 8 2^L + F + H + S, on those that stand before highlights within 3 R + S, and beyond
 * the border, within R, on what is up to 7 B beside it (border_outlines.h). Tiles of
 * the levels must be those of the whole picture, since sums are in their order: windows
 * begin at multiples of the coarsest one. They may end anywhere.
 *
 * Several views: methods/views_lens.c has the margin (rf_views_margin()). Each is
 * surveyed by itself. Places between pixels are whole 128ths of one (rf_snap_px()), so
 * that they are the same from wherever they are counted.
 */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "api/chroma.h"
#include "api/filter.h"
#include "api/focuses.h"
#include "base/error.h"
#include "base/math.h"
#include "base/task.h"
#include "compose/levels.h"
#include "compose/scene.h"
#include "input/depth.h"
#include "input/field.h"
#include "input/film.h"
#include "input/frame.h"
#include "compose/light_map.h"
#include "input/pixels.h"
#include "input/views_in.h"
#include "input/white.h"
#include "kernels/data.h"
#include "lens/aperture.h"
#include "methods/views/views.h"
#include "methods/views/views_lens.h"
#include "surfaces/border_outlines.h"
#include "surfaces/bright_areas.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

enum {
    SURFACE = 96 + RF_GAP_REACH, /* S */
    HIDDEN_MOST = 128,           /* H at most, with the pixels that share an answer */
};

/* H for footprints of r px. */
static int hidden_reach(int r)
{
    return rf_min_int(5 * r + 16, HIDDEN_MOST);
}

static rf_result check_method(const struct rf_frame *f, struct rf_error *error)
{
    const struct rf_method_info *method = rf_method_find(f->params.method);
    if (!method->can_window)
        return rf_fail(error, RF_ERROR_PARAMETER, "method",
                       "%s needs the whole picture at once; windows of it are for "
                       "layered and views",
                       method->name);
    if (rf_chroma_is_on(f, 3))
        return rf_fail(error, RF_ERROR_PARAMETER, rf_chroma_field(f),
                       "chroma and an aperture in colour need the whole picture at "
                       "once");
    if (rf_focuses_are_on(f))
        return rf_fail(error, RF_ERROR_PARAMETER, "split_diopter",
                       "a split diopter needs the whole picture at once");
    if (method->max_views > 1 && rf_field_is_on(&f->params))
        return rf_fail(error, RF_ERROR_PARAMETER, rf_field_param(&f->params),
                       "views of a tilted or bent plane in focus need the whole "
                       "picture at once");
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
/* The members of version 0.1, which is the oldest. */
enum { LEAST_SURVEY_SIZE = sizeof(struct rf_survey) };

static rf_result check_window(const struct rf_frame *f, const struct rf_window *window,
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

static rf_result check_view(const struct rf_frame *f, const struct rf_view *view,
                            const struct rf_window *given, struct rf_error *error)
{
    rf_result result = check_method(f, error);
    if (result == RF_OK && view->n_unseen_lights > 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "unseen_lights",
                       "lights that a picture does not show are for whole pictures; "
                       "leave them out");
    if (result == RF_OK && view->behind_colour.data)
        return rf_fail(error, RF_ERROR_ARGUMENT, "behind_colour",
                       "what lies behind the surfaces is for whole pictures; leave it "
                       "out of windows");
    if (result == RF_OK && view->n_seen > 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "seen",
                       "what is seen in mirrors and through glass is for whole "
                       "pictures; leave it out of windows");
    if (result == RF_OK)
        result = check_window(f, given, NULL, "given", error);
    if (result == RF_OK)
        result =
            rf_image_check(&view->colour, "colour", given->width, given->height, error);
    if (result == RF_OK)
        result = rf_image_check_one(&view->depth, "depth", given->width, given->height,
                                    error);
    if (result == RF_OK && view->mean_depth.data)
        result = rf_image_check_one(&view->mean_depth, "mean_depth", given->width,
                                    given->height, error);
    if (result == RF_OK)
        result = rf_view_check_place(view, error);
    return result;
}

/* The frame of the pixels of a window. */
static struct rf_frame part_of(const struct rf_frame *f, const struct rf_window *given)
{
    struct rf_frame part = *f;
    part.place = (struct rf_place){given->x, given->y, f->width, f->height};
    part.width = given->width;
    part.height = given->height;
    return part;
}

/* Loads the pixels of a window as planes; rf_work_free() in any case. */
static rf_result load(struct rf_work *work, const struct rf_view *views,
                      int64_t *n_known, struct rf_error *error)
{
    rf_result result = rf_work_load_depth(work, views, n_known, error);
    if (result == RF_OK)
        result = rf_work_load_light(work, views, error);
    return result == RF_OK ? rf_work_unpack(work, error) : result;
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
    if (survey->size < LEAST_SURVEY_SIZE)
        return rf_fail(error, RF_ERROR_ARGUMENT, "size",
                       "set rf_survey.size to its sizeof");
    struct rf_view known;
    rf_result result = rf_view_check_size(view, error);
    if (result != RF_OK)
        return result;
    rf_views_copy(&known, view, 1);
    view = &known;
    result = check_view(&filter->frame, view, given, error);
    if (result == RF_OK)
        result = check_window(&filter->frame, counted, given, "counted", error);
    if (result != RF_OK)
        return result;
    struct rf_frame part = part_of(&filter->frame, given);
    struct rf_work_view work_view = {.radius = NULL};
    struct rf_whitened whitened;
    struct rf_work work = {.frame = &whitened.frame,
                           .n_planes = view->colour.channels,
                           .n_views = 1,
                           .views = &work_view};
    struct rf_areas areas = {.mean = NULL};
    int64_t n_known = 0;
    result = rf_whiten(&whitened, &part, view, 1, error);
    if (result == RF_OK)
        result = load(&work, whitened.views, &n_known, error);
    if (result == RF_OK)
        result = rf_areas_measure(&areas, &part, &work_view, work.n_planes, error);
    if (result == RF_OK) {
        struct rf_window inner = *counted;
        inner.x -= given->x;
        inner.y -= given->y;
        rf_survey_add(survey, &part, &work_view, work.n_planes, &areas, &inner);
        survey->n_known += (double)n_known;
        memcpy(survey->lens_offset, view->lens_offset, sizeof survey->lens_offset);
        survey->shear_distance = view->shear_distance;
    }
    rf_areas_free(&areas, part.context);
    rf_work_free(&work);
    rf_whitened_free(&whitened);
    return result;
}

/*
 * The surveys of a caller whose struct may be another version's: the members that are
 * known here.
 */
static rf_result copy_surveys(struct rf_survey *known, const struct rf_survey *surveys,
                              int32_t n, struct rf_error *error)
{
    if (!surveys || surveys->size < LEAST_SURVEY_SIZE)
        return rf_fail(error, RF_ERROR_ARGUMENT, "survey",
                       "there is no survey: count the picture with rf_filter_survey()");
    size_t step = surveys->size;
    for (int32_t j = 0; j < n && n <= RF_MAX_VIEWS; j++) {
        memset(&known[j], 0, sizeof known[j]);
        memcpy(&known[j], (const char *)surveys + step * (size_t)j,
               step < sizeof known[j] ? step : sizeof known[j]);
    }
    return RF_OK;
}

static rf_result check_survey(const struct rf_frame *f, const struct rf_survey *survey,
                              struct rf_error *error)
{
    if (survey->n_pixels != (double)f->width * f->height)
        return rf_fail(error, RF_ERROR_ARGUMENT, "survey",
                       "the survey has counted %.0f pixels of %.0f", survey->n_pixels,
                       (double)f->width * f->height);
    if (!(survey->n_known > 0))
        return rf_fail_empty_depth(error);
    return RF_OK;
}

static rf_result check_surveys(const struct rf_frame *f,
                               const struct rf_survey *surveys, int32_t n_views,
                               struct rf_error *error)
{
    int most = rf_method_find(f->params.method)->max_views;
    if (n_views < 1 || n_views > most)
        return rf_fail(error, RF_ERROR_ARGUMENT, "n_views",
                       "%d views were given; the method takes 1 to %d", n_views, most);
    rf_result result = RF_OK;
    for (int j = 0; j < n_views && result == RF_OK; j++)
        result = check_survey(f, &surveys[j], error);
    return result;
}

static float largest_radius(const struct rf_survey *surveys, int n_views)
{
    float largest = 0;
    for (int j = 0; j < n_views; j++)
        largest = rf_max_float(surveys[j].largest_radius, largest);
    return largest;
}

/* How far a surface looks: film whose depth is filled looks further than S says. */
static int surface_reach(const struct rf_frame *f, const struct rf_survey *surveys,
                         int n_views)
{
    bool is_film = false;
    for (int j = 0; j < n_views; j++)
        is_film |= surveys[j].n_transparent > 0;
    int more = is_film ? rf_film_reach(f) - RF_FILM_REACH_LEAST : 0;
    return SURFACE + rf_max_int(more, 0);
}

/* What one view needs around a window. */
static struct rf_margin margin_of_one(const struct rf_frame *f, float largest,
                                      int surface)
{
    double extent[2];
    rf_shape_extent(&f->shape, extent);
    float reach = largest * (float)fmax(fmax(extent[0], extent[1]), 1);
    /* Radii are averaged: a sum may round up beyond the largest. */
    const struct rf_levels levels = rf_levels_of(&f->shape);
    int level = rf_level_up_to(&levels, largest * 1.0001f);
    int size = 1 << level, passes = level ? 16 * size : 0;
    int r = (int)ceilf(reach), spread = r + 4 * size;
    int visible = rf_max_int(passes, passes / 2 + hidden_reach(r)) + spread;
    int border = rf_picture_border(largest);
    int beyond = rf_max_int(3 * r, r + RF_BESIDE_BORDER * border);
    return (struct rf_margin){
        .px = rf_max_int(visible, beyond) + surface, .border = border, .level = level};
}

static rf_result margin_of(const struct rf_frame *f, const struct rf_survey *surveys,
                           int n_views, struct rf_margin *margin,
                           struct rf_error *error)
{
    struct rf_work_view places[RF_MAX_VIEWS] = {{.radius = NULL}};
    struct rf_work work = {.frame = f,
                           .n_views = n_views,
                           .views = places,
                           .largest_radius = largest_radius(surveys, n_views)};
    int surface = surface_reach(f, surveys, n_views);
    if (n_views == 1) {
        *margin = margin_of_one(f, work.largest_radius, surface);
        return RF_OK;
    }
    for (int j = 0; j < n_views; j++)
        rf_work_view_place(&places[j], surveys[j].lens_offset,
                           surveys[j].shear_distance, &f->lens, f->params.pixel_aspect);
    double extent[2];
    rf_shape_extent(&f->shape, extent);
    float reach = work.largest_radius * (float)fmax(fmax(extent[0], extent[1]), 1);
    return rf_views_margin(&work, surface, hidden_reach((int)ceilf(reach)), margin,
                           error);
}

/* Where the window that begins at `first` must begin to have the whole's tiles. */
static int first_on_grid(int first, int border, int tile)
{
    int at = (first + border) / tile * tile - border;
    return first <= 0 || at <= 0 ? 0 : at;
}

/* Which window must be given for `kept`, of surveys and a window that are in order. */
static rf_result window_around(const struct rf_frame *f,
                               const struct rf_survey *surveys, int n_views,
                               const struct rf_window *kept, struct rf_window *given,
                               struct rf_error *error)
{
    if (n_views == 1 && rf_frame_is_sharp(f, surveys->largest_radius)) {
        *given = *kept;
        return RF_OK;
    }
    struct rf_margin margin;
    rf_result result = margin_of(f, surveys, n_views, &margin, error);
    if (result != RF_OK)
        return result;
    int border = margin.border, level = margin.level;
    int px = margin.px + 6 * (int)ceil(f->shape.glow_px);
    int x0 = first_on_grid(kept->x - px, border, RF_TILE_W << level);
    int y0 = first_on_grid(kept->y - px, border, RF_TILE_H << level);
    int x1 = rf_min_int(kept->x + kept->width + px, f->width);
    int y1 = rf_min_int(kept->y + kept->height + px, f->height);
    *given = (struct rf_window){x0, y0, x1 - x0, y1 - y0};
    return RF_OK;
}

rf_result rf_filter_window(const struct rf_filter *filter,
                           const struct rf_survey *surveys, int32_t n_views,
                           const struct rf_window *kept, struct rf_window *given,
                           struct rf_error *error)
{
    if (!filter || !given)
        return rf_fail(error, RF_ERROR_ARGUMENT, !filter ? "filter" : "given",
                       "a pointer is NULL");
    const struct rf_frame *f = &filter->frame;
    struct rf_survey known[RF_MAX_VIEWS];
    rf_result result = check_method(f, error);
    if (result == RF_OK)
        result = copy_surveys(known, surveys, n_views, error);
    if (result == RF_OK)
        result = check_surveys(f, known, n_views, error);
    if (result == RF_OK)
        result = check_window(f, kept, NULL, "kept", error);
    return result == RF_OK ? window_around(f, known, n_views, kept, given, error)
                           : result;
}

size_t rf_window_bytes(const struct rf_filter *filter, const struct rf_survey *surveys,
                       int32_t n_views, const struct rf_window *given)
{
    const struct rf_frame *f = &filter->frame;
    struct rf_survey known[RF_MAX_VIEWS];
    if (n_views < 1 || n_views > RF_MAX_VIEWS ||
        copy_surveys(known, surveys, n_views, NULL) != RF_OK)
        return 0;
    int border = 2 * rf_picture_border(largest_radius(known, n_views));
    size_t n_more = n_views > 1 ? (size_t)n_views : 0;
    int width = given->width + (given->width < f->width ? border / 2 : border);
    int height = given->height + (given->height < f->height ? border / 2 : border);
    return (size_t)width * (size_t)height *
               (RF_WINDOW_BYTES_PER_PIXEL + n_more * RF_WINDOW_BYTES_PER_VIEW +
                (size_t)n_views * rf_whitened_bytes(f)) +
           RF_WINDOW_BYTES;
}

/* A window of a picture that is to be filtered. */
struct job {
    const struct rf_filter *filter;
    const struct rf_survey *surveys;
    const struct rf_view *views;
    int n_views;
    const struct rf_window *given, *kept;
    const struct rf_image *out;
};

/* Are the views those that were surveyed, and all like the first? */
static rf_result check_alike(const struct job *job, struct rf_error *error)
{
    for (int j = 0; j < job->n_views; j++) {
        const struct rf_view *view = &job->views[j];
        const struct rf_survey *survey = &job->surveys[j];
        int32_t n = view->colour.channels, n_first = job->views->colour.channels;
        if (n != n_first)
            return rf_fail(error, RF_ERROR_ARGUMENT, "colour",
                           "view %d has %d channels and view 0 %d: give all the same",
                           j, n, n_first);
        if (view->lens_offset[0] != survey->lens_offset[0] ||
            view->lens_offset[1] != survey->lens_offset[1] ||
            view->shear_distance != survey->shear_distance)
            return rf_fail(error, RF_ERROR_ARGUMENT, "lens_offset",
                           "view %d was at another place when it was surveyed", j);
    }
    return RF_OK;
}

static rf_result check_job(const struct job *job, struct rf_error *error)
{
    const struct rf_frame *f = &job->filter->frame;
    const struct rf_window *given = job->given, *kept = job->kept;
    struct rf_window needed;
    rf_result result = check_view(f, job->views, given, error);
    if (result == RF_OK)
        result = check_window(f, kept, given, "kept", error);
    if (result == RF_OK)
        result = rf_filter_window(job->filter, job->surveys, job->n_views, kept,
                                  &needed, error);
    for (int j = 1; j < job->n_views && result == RF_OK; j++)
        result = check_view(f, &job->views[j], given, error);
    if (result == RF_OK)
        result = check_alike(job, error);
    if (result != RF_OK)
        return result;
    if (memcmp(&needed, given, sizeof needed) != 0)
        return rf_fail(error, RF_ERROR_ARGUMENT, "given",
                       "%d x %d px from (%d, %d) are given; rf_filter_window() asks "
                       "for %d x %d px from (%d, %d)",
                       given->width, given->height, given->x, given->y, needed.width,
                       needed.height, needed.x, needed.y);
    result = rf_image_check_out(job->out, "out", kept->width, kept->height, 0, error);
    if (result == RF_OK && job->out->channels != job->views->colour.channels)
        result = rf_fail(error, RF_ERROR_ARGUMENT, "out",
                         "out has %d channels and colour %d: give both the same",
                         job->out->channels, job->views->colour.channels);
    return result;
}

/* Makes the window of `views`, those of the job with a white of 1. */
static rf_result run(const struct job *job, const struct rf_view *views,
                     struct rf_work *work, struct rf_error *error)
{
    const struct rf_frame *f = work->frame;
    const struct rf_window *given = job->given, *kept = job->kept;
    int x = kept->x - given->x, y = kept->y - given->y;
    if (work->n_views == 1 && rf_frame_is_sharp(f, work->largest_radius)) {
        struct rf_image from = views->colour;
        from.data = (void *)rf_image_at(&views->colour, x, y, 0);
        rf_frame_copy_light(&f->params, &from, job->out);
        return RF_OK;
    }
    rf_result result = rf_views_run(work, error); /* of one view: the method layered */
    if (result == RF_OK && rf_task_is_cancelled(work->task))
        result = rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    if (result != RF_OK)
        return result;
    float *planes[4] = {NULL};
    for (int p = 0; p < work->n_planes; p++)
        planes[p] = work->colour[p] + (size_t)y * work->stride + (size_t)x;
    rf_frame_store(f->context, &f->params, planes, work->stride, job->out);
    return RF_OK;
}

/* Loads and filters the window, of arguments that are in order. */
static rf_result process(const struct job *job, struct rf_task *task,
                         struct rf_error *error)
{
    struct rf_frame part = part_of(&job->filter->frame, job->given);
    struct rf_whitened whitened;
    struct rf_work_view work_views[RF_MAX_VIEWS] = {{.radius = NULL}};
    for (int j = 0; j < job->n_views; j++)
        work_views[j].survey = &job->surveys[j];
    struct rf_work work = {.frame = &whitened.frame,
                           .n_planes = job->views->colour.channels,
                           .n_views = job->n_views,
                           .views = work_views,
                           .stride = (size_t)job->given->width,
                           .largest_radius = largest_radius(job->surveys, job->n_views),
                           .task = task};
    int64_t n_known;
    rf_result result = rf_whiten(&whitened, &part, job->views, job->n_views, error);
    if (result == RF_OK)
        result = load(&work, whitened.views, &n_known, error);
    if (result == RF_OK)
        result = run(job, whitened.views, &work, error);
    if (result == RF_OK)
        result = rf_take_vignette(&part, job->kept->x - job->given->x,
                                  job->kept->y - job->given->y, job->out, error);
    if (result == RF_OK)
        rf_unwhiten(&part, job->out);
    rf_work_free(&work);
    rf_whitened_free(&whitened);
    return result;
}

rf_result
rf_filter_process_window(const struct rf_filter *filter,
                         const struct rf_survey *surveys, const struct rf_view *views,
                         int32_t n_views, const struct rf_window *given,
                         const struct rf_window *kept, const struct rf_image *out,
                         const struct rf_progress *progress, struct rf_error *error)
{
    if (!filter || !views || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter  ? "filter"
                       : !views ? "views"
                                : "out",
                       "a pointer is NULL");
    struct rf_survey known[RF_MAX_VIEWS];
    struct rf_view known_views[RF_MAX_VIEWS];
    rf_result result = check_method(&filter->frame, error);
    if (result == RF_OK)
        result = copy_surveys(known, surveys, n_views, error);
    if (result == RF_OK)
        result = check_surveys(&filter->frame, known, n_views, error);
    if (result == RF_OK)
        result = rf_view_check_size(views, error);
    if (result != RF_OK)
        return result;
    rf_views_copy(known_views, views, n_views);
    const struct job job = {filter, known, known_views, n_views, given, kept, out};
    result = check_job(&job, error);
    if (result != RF_OK)
        return result;
    struct rf_task task;
    rf_task_begin(&task, progress);
    if (rf_task_is_cancelled(&task))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    result = process(&job, &task, error);
    if (result == RF_OK)
        rf_task_end(&task);
    return result;
}
