/* SPDX-License-Identifier: Apache-2.0 */
/* What lies behind the near surfaces of each view. */
#ifndef RF_METHODS_VIEWS_VIEWS_BEHIND_H
#define RF_METHODS_VIEWS_VIEWS_BEHIND_H

#include "methods/views/merge.h"
#include "rackfocus/rackfocus.h"

/*
 * Sets v->occluders[].behind of all views from v->unseen, in *planes, which the caller
 * frees when the occluders are no longer used, and in any case.
 */
rf_result rf_views_find_behind(const struct rf_views *v, float **planes,
                               struct rf_error *error);

#endif
