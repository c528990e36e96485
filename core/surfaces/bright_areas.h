/* SPDX-License-Identifier: Apache-2.0 */
/* What is a highlight, as far as the picture around and the whole of it decide. */
#ifndef RF_SURFACES_BRIGHT_AREAS_H
#define RF_SURFACES_BRIGHT_AREAS_H

#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

/*
 * Geometric mean luminance of the squares of 32 x 32 px of the whole picture, as far as
 * the pixels at hand lie in them.
 */
struct rf_areas {
    int x, y;          /* of the first pixel at hand, in the whole picture */
    int width, height; /* pixels at hand */
    int first_x, first_y, n_x, n_y;
    float *mean;
};

/* Areas that are yet to be measured. */
rf_result rf_areas_begin(struct rf_areas *areas, const struct rf_frame *frame,
                         struct rf_error *error);

/* The area of pixel (x, y) of those at hand, or of the nearest to it. */
int rf_area_of(const struct rf_areas *areas, int x, int y);

/*
 * Measures the areas around those of which `wanted` is not 0: all that
 * rf_usual_luminance() needs of them. `luminance` is that of the first pixel at hand,
 * in rows of `stride`; wanted == NULL: all areas.
 */
void rf_areas_measure_some(struct rf_areas *areas, const struct rf_context *context,
                           const unsigned char *wanted, const float *luminance,
                           size_t stride);

/* Areas with all that, of a view's planes. */
rf_result rf_areas_measure(struct rf_areas *areas, const struct rf_frame *frame,
                           const struct rf_work_view *view, int n_planes,
                           struct rf_error *error);

void rf_areas_free(struct rf_areas *areas, const struct rf_context *context);

/*
 * Lower middle of the areas around pixel (x, y) of those at hand, or around the nearest
 * to it: a lamp that fills its own area does not count.
 */
float rf_usual_luminance(const struct rf_areas *areas, int x, int y);

/* `factor` is on the thresholds of luminance, `usual` as rf_usual_luminance(). */
bool rf_is_highlight(float luminance, float r, float factor, float usual);

/*
 * Is a highlight at pixel (x, y) of those at hand, which may lie beside them, part of
 * something large: a window, a bright sky or their reflection? As an ordinary surface
 * it goes on behind what stands before it, where a lamp would be doubled. What counts
 * lies less than 32 px away and is not hidden by what is nearer: a sky between leaves is
 * a sky.
 */
bool rf_is_large_light(const struct rf_areas *areas, const struct rf_work_view *view,
                       int n_planes, int x, int y, float luminance, float r);

/*
 * Adds the pixels of a window, counted from the first pixel at hand, to the survey. Any
 * order of windows and any threads give the same numbers.
 */
void rf_survey_add(struct rf_survey *survey, const struct rf_frame *frame,
                   const struct rf_work_view *view, int n_planes,
                   const struct rf_areas *areas, const struct rf_window *window);

/* Adds one pixel's disc, as rf_survey_add() does. */
void rf_survey_add_light(struct rf_survey *survey, const struct rf_frame *frame,
                         const struct rf_work_view *view, int n_planes,
                         const struct rf_areas *areas, int x, int y);

/* A pixel with less luminance is no highlight. */
float rf_least_highlight(void);

/* The least factor, a power of two, at which the highlights' discs fit into a budget.
 */
float rf_survey_factor(const struct rf_survey *survey);

#endif
