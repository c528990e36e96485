/* SPDX-License-Identifier: Apache-2.0 */
#ifndef APP_FINISH_LENS_H
#define APP_FINISH_LENS_H

#include <stdbool.h>
#include <stddef.h>

#include "filter/finish_mix.h"

struct settings;

/* Is much of what has detail in ours sharper or softer in the own picture? `share`: how
 * much of it. False without memory. */
bool finish_lens_differs(const struct finish_picture *picture, double *share);

/* Takes the lens from the options that a picture of ours was made with. False where they
 * are none. */
bool finish_lens_made(const char *made, struct settings *settings);

/* Do both headers give the lens, and is it another? `text` says which and how. */
bool finish_lens_headers_differ(const struct settings *own, const struct settings *ours,
                                char *text, size_t n_text);

#endif
