/* SPDX-License-Identifier: Apache-2.0 */
/* The filter object. */
#ifndef RF_API_FILTER_H
#define RF_API_FILTER_H

#include "input/frame.h"
#include "input/bokeh.h"

/* Immutable: what works on a part of the picture does so with a frame of its own. */
struct rf_filter {
    struct rf_frame frame;         /* of the whole picture */
    struct rf_bokeh *bokeh, *ring; /* its own; NULL: none */
};

#endif
