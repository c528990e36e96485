/* SPDX-License-Identifier: Apache-2.0 */
/* How much light the looks of a lens let through, over a picture. */
#ifndef RF_COMPOSE_LIGHT_MAP_H
#define RF_COMPOSE_LIGHT_MAP_H

#include "input/frame.h"
#include "lens/aperture.h"
#include "rackfocus/rackfocus.h"

/*
 * The share of a shape's light that comes through, at nodes RF_LIGHT_STEP px apart of the
 * whole picture; linear between them.
 */
struct rf_light_map {
    int x, y;             /* the first node, in steps of the whole picture */
    int n_x, n_y;         /* nodes */
    int first_x, first_y; /* the first pixel, in the whole picture */
    float *at;
};

enum { RF_LIGHT_STEP = 16 };

/*
 * The map of a frame's pixels, of a shape with the light of `plane` of the frame's picture
 * of the aperture (not read where its light is even); rf_light_map_free() in any case.
 */
rf_result rf_light_map_make(struct rf_light_map *map, const struct rf_frame *frame,
                            const struct rf_shape *shape, int plane,
                            struct rf_error *error);

void rf_light_map_free(struct rf_light_map *map, const struct rf_context *context);

/* The values at n pixels from (x, y) of the frame on. */
void rf_light_map_row(const struct rf_light_map *map, int x, int y, int n, float *out);

/*
 * Takes the light out of a finished picture that its looks do, where the parameters ask
 * for it: colours fall, alpha stays. `out` begins at pixel (x, y) of the frame.
 */
rf_result rf_take_vignette(const struct rf_frame *frame, int x, int y,
                           const struct rf_image *out, struct rf_error *error);

#endif
