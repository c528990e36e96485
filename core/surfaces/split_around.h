/* SPDX-License-Identifier: Apache-2.0 */
/* The pixels around one that may be mixed, and what meets in it. */
#ifndef RF_SURFACES_SPLIT_AROUND_H
#define RF_SURFACES_SPLIT_AROUND_H

#include <stdbool.h>
#include <stdint.h>

#include "kernels/data.h"
#include "surfaces/split_pixels.h"
#include "surfaces/surfaces.h"

/* The 5 x 5 pixels around one, a bit for each as in struct rf_sides. */
enum { RF_SPLIT_WINDOW = RF_SIDES_AROUND / 2 };
enum { RF_SPLIT_MIDDLE = 1 << RF_SPLIT_STEPS / 2 }; /* the bit of the pixel itself */

struct rf_split_around {
    const struct rf_surface *middle;
    const int32_t *steps; /* from it to each */
};

/* What meets in a pixel. */
struct rf_meeting {
    struct rf_surface f, b; /* the near and the far surface */
    uint32_t near, far;     /* pixels that show them, mixed ones too */
    uint32_t own, other; /* pixels within the one that the depth says, and the other */
    bool is_near;        /* it is the near one */
    bool is_within;      /* a thin thing lies to both sides, without an interior */
};

/* For each bit f(squared distance from the middle). */
#define RF_OF_DISTANCES(f)                                                             \
    {                                                                                  \
        f(8), f(5), f(4), f(5), f(8), f(5), f(2), f(1), f(2), f(5), f(4), f(1), f(0),  \
            f(1), f(4), f(5), f(2), f(1), f(2), f(5), f(8), f(5), f(4), f(5), f(8)     \
    }

/* Mean of the pixels of a set that is not empty, the nearer ones counting more. */
struct rf_surface rf_split_mean_of(const struct rf_split_around *around, uint32_t bits);

#endif
