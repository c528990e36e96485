/* SPDX-License-Identifier: Apache-2.0 */
/* Do several views lie where their headers say? */
#ifndef APP_VIEWS_FIT_H
#define APP_VIEWS_FIT_H

#include <stdbool.h>
#include <stddef.h>

#include "rackfocus/rackfocus.h"

/* What was found: either all views lie elsewhere, or one of them does. */
struct views_fit {
    int wrong_view; /* -1: all of them */
    double as_is; /* share of the edges of near things that are where they should be */
    double
        otherwise; /* the same as `way_out` has it; of one view: that of the others */
    char way_out[160]; /* what would be right; empty for one view */
};

/*
 * Holds the depths of n views against each other; false where they fit, where nothing
 * tells, and without memory. Of planar and radial depth in a perspective.
 */
bool views_fit_is_wrong(const struct rf_view *views, int n,
                        const struct rf_params *params, const struct rf_lens *lens,
                        struct views_fit *found);

/* What is wrong as words after the name of the file, that of `wrong_view` or of the
 * first, with the way out. */
void views_fit_describe(const struct views_fit *found, char *text, size_t n_bytes);

#endif
