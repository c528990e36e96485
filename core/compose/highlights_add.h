/* SPDX-License-Identifier: Apache-2.0 */
/* Highlights with exact visibility. */
#ifndef RF_COMPOSE_HIGHLIGHTS_ADD_H
#define RF_COMPOSE_HIGHLIGHTS_ADD_H

#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/* Adds the light of the highlights to the finished planes (highlights_add.c). */
rf_result rf_add_highlights(const struct rf_scene *scene, const struct rf_crop *out,
                            struct rf_error *error);

#endif
