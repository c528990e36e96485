/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/focus_pick.h"

#include <math.h>
#include <stdlib.h>

#include "common/report.h"
#include "sources/depth_repair.h"

static int compare_floats(const void *a, const void *b)
{
    const float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* Median of the 3 x 3 px around (x, y), as far as they are there. */
static float median_at(const float *depth, int32_t width, int32_t height, int32_t x,
                       int32_t y)
{
    float found[9];
    size_t n = 0;
    for (int32_t j = y - 1; j <= y + 1; j++)
        for (int32_t i = x - 1; i <= x + 1; i++)
            if (i >= 0 && i < width && j >= 0 && j < height)
                found[n++] = depth[(size_t)j * (size_t)width + (size_t)i];
    qsort(found, n, sizeof(*found), compare_floats);
    return found[(n - 1) / 2];
}

/* Planar distances in place of a depth. */
static bool make_planar(const struct source *source, const struct rf_params *params,
                        float *depth, const struct depth_numbers *numbers,
                        struct image_error *error)
{
    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    struct rf_error core_error;
    struct rf_params plain = *params;
    const struct rf_image image =
        rf_image_packed(depth, source->width, source->height, 1);
    plain.aperture = RF_APERTURE_DISC; /* needs no picture */
    const bool is_good =
        rf_context_create(&context, NULL, &core_error) == RF_OK &&
        rf_filter_create(&filter, context, &plain, source->width, source->height,
                         &core_error) == RF_OK &&
        rf_filter_planar_depth(filter, &image, &image, &core_error) == RF_OK;
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    char way_out[500] = "";
    if (!is_good && core_error.code == RF_ERROR_DEPTH)
        depth_explain(numbers, source, params, way_out, sizeof(way_out));
    return is_good || set_error(error, "%s: %s%s", image_path(source->depth),
                                core_error.message, way_out);
}

/* What filter refuses is no distance to focus on either, what it warns of is told. */
static bool judge(const struct source *source, const struct settings *settings,
                  float *depth, const struct app_host *host,
                  struct depth_numbers *numbers, struct image_error *error)
{
    const struct rf_depth_channel channel = {.depth = depth,
                                             .width = source->width,
                                             .height = source->height,
                                             .infinity =
                                                 settings->params.depth_infinity};
    const char *path = image_path(source->depth);
    struct depth_findings found;
    char text[700];
    if (!depth_find(&found, source, settings, NULL, &channel))
        return set_error(error, "%s: out of memory", path);
    *numbers = found.numbers;
    if (depth_is_refused(&found, text, sizeof(text)))
        return set_error(error, "%s: the depth %s", path, text);
    if (source_explains_depth(source, text, sizeof(text)) &&
        app_warn(host, error, "%s: the depth %s", path, text) != APP_DONE)
        return false;
    return !depth_is_doubtful(&found, text, sizeof(text)) ||
           app_warn(host, error, "%s: the depth %s", path, text) == APP_DONE;
}

static bool pick(const struct source *source, const struct settings *settings,
                 const struct rf_params *params, const struct focus_request *request,
                 double *distance, struct image_error *error)
{
    const struct focus_place *place = &request->place;
    const struct image_box *data = &source->info.data_window;
    const struct image_box *display = &source->info.display_window;
    const double x = floor(place->x) + display->min_x - data->min_x;
    const double y = floor(place->y) + display->min_y - data->min_y;
    const char *path = image_path(source->depth);
    if (!(x >= 0 && x < source->width && y >= 0 && y < source->height))
        return set_error(error, "%s: (%g, %g) lies outside of its %d x %d px", path,
                         place->x, place->y, source->width, source->height);
    struct depth_numbers numbers;
    float *depth = source_read_depth(source, 1, error);
    if (!depth || !judge(source, settings, depth, request->host, &numbers, error) ||
        !make_planar(source, params, depth, &numbers, error)) {
        free(depth);
        return false;
    }
    *distance =
        (double)median_at(depth, source->width, source->height, (int32_t)x, (int32_t)y);
    free(depth);
    return isfinite(*distance) ||
           set_error(error, "%s: nothing was hit at (%g, %g); pick a pixel of a thing",
                     path, place->x, place->y);
}

bool focus_pick(const struct focus_request *request, const struct settings *settings,
                double *distance, struct image_error *error)
{
    struct source source;
    struct rf_params params;
    struct rf_error core_error;
    char text[1024];
    if (!source_open(&source, request->source, error))
        return false;
    bool is_good = false;
    struct settings *own = app_memory(1, sizeof(*own), error);
    if (own)
        *own = *settings;
    if (own && !source_check_depth(&source, error))
        is_good = false;
    else if (own && source.info.is_deep)
        set_error(error,
                  "%s: holds deep samples; pick in a flat file of it "
                  "(filter --flattened)",
                  image_path(source.colour));
    else if (own && !source_read_facts(&source, own, text, sizeof(text)))
        set_error(error, "%s", text);
    else if (own &&
             settings_fit_window(own, &source.info, &params, &core_error) != RF_OK)
        set_error(error, "%s: %s", image_path(source.depth), core_error.message);
    else if (own)
        is_good = pick(&source, own, &params, request, distance, error);
    free(own);
    source_close(&source);
    return is_good;
}
