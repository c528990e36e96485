/* SPDX-License-Identifier: Apache-2.0 */
/* The table of methods. */
#ifndef RF_METHODS_METHODS_H
#define RF_METHODS_METHODS_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

/* One row of the table (methods.c). */
struct rf_method_entry {
    rf_result (*run)(struct rf_work *work, struct rf_error *error);
    int max_views;
};

/* The row of a method, which the parameters' check has found to be one. */
const struct rf_method_entry *rf_method_of(enum rf_method method);

#endif
