/* SPDX-License-Identifier: Apache-2.0 */
/* The method views. */
#ifndef RF_METHODS_VIEWS_VIEWS_H
#define RF_METHODS_VIEWS_VIEWS_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_views_run(struct rf_work *work, struct rf_error *error);

#endif
