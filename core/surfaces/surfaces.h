/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of surfaces, and the pixels that they are made from. */
#ifndef RF_SURFACES_SURFACES_H
#define RF_SURFACES_SURFACES_H

#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "base/math.h"
#include "kernels/data.h"
#include "rackfocus/rackfocus.h"

/* Of a pixel, for its near part to count as something that stands before others. */
static const float RF_OCCLUDER_SHARE = 0.02f;

/*
 * The farther parts of a picture have room once all mixed pixels are marked, which any
 * thread does: rf_far_begin(), rf_far_mark(), rf_far_allocate().
 */
rf_result rf_far_begin(struct rf_surfaces *s, const struct rf_context *context,
                       struct rf_error *error);

static inline void rf_far_mark(struct rf_surfaces *s, size_t i)
{
    __atomic_fetch_or(&s->mixed[i / 64].bits, (uint64_t)1 << i % 64, __ATOMIC_RELAXED);
}

rf_result rf_far_allocate(struct rf_surfaces *s, const struct rf_context *context,
                          struct rf_error *error);

void rf_far_free(struct rf_surfaces *s, const struct rf_context *context);

/*
 * What the edges of the picture are split from: pixels as they came. The planes repeat
 * the edge of the picture for RF_ROW_MARGIN floats before each row of `stride`, and at
 * least as many after it.
 */
struct rf_pixels {
    int width, height;
    struct rf_surface *at; /* packed */
    size_t stride;
    float *luminance;
    float *radius;
    /* Where edges are split: the radii of split pixels as they came, or NULL. */
    struct rf_split_radius *split;
    size_t *split_row; /* where each row's begin, height + 1 */
    /* Packed: which pixel each one beyond the border goes on from. Or NULL. */
    size_t *source;
};

/* Of a row these lie from left to right. */
struct rf_split_radius {
    int x;
    float r;
};

/* First pixel of a row of a plane. */
static inline float *rf_plane_row(const struct rf_pixels *p, float *plane, int y)
{
    return plane + p->stride * (size_t)y + RF_ROW_MARGIN;
}

/* The rows y - reach to y + reach of a plane, those outside repeating its edge. */
static inline void rf_plane_rows(const struct rf_pixels *p, float *plane, int y,
                                 int reach, const float *rows[])
{
    for (int k = -reach; k <= reach; k++)
        rows[k + reach] =
            rf_plane_row(p, plane, rf_min_int(rf_max_int(y + k, 0), p->height - 1));
}

/* A bit for each pixel of a row, in whole words: how many. */
static inline size_t rf_row_words(int width)
{
    return ((size_t)width + 63) / 64;
}

#endif
