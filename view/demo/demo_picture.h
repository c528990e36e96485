/* SPDX-License-Identifier: Apache-2.0 */
/* The picture that hangs three times in the demo's scene. */
#ifndef VIEW_DEMO_PICTURE_H
#define VIEW_DEMO_PICTURE_H

#include <stdint.h>

#define DEMO_PICTURE_SIDE 512

/* A landscape at dusk in a striped frame, with lamps, fine lines and a test star:
 * things that show blur. sRGB encoded RGBA, DEMO_PICTURE_SIDE squared, rows from the
 * top. */
void demo_picture_paint(uint8_t *rgba);

#endif
