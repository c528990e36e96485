/* SPDX-License-Identifier: Apache-2.0 */
#include "views.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"

bool views_find_place(const struct exr_input *input, double lens_offset[2],
                      double *shear_distance)
{
    if (!exr_attribute_v2f(input, VIEWS_OFFSET, lens_offset))
        return false;
    if (!exr_attribute_number(input, VIEWS_SHEAR, shear_distance))
        *shear_distance = 0;
    return true;
}

int views_count(char *const *paths, int n_paths, const char **other,
                struct exr_error *error)
{
    for (int i = 0; i < n_paths; i++) {
        struct exr_input *input;
        double place[2], shear;
        if (!exr_open(&input, paths[i], error))
            return -1;
        const bool is_view = views_find_place(input, place, &shear);
        exr_close(input);
        if (!is_view) {
            *other = paths[i];
            return i;
        }
    }
    return n_paths;
}

static bool check_like(const struct source *view, const struct source *first,
                       struct exr_error *error)
{
    const struct exr_part_info *a = &view->info, *b = &first->info;
    if (memcmp(&a->data_window, &b->data_window, sizeof(a->data_window)) == 0 &&
        memcmp(&a->display_window, &b->display_window, sizeof(a->display_window)) ==
            0 &&
        view->n_channels == first->n_channels)
        return true;
    snprintf(error->message, sizeof(error->message),
             "%s: is %d x %d with %d channels of colour, but %s is %d x %d with %d; "
             "render all views with the same windows and channels",
             exr_path(view->colour), view->width, view->height, view->n_channels,
             exr_path(first->colour), first->width, first->height, first->n_channels);
    return false;
}

static bool read_view(struct views *views, const struct source *first, int n_threads,
                      struct exr_error *error)
{
    const struct source *source = &views->sources[views->n - 1];
    struct rf_view *view = &views->views[views->n - 1];
    if (!source_check(source, error) || !check_like(source, first, error))
        return false;
    float *colour = source_read_colour(source, n_threads, error);
    view->colour =
        rf_image_packed(colour, source->width, source->height, source->n_channels);
    if (!colour)
        return false;
    float *depth = source_read_depth(source, n_threads, error);
    view->depth = rf_image_packed(depth, source->width, source->height, 1);
    views_find_place(source->colour, view->lens_offset, &view->shear_distance);
    return depth != NULL;
}

bool views_read(struct views *views, const struct source *first,
                const struct source_request *request, int n_threads,
                struct exr_error *error)
{
    *views = (struct views){
        .sources = need_memory((size_t)request->n_paths, sizeof(*views->sources)),
        .views = need_memory((size_t)request->n_paths, sizeof(*views->views))};
    for (int i = 0; i < request->n_paths; i++) {
        struct source_request one = *request;
        one.paths = request->paths + i;
        one.n_paths = 1;
        if (!source_open(&views->sources[i], &one, error))
            return false;
        views->n++;
        if (!read_view(views, first, n_threads, error))
            return false;
    }
    return true;
}

void views_free(struct views *views)
{
    for (int i = 0; i < views->n; i++) {
        free(views->views[i].colour.data);
        free(views->views[i].depth.data);
        source_close(&views->sources[i]);
    }
    free(views->sources);
    free(views->views);
    *views = (struct views){0};
}
