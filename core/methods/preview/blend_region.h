/* SPDX-License-Identifier: Apache-2.0 */
/* The blend region. */
#ifndef RF_METHODS_PREVIEW_BLEND_REGION_H
#define RF_METHODS_PREVIEW_BLEND_REGION_H

#include "methods/preview/leak.h"
#include "rackfocus/rackfocus.h"

rf_result rf_blend_region(struct rf_preview *preview, struct rf_error *error);

#endif
