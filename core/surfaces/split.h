/* SPDX-License-Identifier: Apache-2.0 */
/* Edge pixels split into their two surfaces. */
#ifndef RF_SURFACES_SPLIT_H
#define RF_SURFACES_SPLIT_H

#include <stdbool.h>

#include "kernels/data.h"
#include "surfaces/splitter.h"
#include "rackfocus/rackfocus.h"

rf_result rf_split_begin(struct rf_splitter *s, struct rf_error *error);

/* False: out of memory. */
bool rf_split_row(struct rf_splitter *s, int y, int thread);

/*
 * The plane of radii becomes that of the near parts, INFINITY where their share is not
 * above RF_OCCLUDER_SHARE. The pixels become the near parts, and pixels->at is lost.
 */
rf_result rf_split_end(struct rf_splitter *s, struct rf_error *error);

/* The radius of pixel (x, y) as it came, which the splitter has kept. */
float rf_split_radius_at(const struct rf_pixels *p, int x, int y);

void rf_split_free(struct rf_splitter *s);

#endif
