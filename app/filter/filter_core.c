/* SPDX-License-Identifier: Apache-2.0 */
/* The core's objects of a run, and what the core says in words of its files. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "filter/filter_private.h"
#include "filter/filter_run.h"
#include "sources/depth_repair.h"
#include "sources/picture.h"
#include "sources/picture_doubts.h"

/* ---- messages ------------------------------------------------------------------- */

/* Was anything about the lens (aperture, ...) typed? Conflicts have two sides. */
static bool is_group_typed(const struct settings *settings, enum rf_param_group group)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++)
        if (list[i].group == group &&
            settings_origin(settings, list[i].key) == ORIGIN_COMMAND_LINE)
            return true;
    return false;
}

/* A parameter: wrong usage where it or what it conflicts with was typed, else the fault
 * of the header. */
static int fail_parameter(const struct run *run, const struct rf_error *error)
{
    const struct rf_param_info *info = rf_param_find(error->field);
    const char *path = image_path(run->source.colour);
    if (!info) {
        return app_fail(run->error, APP_FAILED, "%s: %s", path, error->message);
    }
    if (settings_origin(run->settings, info->key) == ORIGIN_COMMAND_LINE) {
        return app_fail(run->error, APP_USAGE, "--%s: %s", info->key, error->message);
    }
    char origin[128];
    settings_describe_origin(run->settings, info->key, origin, sizeof(origin));
    return app_fail(
        run->error, is_group_typed(run->settings, info->group) ? APP_USAGE : APP_FAILED,
        "%s: %s (--%s, from the %s)", path, error->message, info->key, origin);
}

/* The view whose pixels the core refuses, else the first one. */
static const struct source *faulty_source(const struct run *run)
{
    for (int i = 0; i < run->views.n; i++) {
        const struct rf_view *view = &run->views.views[i];
        const float *colour = view->colour.data;
        const size_t n = (size_t)view->colour.width * (size_t)view->colour.height *
                         (size_t)view->colour.channels;
        for (size_t k = 0; k < n; k++)
            if (!isfinite(colour[k]))
                return &run->views.sources[i];
        if (rf_filter_planar_depth(run->filter, &view->depth, &view->depth, NULL) !=
            RF_OK)
            return &run->views.sources[i];
    }
    return &run->source;
}

static int fail_of(const struct run *run, const struct source *source,
                   const struct rf_error *error)
{
    if (error->code == RF_ERROR_PARAMETER)
        return fail_parameter(run, error);
    if (error->code == RF_ERROR_CANCELLED)
        return APP_INTERRUPTED;
    if (error->code == RF_ERROR_MEMORY && run->tool->max_memory_mib) {
        return app_fail(
            run->error, APP_FAILED,
            "--max-memory: %d MiB are too few: %s; allow more, or give fewer views",
            run->tool->max_memory_mib, error->message);
    }
    if (!source)
        source = faulty_source(run);
    const struct image_input *input =
        error->code == RF_ERROR_DEPTH ? source->depth : source->colour;
    char way_out[900] = "";
    if (error->code == RF_ERROR_PIXEL && strcmp(error->field, "colour") == 0 &&
        !run->has_views && !run->is_deep)
        picture_explain_pixels(source, way_out, sizeof(way_out));
    if (error->code == RF_ERROR_DEPTH && source == &run->source)
        depth_explain(&run->numbers, source, &run->settings->params, way_out,
                      sizeof(way_out));
    return app_fail(run->error,
                    error->code == RF_ERROR_MEMORY ? APP_NO_MEMORY : APP_FAILED,
                    "%s: %s%s", image_path(input), error->message, way_out);
}

int filter_fail_core(const struct run *run, const struct rf_error *error)
{
    return fail_of(run, NULL, error);
}

int filter_fail_view(const struct run *run, int view, const struct rf_error *error)
{
    return fail_of(run, run->has_views ? &run->views.sources[view] : &run->source,
                   error);
}

static void log_remark(void *user, enum rf_log_level level, const char *text)
{
    const struct filter_kept *kept = user;
    struct run *run = kept->run;
    if (level == RF_LOG_WARNING && run->remark == APP_DONE)
        run->remark = app_warn(run->tool->host, run->error, "%s: %s",
                               image_path(run->source.colour), text);
}

/* ---- context and filter --------------------------------------------------------- */

/* Grey is spread by the mean of the aperture's colours. */
static void make_grey(struct picture *picture)
{
    const size_t n = (size_t)picture->width * (size_t)picture->height;
    for (size_t i = 0; i < n; i++) {
        float *c = picture->samples + 3 * i;
        c[0] = c[1] = c[2] = (c[0] + c[1] + c[2]) / 3;
    }
}

/* The filter, with the picture that the method scatter spreads light by. */
static int create_filter(struct run *run)
{
    const char *path = run->tool->aperture_image ? run->tool->aperture_image
                                                 : run->tool->distribution_image;
    struct rf_error core_error;
    struct rf_image light = {0};
    struct picture picture = {0};
    if (path) {
        if (!picture_read(path, NULL, run->n_threads, &picture, run->error)) {
            app_missing(run->error,
                        run->tool->aperture_image ? "aperture-image"
                                                  : "distribution-image",
                        path);
            return app_code_of(run->error);
        }
        if (run->source.is_grey && run->source.n_channels == 4)
            make_grey(&picture);
        light = rf_image_packed(picture.samples, picture.width, picture.height, 3);
    }
    const rf_result result = rf_filter_create_with(
        &run->filter, run->context, &run->params, run->source.width, run->source.height,
        path ? &light : NULL, &core_error);
    if (path)
        picture_free(&picture);
    if (result == RF_OK)
        return APP_DONE;
    return path && strcmp(core_error.field, "distribution") == 0
               ? app_fail(run->error, APP_FAILED, "%s: %s", path, core_error.message)
               : filter_fail_core(run, &core_error);
}

void filter_kept_free(struct filter_kept *kept)
{
    rf_context_destroy(kept->context);
    *kept = (struct filter_kept){.context = NULL};
}

int filter_make(struct run *run, size_t max_bytes)
{
    struct rf_error error;
    struct filter_kept *kept = run->tool->kept ? run->tool->kept : &run->own;
    const struct rf_context_params params = {.size = sizeof(params),
                                             .cpu = getenv("RACKFOCUS_CPU"),
                                             .n_threads = run->tool->n_threads,
                                             .max_bytes = max_bytes,
                                             .log = log_remark,
                                             .user = kept};
    rf_filter_destroy(run->filter);
    run->filter = NULL;
    run->context = NULL;
    if (kept->max_bytes != max_bytes)
        filter_kept_free(kept);
    if (!kept->context && rf_context_create(&kept->context, &params, &error) != RF_OK)
        return filter_fail_core(run, &error);
    kept->max_bytes = max_bytes;
    kept->run = run;
    run->context = kept->context;
    return create_filter(run);
}

bool filter_needs_white(const struct run *run)
{
    return white_is_open(run->settings) && !run->is_deep &&
           (run->tool->denoise || rf_method_find(run->params.method)->has_layers);
}

int filter_take_white(struct run *run, const struct white_tally *tally)
{
    const double white = white_of(tally);
    if (white == 1)
        return APP_DONE;
    settings_set_header(run->settings, "white", white, "the picture", NULL);
    run->params.white = white;
    return filter_make(run, (size_t)run->tool->max_memory_mib << 20);
}
