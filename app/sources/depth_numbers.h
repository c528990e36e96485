/* SPDX-License-Identifier: Apache-2.0 */
/* What the numbers of a depth say beside their range: counted row by row. */
#ifndef APP_DEPTH_NUMBERS_H
#define APP_DEPTH_NUMBERS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* Begins as zeros. */
struct depth_numbers {
    size_t n;       /* all of them */
    size_t n_hits;  /* above 0 and below infinity */
    size_t n_parts; /* hits that are no whole numbers */
    size_t n_far;   /* below infinity, but at the end of the kind where nothing was hit:
                        1 of normalised depth and beyond, 1 or 0 of depth buffers */
    size_t
        n_beyond;  /* of them normalised depth well above 1, where it has no meaning */
    double beyond; /* the largest of them, scaled */
    size_t n_nan, n_below; /* NaN, scaled below 0 and no infinity */
    float below[2];        /* the least and the greatest of the latter, as read */
    uint32_t seen[8];      /* which whole numbers there are, by 8 bits made of each */
};

/* Adds n numbers as they were read, which `params` say the meaning of. */
void depth_numbers_add(struct depth_numbers *numbers, const struct rf_params *params,
                       const float *depth, size_t n);

/* Are all hits whole numbers, of so many kinds that it is no scene of a few walls? */
bool depth_numbers_are_whole(const struct depth_numbers *numbers);

/*
 * What the core refuses, as a way out for `text`: "; where NaN means that nothing was hit,
 * ...". "" where none is known. `channel` has the depth of `file`, as oiiotool is to read it.
 */
void depth_numbers_explain(const struct depth_numbers *numbers,
                           const struct rf_params *params, const char *file,
                           const char *channel, char *text, size_t n_bytes);

#endif
