/* SPDX-License-Identifier: Apache-2.0 */
/* Places of a picture that are worth a look from near. */
#ifndef CLI_METHODS_DETAILS_H
#define CLI_METHODS_DETAILS_H

#include <stdbool.h>

#include "pages/canvas.h"

enum { N_DETAILS = 2 };

/*
 * Sets both boxes, of box_width x box_height px at most: where most pixels are exposed
 * to leaks (edges of what is in focus), and where the lens changes the pinhole picture
 * most, beside the first if there is room. False without memory.
 */
bool methods_find_details(const unsigned char *is_exposed,
                          const struct canvas_picture *pinhole,
                          const struct canvas_picture *reference, int32_t box_width,
                          int32_t box_height, struct canvas_box details[N_DETAILS]);

#endif
