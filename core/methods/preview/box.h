/* SPDX-License-Identifier: Apache-2.0 */
/* The generator box. */
#ifndef RF_METHODS_PREVIEW_BOX_H
#define RF_METHODS_PREVIEW_BOX_H

#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_box(const struct rf_blur *blur, struct rf_error *error);

#endif
