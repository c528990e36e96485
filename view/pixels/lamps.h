/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Highlights of previews. The previews of the method scatter gather: a pixel is blurred
 * by its own circle of confusion, so that a lamp before the focus stays a bright core in
 * a pale disc, and a lamp far behind it becomes a square of a coarser level. Here the
 * light that lamps have more than what surrounds them is taken off before the preview
 * and put back as discs after it, as scatter does with every pixel:
 *
 *   out(p) += sum over lamps  excess D(t) / sum D,    t = |p - lamp|^2 / r^2 <= 1
 *
 * with the densities D of core/methods/scatter. What is approximate: no disc hides or is
 * hidden, and at most LAMPS_MAX lamps and LAMPS_MOST_PX px of discs are drawn, those with
 * the most light first; the others stay in the picture.
 */
#ifndef VIEW_LAMPS_H
#define VIEW_LAMPS_H

#include <stdbool.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

enum {
    LAMPS_MAX = 2048,
    LAMPS_MOST_PX = 1500000, /* some 4 ms on one core */
};

struct lamp {
    int32_t x, y;
    double radius; /* px */
    float excess[3];
};

struct lamps {
    int n;
    struct lamp *items;
    int32_t distribution; /* RF_DISTRIBUTION_*; that of a picture is drawn as uniform */
};

/* What is blurred: colour of 3 or 4 channels, packed; it is changed, by what the lamps
 * have more. `radius` (px, signed) is that of each px. False without memory, then
 * nothing has changed. */
bool lamps_take(struct lamps *lamps, float *colour, int n_channels, const float *radius,
                int32_t width, int32_t height);
void lamps_free(struct lamps *lamps);

/* Adds the discs to the blurred picture. */
void lamps_add(const struct lamps *lamps, float *colour, int n_channels, int32_t width,
               int32_t height);

#endif
