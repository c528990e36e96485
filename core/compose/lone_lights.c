/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Which highlights are points of light: they are drawn as what of the lens' shape lies in
 * each pixel. The light of all others was spread over pixels by the filter of the
 * renderer, which the same would do a second time: their footprints are narrower by a
 * pixel's variance. Points for all lose 0.05 dB on posts and portrait, 0.15 on foliage;
 * narrower ones for all are wrong by 7 to 9 % of the area of a lone disc of 2 px, where
 * points are by 0.7 % (tests/physics/test_looks.c). Ours.
 */
#include "compose/lone_lights.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "compose/scene.h"
#include "rackfocus/rackfocus.h"

/* How many highlights a pixel has, up to 2. */
struct counts {
    unsigned char *at;
    int width, height;
};

static unsigned char *count_of(const struct counts *c, int x, int y)
{
    bool is_inside = x >= 0 && y >= 0 && x < c->width && y < c->height;
    return is_inside ? c->at + (size_t)y * (size_t)c->width + (size_t)x : NULL;
}

static void add(const struct counts *c, const struct rf_sample *s)
{
    unsigned char *count = count_of(c, (int)floorf(s->x), (int)floorf(s->y));
    if (count && *count < 2)
        ++*count;
}

static bool is_lone(const struct counts *c, const struct rf_sample *s)
{
    int n = 0, x = (int)floorf(s->x), y = (int)floorf(s->y);
    for (int i = 0; i < 9; i++) {
        const unsigned char *count = count_of(c, x - 1 + i % 3, y - 1 + i / 3);
        n += count ? *count : 0;
    }
    return n == 1;
}

rf_result rf_lone_lights_find(struct rf_lone_lights *lone, const struct rf_scene *scene,
                              struct rf_error *error)
{
    const struct rf_context *context = scene->frame->context;
    const struct rf_samples *samples = &scene->highlights;
    size_t n_pixels = (size_t)scene->width * (size_t)scene->height;
    struct counts counts = {rf_calloc(context, n_pixels, 1), scene->width,
                            scene->height};
    lone->are = rf_calloc(context, samples->n, 1);
    bool is_any = false, has_room = counts.at && lone->are;
    for (size_t i = 0; i < samples->n && has_room; i++)
        add(&counts, &samples->at[i]);
    for (size_t i = 0; i < samples->n && has_room; i++) {
        lone->are[i] = is_lone(&counts, &samples->at[i]);
        is_any |= lone->are[i];
    }
    rf_free(context, counts.at);
    if (!has_room)
        return rf_fail_memory(error, n_pixels + samples->n, 1);
    if (!is_any)
        rf_lone_lights_free(lone, context);
    return RF_OK;
}

void rf_lone_lights_free(struct rf_lone_lights *lone, const struct rf_context *context)
{
    rf_free(context, lone->are);
    lone->are = NULL;
}
