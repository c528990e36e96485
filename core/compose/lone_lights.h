/* SPDX-License-Identifier: Apache-2.0 */
/* Which highlights are points of light. */
#ifndef RF_COMPOSE_LONE_LIGHTS_H
#define RF_COMPOSE_LONE_LIGHTS_H

#include "base/context.h"
#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/* Of each highlight of a scene; rf_lone_lights_free() in any case. */
struct rf_lone_lights {
    unsigned char *are; /* per highlight: is it lone? NULL: none is */
};

/* Finds the highlights that have no other one in the nine pixels around them. */
rf_result rf_lone_lights_find(struct rf_lone_lights *lone, const struct rf_scene *scene,
                              struct rf_error *error);

void rf_lone_lights_free(struct rf_lone_lights *lone, const struct rf_context *context);

#endif
