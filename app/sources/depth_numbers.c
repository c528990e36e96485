/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/depth_numbers.h"

#include <math.h>

/* Rounding and the overshoot of half floats stay below it. */
static const double WELL_ABOVE_ONE = 1.001;

/* Different whole numbers, from which on they are those of a map with few bits: scenes
 * that are put together of walls at 3 and 12 have less. */
enum { FEWEST_DIFFERENT = 8 };

/* Is the scaled value v one that means "nothing hit" of its kind? */
static bool is_far(int32_t kind, double v)
{
    switch (kind) {
    case RF_DEPTH_NORMALISED:
        return v >= 1;
    case RF_DEPTH_BUFFER:
    case RF_DEPTH_BUFFER_INFINITE:
        return v == 1;
    case RF_DEPTH_BUFFER_REVERSED:
    case RF_DEPTH_BUFFER_REVERSED_INFINITE:
    case RF_DEPTH_INVERSE:
    case RF_DEPTH_DISPARITY:
        return v == 0;
    default:
        return false;
    }
}

static void add_hit(struct depth_numbers *numbers, float z)
{
    numbers->n_hits++;
    if (z != floorf(z)) {
        numbers->n_parts++;
    } else if (numbers->n_parts == 0 && z < 4e9F) {
        const uint32_t whole = (uint32_t)z;
        const uint32_t bits = (whole ^ whole >> 8 ^ whole >> 16) & 255;
        numbers->seen[bits / 32] |= 1U << bits % 32;
    }
}

void depth_numbers_add(struct depth_numbers *numbers, const struct rf_params *params,
                       const float *depth, size_t n)
{
    const bool is_scaled = params->depth != RF_DEPTH_PLANAR;
    numbers->n += n;
    for (size_t i = 0; i < n; i++) {
        const float z = depth[i];
        if (!(z < params->depth_infinity) || !isfinite(z))
            continue;
        if (z > 0)
            add_hit(numbers, z);
        if (!is_scaled)
            continue;
        const double v = z * params->depth_scale + params->depth_offset;
        numbers->n_far += is_far(params->depth, v);
        if (params->depth == RF_DEPTH_NORMALISED && v > WELL_ABOVE_ONE) {
            numbers->n_beyond++;
            numbers->beyond = fmax(numbers->beyond, v);
        }
    }
}

bool depth_numbers_are_whole(const struct depth_numbers *numbers)
{
    int n = 0;
    for (int i = 0; i < 256; i++)
        n += (numbers->seen[i / 32] >> i % 32 & 1) != 0;
    return numbers->n_hits > 0 && numbers->n_parts == 0 && n >= FEWEST_DIFFERENT;
}
