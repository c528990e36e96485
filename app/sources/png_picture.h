/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures as PNG, for screens. */
#ifndef APP_PNG_PICTURE_H
#define APP_PNG_PICTURE_H

#include "common/report.h"
#include "sources/source.h"

struct png_picture {
    const struct source *source; /* whose windows and channels it has */
    const float *samples;        /* of the data window, as source_read_colour() */
    int bits;                    /* 8 or 16 */
    const char *name;            /* of what it is made of; NULL: the source's */
    bool is_of_scene;            /* POV-Ray's, whose header says no primaries */
};

/*
 * Writes the display window, as other programs show it: an overscan is left out, and what
 * lies beyond the data window is black, with alpha transparent. Warns of what a PNG cannot
 * hold; false on failure.
 */
bool png_picture_write(const struct app_host *host, const char *path,
                       const struct png_picture *picture, struct image_error *error);

#endif
