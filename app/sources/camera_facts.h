/* SPDX-License-Identifier: Apache-2.0 */
/* The camera, as other programs write it into the headers of their files. */
#ifndef APP_CAMERA_FACTS_H
#define APP_CAMERA_FACTS_H

#include <stdbool.h>

#include "image.h"

/* One value of a header, in the units of the parameter `key`. */
struct camera_fact {
    const char *key;
    double value;
    const char *text; /* the value as a text; belongs to the input; NULL: `value` */
    char attribute[96];
};

enum { CAMERA_MOST_FACTS = 6 };

/* What V-Ray, Unreal or Redshift say of the camera; how many facts there are. */
int camera_facts_read(const struct image_input *input,
                      struct camera_fact facts[CAMERA_MOST_FACTS]);

/* The attribute that V-Ray's focus distance is taken from. */
extern const char camera_facts_target[];

/* That of Redshift, which may not be meant where it renders without depth of field. */
extern const char camera_facts_redshift[];

/*
 * How wide the sensor is by focal lengths: the width of what is seen at a distance of 1.
 * By worldToCamera and worldToNDC, as Arnold, Houdini and RenderMan write them, or the
 * angle of Redshift. Returns the attribute; NULL where there is none or it does not fit
 * the display window of the part.
 */
const char *camera_facts_width(const struct image_input *input,
                               const struct image_part_info *part, double *width);

#endif
