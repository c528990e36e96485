/* SPDX-License-Identifier: Apache-2.0 */
#ifndef APP_FINISH_LIGHT_H
#define APP_FINISH_LIGHT_H

#include <stdbool.h>

#include "filter/finish_mix.h"

/* Is most of the own picture clearly brighter or darker than ours? `times`: how much. */
bool finish_light_differs(const struct finish_picture *picture, double *times);

#endif
