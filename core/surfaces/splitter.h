/* SPDX-License-Identifier: Apache-2.0 */
/* What splits the mixed pixels of a picture (split.c) and what it has. */
#ifndef RF_SURFACES_SPLITTER_H
#define RF_SURFACES_SPLITTER_H

#include <stdbool.h>
#include <stdint.h>

#include "base/arena.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "surfaces/split_pixels.h"
#include "surfaces/surfaces.h"
#include "rackfocus/rackfocus.h"

/*
 * Splits mixed pixels into their two surfaces (split.c), if the parameters say so, row
 * by row: a row may be split once the RF_SPLIT_REACH rows to both sides of it are
 * loaded. rf_split_begin(), rf_split_row() for each row, any thread, rf_split_end();
 * rf_split_free() in any case. The pixels stay as they are until the end.
 */
struct rf_splitter {
    const struct rf_frame *frame;
    bool keeps_radii; /* as they came */
    bool is_alone;    /* the only view: others do not show what a thin thing hides */
    /* Mean distances as in rf_view, the first of pixel (x0, y0); NULL: none. */
    const struct rf_image *mean_depth;
    int x0, y0;
    struct rf_pixels *pixels;
    struct rf_surfaces *out;
    /*
     * Receives the least luminance of the 5 x 5 pixels around each, as a plane like
     * that of the luminance, without its margins; if edges are split.
     */
    float *darkest;
    /* Receives a bit for each pixel that shows more luminance than `bright`. */
    uint64_t *possible_highlights;
    float bright;
    /* Its own: */
    int32_t steps[RF_SPLIT_STEPS]; /* from a pixel to the 5 x 5 around it */
    float *rows;
    struct rf_split_row *splits;
    struct rf_arena arena;
    struct rf_room *rooms;
};

#endif
