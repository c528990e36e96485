/* SPDX-License-Identifier: Apache-2.0 */
/* The shape of the aperture. */
#ifndef RF_LENS_APERTURE_H
#define RF_LENS_APERTURE_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"

/*
 * An aperture of unit size: a convex polygon (a disc has many corners) in lens
 * coordinates, u right and v up, that the footprint of a sample behind the focus has
 * when multiplied with its radius. Corners run counter-clockwise.
 */
enum { RF_DISC_CORNERS = 128, RF_MAX_CORNERS = RF_DISC_CORNERS + RF_MAX_VIEWS };

struct rf_shape {
    int n_corners;
    double corner[RF_MAX_CORNERS][2];
    bool is_disc; /* an ellipse with semi-axes 1/ratio and 1 */
    bool is_part; /* of an aperture, cut out by rf_shape_part() */
    double ratio;
    double size[2];      /* half width and half height of a box around it */
    double pixel_aspect; /* v is multiplied by it to get pixel rows */
    int min_lines;       /* v = const that a footprint is summed over */
};

void rf_shape_init(struct rf_shape *shape, const struct rf_params *params);

/* Is the lens point (u, v) inside? */
bool rf_shape_contains(const struct rf_shape *shape, double u, double v);

/* Half width and half height of the footprint, in px per px of radius. */
void rf_shape_extent(const struct rf_shape *shape, double extent[2]);

/*
 * The part of an aperture that is nearer to site j than to the other n sites (lens
 * coordinates), moved so that its centroid is the origin; `centroid` receives where it
 * was. Returns its area, shared among the sites at the same place; 0, and no part,
 * where it is empty.
 */
double rf_shape_part(const struct rf_shape *whole, double (*site)[2], int n, int j,
                     struct rf_shape *part, double centroid[2]);

#endif
