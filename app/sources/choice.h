/* SPDX-License-Identifier: Apache-2.0 */
/* Which picture of a file is taken, where it holds several. */
#ifndef APP_CHOICE_H
#define APP_CHOICE_H

#include <stdbool.h>
#include <stddef.h>

#include "image.h"

/* The views that have a picture. */
struct eyes {
    const char *taken;          /* that of the layer at hand */
    char all[256], others[256]; /* with commas; all but that one */
};

/* Are there others than that of the layer? */
bool eyes_are_several(const struct image_input *input, const struct image_layer *layer,
                      struct eyes *eyes);

/* Is a view one of the dotted words of the layer that was asked for, if one was? */
bool eye_is_named(const char *layer, const char *eye);

/*
 * Why the layer that was found, `asked` or the first that fits, may not be the one that is
 * meant, into `text`; false: there is no doubt.
 */
bool choice_is_doubtful(const struct image_input *input,
                        const struct image_layer *found, const char *asked, char *text,
                        size_t n_bytes);

#endif
