/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of N times the size that was asked for. */
#ifndef APP_FILTER_SHRINK_H
#define APP_FILTER_SHRINK_H

#include "image.h"

enum { FILTER_MOST_SUPERSAMPLE = 16 };

/* A box of whole blocks of n x n pixels, in blocks. */
struct image_box filter_shrunk_box(const struct image_box *box, int n);

#endif
