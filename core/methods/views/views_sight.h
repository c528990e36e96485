/* SPDX-License-Identifier: Apache-2.0 */
/* What each view shows that others do not see. */
#ifndef RF_METHODS_VIEWS_VIEWS_SIGHT_H
#define RF_METHODS_VIEWS_VIEWS_SIGHT_H

#include "methods/views/merge.h"
#include "rackfocus/rackfocus.h"

/* Lists in v->unseen what each view shows that others do not see. */
rf_result rf_views_find_unseen(struct rf_views *v, struct rf_error *error);

void rf_views_free_unseen(struct rf_views *v);

#endif
