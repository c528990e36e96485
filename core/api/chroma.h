/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that are made colour by colour. */
#ifndef RF_API_CHROMA_H
#define RF_API_CHROMA_H

#include <stdbool.h>

#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* Makes the picture of a frame; see rf_filter_process(). */
typedef rf_result (*rf_process_fn)(const struct rf_frame *frame,
                                   const struct rf_view *views, int n_views,
                                   const struct rf_image *out,
                                   const struct rf_progress *progress,
                                   struct rf_error *error);

/* Do the colours of a picture of so many channels differ in their lens? */
bool rf_chroma_is_on(const struct rf_frame *frame, int n_channels);

/* What makes them differ, where they do: the field that an error names. */
const char *rf_chroma_field(const struct rf_frame *frame);

/* Makes them with `process`, each with its own lens; arguments are in order. */
rf_result rf_chroma_process(const struct rf_frame *frame, const struct rf_view *views,
                            int n_views, const struct rf_image *out,
                            const struct rf_progress *progress, rf_process_fn process,
                            struct rf_error *error);

#endif
