/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that come at once. */
#ifndef VIEW_QUICK_H
#define VIEW_QUICK_H

#include <stdbool.h>

#include "filtering/worker.h"

/* Is the method itself quick enough to follow the mouse? */
bool quick_is_preview(int32_t method);

/* The parameters of a quick picture: the core's own preview quality where it has one.
 */
struct rf_params quick_params(const struct job *job);

#endif
