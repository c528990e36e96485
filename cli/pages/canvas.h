/* SPDX-License-Identifier: Apache-2.0 */
/* A picture to draw a sheet on: pictures, frames and text. Places are px from its top
 * left corner; what lies outside is not drawn. */
#ifndef CLI_CANVAS_H
#define CLI_CANVAS_H

#include <stdbool.h>
#include <stdint.h>

struct canvas {
    int32_t width, height;
    float *rgb; /* width * height * 3, sRGB encoded */
};

struct canvas_box {
    int32_t x, y, width, height;
};

/* Grey from 0 (black) to 1. */
typedef float canvas_grey;

/* All of one grey. False without memory; free with canvas_free. */
bool canvas_make(struct canvas *canvas, int32_t width, int32_t height,
                 canvas_grey grey);
void canvas_free(struct canvas *canvas);

/* A border of 2 px inside the box, encoded RGB. */
void canvas_frame(struct canvas *canvas, struct canvas_box box, const float colour[3]);

/* A picture of width x height, packed RGB; encoded, or linear and encoded on the way. */
struct canvas_picture {
    const float *rgb;
    int32_t width, height;
    bool is_linear;
};

/* The whole picture in the box, each pixel the mean of what lies under it. */
void canvas_fit(struct canvas *canvas, struct canvas_box box,
                const struct canvas_picture *picture);

/* Pixels of the picture from (x, y) on, one to one. */
void canvas_crop(struct canvas *canvas, struct canvas_box box,
                 const struct canvas_picture *picture, int32_t x, int32_t y);

/*
 * A line of text, UTF-8, size_px high from base line to base line at least; (x, y) is
 * where it begins on the base line. What the font lacks is shown as "?". Returns the
 * width, px.
 */
int32_t canvas_text(struct canvas *canvas, int32_t x, int32_t y, double size_px,
                    canvas_grey grey, const char *text);

/* The width of a line of text, px. */
int32_t canvas_text_width(double size_px, const char *text);

/*
 * Text in lines of at most width px, broken at spaces, from the base line y on. Returns
 * the base line of the line below.
 */
int32_t canvas_paragraph(struct canvas *canvas, struct canvas_box box, double size_px,
                         canvas_grey grey, const char *text);

#endif
