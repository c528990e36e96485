/* SPDX-License-Identifier: Apache-2.0 */
/* Masks of lights whose discs are not drawn where their lens points are. */
#ifndef RF_COMPOSE_BENT_MASKS_H
#define RF_COMPOSE_BENT_MASKS_H

#include "compose/scene.h"
#include "kernels/data.h"

/*
 * Has every pixel of a mask ask where its lens point would be without aberration and
 * with one radius for the whole disc. `plain` has room for the mask.
 */
void rf_mask_bend(const struct rf_scene *scene, const struct rf_shadows *m,
                  float *plain);

#endif
