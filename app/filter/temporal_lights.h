/* SPDX-License-Identifier: Apache-2.0 */
/* Lights that a frame does not show, as the frames beside it do. */
#ifndef APP_TEMPORAL_LIGHTS_H
#define APP_TEMPORAL_LIGHTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

struct image_error;

/* A part of a bright pixel of a frame beside, at a pixel of the frame. */
struct light_point {
    int32_t x, y;
    int32_t frame; /* beside: 0 is asked first */
    uint32_t number;
    float weight, z; /* share of the pixel; planar distance */
    float colour[4];
};

struct light_points {
    struct light_point *at;
    size_t n, room, most; /* what comes after `most` is left out */
    bool is_full;         /* something was left out */
    bool is_short;        /* of memory */
};

/* Luminance that a light has at least: no highlight of the core has less. */
static const float LEAST_LIGHT = 2;

void light_points_add(struct light_points *points, const struct light_point *point);

/*
 * The lights that the points are, in the order of rows: `*lights`, which the caller
 * frees, and how many. False without memory.
 */
bool light_points_join(struct light_points *points, int n_channels,
                       struct rf_unseen_light **lights, size_t *n_lights,
                       struct image_error *error);

void light_points_free(struct light_points *points);

#endif
