/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that are made of pictures of one focus each: those of a split diopter. */
#ifndef RF_API_FOCUSES_H
#define RF_API_FOCUSES_H

#include <stdbool.h>

#include "api/chroma.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* Is the picture of a frame made so? Previews are not: they take a radius by place. */
bool rf_focuses_are_on(const struct rf_frame *frame);

/* Makes it of pictures of `process`, whose frames may be a part; arguments in order. */
rf_result rf_focuses_process(const struct rf_frame *frame, const struct rf_view *views,
                             int n_views, const struct rf_image *out,
                             const struct rf_progress *progress, rf_process_fn process,
                             struct rf_error *error);

#endif
