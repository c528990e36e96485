/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/input_read.h"

#include <stdlib.h>

#include "common/report.h"
#include "sources/deep.h"
#include "sources/mean_depth.h"

struct input *input_read(const struct source *source, int n_threads,
                         struct image_error *error)
{
    const int32_t width = source->width, height = source->height;
    float *colour = source_read_colour(source, n_threads, error);
    float *depth = colour ? source_read_depth(source, n_threads, error) : NULL;
    struct input *input =
        depth ? input_create(width, height, source->n_channels, 1) : NULL;
    if (depth && !input)
        set_error(error, "out of memory");
    if (!input) {
        free(colour);
        free(depth);
        return NULL;
    }
    input->views[0] = (struct rf_view){
        .colour = rf_image_packed(colour, width, height, source->n_channels),
        .depth = rf_image_packed(depth, width, height, 1)};
    if (mean_depth_read_rays(source, n_threads, &input->rays[0], error))
        return input;
    input_drop(input);
    return NULL;
}

static rf_result flatten(const struct input *input, const struct source *source,
                         const struct rf_params *params, int n_threads,
                         struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    const struct rf_context_params how = {.size = sizeof(how), .n_threads = n_threads};
    rf_result result = rf_context_create(&context, &how, error);
    if (result != RF_OK)
        return result;
    result =
        rf_filter_create(&filter, context, params, input->width, input->height, error);
    if (result == RF_OK) {
        result = deep_flatten(input->deep, filter, source, input->views[0].colour.data,
                              input->views[0].depth.data, error);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return result;
}

struct input *input_read_deep(const struct source *source,
                              const struct rf_params *params, int n_threads,
                              struct image_error *error)
{
    struct rf_error core_error;
    const int32_t width = source->width, height = source->height;
    const size_t n = (size_t)width * (size_t)height;
    struct input *input = input_create(width, height, source->n_channels, 1);
    float *colour = app_memory(n, (size_t)source->n_channels * sizeof(float), error);
    float *depth = app_memory(n, sizeof(float), error);
    if (!input || !colour || !depth) {
        set_error(error, "out of memory");
        free(colour);
        free(depth);
        input_drop(input);
        return NULL;
    }
    input->views[0] = (struct rf_view){
        .colour = rf_image_packed(colour, width, height, source->n_channels),
        .depth = rf_image_packed(depth, width, height, 1)};
    input->deep = app_memory(1, sizeof(*input->deep), error);
    bool is_good = input->deep;
    if (is_good)
        *input->deep = (struct deep_frame){0};
    is_good = is_good && deep_read(input->deep, source, NULL, n_threads, error);
    if (is_good && flatten(input, source, params, n_threads, &core_error) != RF_OK)
        is_good =
            set_error(error, "%s: %s", image_path(source->colour), core_error.message);
    if (is_good)
        return input;
    input_drop(input);
    return NULL;
}

struct input *input_read_views(const struct source *first, const struct view_list *list,
                               const struct source_request *request, int n_threads,
                               struct image_error *error)
{
    struct views views;
    struct input *input = NULL;
    if (views_read(&views, first, list, request, n_threads, error)) {
        input = input_create(first->width, first->height, first->n_channels, views.n);
        if (!input)
            set_error(error, "out of memory");
    }
    bool is_read = input;
    for (int i = 0; input && i < views.n; i++) {
        input->views[i] = views.views[i];
        views.views[i].colour.data = views.views[i].depth.data = NULL;
        is_read = is_read && mean_depth_read_rays(&views.sources[i], n_threads,
                                                  &input->rays[i], error);
    }
    views_free(&views);
    if (is_read)
        return input;
    input_drop(input);
    return NULL;
}
