/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The little of OpenGL that the window needs: pictures as textures, triangles of one
 * texture, and frame buffers to read back. Fixed pipeline of OpenGL 2.1, so that any
 * driver will do, software ones too. One thread only.
 */
#ifndef VIEW_GL_H
#define VIEW_GL_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Call with a current context. False with a message where the driver is too old. */
bool gl_load(char *text, size_t n_bytes);

/* Names the driver, "llvmpipe (LLVM 15.0.6, 256 bits)". */
void gl_describe(char *text, size_t n_bytes);

/* Begins a frame: the whole window, y down, cleared to dark grey. */
void gl_begin(int32_t width, int32_t height);

/* Fills a part of the window with 0xRRGGBBAA; much cheaper than triangles where OpenGL
 * runs on the processor. */
void gl_fill(int32_t x, int32_t y, int32_t width, int32_t height, uint32_t rgba);

/* Draws only within this part of the window, until the next call or frame. */
void gl_clip(int32_t x, int32_t y, int32_t width, int32_t height);

/* Reads the window back: RGB, rows from the bottom. */
void gl_read_window(int32_t width, int32_t height, uint8_t *rgb);

/* ---- pictures -------------------------------------------------------------------- */

/* A picture in pieces that the driver takes. Zeroed is empty. */
struct gl_picture {
    int32_t width, height;
    int32_t piece; /* side of a piece, px */
    int n_pieces;
    unsigned *textures;
};

/* Replaces the picture: opaque RGBA, rows from the top. */
void gl_picture_put(struct gl_picture *picture, const uint8_t *rgba, int32_t width,
                    int32_t height);
void gl_picture_free(struct gl_picture *picture);

/* Draws it with its corner at (x, y), `scale_x` and `scale_y` window px per px. Single
 * px are shown as squares where they are larger than one of the window's, unless
 * `is_smooth`. */
void gl_picture_draw(const struct gl_picture *picture, double x, double y,
                     double scale_x, double scale_y, bool is_smooth);

/* ---- triangles ------------------------------------------------------------------- */

struct gl_vertex {
    float x, y, u, v;
    uint8_t rgba[4];
};

/* A texture of coverage, 8 bits a px. */
unsigned gl_make_mask(const uint8_t *coverage, int32_t width, int32_t height);
void gl_draw_quads(const struct gl_vertex *vertices, size_t n, unsigned mask);

/* ---- frame buffers --------------------------------------------------------------- */

struct gl_target {
    unsigned frame, colour, depth;
    int32_t width, height;
};

bool gl_target_make(struct gl_target *target, int32_t width, int32_t height);
void gl_target_free(struct gl_target *target);

/* Draws go there until another begins or one is read: colour (RGBA) and the depth buffer
 * in [0, 1] (NULL: not wanted), rows from the bottom. */
void gl_target_begin(const struct gl_target *target);
void gl_target_read(const struct gl_target *target, uint8_t *rgba, float *depth);

#endif
