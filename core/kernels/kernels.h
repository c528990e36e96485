/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The inner loops, compiled once per instruction set from kernels_tmpl.c and chosen at
 * run time. Every level gives the same bits: vectors of eight floats everywhere, no
 * contraction, fixed order of sums.
 */
#ifndef RF_KERNELS_H
#define RF_KERNELS_H

#include "../footprint.h"
#include "hidden_kernels.h"

enum {
    RF_TILE_W = 64,
    RF_TILE_H = 32,
    RF_TILE_HALO = 12, /* how far a footprint reaches over the edge of its tile, px */
    RF_ACC_LEFT = 24,  /* columns before the tile that footprints may write to */
    RF_ACC_STRIDE = RF_ACC_LEFT + RF_TILE_W + 32,
    RF_MAX_PLANES = 5, /* r g b a and coverage */
};

/* A sample ready to be spread: pixel of its level, footprint, coverage, light. */
struct rf_splat {
    int32_t x, y;
    int32_t slot;
    float cover; /* 0 for light that belongs to another splat's surface */
    float c[4];  /* colour times weight */
};

/*
 * Where samples of one bin gather: per cell and row, the colour planes and, last, the
 * coverage; RF_ACC_STRIDE columns each, of which the tile is the middle part.
 */
struct rf_accumulator {
    int n_cells, n_planes; /* planes with coverage */
    float *at;             /* [cell][row][plane][RF_ACC_STRIDE], zero between bins */
    int first_row,
        last_row; /* rows touched since the last flush; empty: first > last */
};

/* Tile-sized transmittance per cell, and sums per cell or over all cells. */
struct rf_tile_state {
    float *t;               /* [cell][RF_TILE_H][RF_TILE_W] */
    float *sum;             /* [cell or one][plane][RF_TILE_H][RF_TILE_W] */
    size_t sum_cell_stride; /* 0 where all cells share the sums */
};

struct rf_kernels {
    const char *name;
    /*
     * Spreads n splats over a tile whose top left pixel is (x0, y0). Those that do not
     * reach the tile are passed over.
     */
    void (*spread)(struct rf_accumulator *acc, const struct rf_splat *splats, int n,
                   struct rf_footprint *const *footprints, int x0, int y0);
    /*
     * Saturating sum: w = min(coverage, t); sum += colour w / coverage; t -= w. Clears
     * the accumulator.
     */
    void (*flush)(struct rf_accumulator *acc, const struct rf_tile_state *state);

    /*
     * Least and greatest value of (2 reach + 1) columns of n_rows rows around each of n
     * pixels. Rows may be read RF_ROW_MARGIN floats before and, n rounded up to eight,
     * after; so may `scratch`, two rows of it. Either result may be NULL.
     */
    void (*extremes)(const float *const *rows, int n_rows, int reach, int n,
                     float *scratch, float *lowest, float *highest);
    /* v = log(max(v, 0) + 1/1000) for n floats, n a multiple of eight. */
    void (*log_row)(float *v, int n);
    /* Lets the candidates of n blocks vote, which are sorted by ring. */
    void (*vote_blocks)(const struct rf_backs *backs,
                        const struct rf_hidden_query *query,
                        const struct rf_hidden_block *blocks, int n,
                        struct rf_hidden_vote *vote);
    /* The pixels around a query that show the surface of radius about r. */
    void (*gather_window)(const struct rf_backs *backs,
                          const struct rf_hidden_query *query, float r, float reach,
                          struct rf_hidden_window *out);
};

/* The best level of this machine. */
const struct rf_kernels *rf_kernels_best(void);

#endif
