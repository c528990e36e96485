/* SPDX-License-Identifier: Apache-2.0 */
/* Steps of a depth channel, for who measures and who mends them. */
#ifndef RF_INPUT_DEPTH_STEPS_H
#define RF_INPUT_DEPTH_STEPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "rackfocus/rackfocus.h"

/*
 * A step: two flat sides whose depths differ by this factor, and at most so many pixels
 * between them. Pixel filters of renderers are up to 4 px wide.
 */
#define RF_DEPTH_STEP_RATIO 1.3
enum { RF_DEPTH_STEP_PIXELS = 6 };

/* Of steps or pixels: fewer tell nothing of a picture but by chance. */
enum { RF_DEPTH_FEWEST = 20 };

struct rf_depth_step {
    double low, high; /* depths of the sides */
    int32_t n, n_low; /* px from the one to the other, and from the pixel to `low` */
};

/*
 * Do `a` and `b` end the sides of a step, with `beyond_a` and `beyond_b` the next pixels
 * of these sides? Fills `low` and `high`.
 */
bool rf_depth_find_step(double a, double beyond_a, double b, double beyond_b,
                        double infinity, struct rf_depth_step *step);

/* RF_ERROR_ARGUMENT where a channel has no pixels, or colours of another size. */
rf_result rf_depth_check(const struct rf_depth_channel *channel,
                         struct rf_error *error);

/*
 * Gives each pixel of a channel what `change` makes of it, which sees the depths as they
 * were, in `from`; *n_changed is raised by how many differ. RF_ERROR_ARGUMENT where a
 * pointer is NULL, RF_ERROR_MEMORY.
 */
typedef float rf_depth_change(const struct rf_depth_channel *from, int32_t x, int32_t y,
                              const void *data);
rf_result rf_depth_change_all(const struct rf_context *context,
                              struct rf_depth_channel *channel, rf_depth_change *change,
                              const void *data, size_t *n_changed,
                              struct rf_error *error);

/* Memory of the context; of the C library where that is NULL. */
void *rf_depth_take(const struct rf_context *context, size_t count, size_t size);
void rf_depth_give_back(const struct rf_context *context, void *memory);

#endif
