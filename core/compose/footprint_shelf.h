/* SPDX-License-Identifier: Apache-2.0 */
/* Footprints that stay with a context. */
#ifndef RF_COMPOSE_FOOTPRINT_SHELF_H
#define RF_COMPOSE_FOOTPRINT_SHELF_H

#include <stddef.h>

#include "base/context.h"
#include "compose/footprint.h"
#include "rackfocus/rackfocus.h"

/*
 * Small footprints of the last few apertures stay with the context (footprint_shelf.c).
 * Gives those of one that reach the radius, or new ones in `own`, which is not kept;
 * rf_footprints_put() in any case, when the picture is done.
 */
rf_result rf_footprints_get(struct rf_footprints **f, struct rf_footprints *own,
                            const struct rf_context *context,
                            const struct rf_footprint_use *use, struct rf_error *error);

void rf_footprints_put(struct rf_footprints *f, struct rf_footprints *own);

size_t rf_shelf_bytes(void);

/* Frees what is kept; no picture is in work. */
void rf_shelf_clear(const struct rf_context *context);

#endif
