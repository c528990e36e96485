/* SPDX-License-Identifier: Apache-2.0 */
/* The method layered with quality preview. */
#ifndef RF_METHODS_LAYERED_LAYERED_PREVIEW_H
#define RF_METHODS_LAYERED_LAYERED_PREVIEW_H

#include <stdbool.h>

#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

rf_result rf_layered_preview_run(struct rf_work *work, struct rf_error *error);

/*
 * The preview straight from the caller's pixels, plain RGBA, to his, without the planes
 * of the picture: work->colour is not used. *is_done is false where the pixels are not
 * so simple: not finite, or partly transparent without depth.
 */
rf_result rf_layered_preview_stream(struct rf_work *work, const struct rf_image *from,
                                    const struct rf_image *to, bool *is_done,
                                    struct rf_error *error);

#endif
