/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/depth_ratio.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

/* Of v: the number at 0 and at 1, and the v of what was not hit. */
static struct depth_ratio between(const struct rf_params *params, double at_0,
                                  double at_1, double no_hit)
{
    static const double LEAST = 0.02; /* of the range */
    const double least = LEAST * fabs(at_1 - at_0), low = fmin(at_0, at_1);
    at_0 -= low > least ? low - least : 0;
    at_1 -= low > least ? low - least : 0;
    return (struct depth_ratio){.factor = params->depth_scale * (at_1 - at_0),
                                .offset = at_0 + params->depth_offset * (at_1 - at_0),
                                .nothing = (no_hit - params->depth_offset) /
                                           params->depth_scale};
}

struct depth_ratio depth_ratio_of(const struct rf_params *params)
{
    const double near = params->depth_near, far = params->depth_far;
    const bool has_ends = near > 0 && far > near && isfinite(far);
    const struct depth_ratio as_it_is = {0, 0, 0};
    switch (params->depth) {
    case RF_DEPTH_NORMALISED:
        return near >= 0 && far > near ? between(params, near, far, 1) : as_it_is;
    case RF_DEPTH_BUFFER:
        return has_ends ? between(params, 1 / near, 1 / far, 1) : as_it_is;
    case RF_DEPTH_BUFFER_REVERSED:
        return has_ends ? between(params, 1 / far, 1 / near, 0) : as_it_is;
    case RF_DEPTH_BUFFER_INFINITE:
        return between(params, 1, 0, 1);
    case RF_DEPTH_BUFFER_REVERSED_INFINITE:
    case RF_DEPTH_INVERSE:
    case RF_DEPTH_DISPARITY:
        if (params->depth_scale < 0 || params->depth_offset != 0)
            return between(params, 0, 1, 0);
        return as_it_is;
    default:
        return as_it_is;
    }
}

static float made(const struct depth_ratio *ratio, float value)
{
    return (float)(ratio->factor * (double)value + ratio->offset);
}

static float undone(const struct depth_ratio *ratio, float number)
{
    return (float)(((double)number - ratio->offset) / ratio->factor);
}

void depth_ratio_make(const struct depth_ratio *ratio, float *depth, size_t n)
{
    for (size_t i = 0; i < n; i++)
        depth[i] = made(ratio, depth[i]);
}

bool depth_ratio_snap(const struct depth_ratio *ratio, struct rf_depth_channel *channel,
                      size_t *n_changed)
{
    const size_t n = (size_t)channel->width * (size_t)channel->height;
    float *values = channel->depth;
    if (ratio->factor == 0)
        return rf_depth_snap(NULL, channel, n_changed, NULL) == RF_OK;
    struct rf_depth_channel other = *channel;
    other.depth = app_memory(n, sizeof(float), NULL);
    if (!other.depth)
        return false;
    memcpy(other.depth, values, n * sizeof(float));
    depth_ratio_make(ratio, other.depth, n);
    const bool is_done = rf_depth_snap(NULL, &other, n_changed, NULL) == RF_OK;
    float least = INFINITY, most = -INFINITY; /* what is rounded stays within */
    for (size_t i = 0; i < n; i++) {
        least = fminf(least, values[i]);
        most = fmaxf(most, values[i]);
    }
    for (size_t i = 0; i < n && is_done; i++) {
        const float now = other.depth[i];
        if (now == made(ratio, values[i]) || isnan(values[i]))
            continue;
        values[i] = now == 0 ? (float)ratio->nothing
                             : fminf(most, fmaxf(least, undone(ratio, now)));
    }
    free(other.depth);
    return is_done;
}
