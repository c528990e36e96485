/* SPDX-License-Identifier: Apache-2.0 */
/* Histogram and waveform of an 8 bit picture as it is shown. */
#ifndef VIEW_SCOPES_H
#define VIEW_SCOPES_H

#include <stdint.h>

enum { SCOPES_COLUMNS = 128, SCOPES_LEVELS = 64 };

struct scopes {
    uint32_t histogram[3][256]; /* px of each code; R, G, B */
    uint32_t most;              /* the largest of them, the two ends left out */
    double black, white;        /* shares of the px that have a channel at an end */
    uint32_t n;                 /* px that were counted */
    /* Luma (Rec. 709): px of each part of the width and each level, 0 the darkest; the
     * largest. */
    uint32_t waveform[SCOPES_COLUMNS][SCOPES_LEVELS], most_waveform;
};

/* Of a large picture every so many px in both directions are taken. */
void scopes_count(struct scopes *scopes, const uint8_t *rgba, int32_t width,
                  int32_t height);

#endif
