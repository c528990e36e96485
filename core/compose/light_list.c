/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The footprints of highlights whose looks depend on the place. Highlights show their
 * footprints, and there are few of them: their places are rounded to PER_UNIT parts of
 * half a diagonal, far finer than the zones of all other samples, and each footprint is
 * right for its radius, too. Those that share place and radius share the footprint.
 */
#include "compose/light_list.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "compose/footprint.h"
#include "compose/scene.h"
#include "input/frame.h"
#include "lens/look.h"
#include "rackfocus/rackfocus.h"

/* An edge is wrong by 1/256 of the speed at which it moves: 1 % of the area at most. */
enum { PER_UNIT = 128 };

struct key {
    int32_t x, y, index, phase;
    uint32_t light;
};

static int compare_keys(const void *a, const void *b)
{
    const struct key *k = a, *l = b;
    const int32_t of_a[] = {k->x, k->y, k->index, k->phase};
    const int32_t of_b[] = {l->x, l->y, l->index, l->phase};
    for (int i = 0; i < 4; i++)
        if (of_a[i] != of_b[i])
            return of_a[i] < of_b[i] ? -1 : 1;
    return (k->light > l->light) - (k->light < l->light);
}

static bool is_same(const struct key *a, const struct key *b)
{
    return a->x == b->x && a->y == b->y && a->index == b->index && a->phase == b->phase;
}

static void place_of(const struct rf_scene *scene, const struct rf_footprint_use *use,
                     const struct rf_sample *s, double q[2])
{
    const struct rf_place *place = &scene->frame->place;
    rf_look_place(&use->look, (double)s->x - scene->x0 + place->x,
                  (double)s->y - scene->y0 + place->y, q);
}

static struct key key_of(const struct rf_scene *scene,
                         const struct rf_footprint_use *use, uint32_t light)
{
    const struct rf_sample *s = &scene->highlights.at[light];
    const struct rf_footprints any = {.max_index = INT32_MAX,
                                      .n_phases = use->n_phases};
    double q[2];
    place_of(scene, use, s, q);
    return (struct key){.x = (int32_t)floor(q[0] * PER_UNIT + 0.5),
                        .y = (int32_t)floor(q[1] * PER_UNIT + 0.5),
                        .index = rf_radius_index(&any, rf_scene_disc_radius(scene, s)),
                        .phase = rf_phase_of(&any, s->x, s->y),
                        .light = light};
}

/* What each highlight keeps at its own place, in parts of what it does at the rounded
 * one: up to 7e-3 apart. */
static rf_result find_shares(struct rf_light_list *list, const struct rf_scene *scene,
                             const struct rf_footprint_use *use, struct rf_error *error)
{
    size_t n = scene->highlights.n;
    if (use->bokeh || !rf_look_is_open_quick(&use->look, use->shape))
        return RF_OK;
    list->share = rf_alloc(scene->frame->context, n, sizeof *list->share);
    if (!list->share)
        return rf_fail_memory(error, n, sizeof *list->share);
    for (size_t i = 0; i < n; i++) {
        const struct rf_listed *l = &list->at[list->slot[i]];
        double q[2], r = rf_radius_of_index(l->index);
        place_of(scene, use, &scene->highlights.at[i], q);
        double rounded = rf_look_open(&use->look, use->shape, l->q, r);
        double own = rf_look_open(&use->look, use->shape, q, r);
        list->share[i] = rounded > 0 ? (float)(own / rounded) : 1;
    }
    return RF_OK;
}

rf_result rf_light_list_make(struct rf_light_list *list, const struct rf_scene *scene,
                             struct rf_footprint_use *use, struct rf_error *error)
{
    const struct rf_context *context = scene->frame->context;
    size_t n = scene->highlights.n, n_listed = 0;
    *list = (struct rf_light_list){.at = NULL};
    if (!rf_look_is_on(&use->look))
        return RF_OK;
    struct key *keys = rf_alloc(context, n, sizeof *keys);
    list->at = rf_alloc(context, n, sizeof *list->at);
    list->slot = rf_alloc(context, n, sizeof *list->slot);
    if (!keys || !list->at || !list->slot) {
        rf_free(context, keys);
        return rf_fail_memory(error, n, sizeof *keys);
    }
    for (size_t i = 0; i < n; i++)
        keys[i] = key_of(scene, use, (uint32_t)i);
    qsort(keys, n, sizeof *keys, compare_keys);
    for (size_t i = 0; i < n; i++) {
        if (i == 0 || !is_same(&keys[i], &keys[i - 1]))
            list->at[n_listed++] = (struct rf_listed){
                .q = {(double)keys[i].x / PER_UNIT, (double)keys[i].y / PER_UNIT},
                .index = keys[i].index,
                .phase = keys[i].phase};
        list->slot[keys[i].light] = (uint32_t)(n_listed - 1);
    }
    rf_free(context, keys);
    use->list = list->at;
    use->n_listed = n_listed;
    return find_shares(list, scene, use, error);
}

void rf_light_list_free(struct rf_light_list *list, const struct rf_context *context)
{
    rf_free(context, list->at);
    rf_free(context, list->slot);
    rf_free(context, list->share);
}
