/* SPDX-License-Identifier: Apache-2.0 */
/* The method accumulate: the mean of views. */
#ifndef RF_METHODS_ACCUMULATE_H
#define RF_METHODS_ACCUMULATE_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_accumulate_run(struct rf_work *work, struct rf_error *error);

#endif
