/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lights that a frame does not show. Each bright pixel of a frame beside is spread over
 * the four pixels around its place, so that a lamp keeps its light wherever it lies
 * between pixels. Frames are not added up: a lamp that one of them shows in part, beside
 * something nearer, would be too dark. Of each pixel the first frame counts, but for one
 * that shows clearly more of it.
 */
#include "filter/temporal_lights.h"

#include <stdlib.h>
#include <string.h>

#include "sources/picture.h"

/* More of a pixel, to count for more than a nearer frame does. Ours. */
static const float MORE = 0.25f;

enum { FIRST_ROOM = 1024 };

void light_points_free(struct light_points *points)
{
    free(points->at);
    *points = (struct light_points){.most = points->most};
}

void light_points_add(struct light_points *points, const struct light_point *point)
{
    points->is_full |= points->n >= points->most;
    if (points->is_full || points->is_short)
        return;
    if (points->n == points->room) {
        const size_t room = points->room ? 2 * points->room : FIRST_ROOM;
        struct light_point *at = realloc(points->at, room * sizeof(*at));
        points->is_short = !at;
        if (!at)
            return;
        points->at = at;
        points->room = room;
    }
    points->at[points->n] = *point;
    points->at[points->n].number = (uint32_t)points->n;
    points->n++;
}

static int compare_points(const void *a, const void *b)
{
    const struct light_point *p = a, *q = b;
    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    if (p->frame != q->frame)
        return p->frame < q->frame ? -1 : 1;
    return p->number < q->number ? -1 : p->number > q->number;
}

static bool is_same_pixel(const struct light_point *a, const struct light_point *b)
{
    return a->x == b->x && a->y == b->y;
}

/* Adds up the points of one frame at one pixel, from `i` on; returns the next one. */
static size_t sum_frame(const struct light_points *points, size_t i,
                        struct light_point *sum)
{
    const struct light_point *first = &points->at[i];
    *sum = (struct light_point){.x = first->x, .y = first->y, .frame = first->frame};
    for (; i < points->n && is_same_pixel(first, &points->at[i]) &&
           points->at[i].frame == first->frame;
         i++) {
        const struct light_point *point = &points->at[i];
        sum->weight += point->weight;
        sum->z += point->weight * point->z;
        for (int c = 0; c < 4; c++)
            sum->colour[c] += point->weight * point->colour[c];
    }
    return i;
}

static struct rf_unseen_light light_of(const struct light_point *sum, int n_channels)
{
    struct rf_unseen_light light = {
        .x = sum->x + 0.5, .y = sum->y + 0.5, .depth = (double)(sum->z / sum->weight)};
    /* Where its places lie close together there is more than a pixel of it. */
    const float share = sum->weight > 1 ? sum->weight : 1;
    for (int c = 0; c < n_channels; c++)
        light.colour[c] = sum->colour[c] / share;
    return light;
}

bool light_points_join(struct light_points *points, int n_channels,
                       struct rf_unseen_light **lights, size_t *n_lights,
                       struct image_error *error)
{
    *lights = NULL;
    *n_lights = 0;
    if (!points->is_short && points->n == 0)
        return true;
    /* A point makes one light at most. */
    *lights =
        app_memory(points->is_short ? SIZE_MAX : points->n, sizeof(**lights), error);
    if (!*lights)
        return false;
    qsort(points->at, points->n, sizeof(*points->at), compare_points);
    for (size_t i = 0; i < points->n;) {
        struct light_point best, next;
        i = sum_frame(points, i, &best);
        while (i < points->n && is_same_pixel(&best, &points->at[i])) {
            i = sum_frame(points, i, &next);
            if (next.weight > best.weight + MORE)
                best = next;
        }
        (*lights)[(*n_lights)++] = light_of(&best, n_channels);
    }
    return true;
}
