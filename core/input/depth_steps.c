/* SPDX-License-Identifier: Apache-2.0 */
#include "input/depth_steps.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "input/image.h"

bool rf_depth_find_step(double a, double beyond_a, double b, double beyond_b,
                        double infinity, struct rf_depth_step *step)
{
    const bool is_a_low = a < b;
    const double slope_a = fabs(a - beyond_a);
    const double slope_b = fabs(b - beyond_b);
    const double slope_low = is_a_low ? slope_a : slope_b;
    const double slope_high = is_a_low ? slope_b : slope_a;
    step->low = is_a_low ? a : b;
    step->high = is_a_low ? b : a;
    const double height = step->high - step->low;
    /* A height of 1e10 makes all else look flat. */
    return step->low >= 0 && step->low < infinity && isfinite(step->high) &&
           step->high >= RF_DEPTH_STEP_RATIO * step->low && height > 0 &&
           slope_high < 0.05 * height &&
           slope_low < fmin(0.05 * height, 0.1 * step->low + 1e-30);
}

/* Memory of the context, or where there is none of the C library. */
void *rf_depth_take(const struct rf_context *context, size_t count, size_t size)
{
    return context ? rf_alloc(context, count, size) : malloc(count * size);
}

void rf_depth_give_back(const struct rf_context *context, void *memory)
{
    if (context)
        rf_free(context, memory);
    else
        free(memory);
}

rf_result rf_depth_check(const struct rf_depth_channel *channel, struct rf_error *error)
{
    if (!channel || !channel->depth || channel->width < 1 || channel->height < 1)
        return rf_fail(error, RF_ERROR_ARGUMENT, "channel",
                       "a pointer is NULL or the depth has no pixels");
    return channel->colour.data ? rf_image_check(&channel->colour, "colour",
                                                 channel->width, channel->height, error)
                                : RF_OK;
}

/* Of other bits: a NaN is not another one than itself. */
static bool is_other(float a, float b)
{
    uint32_t bits[2];
    memcpy(&bits[0], &a, sizeof a);
    memcpy(&bits[1], &b, sizeof b);
    return bits[0] != bits[1];
}

rf_result rf_depth_change_all(const struct rf_context *context,
                              struct rf_depth_channel *channel, rf_depth_change *change,
                              const void *data, size_t *n_changed,
                              struct rf_error *error)
{
    if (!n_changed)
        return rf_fail(error, RF_ERROR_ARGUMENT, "n_changed", "a pointer is NULL");
    rf_result result = rf_depth_check(channel, error);
    if (result != RF_OK)
        return result;
    const size_t n = (size_t)channel->width * (size_t)channel->height;
    struct rf_depth_channel from = *channel;
    from.depth = rf_depth_take(context, n, sizeof *from.depth);
    if (!from.depth)
        return rf_fail_memory(error, n, sizeof *from.depth);
    memcpy(from.depth, channel->depth, n * sizeof *from.depth);
    float *to = channel->depth;
    for (int32_t y = 0; y < channel->height; y++)
        for (int32_t x = 0; x < channel->width; x++, to++) {
            const float z = change(&from, x, y, data);
            *n_changed += is_other(*to, z);
            *to = z;
        }
    rf_depth_give_back(context, from.depth);
    return RF_OK;
}
