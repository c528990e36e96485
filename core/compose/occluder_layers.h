/* SPDX-License-Identifier: Apache-2.0 */
/* What may stand before a highlight: the near surfaces of each view and what lies behind
 * them, in blocks that know their nearest radius. */
#ifndef RF_COMPOSE_OCCLUDER_LAYERS_H
#define RF_COMPOSE_OCCLUDER_LAYERS_H

#include <stddef.h>

#include "base/context.h"
#include "compose/scene.h"
#include "kernels/data.h"
#include "rackfocus/rackfocus.h"

enum { RF_OCCLUDER_BLOCK = 16 }; /* px, a side of a block */

/* The near surfaces of a view or those behind them, and what helps to find them. */
struct rf_occluder_layer {
    const struct rf_occluders *occluders;
    int view;            /* its index */
    const float *share;  /* of each pixel that is covered; NULL: all of it */
    const float *radius; /* per pixel: of an occluder, or INFINITY */
    size_t stride;       /* of its rows; floats */
    float *own;          /* whole blocks, where the radii are not at hand; or NULL */
    float *own_share;    /* likewise; of far parts alone */
    float *nearest;      /* per block: the least of them */
    float least;         /* of all blocks */
    double extent[2];    /* of u - a u_j over its part of the lens */
};

struct rf_occluder_layers {
    const struct rf_scene *scene;
    int n_x, n_y;          /* blocks */
    size_t stride;         /* px in whole blocks */
    double lens_extent[2]; /* of the lens, in its radii */
    struct rf_occluder_layer
        *at; /* near surfaces of each view, then those behind them */
    int n;
    float *whole;                                      /* a row of shares of 1 */
    float *memory;                                     /* of theirs */
    unsigned char view_at[RF_LENS_GRID][RF_LENS_GRID]; /* to ask, over [-e, e]^2 */
};

/* Fills the rest of layers whose first four members are set. RF_ERROR_MEMORY; they are
 * to be freed in any case. */
rf_result rf_occluder_layers_build(struct rf_occluder_layers *layers,
                                   struct rf_error *error);
void rf_occluder_layers_free(struct rf_occluder_layers *layers,
                             const struct rf_context *context);

#endif
