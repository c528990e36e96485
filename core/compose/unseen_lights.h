/* SPDX-License-Identifier: Apache-2.0 */
/* Lights that a picture does not show, where the caller knows them. */
#ifndef RF_COMPOSE_UNSEEN_LIGHTS_H
#define RF_COMPOSE_UNSEEN_LIGHTS_H

#include "input/views_in.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

/*
 * Puts the lights of a view (rf_view.unseen_lights) to the picture's highlights, if
 * those have been taken, but for those that the picture shows. `estimates` (at NULL:
 * none) say what is usual behind things. RF_ERROR_PIXEL: a colour that cannot be summed.
 */
rf_result rf_unseen_lights_put(struct rf_picture *picture,
                               const struct rf_work_view *view,
                               const struct rf_estimates *estimates,
                               struct rf_error *error);

#endif
