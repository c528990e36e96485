/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters with their defaults, and sizes that can be. */
#ifndef RF_LENS_PARAMS_H
#define RF_LENS_PARAMS_H

#include <stdbool.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* rf_params_check(), but for what depends on the method. */
rf_result rf_params_check_ranges(const struct rf_params *params,
                                 struct rf_error *error);

/*
 * Parameters of a caller that was built with an older header, and knows fewer of them,
 * with the defaults for the rest.
 */
void rf_params_complete(struct rf_params *full, const struct rf_params *params);

/* Does the struct say a size that rf_params_init() of some version gave it? */
bool rf_params_have_size(const struct rf_params *params);

/* Checks the sides of a picture, 1 to 65535 px; field "width" or "height". */
rf_result rf_lens_check_size(int32_t width, int32_t height, struct rf_error *error);

#endif
