/* SPDX-License-Identifier: Apache-2.0 */
/* The method layered with quality preview. */
#ifndef RF_METHODS_LAYERED_LAYERED_PREVIEW_H
#define RF_METHODS_LAYERED_LAYERED_PREVIEW_H

#include <stdbool.h>

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_layered_preview_run(struct rf_work *work, struct rf_error *error);

#endif
