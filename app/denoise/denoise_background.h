/* SPDX-License-Identifier: Apache-2.0 */
/* What lies behind all things has no grain, and keeps its colour. */
#ifndef APP_DENOISE_BACKGROUND_H
#define APP_DENOISE_BACKGROUND_H

#include "denoise/denoise.h"

/*
 * Gives the pixels of `clean`, packed like the samples of the picture, their own samples
 * again where these show the background and have no grain. `guides` as they were
 * rendered, not cleaned; all is finite.
 */
void denoise_keep_background(const struct denoise_picture *grainy,
                             const struct denoise_guides *guides, float *clean,
                             int n_threads);

#endif
