/* SPDX-License-Identifier: Apache-2.0 */
/* How far a picture is from the reference. */
#ifndef VIEW_DIFFERENCE_H
#define VIEW_DIFFERENCE_H

#include "worker.h"

/* Fills shot->rgba with the heat map and shot->tpsnr_db; `pixels` are the shot's. Black
 * without memory. */
void difference_show(const struct job *job, const float *pixels, struct shot *shot);

#endif
