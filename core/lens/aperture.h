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
enum {
    RF_DISC_CORNERS = 128,
    RF_LOOK_CORNERS = 104, /* that looks add at the most */
    RF_MAX_BLADES = 16,
    RF_MAX_CORNERS = RF_DISC_CORNERS + RF_MAX_VIEWS + RF_LOOK_CORNERS,
};

struct rf_shape {
    int n_corners;
    double corner[RF_MAX_CORNERS][2];
    bool is_disc; /* an ellipse with semi-axes 1/ratio and 1 */
    bool is_cut;  /* by looks, from rf_look_shape() */
    bool is_part; /* of an aperture, cut out by rf_shape_part() */
    double ratio;
    double size[2];      /* half width and half height of a box around it */
    double pixel_aspect; /* v is multiplied by it to get pixel rows */
    int min_lines;       /* v = const that a footprint is summed over */
    double origin[2];    /* of a part, in the whole lens */
    double glow_px;      /* spherical aberration makes it larger by this */
    bool glows_near;     /* before the focus; else behind it, where this is false */
    double growth;       /* looks make it larger by this at the most */
};

void rf_shape_init(struct rf_shape *shape, const struct rf_params *params);

/*
 * What hollow blades leave of their polygon: what lies outside of the circles whose arcs
 * are its edges, of radius R and with middles at the distance m along the edges' normals.
 */
struct rf_hollow {
    int n; /* blades; 0: none is hollow */
    double normal[RF_MAX_BLADES][2];
    double edge; /* of the polygon: its distance from the middle of the lens */
    double m, r;
};

void rf_hollow_init(struct rf_hollow *hollow, const struct rf_params *params);

/* How far the polygon's edge is beyond (u, v), at which *beside receives how far (u, v)
 * is outside of the circle of that edge; aperture_ratio is not in it. */
double rf_hollow_within(const struct rf_hollow *hollow, double u, double v,
                        double *beside);

/*
 * Gives the shape the outline of hollow blades and returns true, where they are so:
 * corners so that the triangles of neighbours and the middle have equal areas. It is not
 * convex: for points of the lens and their outline only.
 */
bool rf_shape_hollow_out(struct rf_shape *shape, const struct rf_params *params);

/* Does spherical aberration make footprints of this side of the focus larger? Those of
 * parts are moved as well, to either side. */
static inline bool rf_shape_glows(const struct rf_shape *shape, bool is_near)
{
    return shape->is_part || shape->glows_near == is_near;
}

/* Is the lens point (u, v) inside? */
bool rf_shape_contains(const struct rf_shape *shape, double u, double v);

/* Cuts off what lies beyond normal . (u, v) = limit. */
void rf_shape_cut(struct rf_shape *shape, const double normal[2], double limit);

/* Area and centroid; both 0 where nothing is left of it. */
double rf_shape_area(const struct rf_shape *shape, double centroid[2]);

/* Variances of u and v over the shape. */
void rf_shape_variance(const struct rf_shape *shape, double variance[2]);

/* Lines that a footprint of a part of this half height is summed over at the least. */
int rf_shape_min_lines(double half_height);

/* Half width and half height of the footprint, in px per px of radius. */
void rf_shape_extent(const struct rf_shape *shape, double extent[2]);

/* Where the points of a lens lie, seen from one of them. */
struct rf_reach {
    float most; /* the distance of the farthest */
    /* An octagon around them: right, up, right + up and right - up. */
    float from[4], to[4];
};

/* That of the shape from `point`, both in px per px of radius. */
struct rf_reach rf_shape_reach(const struct rf_shape *shape, const double point[2]);

/*
 * The part of an aperture that is nearer to site j than to the other n sites (lens
 * coordinates), moved so that its centroid is the origin; `centroid` receives where it
 * was. Returns its area, shared among the sites at the same place; 0, and no part,
 * where it is empty.
 */
double rf_shape_part(const struct rf_shape *whole, double (*site)[2], int n, int j,
                     struct rf_shape *part, double centroid[2]);

#endif
