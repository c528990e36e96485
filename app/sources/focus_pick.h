/* SPDX-License-Identifier: Apache-2.0 */
/* The distance of what a pixel shows, to focus on. */
#ifndef APP_FOCUS_PICK_H
#define APP_FOCUS_PICK_H

#include <stdbool.h>

#include "sources/settings.h"
#include "sources/source.h"

/* A pixel, counted from the upper left one of the display window: right and down. */
struct focus_place {
    double x, y; /* px */
};

struct app_host;

/* What is picked, and where. */
struct focus_request {
    const struct source_request *source;
    struct focus_place place;
    const struct app_host *host; /* who is warned, or NULL */
};

/*
 * Planar distance, scene units, of what a picture shows there: the median of 3 x 3
 * pixels, so that an edge that was picked is one side or the other. `settings` is the
 * command line; what the header says is not added to it. False with the error: nothing
 * was hit, the place lies outside, the file cannot be read, or its depth is one that
 * filter refuses. What filter warns of is told to the host.
 */
bool focus_pick(const struct focus_request *request, const struct settings *settings,
                double *distance, struct image_error *error);

#endif
