/* SPDX-License-Identifier: Apache-2.0 */
#include "document.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "pixels/input_read.h"
#include "pixels/maps.h"
#include "pixels/means.h"
#include "pixels/shrink.h"
#include "sources/depth_repair.h"
#include "sources/picture.h"
#include "sources/picture_doubts.h"
#include "sources/views.h"
#include "sources/white.h"
#include "threads.h"
#include "filtering/quick.h"

/* ---- opening --------------------------------------------------------------------- */

static void add_remark(void *user, const char *text)
{
    struct document *document = user;
    const size_t n = strlen(document->remark);
    if (text[0])
        snprintf(document->remark + n, sizeof document->remark - n, "%s%s",
                 n > 0 ? "; " : "", text);
}

bool document_resolve(struct document *document, struct image_error *error)
{
    struct rf_error core_error;
    document->settings = document->typed;
    if (!source_read_facts(&document->source, &document->settings, error->message,
                           sizeof error->message))
        return false;
    if (document->has_views)
        settings_set_header(&document->settings, "method", RF_METHOD_VIEWS,
                            VIEWS_OFFSET, NULL);
    if (document->white > 0)
        settings_set_header(&document->settings, "white", document->white,
                            "the picture", NULL);
    if (settings_fit_window(&document->settings, &document->source.info,
                            &document->params, &core_error) != RF_OK)
        return set_error(error, "%s", core_error.message);
    return true;
}

/* The depth of all views, as `rackfocus filter` takes it. */
static bool mend_depth(struct document *document, struct image_error *error)
{
    if (!document_resolve(document, error))
        return false;
    const struct depth_picture picture = {&document->source, &document->settings,
                                          &document->params, document->input->views,
                                          document->input->n_views};
    char mended[200];
    const struct depth_listener listener = {add_remark, document};
    if (!depth_mend(&picture, mended, sizeof mended, listener, error))
        return false;
    add_remark(document, mended);
    picture_say_doubts(&picture, add_remark, document);
    return true;
}

static void find_white(struct document *document)
{
    const struct rf_image *colour = &document->input->views[0].colour;
    const size_t n = (size_t)colour->width * (size_t)colour->height;
    document->white = white_of_pixels(colour->data, n, colour->channels);
}

static bool open_source(struct document *document, const struct source_request *request,
                        const struct view_list *list, struct image_error *error)
{
    struct source_request first = *request;
    first.n_paths = document->has_views ? 1 : request->n_paths;
    first.view = document->has_views ? list->items[0].name : NULL;
    document->is_open = source_open(&document->source, &first, error);
    if (!document->is_open || !source_check(&document->source, error))
        return false;
    source_say_doubts(&document->source, add_remark, document);
    if (!document->source.info.is_deep)
        return true;
    return set_error(error,
                     "%s: holds deep samples, which this page does not show; "
                     "rackfocus filter --flattened FILE.exr writes the flat picture "
                     "and its depth",
                     request->paths[0]);
}

static bool read_files(struct document *document, char *const *paths, int n_paths,
                       struct image_error *error)
{
    const struct source_request request = {.paths = paths, .n_paths = n_paths};
    struct view_list list = {0};
    const char *other = NULL;
    struct rf_error core_error;
    if (!views_list(paths, n_paths, &list, &other, error))
        return false;
    document->has_views = !other && list.n > 1;
    bool is_good = document->has_views || n_paths <= 2;
    if (!is_good)
        set_error(
            error,
            "%s: is no view from a point of the lens, its header has no " VIEWS_OFFSET
            "; open one file of colour and one of depth, or views",
            other);
    is_good = is_good && open_source(document, &request, &list, error);
    if (is_good)
        document->input =
            document->has_views
                ? input_read_views(&document->source, &list, &request, 1, error)
                : input_read(&document->source, 1, error);
    is_good = is_good && document->input && mend_depth(document, error);
    views_list_free(&list);
    if (is_good)
        find_white(document);
    if (is_good && !input_prepare(document->input, document->context, &document->params,
                                  &core_error))
        return set_error(error, "%s: %s", paths[0], core_error.message);
    return is_good;
}

struct document *document_open(char *const *paths, int n_paths, int n_threads,
                               struct image_error *error)
{
    struct document *document = app_memory(1, sizeof *document, error);
    const struct rf_context_params how = threads_params(n_threads);
    struct rf_error core_error;
    if (!document)
        return NULL;
    settings_init(&document->typed);
    document->tone = tone_create();
    bool is_good = document->tone || set_error(error, "out of memory");
    if (is_good && rf_context_create(&document->context, &how, &core_error) != RF_OK)
        is_good = set_error(error, "%s", core_error.message);
    if (is_good && read_files(document, paths, n_paths, error))
        return document;
    document_close(document);
    return NULL;
}

void document_close(struct document *document)
{
    if (!document)
        return;
    input_drop(document->input);
    if (document->is_open)
        source_close(&document->source);
    rf_context_destroy(document->context);
    tone_destroy(document->tone);
    free(document->pixels);
    free(document->rgba);
    free(document);
}

/* ---- filtering ------------------------------------------------------------------- */

static bool make_room(struct document *document, int times, struct image_error *error)
{
    const struct input *input = document->input;
    const int32_t width = shrink_side(input->width, times);
    const int32_t height = shrink_side(input->height, times);
    if (document->pixels && document->width == width && document->height == height)
        return true;
    free(document->pixels);
    document->pixels = app_memory((size_t)width * (size_t)height,
                                  (size_t)input->n_channels * sizeof(float), error);
    document->width = width;
    document->height = height;
    document->times = times;
    return document->pixels != NULL;
}

/* One picture with one depth, `times` smaller; its memory is the caller's to free where
 * times > 1. */
static bool make_small(const struct document *document, const struct rf_params *params,
                       int times, struct rf_view *view, struct image_error *error)
{
    const struct input *input = document->input;
    const bool is_raw = input->raw && params->depth == document->params.depth;
    const float *depth = is_raw ? input->raw : input->planar;
    const int32_t width = shrink_side(input->width, times);
    const int32_t height = shrink_side(input->height, times);
    const size_t n = (size_t)width * (size_t)height;
    float *colour = (float *)input->colour, *small = (float *)depth;
    if (times > 1) {
        colour = app_memory(n, (size_t)input->n_channels * sizeof(float), error);
        small = app_memory(n, sizeof(float), error);
        if (!colour || !small) {
            free(colour);
            free(small);
            return false;
        }
        shrink_colour(input->colour, input->width, input->height, input->n_channels,
                      times, colour);
        shrink_depth(depth, input->width, input->height, times, small);
    }
    *view = (struct rf_view){
        .colour = rf_image_packed(colour, width, height, input->n_channels),
        .depth = rf_image_packed(small, width, height, 1)};
    return true;
}

static bool run(struct document *document, const struct rf_params *params,
                const struct rf_view *views, int n_views,
                const struct rf_progress *progress, struct image_error *error)
{
    const struct rf_image out =
        rf_image_packed(document->pixels, document->width, document->height,
                        document->input->n_channels);
    struct rf_filter *filter;
    struct rf_error core_error;
    rf_result result = rf_filter_create(&filter, document->context, params,
                                        document->width, document->height, &core_error);
    if (result == RF_OK) {
        result = rf_filter_process(filter, views, n_views, &out, progress, &core_error);
        rf_filter_destroy(filter);
    }
    return result == RF_OK || set_error(error, "%s", core_error.message);
}

static bool run_best(struct document *document, const struct rf_progress *progress,
                     struct image_error *error)
{
    struct means means;
    struct rf_error core_error;
    if (means_open(&means, document->input, &document->params, &core_error) != RF_OK)
        return set_error(error, "%s", core_error.message);
    const bool is_good =
        run(document, &document->params, means.views, means.n, progress, error);
    means_close(&means);
    return is_good;
}

static bool run_quickly(struct document *document, int times, struct image_error *error)
{
    const struct input *input = document->input;
    const struct job job = {.input = document->input, .params = document->params};
    struct rf_params params = quick_params(&job);
    struct rf_lens lens;
    struct rf_error core_error;
    struct rf_view view;
    if (rf_lens_init(&lens, &params, input->width, input->height, &core_error) != RF_OK)
        return set_error(error, "%s", core_error.message);
    if (!make_small(document, &params, times, &view, error))
        return false;
    if (times > 1)
        shrink_params(&params, &lens, times);
    const bool is_good = run(document, &params, &view, 1, NULL, error);
    if (times > 1) {
        free(view.colour.data);
        free(view.depth.data);
    }
    return is_good;
}

bool document_render(struct document *document, bool is_best, int times,
                     const struct rf_progress *progress, struct image_error *error)
{
    if (!document_resolve(document, error) ||
        !make_room(document, is_best ? 1 : times, error))
        return false;
    return is_best ? run_best(document, progress, error)
                   : run_quickly(document, times, error);
}

/* ---- showing and saving ---------------------------------------------------------- */

static bool show_radius(struct document *document, enum document_show what,
                        double exposure, struct image_error *error)
{
    const struct input *input = document->input;
    const struct job job = {.input = document->input, .params = document->params};
    const size_t n = (size_t)input->width * (size_t)input->height;
    float *radius = app_memory(n, sizeof *radius, error);
    struct rf_error core_error;
    if (!radius)
        return false;
    const bool is_good = maps_radius(document->context, &job, radius, &core_error);
    if (!is_good)
        set_error(error, "%s", core_error.message);
    else if (what == SHOW_COC)
        display_coc(radius, n, maps_full_radius(radius, n), document->rgba);
    else
        display_band(document->tone, input->colour, input->n_channels, radius, n,
                     exposure, document->params.coc_limit, document->rgba);
    free(radius);
    return is_good;
}

const uint8_t *document_show(struct document *document, enum document_show what,
                             double exposure, struct image_error *error)
{
    const struct input *input = document->input;
    const size_t n = (size_t)input->width * (size_t)input->height;
    bool is_good = document_resolve(document, error);
    if (is_good && !document->rgba) {
        document->rgba = app_memory(n, 4, error);
        is_good = document->rgba != NULL;
    }
    if (!is_good)
        return NULL;
    if (what == SHOW_PICTURE && document->pixels)
        display_picture(document->tone, document->pixels, input->n_channels,
                        (size_t)document->width * (size_t)document->height, exposure,
                        document->rgba);
    else if (what == SHOW_DEPTH)
        display_depth(input->planar, n, input->nearest, input->farthest,
                      document->rgba);
    else if (what == SHOW_COC || what == SHOW_BAND)
        is_good = show_radius(document, what, exposure, error);
    else
        display_picture(document->tone, input->colour, input->n_channels, n, exposure,
                        document->rgba);
    return is_good ? document->rgba : NULL;
}

bool document_save(struct document *document, const char *path,
                   struct image_error *error)
{
    struct document *d = document;
    if (!document_render(document, true, 1, NULL, error))
        return false;
    const size_t n =
        (size_t)d->width * (size_t)d->height * (size_t)d->input->n_channels;
    float *copy = app_memory(n, sizeof *copy, error);
    if (!copy)
        return false;
    memcpy(copy, d->pixels, n * sizeof *copy);
    settings_print_options(&d->params, d->text, sizeof d->text);
    const struct source_output how = {.type = IMAGE_SAMPLE_HALF,
                                      .made = d->text,
                                      .settings = &d->settings,
                                      .n_threads = 1};
    picture_clip_to_half(copy, n);
    const bool is_good = source_write_colour(&d->source, path, copy, &how, error);
    free(copy);
    return is_good;
}
