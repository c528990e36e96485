/* SPDX-License-Identifier: Apache-2.0 */
/* The weights of a footprint while it is built, and the kernels that make them. */
#ifndef RF_COMPOSE_FOOTPRINT_GRID_H
#define RF_COMPOSE_FOOTPRINT_GRID_H

/*
 * Footprints are of a kind. RF_SHARP keeps the negative weights of the cubic, which keep
 * an in-focus texture sharp; RF_POSITIVE clips them, for samples so bright that they
 * would show.
 */
enum rf_footprint_kind { RF_SHARP, RF_POSITIVE, RF_N_KINDS };

enum { RF_KERNEL_REACH = 2 };

/* k at t, meant over a line's height where it is not smooth, and its antiderivative. */
struct rf_footprint_kernel {
    double (*value)(double t, double height);
    double (*integral)(double t);
};

extern const struct rf_footprint_kernel rf_footprint_kernels[RF_N_KINDS];

/* A dense grid of weights, one layer per cell, around the sample's pixel. */
struct rf_grid {
    const struct rf_footprint_kernel *kernel;
    int reach_x, reach_y, width, height;
    double *weight; /* [cell][y][x] */
    double *line;   /* width + 1 entries: differences of one line */
};

double *rf_grid_row(const struct rf_grid *g, int cell, int y);

/* A line of the aperture: pixels x of [from, to] (px, relative to the sample's pixel
 * corner) get the kernel's integral times the weight, spread over four rows around y. */
struct rf_grid_line {
    double from, to, y;
    double height; /* of what the line stands for, px */
    double weight;
};

void rf_grid_add_line(struct rf_grid *g, int cell, const struct rf_grid_line *line);

#endif
