/* SPDX-License-Identifier: Apache-2.0 */
/* Several views of a lens whose surface in focus is no plane. */
#ifndef RF_INPUT_FIELD_VIEWS_H
#define RF_INPUT_FIELD_VIEWS_H

#include <stdbool.h>

#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* Are so many views moved? */
bool rf_field_moves_views(const struct rf_frame *frame, int n_views);

/*
 * Moves what views show to where the lens of the frame has it, as if they had been
 * sheared to its surface in focus. `views`, in order, then have pixels in *memory,
 * which the caller frees; what is not moved keeps its own.
 */
rf_result rf_field_move_views(const struct rf_frame *frame, struct rf_view *views,
                              int n_views, float **memory, struct rf_error *error);

#endif
