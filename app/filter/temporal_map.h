/* SPDX-License-Identifier: Apache-2.0 */
/* Where the pixels of one frame lie in another. */
#ifndef APP_TEMPORAL_MAP_H
#define APP_TEMPORAL_MAP_H

#include <stdbool.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* A pinhole camera that a picture was taken with. */
struct temporal_camera {
    struct rf_lens lens;
    double pixel_aspect;
    double world_to_camera[16]; /* rows; points are rows: p' = p M */
    bool has_matrix;
    double lens_offset[2], shear_distance; /* of a view, as in struct rf_view */
};

enum temporal_kind { TEMPORAL_NONE, TEMPORAL_MATRICES, TEMPORAL_VECTORS };

/*
 * From one frame, a neighbour, to another. Renderers agree on what worldToCamera is,
 * but not on the axes of the camera: y is up or down, and it looks along z or against
 * it. axes holds the signs.
 */
struct temporal_map {
    enum temporal_kind kind;
    struct temporal_camera from, to;
    double between[16];   /* from the camera of `from` to that of `to`, rows */
    double axes[2];       /* of y and z */
    const float *vectors; /* right and down, px, of each pixel; packed */
    int32_t width;        /* of the vectors */
    double vector_sign[2];
};

enum { TEMPORAL_N_AXES = 3 };

/* Sets map->between from both matrices; false where one cannot be inverted. */
bool temporal_map_join(struct temporal_map *map);

/* Takes one of TEMPORAL_N_AXES conventions of the camera's axes. */
void temporal_map_take_axes(struct temporal_map *map, int i);

struct temporal_place {
    double x, y; /* px, a pixel's middle at + 0.5 */
    double z;    /* planar distance, INFINITY for the sky */
};

/* Where what pixel (x, y) of `from` shows at distance z lies in `to`; false where that
 * is behind the camera. */
bool temporal_map_place(const struct temporal_map *map, int32_t x, int32_t y, double z,
                        struct temporal_place *place);

#endif
