/* SPDX-License-Identifier: Apache-2.0 */
/* The method layered of deep frames. */
#ifndef RF_METHODS_LAYERED_DEEP_H
#define RF_METHODS_LAYERED_DEEP_H

#include "base/task.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* rf_filter_process_deep() and rf_deep_flatten(), of arguments that are in order. */
rf_result rf_deep_run(const struct rf_frame *frame, const struct rf_deep *deep,
                      const struct rf_image *out, struct rf_task *task,
                      struct rf_error *error);
rf_result rf_deep_flatten_to(const struct rf_frame *frame, const struct rf_deep *deep,
                             const struct rf_image *colour,
                             const struct rf_image *depth, struct rf_error *error);

#endif
