/* SPDX-License-Identifier: Apache-2.0 */
#include "input/depth_steps.h"

#include <math.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/pool.h"

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
