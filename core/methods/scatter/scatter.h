/* SPDX-License-Identifier: Apache-2.0 */
/* The method scatter. */
#ifndef RF_METHODS_SCATTER_SCATTER_H
#define RF_METHODS_SCATTER_SCATTER_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_scatter_run(struct rf_work *work, struct rf_error *error);

#endif
