/* SPDX-License-Identifier: Apache-2.0 */
/* Light of things smaller than a sample, which anti-aliasing loses. */
#ifndef POVRAY_SPARSE_H
#define POVRAY_SPARSE_H

#include "scene.h"

/* Adds a warning where the colour of the passes has much less light than `base`, a
 * picture of the same size (RGBA) with one ray in each sample, in places that are dark
 * but for few bright samples. */
void sparse_look(struct povray_passes *passes, const float *base,
                 const struct decode_space *space);

#endif
