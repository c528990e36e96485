/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps of a few pixels keep their light when the grain is taken out. */
#ifndef APP_DENOISE_LAMPS_H
#define APP_DENOISE_LAMPS_H

#include <stdbool.h>

#include "denoise/denoise.h"

struct image_error;

/*
 * Gives the lamps of `clean`, packed RGB of the size of the picture with a white of 1,
 * the light that the samples of the picture have around them. Both are finite.
 */
bool denoise_keep_lamps(const struct denoise_picture *grainy, float *clean,
                        int n_threads, struct image_error *error);

#endif
