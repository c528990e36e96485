/* SPDX-License-Identifier: Apache-2.0 */
/* The generator lowres. */
#ifndef RF_METHODS_PREVIEW_LOWRES_H
#define RF_METHODS_PREVIEW_LOWRES_H

#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_lowres(const struct rf_blur *blur, struct rf_error *error);

#endif
