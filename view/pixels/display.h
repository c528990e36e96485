/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From pictures, depths and radii to what a screen shows: 8 bit RGBA, opaque, rows from
 * the top. Pictures are packed floats of 1, 3 or 4 channels, scene-linear; alpha is
 * premultiplied, so that what is transparent shows as before black.
 */
#ifndef VIEW_DISPLAY_H
#define VIEW_DISPLAY_H

#include <stddef.h>
#include <stdint.h>

/* The view transform: v 2^exposure, clipped to [0, 1], the curve of sRGB, rounded to 8
 * bits as png_write does. Built once, read by any thread. */
struct tone;

struct tone *tone_create(void); /* NULL: no memory */
void tone_destroy(struct tone *tone);
uint8_t tone_encode(const struct tone *tone, float linear);

/* A picture of n px. `rgba` is n * 4 bytes, in all of these. */
void display_picture(const struct tone *tone, const float *pixels, int n_channels,
                     size_t n, double exposure, uint8_t *rgba);

/* Planar depth, lighter = farther: 255 (1/near - 1/z) / (1/near - 1/far), so that equal
 * steps of grey are equal steps of blur; infinity is white. */
void display_depth(const float *planar, size_t n, double near, double far,
                   uint8_t *rgba);

/* Signed radius, px: before the focus orange, behind it blue, black in focus, full
 * colour at abs(r) >= full. Brightness goes with the square root of abs(r) / full. */
void display_coc(const float *radius, size_t n, double full, uint8_t *rgba);

/* The picture, grey and dark but where abs(r) <= limit. */
void display_band(const struct tone *tone, const float *pixels, int n_channels,
                  const float *radius, size_t n, double exposure, double limit,
                  uint8_t *rgba);

/* False colours of luminance (Rec. 709) times 2^exposure, in stops from middle grey,
 * 0.18: violet below -6, blue to -3, grey, green within half a stop of middle grey, grey,
 * yellow from +2, red where a channel is clipped. */
void display_exposure(const float *pixels, int n_channels, size_t n, double exposure,
                      uint8_t *rgba);

/* The false colour of grey so many stops from middle grey, RGB; for a legend. */
void display_exposure_colour(double stops, uint8_t rgb[3]);

/* sRGB encoded floats in [0, 1], packed RGB, as measure_heatmap makes them. */
void display_encoded(const float *rgb, size_t n, uint8_t *rgba);

#endif
