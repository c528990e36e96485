/* SPDX-License-Identifier: Apache-2.0 */
#include "input_read.h"

#include <stdlib.h>

#include "report.h"

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
    return input;
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
    for (int i = 0; input && i < views.n; i++) {
        input->views[i] = views.views[i];
        views.views[i].colour.data = views.views[i].depth.data = NULL;
    }
    views_free(&views);
    return input;
}
