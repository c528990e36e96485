/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/depth_ratio.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

/* Of v: the number at 0 and at 1. */
static struct depth_ratio between(const struct rf_params *params, double at_0,
                                  double at_1)
{
    return (struct depth_ratio){.factor = params->depth_scale * (at_1 - at_0),
                                .offset = at_0 + params->depth_offset * (at_1 - at_0)};
}

struct depth_ratio depth_ratio_of(const struct rf_params *params)
{
    const double near = params->depth_near, far = params->depth_far;
    const bool has_ends = near > 0 && far > near && isfinite(far);
    const struct depth_ratio as_it_is = {0, 0};
    switch (params->depth) {
    case RF_DEPTH_NORMALISED:
        return near >= 0 && far > near ? between(params, near, far) : as_it_is;
    case RF_DEPTH_BUFFER:
        return has_ends ? between(params, 1 / near, 1 / far) : as_it_is;
    case RF_DEPTH_BUFFER_REVERSED:
        return has_ends ? between(params, 1 / far, 1 / near) : as_it_is;
    case RF_DEPTH_BUFFER_INFINITE:
        return between(params, 1, 0);
    case RF_DEPTH_BUFFER_REVERSED_INFINITE:
    case RF_DEPTH_INVERSE:
    case RF_DEPTH_DISPARITY:
        if (params->depth_scale < 0 || params->depth_offset != 0)
            return between(params, 0, 1);
        return as_it_is;
    default:
        return as_it_is;
    }
}

static float made(const struct depth_ratio *ratio, float value)
{
    return (float)(ratio->factor * (double)value + ratio->offset);
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
    for (size_t i = 0; i < n && is_done; i++)
        if (other.depth[i] != made(ratio, values[i]) && !isnan(values[i]))
            values[i] = (float)((other.depth[i] - ratio->offset) / ratio->factor);
    free(other.depth);
    return is_done;
}
