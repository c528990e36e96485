/* SPDX-License-Identifier: Apache-2.0 */
/* Which view sees a place, and how much of it. */
#ifndef RF_METHODS_VIEWS_VIEWS_PLACE_H
#define RF_METHODS_VIEWS_VIEWS_PLACE_H

#include <stdbool.h>
#include <stdint.h>

#include "compose/scene.h"
#include "methods/views/merge.h"

/* How much of a place view j sees, and whether in what was rendered. */
float rf_view_sees(const struct rf_views *v, int j, struct rf_view_place p,
                   bool *is_rendered);

/* Does a place lie outside of what was rendered, in all views? */
bool rf_views_are_beside(const struct rf_views *v, struct rf_view_place p);

/* Finds v->range, which rf_views_leave() needs. */
void rf_views_measure_range(struct rf_views *v);

/* What the rendered pixels of the views other than j leave of a place; `least` or more.
 */
float rf_views_leave(const struct rf_views *v, int j, struct rf_view_place p,
                     float least);

/*
 * The same for those of eight pixels of one surface of view j, (x, y) the first, that
 * are asked for; 0 or less where nothing is left.
 */
void rf_views_leave_eight(const struct rf_views *v, int j, int x, int y, unsigned asked,
                          float left[8]);

/*
 * The same for n <= 64 pixels from (x, y) on, of one surface each and one radius: of
 * those that are asked for the ones of which all is left, and of which more than
 * `least`.
 */
struct rf_emission rf_views_leave_run(const struct rf_views *v, int j, int x, int y,
                                      int n, uint64_t asked, float least);

/*
 * How much of a place those of `views` other than j show, and how much what continues
 * their pictures.
 */
float rf_views_show(const struct rf_views *v, uint64_t views, int j,
                    struct rf_view_place p, float *continued);

/*
 * The weight of a sample of view j at a place: its share of a pixel, divided among
 * those of `views` that see the place. A near part counts its own pixel whole, since
 * its share is how much of the pixel it covers; a far part counts what the near one
 * leaves to be seen. What continues the picture beyond its border counts where no view
 * shows the place.
 */
float rf_view_weight(const struct rf_views *v, uint64_t views, int j,
                     struct rf_view_place p, float share, bool is_far,
                     bool is_rendered);

#endif
