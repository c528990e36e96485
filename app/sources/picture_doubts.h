/* SPDX-License-Identifier: Apache-2.0 */
/* Doubts of a picture in memory, by its pixels: for windows and pages, as filter warns. */
#ifndef APP_PICTURE_DOUBTS_H
#define APP_PICTURE_DOUBTS_H

#include <stdbool.h>
#include <stddef.h>

#include "sources/depth_fit.h"
#include "sources/depth_repair.h"
#include "sources/source.h"

/* How a depth lies on its picture where it does not lie right, and the command that turns
 * or moves it, as "the depth lies upside down: ..."; false: it lies right. */
bool place_is_doubtful(const struct depth_fit *fit, const struct source *source,
                       char *text, size_t n_bytes);

/* That a depth was rendered in a smaller size than its picture and enlarged by repeating
 * pixels. */
void explain_size(int32_t width, int32_t height, char *text, size_t n_bytes);

/* Says that the first depth of a picture lies wrong or was enlarged, that its colour is not multiplied by
 * alpha. */
void picture_say_doubts(const struct depth_picture *picture,
                        void (*say)(void *user, const char *text), void *user);

/* The command that multiplies a straight colour by its alpha, after a colon; "" where
 * its channels are not of one part. */
void explain_straight(const struct source *source, char *text, size_t n_bytes);

/* A way out for colours that are NaN or infinite, "; or give them the mean around: ...";
 * "" where they are not of one part. */
void picture_explain_pixels(const struct source *source, char *text, size_t n_bytes);

#endif
