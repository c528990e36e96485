/* SPDX-License-Identifier: Apache-2.0 */
/* The footprints of highlights whose looks depend on the place. */
#ifndef RF_COMPOSE_LIGHT_LIST_H
#define RF_COMPOSE_LIGHT_LIST_H

#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "compose/footprint.h"
#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/* Which footprint each highlight of a scene has. */
struct rf_light_list {
    struct rf_listed *at; /* different ones */
    uint32_t *slot;       /* per highlight; NULL: looks do not depend on the place */
    /* What each highlight has of its footprint's light, whose place is rounded, where
     * that is quick to find; NULL: as much. */
    float *share;
};

/*
 * Lists the footprints of the scene's highlights and asks for them in `use`, if its
 * look depends on the place. rf_light_list_free() in any case.
 */
rf_result rf_light_list_make(struct rf_light_list *list, const struct rf_scene *scene,
                             struct rf_footprint_use *use, struct rf_error *error);

void rf_light_list_free(struct rf_light_list *list, const struct rf_context *context);

#endif
