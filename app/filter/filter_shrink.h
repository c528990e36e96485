/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of N times the size that was asked for. */
#ifndef APP_FILTER_SHRINK_H
#define APP_FILTER_SHRINK_H

#include "image.h"

enum {
    FILTER_MOST_SUPERSAMPLE = 16,
    FILTER_MOST_PIXELS_WIDTH = 4,
    /* Of a side, for the widest of the kinds: 1.5 widths to both sides. */
    FILTER_MOST_TAPS = 3 * FILTER_MOST_PIXELS_WIDTH * FILTER_MOST_SUPERSAMPLE + 1,
};

/* Pixel filters of renderers: Cycles' names in small letters, in the order of
 * FILTER_PIXELS_CHOICES. Box: each block of pixels has its mean. */
enum filter_pixels {
    FILTER_PIXELS_BLACKMAN_HARRIS,
    FILTER_PIXELS_GAUSSIAN,
    FILTER_PIXELS_BOX,
};
#define FILTER_PIXELS_CHOICES "blackman-harris|gaussian|box"
#define FILTER_PIXELS_USUAL_WIDTH 1.5 /* px, of Cycles */

/* A box of whole blocks of n x n pixels, in blocks. */
struct image_box filter_shrunk_box(const struct image_box *box, int n);

#endif
