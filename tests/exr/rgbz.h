/* SPDX-License-Identifier: Apache-2.0 */
/* What tests and benchmarks write: R G B in half floats, Z in float. */
#ifndef RF_TESTS_RGBZ_H
#define RF_TESTS_RGBZ_H

#include "exr.h"

static inline struct exr_output rgbz_output(struct exr_box window,
                                            const char *compression, int32_t tile_size)
{
    static const char *const names[] = {"R", "G", "B", "Z"};
    static const enum exr_sample_type types[] = {EXR_SAMPLE_HALF, EXR_SAMPLE_HALF,
                                                 EXR_SAMPLE_HALF, EXR_SAMPLE_FLOAT};
    return (struct exr_output){.width = window.max_x - window.min_x + 1,
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
