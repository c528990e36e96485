/* SPDX-License-Identifier: Apache-2.0 */
/* The views of an input with their mean distances, as `rackfocus filter` takes them. */
#ifndef VIEW_MEANS_H
#define VIEW_MEANS_H

#include "pixels/input.h"
#include "rackfocus/rackfocus.h"

struct means {
    int n;
    struct rf_view *views; /* the input's; their mean_depth belongs to this */
};

/* Makes them for a picture of the input's size with these parameters. */
rf_result means_open(struct means *means, const struct input *input,
                     const struct rf_params *params, struct rf_error *error);
void means_close(struct means *means);

#endif
