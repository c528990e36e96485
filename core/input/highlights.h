/* SPDX-License-Identifier: Apache-2.0 */
/* Highlights as the artist wants them, before the light reaches the lens. */
#ifndef RF_INPUT_HIGHLIGHTS_H
#define RF_INPUT_HIGHLIGHTS_H

#include <stdbool.h>

#include "rackfocus/rackfocus.h"

/* Does any parameter change highlights? */
bool rf_highlights_are_changed(const struct rf_params *params);

/* Changes a pixel of linear light: grey where n_channels is 1, else RGB at first. */
void rf_highlights_change(const struct rf_params *params, float *c, int n_channels);

#endif
