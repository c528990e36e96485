/* SPDX-License-Identifier: Apache-2.0 */
/* Several pictures that are filtered each on its own: layers and stereo pairs. */
#ifndef APP_FILTER_MANY_H
#define APP_FILTER_MANY_H

#include "filter/filter_run.h"

/*
 * Filters layers, each with its own depth, and puts them over each other, premultiplied
 * and in linear light: the first lies on top. All but the last need alpha. The output
 * has the channels and the header of the last.
 */
int filter_over(const struct filter_options *tool, const struct settings *settings,
                char *const *paths, int n_paths, struct image_error *error);

/*
 * Filters all views of one multi-view file, or two files, left and right, with the
 * parameters of the first. The output is a multi-view file, or one file per view where
 * its name holds %V (the name of the view) or %v (its first letter).
 */
int filter_stereo(const struct filter_options *tool, struct settings *settings,
                  char *const *paths, int n_paths, struct image_error *error);

/* filter_over, filter_stereo or filter_run, as the options say. An enum app_code. */
int filter_any(const struct filter_options *tool, struct settings *settings,
               char *const *paths, int n_paths, struct image_error *error);

/* Does the name hold %V or %v? */
bool filter_has_view_mark(const char *name);

#endif
