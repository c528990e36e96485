/* SPDX-License-Identifier: Apache-2.0 */
/* From POV-Ray's pixels back to what it computed, and to depth. */
#ifndef POVRAY_DECODE_H
#define POVRAY_DECODE_H

#include <stdbool.h>
#include <stdint.h>

#include "povray.h"

/* A picture as POV-Ray wrote it. */
struct decode_picture {
    int32_t width, height;
    bool has_alpha;
    float *rgba;       /* free with free() */
    int64_t n_clipped; /* pixels that were brighter than the file can say */
};

bool decode_read(struct decode_picture *picture, const char *path, int n_threads,
                 struct povray_error *error);

/* The space in which POV-Ray computed: assumed_gamma, or sRGB's curve where an older
 * scene says nothing. */
struct decode_space {
    double gamma;
    bool is_srgb;
};

/* What POV-Ray computed for a value of its picture, which is linear light. */
double decode_value(const struct decode_space *space, double value);

/*
 * Finds the space from the picture of a surface of known colour. False where no curve
 * explains all three channels.
 */
bool decode_find_space(struct decode_space *space, const double seen[3],
                       const double shown[3]);

/* One distance of the fog: pictures without and with light in it. */
struct decode_fog {
    double distance;
    double light[3];            /* colour of the fog */
    const float *base, *fogged; /* RGBA */
    const float *dark; /* RGBA with the same fog, but black; NULL where not rendered */
    bool is_dark;      /* that is what base has; else none */
};

/* Pixels in which no fog was seen, those about as bright as the fog, whose depth needs
 * `dark`, and those that half floats cannot hold. */
struct decode_counts {
    int64_t n_inside, n_bright, n_beyond;
};

/* Depth of a picture from two fogs, the nearer first. Planar distance, INFINITY where
 * nothing was hit. The camera's direction, which may be sheared, reaches `axis_length`
 * along the axis. */
struct decode_counts decode_depth(const struct decode_fog fogs[2],
                                  const struct decode_space *space,
                                  const struct povray_camera *camera,
                                  double axis_length, int32_t width, int32_t height,
                                  float *depth);

#endif
