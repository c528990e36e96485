/* SPDX-License-Identifier: Apache-2.0 */
/* Does a depth lie on its picture, or upside down, mirrored or some pixels beside it? */
#ifndef APP_DEPTH_FIT_H
#define APP_DEPTH_FIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum depth_turn { DEPTH_UPRIGHT, DEPTH_FLIPPED, DEPTH_MIRRORED, DEPTH_ROTATED };
enum { DEPTH_N_TURNS = 4 };

/* Farther beside its picture a depth is not looked for, in either direction. */
enum { DEPTH_MOST_PX = 8, DEPTH_N_MOVES = 2 * DEPTH_MOST_PX + 1 };

/* Steps along rows or columns that come nearer, or go back: how many were looked at, and
 * of these how many have an edge of the picture so far down and right of them, from
 * -DEPTH_MOST_PX on. */
struct depth_moves {
    size_t n, n_edges[DEPTH_N_MOVES][DEPTH_N_MOVES];
};

/* Steps of the depth, and those of them where the picture has an edge, by how the depth
 * is turned. Zeros at first. */
struct depth_fit {
    size_t n, n_edges[DEPTH_N_TURNS];
    struct depth_moves
        moves[4]; /* of up to MOST_MOVED of the steps; columns from 2 on */
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

/* Where the picture lies from the depth, px right and down, and the shares of the steps
 * that have an edge at their own place and there. */
struct depth_move {
    int32_t right, down;
    double share, share_there;
};

/* False: the depth lies on its picture, or nobody can tell. */
bool depth_fit_move(const struct depth_fit *fit, struct depth_move *move);

#endif
