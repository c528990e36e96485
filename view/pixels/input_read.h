/* SPDX-License-Identifier: Apache-2.0 */
/* Inputs out of files that are open. */
#ifndef VIEW_INPUT_READ_H
#define VIEW_INPUT_READ_H

#include "pixels/input.h"
#include "sources/source.h"
#include "sources/views.h"

/* Colour and depth as they are stored; NULL with a message. */
struct input *input_read(const struct source *source, int n_threads,
                         struct image_error *error);

/* The samples of a deep file, and its flat picture; `params` say what its depth is. */
struct input *input_read_deep(const struct source *source,
                              const struct rf_params *params, int n_threads,
                              struct image_error *error);

/* The views of a list, which are like `first`, the first of them; as views_read(). */
struct input *input_read_views(const struct source *first, const struct view_list *list,
                               const struct source_request *request, int n_threads,
                               struct image_error *error);

#endif
