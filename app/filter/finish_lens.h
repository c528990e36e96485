/* SPDX-License-Identifier: Apache-2.0 */
#ifndef APP_FINISH_LENS_H
#define APP_FINISH_LENS_H

#include <stdbool.h>
#include <stddef.h>

#include "filter/finish_mix.h"

/* Is much of what has detail in ours, which is called `guide` (as "the guide"), sharper
 * or softer in the own picture? `text` says how much of it and what to do, without the
 * name of the own picture. False without memory. */
bool finish_lens_is_other(const struct finish_picture *picture, const char *guide,
                          char *text, size_t n_bytes);

#endif
