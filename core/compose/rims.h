/* SPDX-License-Identifier: Apache-2.0 */
/* What rims leave open of a light that is nearly hidden. */
#ifndef RF_COMPOSE_RIMS_H
#define RF_COMPOSE_RIMS_H

#include "compose/occluder_layers.h"
#include "kernels/data.h"

/* Makes those pixels of a finished mask dark that are blocked by so much that it is no
 * more than a guess; afterwards 1 less what is blocked is seen, 0 to 1. */
void rf_rims_darken(const struct rf_occluder_layers *layers,
                    const struct rf_shadows *m);

#endif
