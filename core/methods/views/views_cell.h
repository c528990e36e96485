/* SPDX-License-Identifier: Apache-2.0 */
/* The picture through one cell of the lens. */
#ifndef RF_METHODS_VIEWS_VIEWS_CELL_H
#define RF_METHODS_VIEWS_VIEWS_CELL_H

#include "methods/views/merge.h"
#include "rackfocus/rackfocus.h"

/*
 * Adds the picture through the cell to its sum. Its samples and estimates are to be
 * freed in any case.
 */
rf_result rf_view_cell_run(struct rf_view_cell *cell, double progress_to,
                           struct rf_error *error);

#endif
