/* SPDX-License-Identifier: Apache-2.0 */
/* Where a picture is the inside of surfaces, behind which no lens sees. */
#ifndef RF_SURFACES_INSIDES_H
#define RF_SURFACES_INSIDES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lens/aperture.h"

struct rf_hidden_facts;
struct rf_inside_edges;

/* What is known of a picture; no blocks: nothing. */
struct rf_insides {
    struct rf_hidden_facts *blocks; /* n_x x n_y of RF_HIDDEN_BLOCK pixels a side */
    struct rf_inside_edges *edges;  /* of the same blocks */
    int n_x, n_y;
    float extent; /* half of the aperture's, px per px of radius; INFINITY: no blocks */
    struct rf_reach reach; /* of the aperture from where the picture was taken */
    /* Of the near surfaces, INFINITY for none, in rows of stride; NULL: not at hand, or
     * spherical aberration bends the rays. */
    const float *radius;
    size_t stride;
    int width, height;
    int border; /* px beyond the picture that count for no surface: others show them */
};

/*
 * The radius behind which nothing is seen through any pixel of block (bx, by); INFINITY:
 * that is not known.
 */
float rf_inside_radius(const struct rf_insides *insides, int bx, int by);

/* Where rays of the pixel that asked before came through, if any: most often those of the
 * next one do, too. Begins as {0}. */
struct rf_inside_hint {
    int x, y;
    bool is_known;
};

/*
 * The pixels of block (bx, by) that may be met before radius r, bits as in struct
 * rf_inside_edges: where a surface ends, the ray through the lens' own point comes past
 * it; where a block without an end goes on beyond r, it may come there.
 */
uint64_t rf_inside_may_be_met(const struct rf_insides *insides, float shift, int bx,
                              int by, float r);

/*
 * Have all rays that come to a pixel, which is before the focus, met something before the
 * depth of radius r? Of those pixels of block (bx, by) that ask, the ones of which that
 * is so. It asks nearer to edges than a block can.
 * `shift` is added to all radii. The answer does not depend on the hint.
 */
uint64_t rf_inside_find_met(const struct rf_insides *insides, float shift, int bx,
                            int by, uint64_t asking, float r,
                            struct rf_inside_hint *hint);

/* Those of which the hint does not tell at once that it is not so. */
uint64_t rf_inside_drop_hinted(const struct rf_insides *insides, float shift, int bx,
                               int by, uint64_t asking, float r,
                               struct rf_inside_hint *hint);

#endif
