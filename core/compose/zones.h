/* SPDX-License-Identifier: Apache-2.0 */
/* Zones: squares of the picture whose samples share the shape of their footprints. */
#ifndef RF_COMPOSE_ZONES_H
#define RF_COMPOSE_ZONES_H

#include <stdbool.h>

#include "base/context.h"
#include "compose/lens_cells.h"
#include "input/bokeh.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/* The aperture as the samples of a zone have it. */
struct rf_zone {
    const struct rf_shape *shape;
    double centroid[2]; /* of the shape, from the middle of the plain one */
    double variance[2]; /* of the shape in u and v, per unit radius */
    struct rf_lens_cells cells;
    /* Where a look has moved the shape's points by their place: what it was asked for. */
    bool is_moved;
    struct rf_look look;
    double q[2], r;
};

/*
 * Zones lie around places that are `step` apart, n_x of them to the left and to the
 * right of the middle one, n_y above and below; by rows from below. Of a lens without
 * looks there is the middle one alone.
 */
struct rf_zones {
    struct rf_look look;
    double step;
    int n_x, n_y, n;
    struct rf_zone *at;
    struct rf_shape *shapes;
};

/*
 * Where footprints lie beside their sample: px right and down per px of radius, and px
 * of full resolution. (0, 0) for a lens whose middle the view was taken from.
 */
struct rf_drift {
    double slope[2], base[2];
};

struct rf_listed;

/* What footprints are asked for. */
struct rf_footprint_use {
    const struct rf_shape *shape;
    struct rf_drift drift;
    struct rf_look look;          /* all zeros: none */
    const struct rf_bokeh *bokeh; /* light of the aperture; NULL: even */
    int bokeh_plane;
    double obstruction; /* that the bokeh is the ring of; 0: it is another */
    double spherical;   /* aberration, px */
    bool is_boundless;  /* no tile limits the aberration */
    bool is_of_points;  /* each pixel gets the share of the shape in it */
    int n_cells;
    double max_radius;
    int n_phases;
    /*
     * Instead of all: RF_POSITIVE ones of full resolution, of one cell, each with the
     * looks of its own place and radius. NULL: all.
     */
    const struct rf_listed *list;
    size_t n_listed;
};

/* Zones of what is asked for. rf_zones_free() in any case. */
rf_result rf_zones_init(struct rf_zones *zones, const struct rf_context *context,
                        const struct rf_footprint_use *use, struct rf_error *error);

/* A part of a zone's shape. */
struct rf_piece {
    double from[2], to[2]; /* u, v */
};

/* The light that comes through a piece: of an even lens, its area. */
double rf_zone_light(const struct rf_zone *zone, const struct rf_bokeh *bokeh,
                     int plane, const struct rf_piece *piece);

/*
 * The shares of a zone's cells and its variances by light, as sums over small squares;
 * returns its light, in parts of the picture's.
 */
double rf_zone_weigh(struct rf_zone *zone, const struct rf_bokeh *bokeh, int plane);

/* |p|^2 of the point of the whole lens that the zone's point u is of. */
double rf_zone_height2(const struct rf_zone *zone, const double u[2]);

void rf_zones_free(struct rf_zones *zones, const struct rf_context *context);

/* The zone of a place; places beyond the picture have that of its edge. */
int rf_zone_at(const struct rf_zones *zones, const double q[2]);

/* The middle one, which has the plain shape. */
static inline int rf_zone_middle(const struct rf_zones *zones)
{
    return zones->n / 2;
}

/*
 * A zone of one place alone, for samples of radius r. `shape` lasts as long as it.
 * Returns what rf_look_shape() does.
 */
double rf_zone_make(struct rf_zone *zone, struct rf_shape *shape,
                    const struct rf_shape *whole, const struct rf_look *look,
                    const double q[2], double r);

#endif
