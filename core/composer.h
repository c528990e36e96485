/* SPDX-License-Identifier: Apache-2.0 */
/* What the parts of the compositing share: composite.c says how it works. */
#ifndef RF_COMPOSER_H
#define RF_COMPOSER_H

#include "arena.h"
#include "composite.h"
#include "kernels/kernels.h"

enum {
    RF_MAX_LEVEL = 12,
    RF_BIN_PX = 2 /* of radius, whose samples a tile spreads together */
};

/* Lists of one tile's samples, ordered by bin. */
struct rf_tile_list {
    int n;
    int *bin; /* n_bins + 1 offsets into the list; NULL where empty */
    const struct rf_splat *at;
    const rf_place *places; /* instead of them, where not NULL: by rows in each bin */
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

struct rf_composer {
    const struct rf_scene *scene;
    const struct rf_context *context;
    const struct rf_kernels *kernels;
    struct rf_canvas canvas;
    struct rf_footprints *footprints;
    struct rf_accumulator *acc; /* one per thread */
    float *tiles;               /* per thread n_tile floats: t of a tile, its sums */
    size_t n_tile;
    unsigned char *needed; /* per footprint: does a splat use it? Of a set */
    float split;           /* radius from which the resolution falls, px */
    int n_threads;
    unsigned char *gaps; /* a byte for each pixel of the result; NULL: none is filled */
};

/* ---- lists of samples ---------------------------------------------------------- */

/* All groups of a set of samples: near ones coarse to fine, level 0, far ones. */
struct rf_groups {
    struct rf_group at[2 * RF_MAX_LEVEL + 1];
    int n;
    /* Memory of the lists. */
    struct rf_tile_list *tiles;
    struct rf_arena arena;
};

/* ---- levels.c ------------------------------------------------------------------ */

/* Radius of level 0 up to which footprints of a shape are spread in full, px. */
float rf_level_split(const struct rf_shape *shape);
/* The level that spreads samples of radius r. */
int rf_level_of(float split, float r);
/* The tiles of a level and side of the focus, without lists. */
struct rf_group rf_group_make(const struct rf_composer *c, int level, bool is_near);

/* ---- sample_lists.c ------------------------------------------------------------ */

/*
 * Sorts samples into the lists of `groups` and notes in c->needed what they need; steps
 * the task once per tile of full resolution. They come from the source where that
 * emits. rf_groups_free() in any case, and c->needed is to be freed.
 */
rf_result rf_groups_build(struct rf_groups *groups, struct rf_composer *c,
                          const struct rf_samples *samples,
                          const struct rf_source *source, double progress_to,
                          struct rf_error *error);
void rf_groups_free(struct rf_groups *groups, const struct rf_composer *c);

/* ---- composite_tiles.c --------------------------------------------------------- */

/* Where a tile of the canvas is. */
struct rf_tile_state rf_canvas_tile(const struct rf_composer *c, int tile);
/* Begins all tiles of the canvas that are not yet. */
void rf_begin_canvas(const struct rf_composer *c);
/* Composites a tile of level 0 straight into the canvas. */
void rf_run_full_tile(const struct rf_composer *c, const struct rf_group *g, int tile);
/* Two sets of samples in a tile of level 0, without a canvas: the thread's state. */
struct rf_tile_state rf_run_lone_tile(const struct rf_composer *c,
                                      const struct rf_group *const sets[2], int tile);
/* Has a tile of a group up to `reach` tiles from (tx, ty) samples? */
bool rf_has_near(const struct rf_group *g, int tx, int ty, int reach);
/* Is there any T left in a tile's row? */
bool rf_is_row_open(const float *t);
/* Has every pixel of the tile been covered? */
bool rf_is_used_up(const struct rf_tile_state *s, int n_cells);
/* Composites all bins of the samples around a tile into its state. */
void rf_composite_tile(const struct rf_composer *c, const struct rf_group *g, int tx,
                       int ty, struct rf_accumulator *acc,
                       const struct rf_tile_state *state);
/* Nothing in a tile of a plane. */
void rf_clear_tile(float *tile, size_t stride);
/* To a tile nothing has come. */
void rf_begin_tile(const struct rf_composer *c, const struct rf_tile_state *s);

/* ---- coarse_levels.c ----------------------------------------------------------- */

/* Composites a coarse level, and adds it to the canvas. */
rf_result rf_run_level(const struct rf_composer *c, const struct rf_group *g,
                       struct rf_error *error);

/* ---- smooth.c ------------------------------------------------------------------ */

/* What smooth surfaces near the focus leave open in a tile of level 0 shows their own
 * colour; once all samples up to 2 px of radius are in it. Of one view. */
void rf_close_smooth(const struct rf_composer *c, int tx, int ty,
                     const struct rf_tile_state *state);

/* ---- gaps.c -------------------------------------------------------------------- */

/* Notes for n pixels how much of a gap they are, 0 for those that are none. */
void rf_gaps_note(unsigned char *gaps, const float *coverage, int n);
/* Fills the gaps of a finished part, whose size `gaps` has, from around them. */
void rf_gaps_fill(const struct rf_crop *crop, const unsigned char *gaps, int n_threads);

#endif
