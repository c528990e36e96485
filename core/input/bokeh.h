/* SPDX-License-Identifier: Apache-2.0 */
/* An image as the distribution of light in a circle of confusion. */
#ifndef RF_INPUT_BOKEH_H
#define RF_INPUT_BOKEH_H

#include <stdbool.h>

#include "base/context.h"
#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

struct rf_bokeh {
    int width, height;
    int n_planes; /* 1, or 4: red, green, blue and their mean */
    double *sum;  /* per plane (height + 1) x (width + 1), the last of them 1 */
};

/* Share of the light left of x and above y, clamped to the picture. */
double rf_bokeh_sum(const struct rf_bokeh *d, int plane, double x, double y);

/* Checks a picture and makes a distribution of it, which is to be freed. */
rf_result rf_bokeh_make(struct rf_bokeh **bokeh, const struct rf_context *context,
                        const struct rf_image *image, struct rf_error *error);

/* That of a lens whose middle is hidden: dark within `hole`, in parts of the radius,
 * and even around it, as far as the aperture reaches. */
rf_result rf_bokeh_make_ring(struct rf_bokeh **bokeh, const struct rf_context *context,
                             double hole, struct rf_error *error);

/* The same of hollow blades, whose shape is their polygon; `hole` may be 0. */
rf_result rf_bokeh_make_hollow(struct rf_bokeh **bokeh,
                               const struct rf_context *context,
                               const struct rf_hollow *hollow, double hole,
                               struct rf_error *error);

/* A distribution of one plane of another, which is to be freed. */
rf_result rf_bokeh_copy_plane(struct rf_bokeh **copy, const struct rf_context *context,
                              const struct rf_bokeh *bokeh, int plane,
                              struct rf_error *error);

/* Is `copy` that of this plane, to the bit? */
bool rf_bokeh_is_plane(const struct rf_bokeh *copy, const struct rf_bokeh *bokeh,
                       int plane);

void rf_bokeh_free(struct rf_bokeh *bokeh, const struct rf_context *context);

#endif
