/* SPDX-License-Identifier: Apache-2.0 */
/* Whether views were rendered with one seed. */
#ifndef APP_DENOISE_SEEDS_H
#define APP_DENOISE_SEEDS_H

#include <stdbool.h>

#include "denoise/denoise_share.h"

/* What to say of it. */
#define DENOISE_ONE_SEED                                                               \
    "the grain of the views is alike, as of renders with one seed, and does not "      \
    "average out; render each view with a seed of its own, far from the others"

/*
 * Is the grain of the first two views, their samples less what they are without it, in
 * made[0] and made[1], alike where they show different points? False where too little of
 * them does so to tell.
 */
bool denoise_have_one_seed(const struct share *share, float *const *made);

#endif
