/* SPDX-License-Identifier: Apache-2.0 */
/* Filters a picture that does not fit into memory, window by window. */
#ifndef APP_WINDOWS_H
#define APP_WINDOWS_H

#include "rackfocus/rackfocus.h"
#include "source.h"

struct windows_job {
    int n_views;
    const struct source *sources;      /* of the views */
    const struct rf_view *places;      /* on the lens; of one view not looked at */
    const struct image_output *output; /* but for its samples */
    const char *path;                  /* of the output */
    const struct rf_params *params;
    const struct rf_context_params *context; /* max_bytes is not looked at */
    int32_t mist_falloff;                    /* as in depth_repair.h */
    double depth_infinity;
    int n_threads;
    size_t max_bytes; /* to hold at a time */
    const struct app_host *host;
    struct image_error *error; /* where what went wrong is said */
    double *largest_radius;    /* px; receives that of all views */

    /* What windows_measure() led to: repairs of the depth of a lone view. */
    bool is_premultiplied, is_mixed;
};

/* Bytes that n views like a source take when they are filtered whole. */
size_t windows_whole_bytes(const struct source *source, int n_views);

/* Does the way through windows know pictures like this one? */
bool windows_are_possible(const struct source *source, const struct rf_params *params);

/* What the depth of a lone view looks like, from a pass over the file. An enum
 * app_code. */
int windows_measure(const struct windows_job *job, struct rf_depth_stats *stats);

/*
 * Reads strips of rows, filters windows of them and writes each strip when it is done:
 * the same bits as those of the whole picture. An enum app_code.
 */
int windows_filter(const struct windows_job *job);

#endif
