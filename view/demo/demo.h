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

#include "controls/gl.h"
#include "image.h"
#include "pixels/input.h"
#include "sources/picture.h"
#include "sources/settings.h"

/* Scene units are metres. */
#define DEMO_NEAR 0.5
#define DEMO_FAR 50.0
#define DEMO_FOCAL_LENGTH_MM 85.0
#define DEMO_SENSOR_MM 36.0
#define DEMO_N_PICTURES 3
#define DEMO_EYES 0.065 /* between the pupils of grown-up people, their mean */

struct demo_vertex;

struct demo {
    int32_t width, height; /* of the picture that is filtered */
    double yaw, pitch;     /* of the scene about its middle, radians */
    bool is_stereo;        /* both eyes, the middle picture at the screen's distance */
    struct gl_target targets[2];
    unsigned texture;
    double picture_aspect; /* width / height */
    struct demo_vertex
        *vertices; /* of the scene as it is turned, in the camera's frame */
};

/* How the camera of a view moves: the axis stays parallel and the frustum is sheared, or
 * the camera turns to the middle of the plane in focus. */
enum demo_move { DEMO_SHIFT, DEMO_LOOK_AT };

/* Where a view is seen from: scene units right and up of the middle of the lens. */
struct demo_eye {
    double x, y;
    double focus; /* distance of the plane in focus */
    enum demo_move move;
};

/* The scene with the picture of a file, or with its own where `path` is NULL; a height of
 * 0 is 9/16 of the width. Needs a current OpenGL context. False with a message. */
bool demo_open(struct demo *demo, int32_t width, int32_t height, const char *path,
               struct image_error *error);
void demo_close(struct demo *demo);

/* Turns by a drag of (dx, dy) px of the picture; the pitch stays from -20 to 60
 * degrees. */
void demo_turn(struct demo *demo, double dx, double dy);

/* Draws the scene and reads it back; the caller holds the result. With stereo it is the
 * left eye's, and the right one's its others[0]. NULL without memory. */
struct input *demo_draw(struct demo *demo);

/* Lays out the scene as it is turned now, for demo_begin_view(). */
void demo_lay(struct demo *demo);

/* Begins to draw what an eye on the lens sees, in one of two frame buffers (0, 1), and
 * does not wait for it; reads it: sRGB codes, RGBA, rows from the bottom. */
void demo_begin_view(const struct demo *demo, const struct demo_eye *eye, int buffer);
void demo_read_view(const struct demo *demo, int buffer, uint8_t *rgba);

/* Focal length of the demo's camera, px. */
double demo_focal_px(const struct demo *demo);

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

/* Writes the mean of n views, float. */
bool demo_save_views(const char *path, const struct picture *mean, int n,
                     enum demo_move move, int n_threads, struct image_error *error);

#endif
