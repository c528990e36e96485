/* SPDX-License-Identifier: Apache-2.0 */
/* Light that is seen in mirrors and through glass, and where its depth comes from. */
#ifndef APP_SEEN_H
#define APP_SEEN_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"

struct filter_options;
struct run;

enum seen_kind { SEEN_REFLECTION, SEEN_TRANSMISSION, SEEN_KINDS };

/* The lights of a view, in the order of seen.kinds. */
struct seen_view {
    struct rf_seen_light lights[SEEN_KINDS];
    /* With --denoise, which changes the view's colour: what part of it each light is;
     * NULL: the lights are as they were read. */
    float *parts[SEEN_KINDS];
};

/* The lights of a run; begins as zeros. */
struct seen {
    int n, n_views;
    enum seen_kind kinds[SEEN_KINDS];
    double shares[SEEN_KINDS]; /* of the picture, that have a depth of their own */
    struct seen_view *views;
};

/* Was anything of it asked for? */
bool seen_is_asked(const struct filter_options *tool);

/* What it does not go together with, before pixels are read. An enum app_code. */
int seen_check(const struct run *run);

/* Reads the lights and finds their depths. An enum app_code. */
int seen_find(struct run *run);

/* Puts the lights into a view, whose colours are at hand. */
void seen_set(const struct run *run, int index, struct rf_view *view);

/* For the line at the end: ", reflections ..." or nothing. */
void seen_describe(const struct seen *seen, char *text, size_t n_bytes);

void seen_free(struct seen *seen);

#endif
