/* SPDX-License-Identifier: Apache-2.0 */
/* The transfer curve of sRGB (IEC 61966-2-1), of one channel. */
#ifndef RF_SRGB_H
#define RF_SRGB_H

#include <math.h>

/* Scene-linear to encoded; both in [0, 1]. */
static inline float srgb_encode(float linear)
{
    return linear <= 0.0031308f ? 12.92f * linear
                                : 1.055f * powf(linear, 1.0f / 2.4f) - 0.055f;
}

/* Encoded to scene-linear; both in [0, 1]. */
static inline float srgb_decode(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f
                               : powf((encoded + 0.055f) / 1.055f, 2.4f);
}

#endif
