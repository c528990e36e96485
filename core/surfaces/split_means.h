/* SPDX-License-Identifier: Apache-2.0 */
/* What mean distances tell of mixed pixels (docs/algorithm.md, Mean distances). */
#ifndef RF_SURFACES_SPLIT_MEANS_H
#define RF_SURFACES_SPLIT_MEANS_H

#include <stdbool.h>
#include <stdint.h>

#include "surfaces/split_around.h"
#include "surfaces/splitter.h"
#include "surfaces/surfaces.h"

/*
 * Of edges: up to here from the focus, in px of radius, pure pixels tell more than blur
 * hides. Half: cards -0.03; none: grass -0.07, portrait of 4 views -0.14.
 */
static const float RF_SPLIT_SHARP_PX = 2;

/*
 * The pixels of a set around (x, y) that show one surface alone: their mean distance is
 * that of their sample, or 0 before nothing. None where mean distances are not known.
 * nearest_radius: of the nearest surface around, px.
 */
uint32_t rf_split_find_pure(const struct rf_splitter *s,
                            const struct rf_split_around *around, uint32_t bits,
                            float nearest_radius, int x, int y);

/*
 * Share of the near surface of pixel (x, y), 0 to 1, by the mean distance of its
 * samples; NAN: not known, or another surface is there too. Where the far side is a
 * surface before nothing (a twig before the sky) the colour of m->b becomes their mixture
 * in this pixel.
 */
float rf_split_measured_share(const struct rf_splitter *s,
                              const struct rf_split_around *around,
                              struct rf_meeting *m, int x, int y);

/*
 * Do mean distances tell which pixels around (x, y) are whole: both surfaces near the
 * focus have a pure one, or half of the pixels within both are? In fog they do not.
 */
bool rf_split_are_told_whole(const struct rf_splitter *s,
                             const struct rf_split_around *around,
                             const struct rf_meeting *m, int x, int y);

#endif
