/* SPDX-License-Identifier: Apache-2.0 */
/* Depth for what is partly transparent. */
#ifndef RF_INPUT_FILM_H
#define RF_INPUT_FILM_H

#include <stdbool.h>

#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* Is one of n pixels partly transparent and without depth, so that it needs that? */
bool rf_film_is_missing(const struct rf_filter *filter, const float *alpha,
                        const float *radius, int n);

/* Gives partly transparent pixels without depth that of a surface, as film_depth says.
 */
rf_result rf_film_fill(const struct rf_filter *filter, const float *alpha,
                       float *radius, bool *is_changed, struct rf_error *error);

#endif
