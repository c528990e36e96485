/* SPDX-License-Identifier: Apache-2.0 */
/* Lens looks: how the footprint depends on the place in the picture. */
#ifndef RF_LENS_LOOK_H
#define RF_LENS_LOOK_H

#include <stdbool.h>

#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

enum { RF_DOOR_LEFT, RF_DOOR_RIGHT, RF_DOOR_TOP, RF_DOOR_BOTTOM, RF_N_DOORS };

/*
 * The looks that depend on the place, for one size of the picture. A place q counts
 * from the picture's centre, in halves of its diagonal, y up; look.c has the formulas.
 */
struct rf_look {
    double centre[2];    /* px of the whole picture */
    double half_px;      /* of its diagonal */
    double pixel_aspect; /* rows per px of height */
    double ratio;        /* of the aperture */
    double cat_eye, astigmatism, swirl, door[RF_N_DOORS];
    /* The surface in focus adds slope . q + bend |q|^2 px to a radius; see
     * rf_field_look(). */
    double slope[2], bend;
    double most_px;   /* radii of a bent surface are clipped to it */
    bool is_measured; /* shapes have the area of a disc, as where light is taken away */
    bool is_rough;    /* shapes have few corners: areas are within 2e-3 */
};

/* Of a whole picture of width x height px. */
struct rf_look rf_look_make(const struct rf_params *params, int width, int height);

/* Is any of them in use? Then each place has a footprint of its own. */
bool rf_look_is_on(const struct rf_look *look);

/* Does any take light away? */
bool rf_look_is_dark(const struct rf_look *look);

/* The place of (x, y), px of the whole picture. */
static inline void rf_look_place(const struct rf_look *look, double x, double y,
                                 double q[2])
{
    q[0] = (x - look->centre[0]) / look->half_px;
    q[1] = (look->centre[1] - y) / (look->half_px * look->pixel_aspect);
}

/* How many times larger than the aperture a footprint may be. */
double rf_look_growth(const struct rf_look *look);

/*
 * The aperture, or the part of one, that a sample at q has for its footprint of
 * |r| = `radius` px with the sign of r, moved so that its centroid is the origin;
 * `centroid` receives where it was, from the part's own. Returns how much of its area
 * lets light through, 0 to 1; where that is nothing the shape is as if no light were
 * taken.
 */
double rf_look_shape(const struct rf_look *look, const struct rf_shape *whole,
                     const double q[2], double r, struct rf_shape *shape,
                     double centroid[2]);

/* Are footprints the aperture, scaled, but for what is cut out of it? */
bool rf_look_is_scaled(const struct rf_look *look);

/*
 * The point u of the whole lens that rf_look_shape() has brought to `at`. Returns by
 * how much an area around it is smaller on the lens, as a length.
 */
double rf_look_lens_at(const struct rf_look *look, const double q[2], double r,
                       const double at[2], double u[2]);

/*
 * How far from a sample at q of radius r the pixels lie that it can light, px along each
 * axis at the most; rows count as the pixels that they are high.
 */
double rf_look_bound_px(const struct rf_look *look, const struct rf_shape *whole,
                        const double q[2], double r);

/*
 * May a lens point of a sample at q light several pixels, or be found too slowly? Then
 * rf_look_shape() does not know the footprint, which is traced by rf_look_lens_point().
 */
bool rf_look_is_folded(const struct rf_look *look, const struct rf_shape *whole,
                       const double q[2], double r);

/*
 * The point u of the whole lens through which the pixel's place `to` sees a sample at q
 * of radius r. False: the lens is closed there, or u lies beside it.
 */
bool rf_look_lens_point(const struct rf_look *look, const struct rf_shape *whole,
                        const double q[2], double r, const double to[2], double u[2]);

/* How much of a disc of places a sample lights. */
enum rf_look_lit { RF_LIT_NOWHERE, RF_LIT_SOMEWHERE, RF_LIT_EVERYWHERE };

/* Of a lens, for rf_look_lit_in(). */
struct rf_look_limits {
    double reach; /* of its farthest point from the middle */
    double open;  /* the radius of a disc around the middle that is open everywhere */
};

struct rf_look_limits rf_look_limits_make(const struct rf_look *look,
                                          const struct rf_shape *whole);

/*
 * How much of the disc of places within `away` of `to` a sample at q of radius r lights
 * by rf_look_lens_point(), told by bounds: RF_LIT_SOMEWHERE where they do not decide.
 */
enum rf_look_lit rf_look_lit_in(const struct rf_look *look,
                                const struct rf_look_limits *limits, const double q[2],
                                double r, const double to[2], double away);

/* The looks without those that take light away. */
struct rf_look rf_look_bright(const struct rf_look *look);

/*
 * Which points u of the whole lens looks leave open for a sample: those with
 * |eye u - middle| <= 1 and normal . u <= limit for each door.
 */
struct rf_look_opening {
    bool has_eye;
    double eye[2][2], scale /* its determinant, not 0 */, middle[2];
    int n_doors;
    double normal[RF_N_DOORS][2], limit[RF_N_DOORS];
};

/* Of a sample at q of radius r, as if M and what bends the focus were everywhere as
 * they are at q: exact where rf_look_is_scaled(). */
struct rf_look_opening rf_look_opening_at(const struct rf_look *look, const double q[2],
                                          double r);

/*
 * The share of a whole or part aperture that lets light through, 0 to 1, by
 * rf_look_opening_at(): within 1e-7 of two discs' common area and of straight blades,
 * within 2e-5 of ovals. It takes 1 to 3 us.
 */
double rf_look_open_near(const struct rf_look *look, const struct rf_shape *whole,
                         const double q[2], double r);

/*
 * The share of its light that a lone sample at q of radius r keeps, 0 to 1: of its
 * footprint's area, what the looks leave. As rf_look_open_near() where
 * rf_look_is_scaled(), else from rf_look_shape(), in 50 us.
 */
double rf_look_open(const struct rf_look *look, const struct rf_shape *whole,
                    const double q[2], double r);

#endif
