/* SPDX-License-Identifier: Apache-2.0 */
/* The lights of all views, each once. */
#ifndef RF_METHODS_VIEWS_VIEWS_LIGHTS_H
#define RF_METHODS_VIEWS_VIEWS_LIGHTS_H

#include "methods/views/merge.h"
#include "rackfocus/rackfocus.h"

/* How far from a light others lie that make its lamp one of several pixels, px, and
 * those that decide whose mask it takes. */
enum { RF_BESIDE_LAMP_PX = 2, RF_LAMP_REACH_PX = 4 };

/*
 * Takes the lights out of all pictures: each once, the mean of the views that see it
 * whole, its depth one at which the other views show it too.
 */
rf_result rf_views_take_lights(struct rf_views *v, struct rf_error *error);

#endif
