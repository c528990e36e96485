/* SPDX-License-Identifier: Apache-2.0 */
/* The generator mipmap-offset. */
#ifndef RF_METHODS_PREVIEW_MIPMAP_OFFSET_H
#define RF_METHODS_PREVIEW_MIPMAP_OFFSET_H

#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_mipmap_offset(const struct rf_blur *blur, struct rf_error *error);

#endif
