/* SPDX-License-Identifier: Apache-2.0 */
/* What a view hides, where the caller knows it. */
#ifndef RF_COMPOSE_KNOWN_HIDDEN_H
#define RF_COMPOSE_KNOWN_HIDDEN_H

#include "input/views_in.h"
#include "surfaces/hidden.h"
#include "surfaces/picture.h"
#include "rackfocus/rackfocus.h"

/*
 * Puts what the caller knows to lie behind the picture's pixels (rf_view.behind_colour)
 * in place of the estimates there, and its lamps to the picture's highlights, if those
 * have been taken. Nothing where the view brings none. RF_ERROR_PIXEL: a colour that
 * cannot be summed.
 */
rf_result rf_known_hidden_put(struct rf_picture *picture,
                              const struct rf_work_view *view,
                              struct rf_estimates *estimates, struct rf_error *error);

#endif
