/* SPDX-License-Identifier: Apache-2.0 */
/* Where the light of a lamp's rim comes from. */
#ifndef RF_COMPOSE_LAMP_RIMS_H
#define RF_COMPOSE_LAMP_RIMS_H

#include "base/context.h"
#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/* Of each highlight of a scene; rf_lamp_rims_free() in any case. */
struct rf_lamp_rims {
    float (*inward)[2]; /* px to the right and down from its pixel; NULL: none moves */
};

/* Finds from where in its lamp the light of each highlight comes. */
rf_result rf_lamp_rims_find(struct rf_lamp_rims *rims, const struct rf_scene *scene,
                            struct rf_error *error);

void rf_lamp_rims_free(struct rf_lamp_rims *rims, const struct rf_context *context);

#endif
