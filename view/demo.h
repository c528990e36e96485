/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The set-up of the literature: three identical pictures, one behind the other, drawn
 * with OpenGL and turned with the mouse. Colour and depth buffer are read back; the
 * depth buffer is unprojected with the near and the far plane by the core, as it would
 * be for the file of any other program (depth "buffer").
 *
 * Source of the set-up: Yu, "Depth of field implementation with OpenGL", 2004.
 */
#ifndef VIEW_DEMO_H
#define VIEW_DEMO_H

#include <stdbool.h>
#include <stdint.h>

#include "image.h"
#include "gl.h"
#include "input.h"
#include "settings.h"

/* Scene units are metres. */
#define DEMO_NEAR 0.5
#define DEMO_FAR 50.0
#define DEMO_FOCAL_LENGTH_MM 85.0
#define DEMO_SENSOR_MM 36.0
#define DEMO_N_PICTURES 3

struct demo {
    int32_t width, height; /* of the picture that is filtered */
    double yaw, pitch;     /* of the scene about its middle, radians */
    struct gl_target target;
    unsigned texture;
    double picture_aspect; /* width / height */
};

/* The scene with the picture of a file, or with its own where `path` is NULL. Needs a
 * current OpenGL context. False with a message. */
bool demo_open(struct demo *demo, int32_t width, const char *path,
               struct image_error *error);
void demo_close(struct demo *demo);

/* Turns by a drag of (dx, dy) px of the picture; the pitch stays from -20 to 60
 * degrees. */
void demo_turn(struct demo *demo, double dx, double dy);

/* Draws the scene and reads it back; the caller holds the result. */
struct input *demo_draw(const struct demo *demo);

/* What a file of the scene would say in its header. */
void demo_facts(struct settings *settings);

/* Distance of the middle of picture i along the camera's axis, 0 the nearest one. */
double demo_distance(const struct demo *demo, int i);

/* Writes colour and depth buffer as a file of passes, float, with the facts. */
bool demo_save_passes(const char *path, const struct input *input, int n_threads,
                      struct image_error *error);

/* Writes a filtered picture, float or PNG, with the options that made it. */
bool demo_save(const char *path, const float *pixels, int32_t width, int32_t height,
               const struct settings *settings, int n_threads,
               struct image_error *error);

#endif
