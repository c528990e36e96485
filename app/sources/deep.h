/* SPDX-License-Identifier: Apache-2.0 */
/* Deep EXR files as frames for the core. */
#ifndef APP_DEEP_H
#define APP_DEEP_H

#include "rackfocus/rackfocus.h"
#include "sources/source.h"

struct deep_frame {
    struct rf_deep frame;
    size_t *first;
    struct rf_deep_sample *samples;
};

/*
 * Reads the deep samples of a source. `holdout` (may be NULL) is another deep file of
 * the same size whose samples hide and show nothing. False with a message.
 */
bool deep_read(struct deep_frame *deep, const struct source *source,
               const char *holdout, int n_threads, struct image_error *error);
void deep_free(struct deep_frame *deep);

/*
 * The flat picture of a frame: colour with source->n_channels, depth with one; either
 * may be NULL. RF_OK or the core's error.
 */
rf_result deep_flatten(const struct deep_frame *deep, const struct rf_filter *filter,
                       const struct source *source, float *colour, float *depth,
                       struct rf_error *error);

#endif
