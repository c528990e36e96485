/* SPDX-License-Identifier: Apache-2.0 */
/* Depth for what is partly transparent. */
#ifndef RF_INPUT_FILM_H
#define RF_INPUT_FILM_H

#include <stdbool.h>
#include <stddef.h>

#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* The alphas of a picture: that of pixel (x, y) is at[y row + x pixel]. */
struct rf_alphas {
    const float *at;
    ptrdiff_t pixel, row; /* floats */
};

/*
 * Gives partly transparent pixels without depth that of a surface, as film_depth says:
 * changes `radius`, packed. *is_changed is true where one was.
 */
rf_result rf_film_fill(const struct rf_frame *frame, struct rf_alphas alpha,
                       float *radius, bool *is_changed, struct rf_error *error);

#endif
