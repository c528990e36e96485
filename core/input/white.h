/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures whose white is not 1, brought there and back. */
#ifndef RF_INPUT_WHITE_H
#define RF_INPUT_WHITE_H

#include <stddef.h>

#include "base/context.h"
#include "input/frame.h"
#include "rackfocus/rackfocus.h"

/* Views with their light as it is where white is 1, and the frame that goes with it. */
struct rf_whitened {
    struct rf_frame frame;
    struct rf_view views[RF_MAX_VIEWS];
    const struct rf_context *context;
    void *memory[(4 + RF_MAX_SEEN) * RF_MAX_VIEWS];
    int n_memory;
};

/*
 * Where the frame's white is 1 the views are those that were given; else their light is
 * copied, times a power of two. rf_whitened_free() in any case.
 */
rf_result rf_whiten(struct rf_whitened *w, const struct rf_frame *frame,
                    const struct rf_view *views, int n, struct rf_error *error);
void rf_whitened_free(struct rf_whitened *w);

/* Brings a picture of such views back, in place. */
void rf_unwhiten(const struct rf_frame *frame, const struct rf_image *out);

/* Bytes that rf_whiten() takes for each pixel of a view. */
size_t rf_whitened_bytes(const struct rf_frame *frame);

#endif
