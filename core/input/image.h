/* SPDX-License-Identifier: Apache-2.0 */
/* The caller's pixels where they lie. */
#ifndef RF_INPUT_IMAGE_H
#define RF_INPUT_IMAGE_H

#include <stddef.h>

#include "rackfocus/rackfocus.h"

/* From this alpha on a pixel, or a deep sample, hides all behind it. Ours: what half floats
 * make of a 1 that was summed (0.9995) is opaque, the step below 1 of 8 bits (0.996) not. */
#define RF_OPAQUE_ALPHA 0.999f

/* Checks one view, of 1, 3 or 4 channels; `name` is the field in errors. */
rf_result rf_image_check(const struct rf_image *image, const char *name, int width,
                         int height, struct rf_error *error);

/* The same of what has one channel: depth and its like. */
rf_result rf_image_check_one(const struct rf_image *image, const char *name, int width,
                             int height, struct rf_error *error);

/* The same of what is written to, of `channels` channels, 0 for 1, 3 or 4: no stride
 * of 0 puts several samples into one place. */
rf_result rf_image_check_out(const struct rf_image *image, const char *name, int width,
                             int height, int channels, struct rf_error *error);

static inline const float *rf_image_at(const struct rf_image *image, int x, int y,
                                       int c)
{
    return (const float *)((const char *)image->data + (ptrdiff_t)y * image->row_bytes +
                           (ptrdiff_t)x * image->pixel_bytes +
                           (ptrdiff_t)c * image->channel_bytes);
}

#endif
