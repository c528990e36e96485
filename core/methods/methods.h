/* SPDX-License-Identifier: Apache-2.0 */
/* The table of methods. */
#ifndef RF_METHODS_METHODS_H
#define RF_METHODS_METHODS_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

/* Filters a frame: input/views_in.h says what it gets and what it leaves. */
typedef rf_result (*rf_method_fn)(struct rf_work *work, struct rf_error *error);

/* How a method runs, which the parameters' check has found to be one. */
rf_method_fn rf_method_run(enum rf_method method);

#endif
