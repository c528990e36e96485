/* SPDX-License-Identifier: Apache-2.0 */
/* The highlights' light, taken out of its surfaces. */
#ifndef RF_COMPOSE_HIGHLIGHTS_FIND_H
#define RF_COMPOSE_HIGHLIGHTS_FIND_H

#include "input/views_in.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

/*
 * Takes the light of the highlights out of their surfaces, which keep the usual
 * luminance of the place: what is left can be blended, normalised and continued behind
 * things like any other surface, without doubling a lamp.
 */
rf_result rf_picture_take_highlights(struct rf_picture *picture,
                                     const struct rf_work_view *view, int n_planes,
                                     struct rf_error *error);

#endif
