/* SPDX-License-Identifier: Apache-2.0 */
/* What tests and benchmarks write: R G B in half floats, Z in float. */
#ifndef RF_TESTS_RGBZ_H
#define RF_TESTS_RGBZ_H

#include "image.h"

static inline struct image_output
rgbz_output(struct image_box window, const char *compression, int32_t tile_size)
{
    static const char *const names[] = {"R", "G", "B", "Z"};
    static const enum image_sample_type types[] = {
        IMAGE_SAMPLE_HALF, IMAGE_SAMPLE_HALF, IMAGE_SAMPLE_HALF, IMAGE_SAMPLE_FLOAT};
    return (struct image_output){.width = window.max_x - window.min_x + 1,
                                 .height = window.max_y - window.min_y + 1,
                                 .data_window = window,
                                 .display_window = window,
                                 .n_channels = 4,
                                 .channel_names = names,
                                 .types = types,
                                 .compression = compression,
                                 .tile_size = tile_size};
}

#endif
