/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The pixels that the window filters: colour and depth of one view or several, shared
 * by the threads and never changed once prepared.
 */
#ifndef VIEW_INPUT_H
#define VIEW_INPUT_H

#include <stdbool.h>
#include <stdint.h>

#include "model/stack.h"
#include "rackfocus/rackfocus.h"

struct input {
    int n_holders; /* change with input_hold and input_drop only */
    int32_t width, height;
    int n_channels;
    int n_views;
    struct deep_frame
        *deep;             /* of a deep file, whose flat picture is views[0]; or NULL */
    struct rf_view *views; /* as the files have them; their memory belongs to this */
    float **
        rays; /* mean lengths of each view's rays (mean_depth.h), or NULL; theirs too */
    struct input *others[STACK_MOST]; /* of a stack; belong to this */
    int n_others;
    /* Read back from a frame buffer, rows from the bottom; NULL where there is none.
     * Becomes views[0]. */
    uint8_t *frame_rgba;
    float *frame_depth;
    /* What input_prepare finds. */
    bool is_prepared;
    const float *colour;      /* the pinhole picture from the middle of the lens */
    float *planar;            /* its depth, scene units, INFINITY: nothing hit */
    const float *raw;         /* the same as it was stored; NULL: there is none */
    float **view_planar;      /* planar depth of every view where there are several */
    float *middle;            /* memory of `colour` where views had to be moved */
    double nearest, farthest; /* of the finite depths; 1 and 1 where there is none */
};

/* An empty one with one holder; NULL without memory. */
struct input *input_create(int32_t width, int32_t height, int n_channels, int n_views);
struct input *input_hold(struct input *input);
void input_drop(struct input *input); /* may be NULL */

/*
 * Works out planar depth and, from views, the picture from the middle of the lens.
 * Once, before threads share it. False with the core's message: bad pixels.
 */
bool input_prepare(struct input *input, const struct rf_context *context,
                   const struct rf_params *params, struct rf_error *error);

/* Linear light of the codes of sRGB, as frame buffers have them. */
void input_fill_decoder(float decoder[256]);

/*
 * What an eye on the lens sees, `eye` in lens radii right and up; the plane in focus
 * stays. `out` is width * height * n_channels. Of several views that nearest to the eye
 * is taken and moved the rest of the way; *view receives its index. False without memory.
 */
bool input_see(const struct input *input, const struct rf_lens *lens,
               const double eye[2], float *out, int *view);

#endif
