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
#include "base/parallel.h"
#include "base/pool.h"
#include "compose/footprint.h"
#include "compose/lens_light.h"
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

/*
 * What a listed footprint keeps of the light of the lens at its place q and near it:
 * rf_look_open_near() and what is lacking there, which is as good as linear.
 */
struct kept {
    double near, light; /* by area, by light */
    double lack, slope[2];
};

struct sharing {
    struct rf_light_list *list;
    const struct rf_scene *scene;
    const struct rf_footprint_use *use;
    struct rf_lens_light light;
    struct kept *kept; /* per listed */
};

/* What rf_look_open_near() lacks at q. */
static double lack_of(const struct sharing *s, const double q[2], double r)
{
    struct rf_look rough = s->use->look;
    rough.is_rough = true;
    return rf_look_open(&rough, s->use->shape, q, r) -
           rf_look_open_near(&rough, s->use->shape, q, r);
}

static void find_kept(void *data, int64_t begin, int64_t end, int thread)
{
    static const double STEP = 0.5 / PER_UNIT;
    const struct sharing *s = data;
    const struct rf_look *look = &s->use->look;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const struct rf_listed *l = &s->list->at[i];
        struct kept *kept = &s->kept[i];
        double r = rf_radius_of_index(l->index);
        *kept = (struct kept){.light = rf_lens_light_open(&s->light, l->q, r)};
        kept->near = s->use->bokeh ? rf_look_open_near(look, s->use->shape, l->q, r)
                                   : kept->light;
        if (rf_look_is_scaled(look) || rf_look_is_folded(look, s->use->shape, l->q, r))
            continue;
        kept->lack = lack_of(s, l->q, r);
        for (int k = 0; k < 2; k++) {
            double beside[2] = {l->q[0], l->q[1]};
            beside[k] += STEP;
            kept->slope[k] = (lack_of(s, beside, r) - kept->lack) / STEP;
        }
    }
}

/* What the sample at q of radius r keeps, in parts of what its listed footprint does. */
static double share_of(const struct sharing *s, size_t slot, const double q[2],
                       double r)
{
    const struct rf_listed *l = &s->list->at[slot];
    const struct kept *kept = &s->kept[slot];
    double near = rf_look_open_near(&s->use->look, s->use->shape, q, r);
    double own = near + kept->lack, share = 1;
    for (int k = 0; k < 2; k++)
        own += kept->slope[k] * (q[k] - l->q[k]);
    if (kept->near + kept->lack > 0)
        share = own / (kept->near + kept->lack);
    if (s->use->bokeh && near > 0 && kept->light > 0)
        share *=
            rf_lens_light_open(&s->light, q, r) / kept->light * (kept->near / near);
    return fmax(share, 0);
}

static void share_out(void *data, int64_t begin, int64_t end, int thread)
{
    const struct sharing *s = data;
    (void)thread;
    for (int64_t i = begin; i < end; i++) {
        const struct rf_sample *light = &s->scene->highlights.at[i];
        double q[2], r = (double)rf_scene_disc_radius(s->scene, light);
        place_of(s->scene, s->use, light, q);
        s->list->share[i] = (float)share_of(s, s->list->slot[i], q, r);
    }
}

/* What each highlight keeps by its own place and radius, in parts of what it does by the
 * rounded ones: up to 7e-3 apart by the place, 2e-4 by the radius. */
static rf_result find_shares(struct rf_light_list *list, const struct rf_scene *scene,
                             const struct rf_footprint_use *use, struct rf_error *error)
{
    const struct rf_context *context = scene->frame->context;
    size_t n = scene->highlights.n;
    struct sharing s = {.list = list, .scene = scene, .use = use};
    if (!rf_look_is_dark(&use->look))
        return RF_OK;
    list->share = rf_alloc(context, n, sizeof *list->share);
    s.kept = rf_alloc(context, use->n_listed, sizeof *s.kept);
    if (!list->share || !s.kept) {
        rf_free(context, s.kept);
        return rf_fail_memory(error, n, sizeof *s.kept);
    }
    rf_lens_light_init(&s.light, &use->look, use->shape, use->bokeh, use->bokeh_plane);
    rf_parallel(context, (int64_t)use->n_listed, RF_EQUAL_PARTS, find_kept, &s);
    rf_parallel(context, (int64_t)n, RF_EQUAL_PARTS, share_out, &s);
    rf_free(context, s.kept);
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
