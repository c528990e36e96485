/* SPDX-License-Identifier: Apache-2.0 */
/* Do several views lie where their headers say? */
#ifndef APP_VIEWS_FIT_H
#define APP_VIEWS_FIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* How the reader knows what is said of a view's place. */
struct views_words {
    const char *header, *plural; /* what says it: "its header", "headers" */
    const char *offset, *shear;  /* names of the place and of the plane kept fixed */
};

/* What is looked at: n views of planar or radial depth, or a band of whole rows of them.
 */
struct views_fit_given {
    const struct rf_view *views;
    int n;
    int32_t first_row; /* of the band, in the picture */
    const struct rf_params *params;
    const struct rf_lens *lens;
    const struct views_words *words;
};

/* What was found: either all views lie elsewhere, or one of them does. */
struct views_fit {
    int wrong_view; /* -1: all of them */
    double as_is; /* share of the edges of near things that are where they should be */
    double
        otherwise; /* the same as `way_out` has it; of one view: that of the others */
    char way_out[160]; /* what would be right; empty for one view */
};

/*
 * Holds the depths of views against each other; false where they fit, where nothing
 * tells, and without memory.
 */
bool views_fit_is_wrong(const struct views_fit_given *given, struct views_fit *found);

/* Says what was found, without the name of the file or of the view. */
void views_fit_explain(const struct views_fit *found, const struct views_words *words,
                       char *text, size_t n_text);

#endif
