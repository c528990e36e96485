/* SPDX-License-Identifier: Apache-2.0 */
/* The layers of a file that hold the light of mirrors and glass. */
#ifndef APP_SEEN_LIGHT_H
#define APP_SEEN_LIGHT_H

#include <stdbool.h>

#include "filter/seen.h"

struct source;

/* The layers that were named for a kind; NULL: none were. */
const char *seen_asked_layers(const struct filter_options *tool, enum seen_kind kind);

/* Were layers named for a kind, or has the file some that are known? */
bool seen_has_light(const struct run *run, const struct source *source,
                    enum seen_kind kind);

/* The channel of a layer and a letter in a part (-1: in any), of the colour's view; -1:
 * there is none. */
int seen_find_channel(const struct source *source, const char *layer, size_t length,
                      char letter, int part);

/* The light of a kind in a file, three floats per pixel; NULL on failure. */
float *seen_read_light(const struct run *run, const struct source *source,
                       enum seen_kind kind);

#endif
