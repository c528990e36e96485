/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of which a part is seen in mirrors or through glass. */
#ifndef RF_API_SEEN_H
#define RF_API_SEEN_H

#include "api/chroma.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* Are the pixels of a light good beside those of its view? Its depth may be any. */
rf_result rf_seen_check_light(const struct rf_frame *frame, const struct rf_view *view,
                              const struct rf_seen_light *light,
                              struct rf_error *error);

rf_result rf_seen_check(const struct rf_frame *frame, const struct rf_view *views,
                        int n_views, struct rf_error *error);

/* Makes the picture of views that have such lights with `process`. */
rf_result rf_seen_process(const struct rf_frame *frame, const struct rf_view *views,
                          int n_views, const struct rf_image *out,
                          const struct rf_progress *progress, rf_process_fn process,
                          struct rf_error *error);

#endif
