/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Figures that tell whether depth is what it is taken for: in the unit of the focus, and
 * of its kind and size. Most are taken at up to 60000 places on a grid, so that they cost
 * next to nothing.
 */
#ifndef APP_DEPTH_DOUBTS_H
#define APP_DEPTH_DOUBTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* Some rows of a depth as read, packed. */
struct doubts_rows {
    const float *depth;
    int32_t first, n; /* of the picture's rows, those at hand */
};

struct doubts_tally;

/* Of pictures of this size, whose depth is 16 bit or not; the parameters are kept by
 * pointer. NULL without memory. */
struct doubts_tally *doubts_create(const struct rf_params *params,
                                   const struct rf_lens *lens, int32_t width,
                                   int32_t height, bool is_half);
void doubts_free(struct doubts_tally *tally);

/* All of the picture, or strips of it from the top down. */
void doubts_add(struct doubts_tally *tally, const struct doubts_rows *rows);

/* Planar or radial distances where something was hit. */
struct doubts_range {
    size_t n_hits, n_far, n_near; /* beyond 20 times the focus, before a 20th of it */
    double nearest, farthest;
};
void doubts_find_range(const struct doubts_tally *tally, struct doubts_range *range);

/* What makes flat things flat: the number as a distance along the axis, as 1 / distance
 * or a z-buffer, as a distance along the ray; of numbers between a near and a far end
 * also from the far to the near one, along either. */
enum doubts_kind {
    DOUBTS_PLANAR,
    DOUBTS_INVERSE,
    DOUBTS_RADIAL,
    DOUBTS_SWAPPED,
    DOUBTS_SWAPPED_RADIAL,
    DOUBTS_N_KINDS
};

/* Places on slanted surfaces, and those of them where one kind of depth alone would be
 * that of a flat surface. */
struct doubts_kinds {
    size_t n, n_alone[DOUBTS_N_KINDS];
};

/* Places near each other, and others farther apart; of the latter there may be none. */
enum { DOUBTS_N_STEPS = 2 };
void doubts_find_kinds(const struct doubts_tally *tally,
                       struct doubts_kinds kinds[DOUBTS_N_STEPS]);

/* The size that the depth was rendered in, where it was enlarged since (depth_grid.h). */
bool doubts_find_size(const struct doubts_tally *tally, int32_t *width,
                      int32_t *height);

#endif
