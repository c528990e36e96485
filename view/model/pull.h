/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A focus pull: key frames of focus distance and aperture. Between two of them values go
 * by t^2 (3 - 2 t), which frame_table.h calls ease-in-out; before the first and behind
 * the last they stay. Saved as `rackfocus filter --frame-parameters` reads it.
 */
#ifndef VIEW_PULL_H
#define VIEW_PULL_H

#include <stdbool.h>
#include <stdint.h>

#include "image.h"

#define PULL_MAX 256

struct pull_key {
    int32_t frame;
    double focus;    /* scene units */
    double aperture; /* f-stop, or lens radius; see is_radius */
};

struct pull {
    int n;
    struct pull_key keys[PULL_MAX]; /* frames rise */
    bool is_radius; /* the aperture is the radius of the lens, scene units */
};

/* Sets the key of its frame, in place of one that is there. False where there are
 * PULL_MAX. */
bool pull_set(struct pull *pull, const struct pull_key *key);

/* False where the frame has none. */
bool pull_remove(struct pull *pull, int32_t frame);
bool pull_has(const struct pull *pull, int32_t frame);

/* The values of a frame; false without keys. */
bool pull_at(const struct pull *pull, int32_t frame, struct pull_key *key);

/* As CSV, beside its place and renamed. False with a message. */
bool pull_write(const struct pull *pull, const char *path, struct image_error *error);

/* The number in a file's name, shot.0012.exr: 12; `otherwise` where it has none. */
int32_t pull_frame_of(const char *path, int32_t otherwise);

#endif
