/* SPDX-License-Identifier: Apache-2.0 */
/* What the colours have in common of a scene that is composited colour by colour. */
#ifndef RF_COMPOSE_COMMON_H
#define RF_COMPOSE_COMMON_H

#include <stdbool.h>

#include "base/context.h"
#include "compose/composer.h"
#include "compose/occluder_layers.h"

/*
 * Made with the first colour: what may stand before highlights and, if `has_lists`, the
 * lists of samples, whose radii are the same in all colours then. All else is zeros at
 * first; rf_common_free() in any case.
 */
struct rf_common {
    bool has_lists;
    struct rf_lists lists;
    struct rf_occluder_layers layers;
};

void rf_common_free(struct rf_common *common, const struct rf_context *context);

#endif
