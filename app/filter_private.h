/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of a run of the filter share. */
#ifndef APP_FILTER_PRIVATE_H
#define APP_FILTER_PRIVATE_H

#include "aov.h"
#include "deep.h"
#include "filter_run.h"
#include "settings.h"
#include "source.h"
#include "views.h"

/* Everything that one run holds. */
struct run {
    const struct filter_options *tool;
    struct image_error *error;
    int remark; /* APP_DONE, or an error that the core's remarks were to the host */
    struct settings *settings;
    struct rf_params params; /* for the data window */
    struct source_request request;
    struct source source; /* of the first view where there are several */
    bool has_views;
    struct view_list list;
    struct views views;
    double aperture_at[2]; /* scene units right and up on the lens of the views */
    struct aovs aovs;
    bool is_deep;
    struct deep_frame deep;
    float *colour, *depth; /* of the first view; colour becomes the result */
    struct rf_context_params context_params;
    struct rf_context *context;
    struct rf_filter *filter;
    int n_threads;
};

/* ---- filter_output.c ------------------------------------------------------------- */

/* Takes from a description what the lens's picture does not have: it is no view, and
 * has no name among others. */
void filter_drop_view(const struct run *run, struct source_description *to);

/* What the filter did, for the header. */
void filter_describe(const struct run *run, char *text, size_t n_bytes);
/* Of the output; that of the input where nothing was said. */
const char *filter_compression(const struct run *run);
/* The picture and, from the depth, which holds radii by then, the radii. */
bool filter_write_files(const struct run *run, struct image_error *error);
/* Colour and depth of a deep input, flat: float, as other filters would want them. */
bool filter_write_flattened(const struct run *run, struct image_error *error);

#endif
