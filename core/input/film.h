/* SPDX-License-Identifier: Apache-2.0 */
/* Transparent film: what is empty, and depth for what is partly transparent. */
#ifndef RF_INPUT_FILM_H
#define RF_INPUT_FILM_H

#include <stdbool.h>
#include <stddef.h>

#include "base/math.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* The colours and alpha of a picture: of pixel (x, y) at[c][y row + x pixel]. */
struct rf_film {
    const float *at[4];
    ptrdiff_t pixel, row; /* floats */
};

/* Up to that alpha a pixel shows nothing; our own, far below what a thing's rim has. */
#define RF_EMPTY_ALPHA 0.02f

/*
 * Is light seen, in parts of white, where alpha says that nothing is? Not the light of a
 * lamp's rim, which a hundred whites may have.
 */
static inline bool rf_film_is_lit(const float colour[4])
{
    float most = rf_max_float(rf_max_float(colour[0], colour[1]), colour[2]);
    return most > 1e-3f + 100 * rf_max_float(colour[3], 0);
}

enum { RF_FILM_REACH_LEAST = 8, RF_FILM_REACH_MOST = 64 }; /* px, of edges */

/* How far away in x and y rf_film_fill() looks, px. */
int rf_film_reach(const struct rf_frame *frame);

/*
 * Gives partly transparent pixels without depth that of a surface, as film_depth says:
 * changes `radius`, packed. *is_changed is true where one was.
 */
rf_result rf_film_fill(const struct rf_frame *frame, const struct rf_film *film,
                       float *radius, bool *is_changed, struct rf_error *error);

#endif
