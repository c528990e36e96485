/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The four graphs of Yu 2004: the circle of confusion of a thing over the aperture, the
 * position of the screen, the focal length and the distance of the thing, one of them
 * changed at a time. The values are the core's, from rf_lens_radius_px() with optics yu.
 */
#ifndef VIEW_GRAPHS_H
#define VIEW_GRAPHS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

/* X(NAME, "label of the axis") */
#define GRAPH_AXES(X)                                                                  \
    X(APERTURE, "aperture a, mm")                                                      \
    X(SCREEN, "screen position s, mm")                                                 \
    X(FOCAL, "focal length f, mm")                                                     \
    X(DISTANCE, "distance d, scene units")
#define GRAPH_ENUM(name, label) GRAPH_##name,
enum graph_axis { GRAPH_AXES(GRAPH_ENUM) N_GRAPHS };
#undef GRAPH_ENUM

enum { GRAPH_STEPS = 240, GRAPH_MOST_TICKS = 6 };

struct graph {
    const char *label;
    double from, to;        /* of the axis */
    double now, now_px;     /* what is set, and the diameter that it gives */
    double sharp;           /* where the diameter is 0; NAN: nowhere within the axis */
    double px[GRAPH_STEPS]; /* diameters at equal steps from `from` to `to` */
    double top_px;          /* the largest of them */
    double ticks[GRAPH_MOST_TICKS], ticks_px[GRAPH_MOST_TICKS];
    int n_ticks, n_ticks_px;
};

/*
 * `params` with a focal length, for a picture of width x height px; `distance` of the
 * thing in scene units, above 0 and finite. False with a reason where there is no
 * such lens: orthographic, without millimetres, focused inside its focal length.
 */
bool graph_make(enum graph_axis axis, const struct rf_params *params, int32_t width,
                int32_t height, double distance, struct graph *graph, char *why_not,
                size_t n_bytes);

/* Multiples of 1, 2 or 5 times a power of ten within [from, to], at most
 * GRAPH_MOST_TICKS and at least two; returns how many. */
int graph_ticks(double from, double to, double *ticks);

#endif
