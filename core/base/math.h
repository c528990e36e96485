/* SPDX-License-Identifier: Apache-2.0 */
/* Small arithmetic that all modules share. */
#ifndef RF_BASE_MATH_H
#define RF_BASE_MATH_H

#include <math.h>

#define RF_PI 3.14159265358979323846

static inline int rf_min_int(int a, int b)
{
    return a < b ? a : b;
}

static inline int rf_max_int(int a, int b)
{
    return a > b ? a : b;
}

/* fminf() and fmaxf() for numbers: without a call, b where a is NaN. */
static inline float rf_min_float(float a, float b)
{
    return a < b ? a : b;
}

static inline float rf_max_float(float a, float b)
{
    return a > b ? a : b;
}

/*
 * A displacement to whole 128ths of a pixel. Sums of such are exact in all pictures
 * that there can be, so no place depends on where the window begins that it lies in.
 */
static inline float rf_snap_px(float v)
{
    static const float ROUND = 98304; /* 1.5 x 2^16, where floats are that far apart */
    return (v + ROUND) - ROUND;
}

/*
 * exp of the core: the C library's differs in the last bit between processors and
 * versions, and results must not. Relative error 4e-7 on [-80, 88].
 */
float rf_expf(float v);

/* v within 0 to 1. */
static inline float rf_clamp01(float v)
{
    return v < 0 ? 0 : v > 1 ? 1 : v;
}

/*
 * Length of (x, y), of squares that neither overflow nor vanish. hypot() of the C library
 * has not the same last bit everywhere, and asks for glibc 2.35; these three roundings
 * are IEEE 754's own. Relative error below 2^-52.
 */
static inline double rf_length(double x, double y)
{
    return sqrt(x * x + y * y);
}

/*
 * By what the brightest light, above RF_MOST_TO_SQUARE, is multiplied before it is
 * squared, so that no sum of a few such squares overflows. A power of two changes no
 * digit.
 */
#define RF_UNIT_TO_SQUARE 0x1p-66f
#define RF_MOST_TO_SQUARE 0x1p60f

static inline float rf_luminance(float r, float g, float b)
{
    return 0.2126f * r + 0.7152f * g + 0.0722f * b;
}

#endif
