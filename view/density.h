/* SPDX-License-Identifier: Apache-2.0 */
/* How dense the display is. */
#ifndef VIEW_DENSITY_H
#define VIEW_DENSITY_H

#include <SDL.h>

/* Dots per inch that letters should have: what the user has set (X resource Xft.dpi),
 * else what the display says of its size, else 96. */
double density_find_dpi(SDL_Window *window);

#endif
