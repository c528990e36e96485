/* SPDX-License-Identifier: Apache-2.0 */
/* Where edges of a depth channel lie beside those of the colours. */
#ifndef RF_INPUT_DEPTH_EDGES_H
#define RF_INPUT_DEPTH_EDGES_H

#include <stddef.h>

#include "rackfocus/rackfocus.h"

/* Over depth steps: of shares of the near colour, as rf_depth_stats.near_shares has them. */
struct rf_edge_sums {
    double shares[3];
    size_t n;
    double side_shares[2]; /* the first and the third of steps to the left and right */
    size_t n_sides[2];
    double inside; /* of pixels farther within near sides, which show nothing behind */
    size_t n_inside;
};

/* Adds the steps along the rows of a strip that has colours. */
void rf_depth_count_edges(const struct rf_depth_channel *strip,
                          struct rf_edge_sums *sums);

/* Makes means of the sums: near_shares and is_widened. */
void rf_depth_judge_edges(const struct rf_edge_sums *sums,
                          struct rf_depth_stats *stats);

#endif
