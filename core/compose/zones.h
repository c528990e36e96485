/* SPDX-License-Identifier: Apache-2.0 */
/* Zones: squares of the picture whose samples share the shape of their footprints. */
#ifndef RF_COMPOSE_ZONES_H
#define RF_COMPOSE_ZONES_H

#include "base/context.h"
#include "compose/lens_cells.h"
#include "lens/aperture.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/* The aperture as the samples of a zone have it. */
struct rf_zone {
    const struct rf_shape *shape;
    double centroid[2]; /* of the shape, from the middle of the plain one */
    double variance[2]; /* of the shape in u and v, per unit radius */
    struct rf_lens_cells cells;
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

/* Zones of a shape; n_cells is of the lens cells of each. rf_zones_free() in any case.
 */
rf_result rf_zones_init(struct rf_zones *zones, const struct rf_context *context,
                        const struct rf_shape *shape, const struct rf_look *look,
                        int n_cells, struct rf_error *error);

void rf_zones_free(struct rf_zones *zones, const struct rf_context *context);

/* The zone of a place; places beyond the picture have that of its edge. */
int rf_zone_at(const struct rf_zones *zones, const double q[2]);

/* The middle one, which has the plain shape. */
static inline int rf_zone_middle(const struct rf_zones *zones)
{
    return zones->n / 2;
}

/* A zone of one place alone, for samples of radius r. `shape` lasts as long as it. */
void rf_zone_make(struct rf_zone *zone, struct rf_shape *shape,
                  const struct rf_shape *whole, const struct rf_look *look,
                  const double q[2], double r);

#endif
