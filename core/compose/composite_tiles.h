/* SPDX-License-Identifier: Apache-2.0 */
/* The saturating sums of tiles. */
#ifndef RF_COMPOSE_COMPOSITE_TILES_H
#define RF_COMPOSE_COMPOSITE_TILES_H

#include <stdbool.h>
#include <stddef.h>

#include "compose/composer.h"
#include "kernels/data.h"

/* Where a tile of the canvas is. */
struct rf_tile_state rf_canvas_tile(const struct rf_composer *c, int tile);

/* Begins all tiles of the canvas that are not yet. */
void rf_begin_canvas(struct rf_composer *c);

/* Composites a tile of level 0 straight into the canvas. */
void rf_run_full_tile(const struct rf_composer *c, const struct rf_group *g, int tile,
                      int thread);

/* Two sets of samples in a tile of level 0, without a canvas: the thread's state. */
struct rf_tile_state rf_run_lone_tile(const struct rf_composer *c,
                                      const struct rf_group *const sets[2], int tile,
                                      int thread);

/* Has a tile of a group up to `reach` tiles from (tx, ty) samples? */
bool rf_has_near(const struct rf_group *g, int tx, int ty, int reach);

/* Has every pixel of the tile been covered? */
bool rf_is_used_up(const struct rf_tile_state *s, int n_cells);

/* Composites all bins of the samples around a tile into its state. */
void rf_composite_tile(const struct rf_composer *c, const struct rf_group *g, int tx,
                       int ty, struct rf_spread_sums *acc,
                       const struct rf_tile_state *state);

/* Nothing in a tile of a plane. */
void rf_clear_tile(float *tile, size_t stride);

/* Begins a tile that no splat has touched: T is each cell's share, sums are 0. */
void rf_begin_tile(const struct rf_composer *c, const struct rf_tile_state *s);

#endif
