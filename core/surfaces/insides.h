/* SPDX-License-Identifier: Apache-2.0 */
/* Where a picture is the inside of surfaces, behind which no lens sees. */
#ifndef RF_SURFACES_INSIDES_H
#define RF_SURFACES_INSIDES_H

struct rf_hidden_facts;

/* What is known of the blocks of a picture; no blocks: nothing. */
struct rf_insides {
    struct rf_hidden_facts *blocks; /* n_x x n_y of RF_HIDDEN_BLOCK pixels a side */
    int n_x, n_y;
    float extent; /* half of the aperture's, px per px of radius */
};

/*
 * The radius behind which nothing is seen through any pixel of block (bx, by); INFINITY:
 * that is not known.
 */
float rf_inside_radius(const struct rf_insides *insides, int bx, int by);

#endif
