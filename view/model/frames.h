/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures of a sequence that were shown, kept so that they can be played. */
#ifndef VIEW_FRAMES_H
#define VIEW_FRAMES_H

#include <stddef.h>
#include <stdint.h>

#define FRAMES_MOST_BYTES ((size_t)768 << 20) /* of all that are kept */

struct frame_shot {
    uint8_t *rgba; /* NULL: not kept */
    int32_t width, height;
    uint32_t look; /* what it was made with */
};

struct frames {
    struct frame_shot *shots; /* of each picture of the playlist */
    int n;
    size_t n_bytes;
};

/* Forgets all, and makes room for n. */
void frames_start(struct frames *frames, int n);
void frames_free(struct frames *frames);

/* Keeps a picture, which then belongs to this; too large a one is freed. Of those that
 * are kept the ones farthest ahead in the round from `i` go first. */
void frames_keep(struct frames *frames, int i, const struct frame_shot *shot);

/* The picture, if it was made with that look; else NULL. */
const struct frame_shot *frames_find(const struct frames *frames, int i, uint32_t look);

#endif
