/* SPDX-License-Identifier: Apache-2.0 */
/* How the outlines of what is cut by the border go on beyond it. */
#ifndef RF_SURFACES_BORDER_OUTLINES_H
#define RF_SURFACES_BORDER_OUTLINES_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "rackfocus/rackfocus.h"

/*
 * A larger step of the radius from pixel to pixel, in px, parts two surfaces (its worth:
 * docs/notebook/border.md).
 */
static const float RF_LARGEST_STEP = 1;

static inline bool rf_is_same_surface(float a, float b)
{
    return fabsf(a - b) <= RF_LARGEST_STEP;
}

/*
 * How far beside its own line a pixel beyond the border depends on what is at the border,
 * in parts of the continued width: outlines lean by 2 px per px, the gap where surfaces
 * part is as wide as two of them make it and filled from as far as that width beside it,
 * and light is taken from twice that width (border.c).
 */
enum { RF_BESIDE_BORDER = 7 };

/* Radii, px, of lines of pixels that begin at the border. */
struct rf_border_radii {
    const float *first; /* of line 0, at the border */
    ptrdiff_t next;     /* from a line to the next one */
    ptrdiff_t inwards;  /* from a line's pixel to the next one inwards */
    int n_lines, depth; /* depth: pixels of a line that are looked at */
    int border;         /* pixels that are continued */
};

/* One surface along the border. */
struct rf_outline {
    int begin, end;   /* its lines; end: the first that is not */
    float slope[2];   /* lines per px beyond the border, of its outline at both ends */
    float n_affected; /* lines beside an end that go along with it */
};

struct rf_outlines {
    struct rf_outline *at;
    int n;
    bool are_upright; /* nothing leans: each line goes on as itself */
};

/* Finds the surfaces along the border and how their outlines lean. Freed with
 * rf_outlines_free(). Fails out of memory. */
rf_result rf_outlines_find(struct rf_outlines *outlines,
                           const struct rf_border_radii *radii,
                           const struct rf_context *context, struct rf_error *error);

void rf_outlines_free(struct rf_outlines *outlines, const struct rf_context *context);

/* Which line is seen at each one's place, k px beyond the border: n_lines of them. */
void rf_outlines_at(const struct rf_outlines *outlines,
                    const struct rf_border_radii *radii, int k, int *line);

#endif
