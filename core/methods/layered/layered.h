/* SPDX-License-Identifier: Apache-2.0 */
/* The method layered, of every quality but preview. */
#ifndef RF_METHODS_LAYERED_LAYERED_H
#define RF_METHODS_LAYERED_LAYERED_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_layered_run(struct rf_work *work, struct rf_error *error);

#endif
