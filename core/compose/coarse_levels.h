/* SPDX-License-Identifier: Apache-2.0 */
/* Radii at a reduced resolution. */
#ifndef RF_COMPOSE_COARSE_LEVELS_H
#define RF_COMPOSE_COARSE_LEVELS_H

#include <stdbool.h>

#include "compose/composer.h"
#include "rackfocus/rackfocus.h"

/* Composites a coarse level, and adds it to the canvas; with what is visible it closes
 * the insides of surfaces. */
rf_result rf_run_level(const struct rf_composer *c, const struct rf_group *g,
                       bool is_visible, struct rf_error *error);

#endif
