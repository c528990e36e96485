/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Checks a recovered camera against the scene's own: a small sphere around the place
 * where the camera should be shows to each ray of the scene's camera where it went.
 */
#ifndef POVRAY_PROBE_H
#define POVRAY_PROBE_H

#include <stdbool.h>

#include "decode.h"
#include "povray.h"
#include "text.h"

/* What to add at the beginning and at the end of the scene. */
extern const char *const probe_head;
/* How many times the usual size the sphere may be: smaller where the scene's own things
 * are as near and hide it. */
#define PROBE_N_SCALES 4
#define PROBE_SCALES                                                                   \
    {                                                                                  \
        1, 0.3, 0.1, 0.01                                                              \
    }

struct probe {
    const struct povray_camera *camera;
    double scale;          /* of PROBE_SCALES */
    int32_t width, height; /* rendered, px */
    int32_t picture_width; /* whose pixels errors are told in */
};

void probe_write(struct text *out, const struct probe *probe);

/*
 * Compares the picture with the camera, and finds the space in which POV-Ray computed.
 * False with a message where the camera is not the scene's.
 */
bool probe_check(const struct probe *probe, const struct decode_picture *picture,
                 struct decode_space *space, struct povray_error *error);

#endif
