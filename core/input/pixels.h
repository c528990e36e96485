/* SPDX-License-Identifier: Apache-2.0 */
/* The caller's pixels to planes of light, and back. */
#ifndef RF_INPUT_PIXELS_H
#define RF_INPUT_PIXELS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "input/frame.h"
#include "input/image.h"
#include "rackfocus/rackfocus.h"

/* Are the pixels RGBA quadruples, in the space that light is summed in? */
bool rf_image_is_plain(const struct rf_params *params, const struct rf_image *image);

/* The same of an input: can its pixels be blurred as they are? */
bool rf_image_is_light(const struct rf_params *params, const struct rf_image *image);

/*
 * The colour of a view, unpacked to planes of width x height in the space in which
 * light is summed (blend gamma). Grey gives one plane, RGB three, RGBA four.
 */
rf_result rf_frame_load(const struct rf_frame *frame, const struct rf_image *colour,
                        float *const planes[4], struct rf_error *error);

/*
 * The same checks, and nothing loaded: RF_ERROR_PIXEL where a value is not finite, or
 * not in the blend gamma.
 */
rf_result rf_frame_check(const struct rf_frame *frame, const struct rf_image *colour,
                         struct rf_error *error);

/* One value of light in the space in which light is summed. */
float rf_to_blend_space(const struct rf_params *params, float v);

/* Can a value of that space be summed up? Not NaN, not infinite or nearly so. */
bool rf_is_light(const struct rf_params *params, float v);

/*
 * Copies plain pixels; false where they are not packed or not finite, or are the same,
 * which rf_frame_load() and rf_image_copy() know.
 */
bool rf_frame_copy(const struct rf_context *context, const struct rf_image *colour,
                   const struct rf_image *out);

/* Copies pixels between two views of the same size and channel count, in no blend
 * space; bit for bit but for highlights that are changed. */
void rf_frame_copy_light(const struct rf_params *params, const struct rf_image *from,
                         const struct rf_image *out);

/* Writes planes, rows of `stride` floats, to an image, undoing the blend gamma. */
void rf_frame_store(const struct rf_context *context, const struct rf_params *params,
                    float *const planes[4], size_t stride, const struct rf_image *out);

/* Copies pixels bit for bit between two views of the same size and channel count. */
void rf_image_copy(const struct rf_image *from, const struct rf_image *to);

#endif
