/* SPDX-License-Identifier: Apache-2.0 */
/* Samples of surfaces in, the picture through the lens out. */
#ifndef RF_COMPOSE_COMPOSITE_H
#define RF_COMPOSE_COMPOSITE_H

#include "compose/scene.h"
#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

/*
 * Composites the scene, crops the border and writes the image of `work`, its colours,
 * or gives it planes where it has neither (rf_work_drop_views()). Where nothing reached
 * a pixel it is 0, unless gaps are filled.
 */
rf_result rf_composite_crop(struct rf_scene *scene, struct rf_work *work,
                            struct rf_error *error);

#endif
