/* SPDX-License-Identifier: Apache-2.0 */
/* Pinhole views from points of the lens: files whose headers say where each was taken.
 */
#ifndef APP_VIEWS_H
#define APP_VIEWS_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"
#include "sources/source.h"
#include "sources/views_fit.h"

#define VIEWS_OFFSET "rackfocus:lensOffset" /* v2f, scene units right and up */
#define VIEWS_ONE_IS_MEAN                                                              \
    "%s: one view is its own mean: nothing is blurred; give the views from all "       \
    "points "                                                                          \
    "of the lens, or blur this one by its depth with rackfocus filter --method "       \
    "layered"
#define VIEWS_SHEAR "rackfocus:shearDistance" /* float, scene units; 0: parallel */

/* That the headers of files say where views were taken. */
extern const struct views_words views_in_headers;

/* Where a view was taken; `view` names one of a multi-view file, or is NULL. False
 * where the header does not say it: no view from a point of the lens. */
bool views_find_place(const struct image_input *input, const char *view,
                      double lens_offset[2], double *shear_distance);

/* A view to read. */
struct view_input {
    const char *path;
    char *name; /* within a multi-view file, else NULL */
};

struct view_list {
    int n;
    struct view_input *items;
};

/*
 * The views that the files hold: one each, or as many as a multi-view file has. Stops
 * at the first file that is no view from a point of the lens and puts it in *other,
 * else NULL; a multi-view file of which only some views are is an error. False on
 * failure.
 */
bool views_list(char *const *paths, int n_paths, struct view_list *list,
                const char **other, struct image_error *error);
void views_list_free(struct view_list *list);

/* Opened files, where they were taken, and their pixels once they are read. */
struct views {
    int n;
    struct source *sources;
    struct rf_view *views; /* point to memory that belongs to this */
};

/* Opens all views; they must be like `first`, which is the first of them, opened. */
bool views_open(struct views *views, const struct source *first,
                const struct view_list *list, const struct source_request *request,
                struct image_error *error);
/* The middle of the views' places, and how far the farthest is from it; scene units. */
double views_reach(const struct views *views, double middle[2]);
bool views_read_pixels(struct views *views, int n_threads, struct image_error *error);
/* Both. */
bool views_read(struct views *views, const struct source *first,
                const struct view_list *list, const struct source_request *request,
                int n_threads, struct image_error *error);
void views_free(struct views *views);

#endif
