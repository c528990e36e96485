/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Several pictures that are filtered each on its own and shown as one: layers over each
 * other (as `rackfocus filter --over`) and the two eyes of a stereo pair (--stereo).
 */
#ifndef VIEW_STACK_H
#define VIEW_STACK_H

#include <stddef.h>
#include <stdint.h>

#include "rackfocus/rackfocus.h"

enum { STACK_MOST = 7 }; /* others beside the first */

enum stack_kind { STACK_NONE, STACK_OVER, STACK_STEREO };
enum stack_eyes { EYES_LEFT, EYES_RIGHT, EYES_ANAGLYPH, EYES_BESIDE };

/* What is done with input->others, whose number is n. Compared byte by byte. */
struct stack {
    int32_t kind, eyes, n;
    struct rf_params params[STACK_MOST]; /* of each of them */
};

/* Lies over a picture, premultiplied and in linear light: `top` has 4 channels, `bottom`
 * 1, 3 or 4 and receives the result. */
void stack_put_over(const float *top, float *bottom, size_t n, int n_channels);

/* What both eyes see: red of the left and the rest of the right one, for glasses; or
 * side by side, each half as wide. `left` receives it. */
void stack_join_eyes(float *left, const float *right, int32_t width, int32_t height,
                     int n_channels, int32_t eyes);

#endif
