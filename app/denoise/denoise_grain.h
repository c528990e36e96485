/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the grain of a picture goes from pixel to pixel. */
#ifndef APP_DENOISE_GRAIN_H
#define APP_DENOISE_GRAIN_H

#include <stdbool.h>

#include "denoise/denoise.h"

/*
 * Is the grain smeared over pixels, as by a pixel filter that spreads each sample?
 * False where albedo and normals are not known, or where there is too little grain on
 * plain surfaces to tell.
 */
bool denoise_is_smeared(const struct denoise_picture *picture,
                        const struct denoise_guides *guides);

#endif
