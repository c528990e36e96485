/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What the scene looks like from another point of the lens, out of a picture and its
 * depth. An eye moved on the lens by u (in lens radii, right and up) and turned so that
 * the plane at distance D stays where it is sees a point at depth z moved by
 *
 *   u K (1/D - 1/z)   px to the right and up,   K = lens radius times focal length in
 * px
 *
 * which is u times the signed radius of the circle of confusion for a focus at D. Every
 * px of the result looks along its line of such places, nearest depth first, for the
 * surface that comes to lie there; where none does, the background beside the hole is
 * continued.
 */
#ifndef VIEW_RELIEF_H
#define VIEW_RELIEF_H

#include <stdint.h>

/* Shift of every px: x = slope_x w + base_x to the right, y = slope_y w + base_y down,
 * px, where w is `disparity`: it grows with distance. */
struct relief {
    double slope[2], base[2];
};

/*
 * Warps `colour` (packed, n_channels) and, where not NULL, `depth` into out_*. The
 * disparity of a px is one float that grows with its distance (such as the signed
 * radius); nothing may be NaN.
 */
void relief_warp(const struct relief *relief, int32_t width, int32_t height,
                 int n_channels, const float *disparity, const float *colour,
                 const float *depth, float *out_colour, float *out_depth);

#endif
