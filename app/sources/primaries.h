/* SPDX-License-Identifier: Apache-2.0 */
/* Which colours red, green and blue of a picture are, by its header. */
#ifndef APP_PRIMARIES_H
#define APP_PRIMARIES_H

#include <stdbool.h>
#include <stddef.h>

#include "common/report.h"
#include "image.h"

struct primaries {
    float xy[8];    /* of red, green, blue and white; Rec. 709's where none are said */
    const char *by; /* the attribute by which they are not Rec. 709's; NULL: they are */
};

void primaries_read(const struct image_input *input, int part, struct primaries *found);

bool primaries_differ(const struct primaries *a, const struct primaries *b);

/*
 * Warns where a picture has other primaries than another one with which its numbers are
 * added up or compared; `what` then comes out wrong. APP_DONE where they are alike.
 */
int primaries_warn(const struct app_host *host, const char *path,
                   const struct primaries *own, const char *other_path,
                   const struct primaries *other, const char *what,
                   struct image_error *error);

#endif
