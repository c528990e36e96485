/* SPDX-License-Identifier: Apache-2.0 */
#include "model/frames.h"

#include <stdlib.h>

#include "common/report.h"

static size_t size_of(const struct frame_shot *shot)
{
    return shot->rgba ? 4 * (size_t)shot->width * (size_t)shot->height : 0;
}

static void forget(struct frames *frames, int i)
{
    frames->n_bytes -= size_of(&frames->shots[i]);
    free(frames->shots[i].rgba);
    frames->shots[i] = (struct frame_shot){0};
}

void frames_free(struct frames *frames)
{
    for (int i = 0; i < frames->n; i++)
        forget(frames, i);
    free(frames->shots);
    *frames = (struct frames){0};
}

void frames_start(struct frames *frames, int n)
{
    frames_free(frames);
    frames->shots = n > 0 ? app_memory((size_t)n, sizeof(*frames->shots), NULL) : NULL;
    frames->n = frames->shots ? n : 0;
    for (int i = 0; i < frames->n; i++)
        frames->shots[i] = (struct frame_shot){0};
}

void frames_keep(struct frames *frames, int i, const struct frame_shot *shot)
{
    const size_t n_bytes = size_of(shot);
    if (i < 0 || i >= frames->n || n_bytes > FRAMES_MOST_BYTES) {
        free(shot->rgba);
        return;
    }
    forget(frames, i);
    for (int k = 1; k < frames->n && frames->n_bytes + n_bytes > FRAMES_MOST_BYTES; k++)
        forget(frames, (i + frames->n - k) % frames->n);
    frames->shots[i] = *shot;
    frames->n_bytes += n_bytes;
}

const struct frame_shot *frames_find(const struct frames *frames, int i, uint32_t look)
{
    if (i < 0 || i >= frames->n || !frames->shots[i].rgba ||
        frames->shots[i].look != look)
        return NULL;
    return &frames->shots[i];
}
