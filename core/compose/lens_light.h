/* SPDX-License-Identifier: Apache-2.0 */
/* How much of a lens' light its looks leave, for one sample at a time. */
#ifndef RF_COMPOSE_LENS_LIGHT_H
#define RF_COMPOSE_LENS_LIGHT_H

#include "compose/lens_cells.h"
#include "compose/zones.h"
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "lens/look.h"

enum { RF_LIGHT_LINES = 512 };

/* A shape's light, of a plane of `bokeh`, or even (NULL). */
struct rf_lens_light {
    struct rf_look look;
    const struct rf_shape *shape;
    const struct rf_bokeh *bokeh;
    int plane;
    /* Of light that is not even: where lines cut the shape, and all of the light. */
    struct rf_interval range, line[RF_LIGHT_LINES];
    double whole;
};

/* Keeps the pointers. It takes 50 us where the light is not even. */
void rf_lens_light_init(struct rf_lens_light *light, const struct rf_look *look,
                        const struct rf_shape *shape, const struct rf_bokeh *bokeh,
                        int plane);

/*
 * The share of the light that comes through to a sample at q of radius r, 0 to 1, as
 * rf_look_open_near() has it; within 2e-5 of all light, in 25 us, where that is not even.
 */
double rf_lens_light_open(const struct rf_lens_light *light, const double q[2],
                          double r);

/*
 * rf_zone_make() by the light of `bokeh` (NULL: an even lens), as rf_zone_weigh() has it.
 * Returns the share of a lone sample's light that its looks leave, 0 to 1: of its
 * footprint, not of the lens; 0 where the shape is as if they took none.
 */
double rf_zone_make_lit(struct rf_zone *zone, struct rf_shape *shape,
                        const struct rf_shape *whole, const struct rf_look *look,
                        const double q[2], double r, const struct rf_bokeh *bokeh,
                        int plane);

#endif
