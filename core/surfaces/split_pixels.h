/* SPDX-License-Identifier: Apache-2.0 */
/* What splitting (split.c, split_fringe.c) looks at: pixels as they came. */
#ifndef RF_SURFACES_SPLIT_PIXELS_H
#define RF_SURFACES_SPLIT_PIXELS_H

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <stdint.h>

#include "base/math.h"
#include "kernels/data.h"
#include "surfaces/surfaces.h"

/* How far splitting looks: rows and columns, and the places of 5 x 5 pixels. */
enum { RF_SPLIT_REACH = 3, RF_SPLIT_STEPS = 5 * 5 };

static const float RF_LEAST_SHARE =
    1e-6f; /* smaller ones are none: colours are divided */
static const float RF_HIGHLIGHT_RATIO = 8; /* highlight over its surroundings */
static const float RF_HIGHLIGHT_OVER_FRINGE = 1.3f;

typedef int32_t rf_truths __attribute__((vector_size(16))); /* of a rf_quad */

/* The pixels around one. */
struct rf_split_window {
    int x0, x1, y0, y1; /* inclusive, clipped to the picture */
};

static inline struct rf_split_window rf_split_window_at(const struct rf_pixels *p,
                                                        int x, int y, int reach)
{
    return (struct rf_split_window){
        rf_max_int(x - reach, 0), rf_min_int(x + reach, p->width - 1),
        rf_max_int(y - reach, 0), rf_min_int(y + reach, p->height - 1)};
}

static inline const struct rf_surface *rf_split_pixel(const struct rf_pixels *p, int x,
                                                      int y)
{
    return p->at + (size_t)y * (size_t)p->width + (size_t)x;
}

static inline float rf_split_luminance(const struct rf_surface *s)
{
    return rf_luminance(s->c[0], s->c[1], s->c[2]);
}

static inline float rf_split_distance_weight(int dx, int dy)
{
    return 1.0f / (0.5f + (float)(dx * dx + dy * dy));
}

static inline void rf_split_insert_sorted(float *sorted, int n, float v)
{
    for (; n > 0 && sorted[n - 1] > v; n--)
        sorted[n] = sorted[n - 1];
    sorted[n] = v;
}

static inline float rf_split_share_of(float v)
{
    float share = rf_clamp01(v);
    return share < RF_LEAST_SHARE ? 0 : share;
}

/* How a pixel lies between two surfaces. */
struct rf_split_position {
    float unit; /* by which colours are multiplied, before they are squared */
    float dot, norm, size; /* (c - b) . e, |e|^2, the sum of f and b */
};

static inline struct rf_split_position rf_split_position_in(const struct rf_surface *c,
                                                            const struct rf_surface *f,
                                                            const struct rf_surface *b,
                                                            float unit)
{
    struct rf_split_position p = {.unit = unit};
    for (int n = 0; n < 4; n++) {
        float d = unit * (f->c[n] - b->c[n]);
        p.dot += unit * (c->c[n] - b->c[n]) * d;
        p.norm += d * d;
        p.size += n < 3 ? unit * (f->c[n] + b->c[n]) : 0;
    }
    return p;
}

/* In a unit in which nothing overflows, a power of two, so that no digit changes. */
static inline struct rf_split_position rf_split_position_of(const struct rf_surface *c,
                                                            const struct rf_surface *f,
                                                            const struct rf_surface *b)
{
    struct rf_split_position p = rf_split_position_in(c, f, b, 1);
    return p.norm + fabsf(p.dot) < FLT_MAX / 4
               ? p
               : rf_split_position_in(c, f, b, RF_UNIT_TO_SQUARE);
}

#endif
