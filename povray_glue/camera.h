/* SPDX-License-Identifier: Apache-2.0 */
/*
 * From the records of the debug stream (rewrite.c) to a camera, by POV-Ray 3.7's rules,
 * found by rendering (docs/povray.md lists them).
 */
#ifndef POVRAY_CAMERA_H
#define POVRAY_CAMERA_H

#include <stdbool.h>

#include "povray.h"
#include "text.h"

/*
 * Replays the records and gives the camera that POV-Ray would use: the last one. False
 * with a message that names the feature where it is no camera of ours.
 *
 * A camera may be a copy of a declared one under a name that only POV-Ray can resolve
 * (a parameter of a macro, an element of an array). `guess` 0 takes the name as it
 * stands, n > 0 the n-th of the declared cameras, counted from the last. *n_guesses is
 * the number of those worth trying, 0 where the camera used is no copy.
 */
bool camera_replay(struct povray_camera *camera, const char *records, int guess,
                   int *n_guesses, struct povray_error *error);

/* A number written by `#debug "@rf~KEY~NUMBER;"`, the last one; false where absent. */
bool records_find_number(const char *records, const char *key, double *number);

/* All texts written by `#debug "@rf~KEY~TEXT;"`, without their blanks. The caller frees
 * them and the list. */
char **records_list(const char *records, const char *key, int *n);

/* The camera in POV-Ray's words. With n_samples > 0 it has its lens. */
void camera_write(struct text *out, const struct povray_camera *camera, int n_samples);

/* Do they make the same picture of the same things? */
bool camera_is_same(const struct povray_camera *a, const struct povray_camera *b);

/* Start and direction of the ray through (x, y) px; the direction reaches from the
 * camera to the plane at distance |camera->direction| along the axis. */
void camera_ray(const struct povray_camera *camera, double x, double y, int32_t width,
                int32_t height, double start[3], double direction[3]);

double vector_length(const double v[3]);

#endif
