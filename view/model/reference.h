/* SPDX-License-Identifier: Apache-2.0 */
/* A picture to compare with, which the threads share. */
#ifndef VIEW_REFERENCE_H
#define VIEW_REFERENCE_H

#include "sources/picture.h"

struct reference {
    int n_holders; /* changes with reference_hold and reference_drop only */
    int n_views;   /* that OpenGL drew and that it is the mean of; 0: of a file, kept */
    struct picture picture; /* never changed */
};

/* Takes the picture over; one holder. NULL without memory: the picture is freed. */
struct reference *reference_create(const struct picture *picture, int n_views);
struct reference *reference_hold(struct reference *reference); /* may be NULL */
void reference_drop(struct reference *reference);              /* may be NULL */

/* Can a picture of this size be compared with it? False for NULL. */
bool reference_fits(const struct reference *reference, int32_t width, int32_t height);

#endif
