/* SPDX-License-Identifier: Apache-2.0 */
/* Straight edges behind a surface, continued behind it. */
#ifndef RF_SURFACES_HIDDEN_LINES_H
#define RF_SURFACES_HIDDEN_LINES_H

#include <stdbool.h>

#include "kernels/hidden_kernels.h"

enum {
    RF_HIDDEN_LINES = 16, /* through a pixel */
    RF_HIDDEN_LINE_STEPS = 11,
    RF_HIDDEN_LINE_PX = 18 /* to each side, along the axis that a line is nearer to */
};

/*
 * Pixels that are looked at from the middle of each line to one of its ends, and their
 * squared distances in units of the lens; the other half mirrors them.
 */
struct rf_hidden_lines {
    int8_t x[RF_HIDDEN_LINES][RF_HIDDEN_LINE_STEPS];
    int8_t y[RF_HIDDEN_LINES][RF_HIDDEN_LINE_STEPS];
    float lens2[RF_HIDDEN_LINES][RF_HIDDEN_LINE_STEPS];
};

/* For an aperture of the extent 1 / sqrt(inv_x2), 1 / sqrt(inv_y2). */
void rf_hidden_lines_set(struct rf_hidden_lines *lines, float inv_x2, float inv_y2);

/*
 * Lets the lines through a query correct the radius *r of what was found behind it, and
 * *d2, the squared distance to that, px^2. No radius near it is above `farthest`. Has the
 * query candidates on both sides? If not, those beside it hardly have.
 */
bool rf_hidden_line_up(const struct rf_hidden_lines *lines,
                       const struct rf_backs *backs,
                       const struct rf_hidden_query *query, float farthest, float *r,
                       int *d2);

#endif
