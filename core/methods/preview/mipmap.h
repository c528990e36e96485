/* SPDX-License-Identifier: Apache-2.0 */
/* The generator mipmap. */
#ifndef RF_METHODS_PREVIEW_MIPMAP_H
#define RF_METHODS_PREVIEW_MIPMAP_H

#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_mipmap(const struct rf_blur *blur, struct rf_error *error);

#endif
