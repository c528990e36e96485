/* SPDX-License-Identifier: Apache-2.0 */
/* What several views show alike: the radius at which their pictures agree. */
#ifndef RF_INPUT_SEEN_MATCH_H
#define RF_INPUT_SEEN_MATCH_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/context.h"
#include "rackfocus/rackfocus.h"

/*
 * One view. What has the radius r lies slope r + base px right and down of where the
 * first view has it.
 */
struct rf_seen_view {
    /* Red, green, blue of each pixel, 0 to 1, as the eye tells them apart; below 0
     * where the view shows nothing of what is looked for. */
    const float *tones;
    double slope[2], base[2];
};

struct rf_seen_problem {
    int width, height;
    int n_views; /* and one: the first is the one whose radii are wanted */
    const struct rf_seen_view *views;
    const float *surface; /* radii of the surfaces of the first view, px */
    float first, step;    /* radii that are tried: first + k step, .. */
    int n_radii;          /* .. k = 0 .. n_radii - 1, at least 3 */
};

/* The most radii that may be tried. */
enum { RF_SEEN_MOST_RADII = 512 };

/* Bytes that it needs. */
size_t rf_seen_match_bytes(const struct rf_seen_problem *problem);

/* Does the first view show something at pixel i? */
static inline bool rf_seen_is_lit(const struct rf_seen_problem *p, size_t i)
{
    return p->views[0].tones[3 * i] >= 0;
}

/* Do two pixels show the same mirror? Their surfaces are 1 px of radius apart at the
 * most. */
static inline bool rf_seen_are_joined(const struct rf_seen_problem *p, size_t i,
                                      size_t q)
{
    static const float EDGE_PX = 1;
    return rf_seen_is_lit(p, i) && rf_seen_is_lit(p, q) &&
           fabsf(p->surface[i] - p->surface[q]) <= EDGE_PX;
}

/* What is found, width x height each. */
struct rf_seen_match {
    float *found; /* radius of what the first view shows behind its surface; else NAN */
    float *cost;  /* how much the pictures differ on average over all radii */
    float *gain;  /* and how much less at the best one, behind the surface or not */
};

rf_result rf_seen_match(const struct rf_context *context,
                        const struct rf_seen_problem *problem,
                        const struct rf_seen_match *match, struct rf_error *error);

#endif
