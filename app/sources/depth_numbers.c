/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/depth_numbers.h"

#include <math.h>
#include <stdio.h>

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

static bool is_distance(const struct rf_params *params)
{
    return params->depth == RF_DEPTH_PLANAR || params->depth == RF_DEPTH_RADIAL;
}

static void add_below(struct depth_numbers *numbers, float z)
{
    const bool is_first = numbers->n_below++ == 0;
    numbers->below[0] = is_first ? z : fminf(numbers->below[0], z);
    numbers->below[1] = is_first ? z : fmaxf(numbers->below[1], z);
}

/* A number below infinity, which may be below 0. */
static void add_scaled(struct depth_numbers *numbers, const struct rf_params *params,
                       float z)
{
    const double v = z * params->depth_scale + params->depth_offset;
    if (v < 0)
        add_below(numbers, z);
    if (is_distance(params))
        return;
    numbers->n_far += is_far(params->depth, v);
    if (params->depth == RF_DEPTH_NORMALISED && isfinite(v) && v > WELL_ABOVE_ONE) {
        numbers->n_beyond++;
        numbers->beyond = fmax(numbers->beyond, v);
    }
}

void depth_numbers_add(struct depth_numbers *numbers, const struct rf_params *params,
                       const float *depth, size_t n)
{
    numbers->n += n;
    for (size_t i = 0; i < n; i++) {
        const float z = depth[i];
        numbers->n_nan += z != z;
        if (!(z < params->depth_infinity) || z == INFINITY)
            continue;
        if (z > 0)
            add_hit(numbers, z);
        add_scaled(numbers, params, z);
    }
}

void depth_numbers_explain(const struct depth_numbers *numbers,
                           const struct rf_params *params, const char *file,
                           const char *channel, char *text, size_t n_bytes)
{
    /* One number for all of the sky; others are no sky, but another kind of depth. */
    const bool is_one = numbers->n_below > 0 && numbers->below[0] == numbers->below[1];
    const bool is_turned = params->depth_scale < 0;
    char what[80];
    *text = 0;
    if (!is_distance(params) || numbers->n_nan + numbers->n_below == 0 ||
        numbers->n_nan >= numbers->n || (numbers->n_below > 0 && !is_one))
        return;
    if (numbers->n_nan > 0 && is_one)
        snprintf(what, sizeof(what), "NaN and %g mean", numbers->below[0]);
    else if (is_one)
        snprintf(what, sizeof(what), "%g means", numbers->below[0]);
    else
        snprintf(what, sizeof(what), "NaN means");
    snprintf(text, n_bytes,
             "; where %s that nothing was hit, make 0 of it: oiiotool %s --ch "
             "%.60s%s%s%s -d float -o depth.exr, and say --depth-file depth.exr%s",
             what, file, channel, numbers->n_nan > 0 ? " --fixnan black" : "",
             is_one && is_turned ? " --mulc -1" : "", is_one ? " --maxc 0" : "",
             is_one && is_turned ? " without --depth-scale" : "");
}

bool depth_numbers_are_whole(const struct depth_numbers *numbers)
{
    int n = 0;
    for (int i = 0; i < 256; i++)
        n += (numbers->seen[i / 32] >> i % 32 & 1) != 0;
    return numbers->n_hits > 0 && numbers->n_parts == 0 && n >= FEWEST_DIFFERENT;
}
