/* SPDX-License-Identifier: Apache-2.0 */
/* The two sides of an edge: which of the pixels around show which surface. */
#ifndef RF_SURFACES_SPLIT_SIDES_H
#define RF_SURFACES_SPLIT_SIDES_H

#include <stdbool.h>

#include "surfaces/split_around.h"
#include "surfaces/splitter.h"

/* Radii around a pixel, in px, that fall into two groups. */
struct rf_split_edge {
    float threshold; /* near: r <= threshold */
    float gap, lowest, highest;
};

/* Finds the two surfaces that meet in pixel (x, y); false: only one. has_lamp: something
 * so bright is around that its fringes must not pass for a surface. */
bool rf_split_find_sides(const struct rf_splitter *s, int x, int y,
                         const struct rf_split_edge *e, bool has_lamp,
                         struct rf_meeting *m);

#endif
