/* SPDX-License-Identifier: Apache-2.0 */
/* Parameters with their defaults. */
#ifndef RF_LENS_PARAMS_H
#define RF_LENS_PARAMS_H

#include "rackfocus/rackfocus.h"

/*
 * Parameters of a caller that was built with an older header, and knows fewer of them,
 * with the defaults for the rest.
 */
void rf_params_complete(struct rf_params *full, const struct rf_params *params);

#endif
