/* SPDX-License-Identifier: Apache-2.0 */
/* Blocks of pixels that the search for hidden background (hidden.c) looks through. */
#ifndef RF_SURFACES_HIDDEN_BLOCKS_H
#define RF_SURFACES_HIDDEN_BLOCKS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "kernels/data.h"
#include "kernels/hidden_kernels.h"
#include "kernels/kernels.h"
#include "surfaces/hidden_lines.h"

/* Blocks a side of an area: what a search reaches lies in it and those around. */
enum { RF_HIDDEN_AREA = RF_HIDDEN_RINGS };

struct rf_known;
struct rf_estimates;

struct rf_hidden_facts {
    float highest; /* radius of the usable surfaces; -INFINITY where there is none */
    float lowest;  /* radius of the near surfaces */
    float step; /* radius of the near side of a step; -INFINITY where there is none */
    /*
     * Of the blocks above and to the left, with this one: how many are rough, that is
     * hold or touch an edge or a slope that could have candidates.
     */
    int n_rough;
    bool has_mixed; /* pixels */
};

/* The pixels of a block where a surface ends. */
struct rf_inside_edges {
    uint64_t bits; /* i + 8 j for column i of row j */
    float lowest;  /* radius of their near surfaces */
};

struct rf_hidden_search {
    const struct rf_surfaces *s;
    const struct rf_known *known; /* or NULL */
    const struct rf_kernels *kernels;
    struct rf_backs backs;
    struct rf_estimates *out;
    const struct rf_context *context;
    int n_x, n_y;
    bool has_radii; /* the plane of radii holds those that came, not backs */
    struct rf_hidden_facts *blocks;
    struct rf_inside_edges *edges;
    uint32_t *rough; /* bits of rough blocks, in rows of n_words */
    int n_words;
    float *
        highest; /* radius of RF_HIDDEN_AREA x RF_HIDDEN_AREA blocks and the areas around them */
    float inv_x2, inv_y2; /* 1 / extent^2 */
    double extent[2];     /* half extent of the aperture in px per px of radius */
    float gap2[2][RF_HIDDEN_RINGS + 1]; /* along each axis, see gap2_of() in hidden.c */
    struct rf_hidden_lines lines;
};

/* The surface that pixel i shows behind others; NULL where it is unreliable. */
static inline const struct rf_surface *rf_hidden_back(const struct rf_surfaces *s,
                                                      size_t i)
{
    float a = s->share[i];
    if (a >= 1)
        return &s->near[i];
    return a > 0.9f ? NULL : rf_far_at(s, i);
}

/* The radii that a row of pixels shows behind others. */
static inline float *rf_hidden_row(const struct rf_hidden_search *search, int y)
{
    return search->backs.r + search->backs.stride * (size_t)y;
}

static inline int rf_hidden_n_areas(int n_blocks)
{
    return (n_blocks + RF_HIDDEN_AREA - 1) / RF_HIDDEN_AREA;
}

/* Is one of the n_x x n_y blocks within `reach` blocks of block (bx, by) rough? */
bool rf_hidden_has_rough(const struct rf_hidden_facts *blocks, int n_x, int n_y, int bx,
                         int by, int reach);

/* Fills the rows of radii (if they are not at hand) and all that is known of blocks. */
void rf_hidden_measure(struct rf_hidden_search *search, bool has_radii);
/* The radii of a row become those of the near surfaces again. */
void rf_hidden_restore_row(const struct rf_hidden_search *search, int y);

#endif
