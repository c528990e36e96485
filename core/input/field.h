/* SPDX-License-Identifier: Apache-2.0 */
/* The surface in focus, where it is no plane: tilt, curvature of field, split diopter. */
#ifndef RF_INPUT_FIELD_H
#define RF_INPUT_FIELD_H

#include <stdbool.h>

#include "input/diopter.h"
#include "input/frame.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/* Does the focus depend on the place? */
bool rf_field_is_on(const struct rf_params *params);

/* The parameter that makes it so; of several the first. */
const char *rf_field_param(const struct rf_params *params);

/* Does rf_field_apply() change radii? */
bool rf_field_is_used(const struct rf_frame *frame);

/*
 * The lens that depths become radii with: that of the frame but, where the focus
 * depends on the place, without a limit of the radius, which rf_field_apply() sets.
 * Where the field is kept apart, radii are limited to what no place brings back below
 * the frame's limit: views are moved by them.
 */
struct rf_lens rf_field_lens(const struct rf_frame *frame);

/*
 * The looks of a frame for footprints that have a place each: with the slope of the
 * surface in focus where that changes their rims, in all windows alike. A split
 * diopter's border is left out.
 */
struct rf_look rf_field_look(const struct rf_frame *frame);

/* What the place adds to a radius. */
struct rf_field {
    double k, most;      /* px times scene units; px */
    double shift;        /* px, of a colour everywhere */
    double principal[2]; /* px of the whole picture */
    double tilt[2];      /* of 1/s per px */
    double curvature;    /* b */
    struct rf_diopter diopter;
    struct rf_look places;
    int x, y; /* of the frame */
};

struct rf_field rf_field_of(const struct rf_frame *frame);

/* The radius at (x, y), px of the frame, of what has radius r by the plane; beyond the
 * picture as the surface goes on. */
float rf_field_radius(const struct rf_field *field, float x, float y, float r);

/* Of pixel (x, y) of the frame, where the field is kept apart; else r. */
float rf_field_seen(const struct rf_frame *frame, int x, int y, float r);

/* The largest magnitude that radii would have with what places add. */
float rf_field_largest(const struct rf_frame *frame, const float *radius);

/* What rf_field_apply() adds to the radii of row y, but for a colour's own shift. */
void rf_field_row(const struct rf_frame *frame, int y, float *shift);

/*
 * Adds what the place makes of the radii of a frame's pixels, packed, and limits them;
 * *largest receives the largest magnitude. Nothing where the focus is the same
 * everywhere, or it is kept apart (struct rf_frame).
 */
void rf_field_apply(const struct rf_frame *frame, float *radius, float *largest);

#endif
