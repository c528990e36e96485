/* SPDX-License-Identifier: Apache-2.0 */
/* A smaller copy of a picture for previews. */
#ifndef VIEW_SHRINK_H
#define VIEW_SHRINK_H

#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* Side of the smaller picture: rounded up, so that nothing is cut off. */
int32_t shrink_side(int32_t side, int times);

/* Mean of blocks of times x times px; what is left over at the right and the bottom
 * makes smaller blocks. */
void shrink_colour(const float *in, int32_t width, int32_t height, int n_channels,
                   int times, float *out);

/* The px in the middle of each block: depths do not mix. */
void shrink_depth(const float *in, int32_t width, int32_t height, int times,
                  float *out);

/* The same lens for the smaller picture. `lens` is that of the picture itself. */
void shrink_params(struct rf_params *params, const struct rf_lens *lens, int times);

#endif
