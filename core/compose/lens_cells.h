/* SPDX-License-Identifier: Apache-2.0 */
/* The cells of the lens whose visibility is kept apart, and lines that cut them. */
#ifndef RF_COMPOSE_LENS_CELLS_H
#define RF_COMPOSE_LENS_CELLS_H

#include "kernels/data.h"
#include "lens/aperture.h"

/*
 * The sub-apertures: the lens is cut into k cells whose visibility is kept apart. The
 * sites are Vogel's points, but two or three lie around the middle; a
 * cell is what lies nearest to
 * its site, less `weight` (0 where no look has moved it).
 */
struct rf_lens_cells {
    int n;
    double site[RF_MAX_CELLS][2];
    double share[RF_MAX_CELLS];  /* of the aperture's area, adds up to 1 */
    double weight[RF_MAX_CELLS]; /* taken off the squared distance */
};

struct rf_interval {
    double from, to;
};

void rf_lens_cells_init(struct rf_lens_cells *cells, const struct rf_shape *shape,
                        int n);

/*
 * Cells of a shape that has become of the one that `plain` are of: near the same parts
 * of the lens, and with the same shares, so that coverage adds up to the same.
 * `variance` is that of the two shapes.
 */
void rf_lens_cells_follow(struct rf_lens_cells *cells, const struct rf_shape *shape,
                          const struct rf_lens_cells *plain, double variance[2][2]);

/* The middle of each cell's area. */
void rf_lens_cells_middle(const struct rf_lens_cells *cells,
                          const struct rf_shape *shape, double middle[][2]);

/* From the lowest to the highest point. */
struct rf_interval rf_shape_v_range(const struct rf_shape *shape);

/* The middle of line i of n. */
static inline double rf_line_at(struct rf_interval range, int i, int n)
{
    return range.from + (range.to - range.from) * (i + 0.5) / n;
}

/* Where n lines cut the aperture, evenly over a range that holds it. */
void rf_shape_lines(const struct rf_shape *shape, struct rf_interval range, int n,
                    struct rf_interval *cut);

/* The part of `cut` that is nearer to site c than to the others. */
struct rf_interval rf_lens_cell_line(const struct rf_lens_cells *cells, int c, double v,
                                     struct rf_interval cut);

/* Variance of u and v over the aperture, whose middle is the origin. */
void rf_shape_line_variance(const struct rf_shape *shape, double variance[2]);

#endif
