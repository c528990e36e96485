/* SPDX-License-Identifier: Apache-2.0 */
/* The methods of the real-time family. */
#ifndef RF_METHODS_PREVIEW_PREVIEW_H
#define RF_METHODS_PREVIEW_PREVIEW_H

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

/* The methods: each generator with the blend that the parameters name. */
rf_result rf_box_run(struct rf_work *work, struct rf_error *error);

rf_result rf_lowres_run(struct rf_work *work, struct rf_error *error);

rf_result rf_mipmap_run(struct rf_work *work, struct rf_error *error);

rf_result rf_mipmap_offset_run(struct rf_work *work, struct rf_error *error);

rf_result rf_offset_run(struct rf_work *work, struct rf_error *error);

rf_result rf_recursive_offset_run(struct rf_work *work, struct rf_error *error);

#endif
