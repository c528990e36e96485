/* SPDX-License-Identifier: Apache-2.0 */
/* How far a picture is from the reference, which has its size. */
#ifndef VIEW_DIFFERENCE_H
#define VIEW_DIFFERENCE_H

#include "filtering/worker.h"

/* The tone mapped error that has the brightest colour: HEAT_FULL_SCALE divided by the
 * gain of the job. */
double difference_full_scale(const struct job *job);

/* Fills shot->rgba with the heat map; `pixels` are the shot's. Black without memory. */
void difference_show(const struct job *job, const float *pixels, struct shot *shot);

/* Finds shot->tpsnr_db, which stays NAN without memory. */
void difference_measure(const struct job *job, const float *pixels, struct shot *shot);

#endif
