/* SPDX-License-Identifier: Apache-2.0 */
/* What is a highlight, as far as the picture around and the whole of it decide. */
#ifndef RF_SURVEY_H
#define RF_SURVEY_H

#include "internal.h"

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

/* Areas that are yet to be measured, row by row. */
rf_result rf_areas_begin(struct rf_areas *areas, const struct rf_filter *filter,
                         struct rf_error *error);
/* The pixels at hand, y0 to y1 - 1, that a row of areas has. */
void rf_areas_rows(const struct rf_areas *areas, int row, int *y0, int *y1);
/* `luminance` is that of the first pixel at hand, in rows of `stride`. */
void rf_areas_measure_row(const struct rf_areas *areas,
                          const struct rf_kernels *kernels, const float *luminance,
                          size_t stride, int row);
/* All of that, of a view's planes. */
rf_result rf_areas_measure(struct rf_areas *areas, const struct rf_filter *filter,
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
 * Adds the pixels of a window, counted from the first pixel at hand, to the survey. Any
 * order of windows and any threads give the same numbers. Of a view's image nothing is
 * transparent.
 */
void rf_survey_add(struct rf_survey *survey, const struct rf_filter *filter,
                   const struct rf_work_view *view, int n_planes,
                   const struct rf_areas *areas, const struct rf_window *window);

/* The least factor, a power of two, at which the highlights' discs fit into a budget.
 */
float rf_survey_factor(const struct rf_survey *survey);

#endif
