/* SPDX-License-Identifier: Apache-2.0 */
#include "surfaces/split_around.h"

#include <stdint.h>
#include <string.h>

#include "kernels/data.h"
#include "surfaces/split_pixels.h"
#include "surfaces/surfaces.h"

_Static_assert((int)RF_SIDES_AROUND *RF_SIDES_AROUND == (int)RF_SPLIT_STEPS,
               "a step to each pixel around");

struct rf_surface rf_split_mean_of(const struct rf_split_around *around, uint32_t bits)
{
#define WEIGHT(d2) 1 / (0.5f + (d2))
    static const float WEIGHTS[RF_SPLIT_STEPS] = RF_OF_DISTANCES(WEIGHT);
#undef WEIGHT
    rf_quad c = {0};
    float r = 0, weight = 0;
    for (; bits; bits &= bits - 1) {
        int bit = __builtin_ctz(bits);
        const struct rf_surface *q = around->middle + around->steps[bit];
        float k = WEIGHTS[bit];
        c += k * *(const rf_quad *)q->c;
        r += k * q->r;
        weight += k;
    }
    struct rf_surface mean = {.r = r / weight};
    c /= weight;
    memcpy(mean.c, &c, sizeof mean.c);
    return mean;
}
