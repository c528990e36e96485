/* SPDX-License-Identifier: Apache-2.0 */
/* Rows of a picture as PNG stores them, and back. */
#ifndef RF_PNG_ROWS_H
#define RF_PNG_ROWS_H

#include <stdbool.h>
#include <stdint.h>

/*
 * `width` pixels of n_channels (1, 3 or 4) floats, scene-linear and premultiplied, to
 * big-endian integers of `bits` (8 or 16): unpremultiplied, clipped to [0, 1] and sRGB
 * encoded; with is_encoded clipped only. NaN becomes 0.
 */
void png_encode_row(const float *in, int32_t width, int n_channels, int bits,
                    bool is_encoded, uint8_t *out);

/* RGBA integers, sRGB encoded, to RGBA floats, scene-linear and premultiplied. */
void png_decode_row(const uint8_t *in, int32_t width, int bits, float *out);

#endif
