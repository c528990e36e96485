/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The samples of one tile of full resolution on their way into lists: an item each,
 * with keys (level, side of the focus, bin of the radius) for runs of them.
 */
#ifndef RF_COMPOSE_LIST_ITEMS_H
#define RF_COMPOSE_LIST_ITEMS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/math.h"
#include "compose/composer.h"
#include "compose/footprint.h"
#include "compose/levels.h"
#include "compose/scene.h"
#include "kernels/data.h"
#include "rackfocus/rackfocus.h"

/* Where samples come from, and the groups that they go to. */
struct rf_lister {
    struct rf_composer *c;
    struct rf_groups *groups;
    int max_level;
    size_t n_tiles;                 /* of full resolution */
    size_t most;                    /* samples of one of them */
    const struct rf_source *source; /* emits, if not NULL; beside the samples: */
    const struct rf_samples *samples;
    uint32_t *order;
    size_t *start; /* in `order`, per tile; NULL: no samples but the source's */
};

/* Items in turn that share a key: from that item on to the next run's. */
struct rf_key_run {
    int first, key;
};

/*
 * The samples of a tile: places of a source, whose other samples are `others`; of
 * coarse levels runs of its surfaces, whose slot is their number, and samples that it
 * emits; or samples of the array.
 */
struct rf_tile_items {
    int n, n_key_runs, n_samples, n_others;
    int zone;       /* of the tile */
    bool has_array; /* are samples of the array among them? */
    bool has_runs;  /* is an item of full resolution more than one surface? */
    struct rf_tile_surfaces surfaces; /* of a source */
    bool has_slants;                  /* is any of these not 0? Of its pixels */
    int16_t slants[RF_TILE_H * RF_TILE_W];
    /* Room for as many as a tile may have; a key run more than items. */
    uint64_t *at;
    struct rf_key_run *key_runs;
    struct rf_sample *samples;
    struct rf_splat *others;
};

/* The row of a sample of the array, whose slot is its index: outside of the tile. */
enum { RF_ARRAY_ROW = 255 };

static inline const struct rf_group *rf_full_group(const struct rf_lister *lister)
{
    return &lister->groups->at[lister->max_level];
}

static inline int rf_bin_of(const struct rf_group *g, float r)
{
    int bin = rf_bin_at(r) - g->first_bin;
    return rf_min_int(rf_max_int(bin, 0), g->n_bins - 1);
}

/* Of samples of radius r, to which that of the scene's colour is added. */
static inline int rf_key_of(const struct rf_lister *lister, float r)
{
    r += lister->c->scene->radius_shift;
    int level = rf_min_int(rf_level_of(&lister->c->levels, r), lister->max_level);
    const struct rf_group *g =
        &lister->groups->at[lister->max_level + (r < 0 ? -level : level)];
    return g->first_key + rf_bin_of(g, r);
}

static inline bool rf_is_full_key(const struct rf_group *full, int key)
{
    return key >= full->first_key && key < full->first_key + full->n_bins;
}

/* The sample that an item of a coarse level is; NULL: a run of surfaces. */
static inline const struct rf_sample *rf_sample_of(const struct rf_lister *lister,
                                                   const struct rf_tile_items *s,
                                                   uint64_t item)
{
    if (rf_packed_y(item) == RF_ARRAY_ROW)
        return &lister->samples->at[(uint32_t)rf_packed_slot(item)];
    return rf_packed_other(item) ? &s->samples[rf_packed_other(item) - 1] : NULL;
}

/* The slot of a footprint, which is noted as needed; r of samples, px of the level. */
static inline int32_t rf_splat_slot(const struct rf_composer *c, int zone, float r,
                                    int phase, enum rf_footprint_kind kind, int level)
{
    float shift = c->scene->radius_shift / (float)(1 << level);
    int index = rf_radius_index(c->footprints, r + shift);
    size_t slot = rf_footprint_slot(c->footprints, zone, index, phase, kind, level);
    /* Threads may find the same footprint at once. */
    if (!__atomic_load_n(&c->needed[slot], __ATOMIC_RELAXED))
        __atomic_store_n(&c->needed[slot], 1, __ATOMIC_RELAXED);
    return (int32_t)slot;
}

/* A sample of full resolution in a tile of that zone, ready to be spread. */
static inline struct rf_splat rf_full_splat(const struct rf_composer *c, int zone,
                                            const struct rf_sample *p)
{
    int phase =
        c->footprints->n_phases == 1 ? 0 : rf_phase_of(c->footprints, p->x, p->y);
    struct rf_splat s = {
        .x = rf_floor_int(p->x),
        .y = rf_floor_int(p->y),
        .slant = p->slant,
        .slot = rf_splat_slot(c, zone, p->r, phase, p->kind, 0),
        .cover = p->kind == RF_SHARP ? p->w : 0,
    };
    for (int n = 0; n < 4; n++)
        s.c[n] = p->c[n] * p->w;
    return s;
}

/* Sorts the samples of the array by tile and counts the most of one; order and start
 * are to be freed in any case. */
rf_result rf_lister_sort(struct rf_lister *l, struct rf_error *error);

/* Lists the samples of a tile in the room of `s`; the source's before the array's. */
void rf_list_items(const struct rf_lister *l, int tile, struct rf_tile_items *s);

#endif
