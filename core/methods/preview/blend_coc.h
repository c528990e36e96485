/* SPDX-License-Identifier: Apache-2.0 */
/* The blend coc. */
#ifndef RF_METHODS_PREVIEW_BLEND_COC_H
#define RF_METHODS_PREVIEW_BLEND_COC_H

#include "methods/preview/leak.h"
#include "rackfocus/rackfocus.h"

rf_result rf_blend_coc(struct rf_preview *preview, struct rf_error *error);

#endif
