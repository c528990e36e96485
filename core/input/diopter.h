/* SPDX-License-Identifier: Apache-2.0 */
/* The split diopter: a second focus distance on one side of a line. */
#ifndef RF_INPUT_DIOPTER_H
#define RF_INPUT_DIOPTER_H

#include <stdbool.h>

#include "input/frame.h"
#include "lens/look.h"

/* The split diopter of a frame; rf_diopter_of() makes it. */
struct rf_diopter {
    double px;    /* what it adds to a radius where its share is 1; 0: there is none */
    bool is_even; /* the share is even_share everywhere, not a matter of the place */
    double even_share;
    double side[2], offset, softness; /* of its line: as in the parameters */
    struct rf_look places;
    int x, y; /* of the frame's first pixel in the whole picture */
};

struct rf_diopter rf_diopter_of(const struct rf_frame *frame);

/* The share of the diopter at a pixel of the frame, 0 to 1. */
double rf_diopter_share(const struct rf_diopter *diopter, int x, int y);

/*
 * How far beyond the line, in halves of the diagonal, the share comes to `share`; -inf
 * for less than 0 and inf for more than 1.
 */
double rf_diopter_beyond(const struct rf_diopter *diopter, double share);

/*
 * Columns of row y, of `width`: all pixels that lie between from and to beyond the line
 * are among columns span[0] to span[1] - 1.
 */
void rf_diopter_span(const struct rf_diopter *diopter, double from, double to, int y,
                     int width, int span[2]);

#endif
