/* SPDX-License-Identifier: Apache-2.0 */
/* Was a depth rendered smaller than its picture and enlarged by repeating pixels? */
#ifndef APP_DEPTH_GRID_H
#define APP_DEPTH_GRID_H

#include <stdbool.h>
#include <stdint.h>

struct depth_grid;

/* Of pictures of this size. NULL without memory. */
struct depth_grid *depth_grid_create(int32_t width, int32_t height);
void depth_grid_free(struct depth_grid *grid);

/* Rows of a packed depth, from the top of the picture down. */
void depth_grid_add(struct depth_grid *grid, const float *depth, int32_t n_rows);

/* The size that it was rendered in; false: as it is. */
bool depth_grid_find(const struct depth_grid *grid, int32_t *width, int32_t *height);

#endif
