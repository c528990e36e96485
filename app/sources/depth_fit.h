/* SPDX-License-Identifier: Apache-2.0 */
/* Does a depth lie on its picture, or upside down or mirrored? */
#ifndef APP_DEPTH_FIT_H
#define APP_DEPTH_FIT_H

#include <stddef.h>
#include <stdint.h>

enum depth_turn { DEPTH_UPRIGHT, DEPTH_FLIPPED, DEPTH_MIRRORED, DEPTH_ROTATED };
enum { DEPTH_N_TURNS = 4 };

/* Steps of the depth, and those of them where the picture has an edge, by how the depth
 * is turned. Zeros at first. */
struct depth_fit {
    size_t n, n_edges[DEPTH_N_TURNS];
};

/* A picture and the radii of its pixels, packed. */
struct depth_fit_picture {
    const float *colour, *radii;
    int n_channels; /* 1, 3 or 4 */
    int32_t width, height;
};

void depth_fit_find(struct depth_fit *fit, const struct depth_fit_picture *picture);

/* How the depth is to be turned to lie on the picture. */
enum depth_turn depth_fit_turn(const struct depth_fit *fit);

#endif
