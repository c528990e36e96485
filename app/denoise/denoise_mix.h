/* SPDX-License-Identifier: Apache-2.0 */
/* How much of the merge of views without grain is wrong, and what that costs it. */
#ifndef APP_DENOISE_MIX_H
#define APP_DENOISE_MIX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "denoise/denoise.h"

struct image_error;

/* Three merges of the same views; packed pictures of one size, scene-linear, finite. */
struct denoise_merges {
    float *clean;         /* of views without grain; becomes the result */
    const float *grainy;  /* of views with their grain */
    const float *flipped; /* of views that denoise_flip() made */
    int32_t width, height;
    int n_channels; /* the first three, or the only one, are colours */
    float white;    /* luminance that is shown as white, a power of two */
    int n_threads;
};

/*
 * Adds the grain of view `index` again, with random signs:
 * grainy + s (grainy - clean) + white / 4, at least 0, into `grainy`; s is 1 or -1, the
 * same for all channels of a pixel, and for 4 x 4 px where pixels side by side have grain
 * that is alike. What is added has the strength of the grain and nothing that differs in
 * the same way in many pixels and views. Alpha stays as it is. All values are finite.
 */
void denoise_flip(const struct denoise_picture *grainy, const float *clean, int index);

/* False where memory is missing: `clean` is then what it was. */
bool denoise_mix(const struct denoise_merges *merges, struct image_error *error);

#endif
