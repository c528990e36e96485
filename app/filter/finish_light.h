/* SPDX-License-Identifier: Apache-2.0 */
#ifndef APP_FINISH_LIGHT_H
#define APP_FINISH_LIGHT_H

#include <stdbool.h>
#include <stddef.h>

#include "filter/finish_mix.h"

/* Is most of the own picture clearly brighter or darker than ours, which is called
 * `guide` (as "the guide")? `text` says how much and what to do, without the name of the
 * own picture. */
bool finish_light_is_other(const struct finish_picture *picture, const char *guide,
                           char *text, size_t n_bytes);

#endif
