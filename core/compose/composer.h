/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the compositing share: composite.c says how it works. */
#ifndef RF_COMPOSE_COMPOSER_H
#define RF_COMPOSE_COMPOSER_H

#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "base/context.h"
#include "compose/footprint.h"
#include "compose/scene.h"
#include "kernels/data.h"
#include "kernels/kernels.h"

enum {
    RF_MAX_LEVEL = 12,
    RF_BIN_PX =
        2 /* of radius, whose samples a tile spreads together; see rf_bin_at() */
};

/* Lists of one tile's samples, ordered by bin. */
struct rf_tile_list {
    int n;
    int *bin; /* n_bins + 1 offsets into the list; NULL where empty */
    const struct rf_splat *at;
    const rf_packed *places; /* instead of them, where not NULL: by rows in each bin */
    struct rf_tile_surfaces surfaces;
};

/* All samples of one level and side of the focus. */
struct rf_group {
    int level;
    bool is_near;
    int width, height, n_x, n_y; /* of the level: pixels, tiles */
    size_t stride, plane;        /* of its planes, which are whole tiles; floats */
    int n_bins, first_bin;
    int first_key; /* of its bins among all groups' */
    struct rf_tile_list *tiles;
};

/*
 * Full-resolution state of the compositing, in whole tiles. What was never begun is not
 * defined: nothing lies there yet. Each tile's T lies together, and so do its sums, for
 * who goes through tiles row by row of planes waits for memory; but sums are planes
 * where they become the work's.
 */
struct rf_canvas {
    int n_cells, n_planes, n_x; /* tiles in a row */
    bool is_planar;             /* sums are [plane][y][x] of the whole scene */
    size_t stride, plane;       /* floats, of planes */
    float *t;   /* [tile][cell][y][x], what is still uncovered; starts at the cell's
                   share */
    float *sum; /* [tile][plane][y][x], colours and coverage */
    unsigned char *is_begun; /* of each tile */
};

/* Radii up to which each level spreads samples, px of level 0: behind the focus, and
 * before it without their sign. */
struct rf_levels {
    float limit[2][RF_MAX_LEVEL + 1];
};

struct rf_composer {
    const struct rf_scene *scene;
    const struct rf_context *context;
    const struct rf_kernels *kernels;
    struct rf_canvas canvas;
    struct rf_footprints *footprints;
    struct rf_spread_sums *acc; /* one per thread */
    float least_slope;          /* that matters, px per px; see slants.h */
    float *factors;             /* of slants, see struct rf_spread_sums */
    float *tiles;               /* per thread n_tile floats: t of a tile, its sums */
    size_t n_tile;
    unsigned char *needed; /* per footprint: does a splat use it? Of a set */
    struct rf_levels levels;
    int n_threads;
    unsigned char *gaps; /* a byte for each pixel of the result; NULL: none is filled */
};

/* All groups of a set of samples: near ones coarse to fine, level 0, far ones. */
struct rf_groups {
    struct rf_group at[2 * RF_MAX_LEVEL + 1];
    int n;
    /* Memory of the lists. */
    struct rf_tile_list *tiles;
    struct rf_arena arena;
};

/* The lists of visible samples and of hidden ones. */
struct rf_lists {
    struct rf_groups groups[2];
    unsigned char *needed[2]; /* as in the composer; NULL: there are no samples */
    size_t n_footprints;      /* that slots are counted among; 0: not made */
};

#endif
