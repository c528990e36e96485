/* SPDX-License-Identifier: Apache-2.0 */
/*
 * FLIP, the difference that an observer sees who flips between two pictures.
 *
 * LDR-FLIP of Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating
 * Images", Proc. ACM Comput. Graph. Interact. Tech. 3(2): the pictures as a screen shows
 * them (clipped to 0 to 1) are filtered by the contrast sensitivity of the eye, compared
 * in CIELAB after Hunt's adjustment, and differences at edges and points count more.
 */
#ifndef APP_FLIP_H
#define APP_FLIP_H

#include <stdbool.h>
#include <stdint.h>

/* Pixels per degree of the observer: a screen of 0.7 m and 3840 pixels at 0.7 m. */
#define FLIP_PIXELS_PER_DEGREE (0.7 * 3840 / 0.7 * 3.14159265358979323846 / 180)

/*
 * The mean over the pixels of FLIP, 0 (alike) to 1, of packed linear RGB, width *
 * height * 3 each, without NaN; primaries and white of sRGB. False without memory, or
 * where another thread set `stop` (may be NULL), which ends it early.
 */
bool flip_measure(const float *a, const float *b, int32_t width, int32_t height,
                  double *flip, const bool *stop);

#endif
