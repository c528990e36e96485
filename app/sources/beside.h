/* SPDX-License-Identifier: Apache-2.0 */
/* Layers beside the colour of a source, by their names. */
#ifndef APP_BESIDE_H
#define APP_BESIDE_H

#include <stdbool.h>

#include "sources/source.h"

/* The view of the colour; NULL: it has none. */
const char *beside_view(const struct source *source);

/* Is a channel of the view that the colour is of? All are where it has none. */
bool beside_is_of_view(const struct source *source, int channel);

/* A channel's name without its view: "v00.R" becomes "R", "ViewLayer.Combined.v00.R"
 * "ViewLayer.Combined.R". */
void beside_drop_view(const char *name, const char *view, char *out, size_t n_bytes);

/* Is a channel that of `base` (0 to 2, x y z or r g b) in a layer of that name, of the
 * view that the colour is of? */
bool beside_is(const struct source *source, int channel, const char *layer, int base);

/* Has the part of a channel the data window of the colour? */
bool beside_has_window(const struct source *source, int channel);

#endif
