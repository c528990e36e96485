/* SPDX-License-Identifier: Apache-2.0 */
/* Have several views of one scene the same exposure, and depth in one unit? */
#ifndef APP_VIEWS_LIGHT_H
#define APP_VIEWS_LIGHT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* The light of n views, a mean for each cell of a grid. */
struct views_light;

/* Of views of width x height px, all black; NULL without memory. */
struct views_light *views_light_create(int n, int32_t width, int32_t height);
void views_light_free(struct views_light *light); /* which may be NULL */

/* Adds rows of a view's colour, the picture's whole width, from first_row on; of any
 * number of channels, of which red, green and blue, or grey, are counted; or of a view's
 * depth, of which what was not hit counts for nothing. */
void views_light_add(struct views_light *light, int view, const struct rf_image *colour,
                     int32_t first_row);

/* What was found: the view that is farthest from the others. */
struct views_light_found {
    int view, n_others; /* of these others, too, are something else than most are */
    double times[3];    /* its red, green and blue by those of the others */
};

/* False where all agree, and where nothing tells: black views, tiny pictures. */
bool views_light_differs(const struct views_light *light,
                         struct views_light_found *found);

/* The same of whole views at once; false without memory, too. */
bool views_light_is_other(const struct rf_view *views, int n,
                          struct views_light_found *found);

/* Says it, without the name of the view, and what can be done. */
void views_light_explain(const struct views_light_found *found, char *text,
                         size_t n_text);

/* The same of depth. */
void views_light_explain_depth(const struct views_light_found *found, char *text,
                               size_t n_text);

#endif
