/* SPDX-License-Identifier: Apache-2.0 */
#include "model/pull.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/text_file.h"

/* Of the first key at the frame or behind it. */
static int find(const struct pull *pull, int32_t frame)
{
    int i = 0;
    while (i < pull->n && pull->keys[i].frame < frame)
        i++;
    return i;
}

bool pull_has(const struct pull *pull, int32_t frame)
{
    const int i = find(pull, frame);
    return i < pull->n && pull->keys[i].frame == frame;
}

bool pull_set(struct pull *pull, const struct pull_key *key)
{
    const int i = find(pull, key->frame);
    if (!pull_has(pull, key->frame)) {
        if (pull->n == PULL_MAX)
            return false;
        memmove(pull->keys + i + 1, pull->keys + i,
                (size_t)(pull->n - i) * sizeof(*pull->keys));
        pull->n++;
    }
    pull->keys[i] = *key;
    return true;
}

bool pull_remove(struct pull *pull, int32_t frame)
{
    const int i = find(pull, frame);
    if (!pull_has(pull, frame))
        return false;
    pull->n--;
    memmove(pull->keys + i, pull->keys + i + 1,
            (size_t)(pull->n - i) * sizeof(*pull->keys));
    return true;
}

bool pull_at(const struct pull *pull, int32_t frame, struct pull_key *key)
{
    if (pull->n == 0)
        return false;
    const int i = find(pull, frame);
    const struct pull_key *next = &pull->keys[i < pull->n ? i : pull->n - 1];
    const struct pull_key *before = &pull->keys[i > 0 ? i - 1 : 0];
    const double span = (double)next->frame - before->frame;
    const double t = i < pull->n && span > 0 ? (frame - before->frame) / span : 1;
    const double share = t * t * (3 - 2 * t);
    key->frame = frame;
    key->focus = before->focus + share * (next->focus - before->focus);
    key->aperture = before->aperture + share * (next->aperture - before->aperture);
    return true;
}

static void print_keys(FILE *file, const void *data)
{
    const struct pull *pull = data;
    fprintf(file, "frame,easing,focus-distance,%s\n",
            pull->is_radius ? "lens-radius" : "f-stop");
    for (int i = 0; i < pull->n; i++)
        fprintf(file, "%d,ease-in-out,%.9g,%.9g\n", pull->keys[i].frame,
                pull->keys[i].focus, pull->keys[i].aperture);
}

bool pull_write(const struct pull *pull, const char *path, struct image_error *error)
{
    return text_file_write(path, print_keys, pull, error);
}

int32_t pull_frame_of(const char *path, int32_t otherwise)
{
    const char *slash = strrchr(path, '/');
    const char *name = slash ? slash + 1 : path, *dot = strrchr(name, '.');
    const char *end = dot ? dot : name + strlen(name);
    while (end > name && !isdigit((unsigned char)end[-1]))
        end--;
    const char *from = end;
    while (from > name && isdigit((unsigned char)from[-1]) && end - from < 9)
        from--;
    return from < end ? (int32_t)strtol(from, NULL, 10) : otherwise;
}
