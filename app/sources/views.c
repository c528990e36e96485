/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/views.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

const struct views_words views_in_headers = {"its header", "headers", VIEWS_OFFSET,
                                             VIEWS_SHEAR};

bool views_find_place(const struct image_input *input, const char *view,
                      double lens_offset[2], double *shear_distance)
{
    *shear_distance = 0;
    if (view) {
        image_view_number(input, view, VIEWS_SHEAR, shear_distance);
        return image_view_v2f(input, view, VIEWS_OFFSET, lens_offset);
    }
    image_attribute_number(input, VIEWS_SHEAR, shear_distance);
    return image_attribute_v2f(input, VIEWS_OFFSET, lens_offset);
}

static bool add_view(struct view_list *list, const char *path, const char *name,
                     struct image_error *error)
{
    struct view_input *items = app_memory((size_t)list->n + 1, sizeof(*items), error);
    char *own_name = items && name ? app_memory(strlen(name) + 1, 1, error) : NULL;
    if (!items || (name && !own_name)) {
        free(items);
        return false;
    }
    if (list->n)
        memcpy(items, list->items, (size_t)list->n * sizeof(*items));
    items[list->n].path = path;
    if (name) {
        strcpy(own_name, name);
        items[list->n].name = own_name;
    }
    free(list->items);
    list->items = items;
    list->n++;
    return true;
}

/* Adds the views of a file, none where it is no view; false on failure. */
static bool add_views(struct view_list *list, const struct image_input *input,
                      const char *path, struct image_error *error)
{
    const int n_views = image_view_count(input), n_before = list->n;
    double place[2], shear;
    if (n_views < 2) {
        return !views_find_place(input, NULL, place, &shear) ||
               add_view(list, path, NULL, error);
    }
    const char *without = NULL;
    for (int i = 0; i < n_views; i++) {
        const char *name = image_view_name(input, i);
        if (!views_find_place(input, name, place, &shear))
            without = name;
        else if (!add_view(list, path, name, error))
            return false;
    }
    if (!without || list->n == n_before)
        return true;
    set_error(error,
              "%s: the header has no " VIEWS_OFFSET " for the view %s, but for others; "
              "say it for all, or name one view with --layer",
              path, without);
    return false;
}

bool views_list(char *const *paths, int n_paths, struct view_list *list,
                const char **other, struct image_error *error)
{
    *list = (struct view_list){0};
    *other = NULL;
    for (int i = 0; i < n_paths && !*other; i++) {
        struct image_input *input;
        const int n_before = list->n;
        if (!image_open(&input, paths[i], error))
            return false;
        const bool is_good = add_views(list, input, paths[i], error);
        image_close(input);
        if (!is_good)
            return false;
        if (list->n == n_before)
            *other = paths[i];
    }
    return true;
}

void views_list_free(struct view_list *list)
{
    for (int i = 0; i < list->n; i++)
        free(list->items[i].name);
    free(list->items);
    *list = (struct view_list){0};
}

static bool check_like(const struct source *view, const struct source *first,
                       struct image_error *error)
{
    const struct image_part_info *a = &view->info, *b = &first->info;
    if (memcmp(&a->data_window, &b->data_window, sizeof(a->data_window)) == 0 &&
        memcmp(&a->display_window, &b->display_window, sizeof(a->display_window)) ==
            0 &&
        view->n_channels == first->n_channels)
        return true;
    const struct image_box *box = &a->data_window, *own = &b->data_window;
    if (view->width == first->width && view->height == first->height &&
        view->n_channels == first->n_channels) {
        const bool is_data = memcmp(box, own, sizeof(*box)) != 0;
        box = is_data ? box : &a->display_window;
        own = is_data ? own : &b->display_window;
        return set_error(error,
                         "%s: its %s window is (%d, %d) to (%d, %d), that of %s (%d, "
                         "%d) to (%d, %d); render all views with the same windows",
                         image_path(view->colour), is_data ? "data" : "display",
                         box->min_x, box->min_y, box->max_x, box->max_y,
                         image_path(first->colour), own->min_x, own->min_y, own->max_x,
                         own->max_y);
    }
    set_error(error,
              "%s: is %d x %d with %d channels of colour, but %s is %d x %d with %d; "
              "render all views with the same windows and channels",
              image_path(view->colour), view->width, view->height, view->n_channels,
              image_path(first->colour), first->width, first->height,
              first->n_channels);
    return false;
}

bool views_open(struct views *views, const struct source *first,
                const struct view_list *list, const struct source_request *request,
                struct image_error *error)
{
    *views = (struct views){
        .sources = app_memory((size_t)list->n, sizeof(*views->sources), error),
        .views = app_memory((size_t)list->n, sizeof(*views->views), error)};
    if (!views->sources || !views->views)
        return false;
    for (int i = 0; i < list->n; i++) {
        char *path[1] = {(char *)list->items[i].path};
        struct source_request one = *request;
        one.paths = path;
        one.n_paths = 1;
        one.view = list->items[i].name;
        const struct source *source = &views->sources[i];
        struct rf_view *view = &views->views[i];
        if (!source_open(&views->sources[i], &one, error))
            return false;
        views->n++;
        if (!source_check(source, error) || !check_like(source, first, error))
            return false;
        views_find_place(source->colour, one.view, view->lens_offset,
                         &view->shear_distance);
    }
    return true;
}

double views_reach(const struct views *views, double middle[2])
{
    double reach = 0;
    middle[0] = middle[1] = 0;
    for (int i = 0; i < views->n; i++)
        for (int k = 0; k < 2; k++)
            middle[k] += views->views[i].lens_offset[k] / views->n;
    for (int i = 0; i < views->n; i++) {
        const double *at = views->views[i].lens_offset;
        reach = fmax(reach, hypot(at[0] - middle[0], at[1] - middle[1]));
    }
    return reach;
}

bool views_read_pixels(struct views *views, int n_threads, struct image_error *error)
{
    for (int i = 0; i < views->n; i++) {
        const struct source *source = &views->sources[i];
        struct rf_view *view = &views->views[i];
        float *colour = source_read_colour(source, n_threads, error);
        view->colour =
            rf_image_packed(colour, source->width, source->height, source->n_channels);
        if (!colour)
            return false;
        float *depth = source_read_depth(source, n_threads, error);
        view->depth = rf_image_packed(depth, source->width, source->height, 1);
        if (!depth)
            return false;
    }
    return true;
}

bool views_read(struct views *views, const struct source *first,
                const struct view_list *list, const struct source_request *request,
                int n_threads, struct image_error *error)
{
    return views_open(views, first, list, request, error) &&
           views_read_pixels(views, n_threads, error);
}

void views_free(struct views *views)
{
    for (int i = 0; i < views->n; i++) {
        free(views->views[i].colour.data);
        free(views->views[i].depth.data);
        free(views->views[i].mean_depth.data);
        source_close(&views->sources[i]);
    }
    free(views->sources);
    free(views->views);
    *views = (struct views){0};
}
