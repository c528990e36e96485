/* SPDX-License-Identifier: Apache-2.0 */
/* Footprints that no polygon is the shape of: each pixel asks for its lens point. */
#ifndef RF_COMPOSE_FOOTPRINT_TRACE_H
#define RF_COMPOSE_FOOTPRINT_TRACE_H

#include "compose/footprint_grid.h"
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "lens/look.h"

/* A sample whose footprint is traced. */
struct rf_trace {
    const struct rf_look *look;
    const struct rf_shape *shape; /* of the lens */
    const struct rf_bokeh *bokeh; /* its light; NULL: even */
    int bokeh_plane;
    const double *q; /* the sample's place, see lens/look.h */
    double r;
    double at[2]; /* px from the corner of its pixel */
};

/* The pixels around its own that the grid of a sample needs: as far as the picture goes
 * and the lens reaches. */
void rf_trace_reach(const struct rf_trace *t, double reach[2]);

/*
 * Adds the light of the lens to the pixels of the picture, and returns their share of
 * all that the lens sends: 0 where none of it comes to the picture.
 */
double rf_trace_fill(const struct rf_trace *t, struct rf_grid *g);

/* The share of the sample's light that its looks leave, within 2e-3 (a lattice); 0: it
 * is dark everywhere. */
double rf_trace_open(const struct rf_trace *t);

#endif
