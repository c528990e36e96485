/* SPDX-License-Identifier: Apache-2.0 */
/* The generator recursive-offset. */
#ifndef RF_METHODS_PREVIEW_RECURSIVE_OFFSET_H
#define RF_METHODS_PREVIEW_RECURSIVE_OFFSET_H

#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_recursive_offset(const struct rf_blur *blur,
                                       struct rf_error *error);

#endif
