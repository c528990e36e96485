/* SPDX-License-Identifier: Apache-2.0 */
/* Depth of what is seen through flat clear glass. */
#ifndef POVRAY_THROUGH_H
#define POVRAY_THROUGH_H

#include "scene.h"

/* Where the user asked for it, renders three fogs more, lit and black, and the light of
 * the first surfaces, and gives flat surfaces that let through or mirror half of the
 * light, or show little else, the depth of what is seen there: the length of the ray's
 * whole way, planar. passes->depth is that of the first surface before; a warning says
 * where nothing has changed. Where it was not asked for, a warning says where it would
 * count (warns_by_look), of the first view. mode: of the copy whose depth was taken.
 * False with a message where a render failed. */
bool through_look(struct povray_scene *scene, const struct shot *shot,
                  enum rewrite_mode mode, struct povray_passes *passes,
                  struct povray_error *error);

#endif
