/* SPDX-License-Identifier: Apache-2.0 */
/* Words of a scene that speak of things which let light through or mirror it. */
#ifndef POVRAY_CLEAR_H
#define POVRAY_CLEAR_H

#include "lexer.h"

/* Names that files of POV-Ray's own declare for such things: Clear, Water, Mirror. They
 * point into the files' text. */
struct clear_names {
    const char **names; /* sorted by length, then by bytes */
    size_t *lengths;
    int n;
};

/* Adds what a file of POV-Ray's own declares so. */
void clear_note_declared(struct clear_names *names, const struct tokens *tokens);

/* Does a file of the scene's own speak of them: by a colour with filter or transmit, by a
 * reflection of a tenth of the light or more or of an unknown share, by one of the names, or
 * by a name of its own with "glass" in it? */
bool clear_is_spoken_of(const struct clear_names *names, const struct tokens *tokens);

void clear_free(struct clear_names *names);

#endif
