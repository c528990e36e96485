/* SPDX-License-Identifier: Apache-2.0 */
/* The radii that a map shows. */
#ifndef VIEW_MAPS_H
#define VIEW_MAPS_H

#include <stdbool.h>

#include "filtering/worker.h"

/* Signed, px, of every pixel of the job's input. */
bool maps_radius(const struct rf_context *context, const struct job *job, float *radius,
                 struct rf_error *error);

/* What has full colour: the largest radius, at least 2 px. */
double maps_full_radius(const float *radius, size_t n);

#endif
