/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Samples on their way into tiles: the lists of every tile of every level, by bins of
 * the radius.
 *
 * Work goes by tiles of full resolution. The samples of one are sorted by key (level,
 * side of the focus, bin); those of level 0 become its list, those of a block and bin
 * of a coarse level become one splat. A tile of a coarse level then joins what the
 * tiles of full resolution have left for it.
 */
#include "compose/sample_lists.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/arena.h"
#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/system_threads.h"
#include "base/task.h"
#include "compose/composer.h"
#include "compose/footprint.h"
#include "compose/levels.h"
#include "compose/list_items.h"
#include "compose/scene.h"
#include "compose/slants.h"
#include "kernels/data.h"
#include "rackfocus/rackfocus.h"

/* ---- what threads work with ----------------------------------------------------- */

/* Sums of the samples of one bin that share a block and a kind. */
struct block_sum {
    float c[4], w, rw, slope[2];
};

struct reducer {
    struct block_sum sum[RF_TILE_W * RF_TILE_H * RF_N_KINDS];
    int touched[RF_TILE_W * RF_TILE_H * RF_N_KINDS];
    int n_touched;
};

/* The splats that a tile of full resolution has for one bin of a coarse group. */
struct run {
    int key, n;
    struct rf_splat *at;
};

struct tile_runs {
    int n;
    struct run *at;
};

struct worker {
    struct rf_tile_items items;
    uint64_t *sorted; /* those of coarse levels */
    int *count;       /* n_keys + 1: where a key ends, later where it begins */
    struct run *runs;
    struct rf_splat *reduced; /* RF_N_KINDS tiles of them */
    struct rf_room room;
    struct reducer reducer;
};

struct builder {
    struct rf_lister lister;
    int n_keys;
    struct tile_runs *runs;
    struct worker *workers;
    char *memory;  /* of the workers */
    bool is_short; /* atomic: there is no memory for a list */
};

/* ---- the samples of one tile ---------------------------------------------------- */

/* A tile of full resolution, or the part of a coarser tile that it is. */
struct part {
    int x0, y0, width, height; /* pixels of the level */
};

static struct part part_of(const struct rf_group *full, int tile, int level)
{
    int x0 = tile % full->n_x * RF_TILE_W, y0 = tile / full->n_x * RF_TILE_H;
    return (struct part){x0 >> level, y0 >> level, rf_max_int(RF_TILE_W >> level, 1),
                         rf_max_int(RF_TILE_H >> level, 1)};
}

/* The sums of a block and kind, which is noted if nothing has come to it. */
static inline struct block_sum *sum_at(struct reducer *reducer, int block)
{
    if (reducer->sum[block].w == 0)
        reducer->touched[reducer->n_touched++] = block;
    return &reducer->sum[block];
}

/* The sums for samples in pixel (x, y) of full resolution. */
static inline struct block_sum *block_of(struct reducer *reducer,
                                         const struct part *part, int level, int x,
                                         int y, enum rf_footprint_kind kind)
{
    x = rf_min_int(rf_max_int((x >> level) - part->x0, 0), part->width - 1);
    y = rf_min_int(rf_max_int((y >> level) - part->y0, 0), part->height - 1);
    int block = (y * part->width + x) * RF_N_KINDS + (int)kind;
    return sum_at(reducer, block);
}

static inline void add_to_block(struct block_sum *sum, float w, float r,
                                const float c[4])
{
    for (int n = 0; n < 4; n++)
        sum->c[n] += w * c[n];
    sum->w += w;
    sum->rw += w * r;
}

/* The same for n surfaces in turn, each of weight 1. */
static inline void add_surfaces(struct block_sum *sum, const struct rf_surface *at,
                                int n)
{
    rf_quad c = *(const rf_quad *)sum->c;
    float w = sum->w, rw = sum->rw;
    for (int i = 0; i < n; i++) {
        c += *(const rf_quad *)at[i].c;
        w += 1;
        rw += at[i].r;
    }
    *(rf_quad *)sum->c = c;
    sum->w = w;
    sum->rw = rw;
}

/* Adds the slope of w surfaces of a slant. */
static inline void add_slant(struct block_sum *sum, float w, int slant)
{
    float slope[2];
    rf_slant_slope(slant, slope);
    for (int k = 0; k < 2; k++)
        sum->slope[k] += w * slope[k];
}

/* A slant, and its slope. */
struct slope {
    int slant;
    float at[2];
};

/* The same of n surfaces of a row; many in turn have one slant, that of `last`. */
static inline void add_slants(struct block_sum *sum, const int16_t *slants, int n,
                              struct slope *last)
{
    for (int i = 0; i < n; i++) {
        if (slants[i] == 0)
            continue;
        if (slants[i] != last->slant)
            rf_slant_slope(slants[i], last->at);
        last->slant = slants[i];
        for (int k = 0; k < 2; k++)
            sum->slope[k] += last->at[k];
    }
}

/* Adds an item of a coarse level; the surfaces of a run block by block. */
static void reduce_item(const struct builder *b, struct worker *w,
                        const struct part *part, int level, uint64_t item)
{
    const struct rf_sample *p = rf_sample_of(&b->lister, &w->items, item);
    if (p) {
        struct block_sum *sum = block_of(&w->reducer, part, level, rf_floor_int(p->x),
                                         rf_floor_int(p->y), p->kind);
        add_to_block(sum, p->w, p->r, p->c);
        if (p->slant)
            add_slant(sum, p->w, p->slant);
        return;
    }
    int x = rf_packed_x(item), y = rf_packed_y(item), end = x + rf_packed_slot(item);
    const struct rf_surface *row = rf_tile_surface(&w->items.surfaces, 0, y);
    const int16_t *slants =
        w->items.has_slants ? w->items.slants + RF_TILE_W * y : NULL;
    int first = ((w->items.surfaces.y + y) >> level) - part->y0;
    first = (first * part->width + (x >> level)) * RF_N_KINDS + RF_SHARP;
    struct slope last = {0, {0, 0}};
    for (int block = first; x < end; block += RF_N_KINDS) {
        int stop = rf_min_int(((x >> level) + 1) << level, end);
        add_surfaces(sum_at(&w->reducer, block), row + x, stop - x);
        if (slants)
            add_slants(&w->reducer.sum[block], slants + x, stop - x, &last);
        x = stop;
    }
}

/* Empties the reducer into splats; returns how many. */
static int reduce_end(const struct rf_composer *c, struct worker *w,
                      const struct part *part, int level)
{
    struct reducer *reducer = &w->reducer;
    struct rf_splat *out = w->reduced;
    int centre = rf_centre_phase(c->footprints);
    float size = (float)(1 << level), scale = 1 / (size * size);
    for (int i = 0; i < reducer->n_touched; i++) {
        int block = reducer->touched[i], at = block / RF_N_KINDS;
        enum rf_footprint_kind kind = (enum rf_footprint_kind)(block % RF_N_KINDS);
        struct block_sum *b = &reducer->sum[block];
        out[i] = (struct rf_splat){
            .x = part->x0 + at % part->width,
            .y = part->y0 + at / part->width,
            .slot = rf_splat_slot(c, w->items.zone, b->rw / b->w / size, centre, kind,
                                  level),
            .cover = kind == RF_SHARP ? b->w * scale : 0,
        };
        for (int n = 0; n < 4; n++)
            out[i].c[n] = b->c[n] * scale;
        if (b->slope[0] != 0 || b->slope[1] != 0)
            out[i].slant =
                rf_slant_of((float[]){b->slope[0] / b->w, b->slope[1] / b->w});
        *b = (struct block_sum){0};
    }
    int n = reducer->n_touched;
    reducer->n_touched = 0;
    return n;
}

/* A copy that lasts as long as the lists; NULL: out of memory. */
static void *take_copy(const struct builder *b, struct worker *w, const void *from,
                       size_t n_bytes)
{
    void *memory = rf_arena_take(&b->lister.groups->arena, &w->room, n_bytes);
    return memory ? memcpy(memory, from, n_bytes) : NULL;
}

/* Counts a tile's samples by key: they will be count[key] .. count[key + 1]. */
static void count_keys(const struct builder *b, struct worker *w)
{
    int *count = w->count;
    memset(count, 0, ((size_t)b->n_keys + 1) * sizeof *count);
    w->items.key_runs[w->items.n_key_runs].first = w->items.n;
    for (const struct rf_key_run *r = w->items.key_runs;
         r < w->items.key_runs + w->items.n_key_runs; r++)
        count[r->key + 1] += r[1].first - r->first;
    for (int k = 0; k < b->n_keys; k++)
        count[k + 1] += count[k];
}

/* Sorts them, those of full resolution into `places`, the others into w->sorted. */
static void sort_tile(const struct builder *b, struct worker *w, uint64_t *places)
{
    const struct rf_group *full = rf_full_group(&b->lister);
    int *count = w->count, from = count[full->first_key];
    for (const struct rf_key_run *r = w->items.key_runs;
         r < w->items.key_runs + w->items.n_key_runs; r++) {
        int n = r[1].first - r->first, to = count[r->key];
        uint64_t *out = rf_is_full_key(full, r->key) ? places - from : w->sorted;
        for (int i = 0; i < n; i++) /* mostly few: no call */
            out[to + i] = w->items.at[r->first + i];
        count[r->key] += n;
    }
    for (int k = b->n_keys; k > 0; k--)
        count[k] = count[k - 1];
    count[0] = 0;
}

/* The list of n sorted samples as splats; some may come from an array. */
static bool keep_splats(const struct builder *b, struct worker *w, const uint64_t *at,
                        int n, struct rf_tile_list *list)
{
    struct rf_splat *out =
        rf_arena_take(&b->lister.groups->arena, &w->room, (size_t)n * sizeof *out);
    for (int i = 0; out && i < n; i++)
        out[i] = rf_packed_y(at[i]) == RF_ARRAY_ROW
                     ? rf_full_splat(b->lister.c, w->items.zone,
                                     rf_sample_of(&b->lister, &w->items, at[i]))
                     : rf_packed_splat(&w->items.surfaces, at[i], 0);
    list->at = out;
    return out != NULL;
}

/*
 * Sorts a tile's samples and makes the list of those of full resolution, as places of a
 * source where that is the smaller list; false: out of memory.
 */
static bool build_full(const struct builder *b, struct worker *w, int tile)
{
    const struct rf_group *g = rf_full_group(&b->lister);
    struct rf_tile_list *list = &g->tiles[tile];
    count_keys(b, w);
    int from = w->count[g->first_key], n = w->count[g->first_key + g->n_bins] - from;
    bool has_splats =
        w->items.has_array || (!w->items.has_runs && w->items.n_others > n / 4 * 3);
    uint64_t *places = w->sorted + from;
    if (n > 0 && !has_splats) {
        places = rf_arena_take(&b->lister.groups->arena, &w->room,
                               (size_t)n * sizeof *places);
        list->places = places;
        list->surfaces = w->items.surfaces;
        list->surfaces.others = take_copy(
            b, w, w->items.others, (size_t)w->items.n_others * sizeof *w->items.others);
        if (!places || !list->surfaces.others)
            return false;
    }
    sort_tile(b, w, places);
    if (n == 0)
        return true;
    list->bin = take_copy(b, w, w->count + g->first_key,
                          ((size_t)g->n_bins + 1) * sizeof *list->bin);
    if (!list->bin || (has_splats && !keep_splats(b, w, places, n, list)))
        return false;
    for (int k = 0; k <= g->n_bins; k++)
        list->bin[k] -= from;
    list->n = n;
    return true;
}

/* What a tile of full resolution has for the coarse group g. */
static bool build_runs(const struct builder *b, struct worker *w, int tile,
                       const struct rf_group *g, int *n_runs)
{
    struct part part = part_of(rf_full_group(&b->lister), tile, g->level);
    for (int key = g->first_key; key < g->first_key + g->n_bins; key++) {
        if (w->count[key] == w->count[key + 1])
            continue;
        for (int i = w->count[key]; i < w->count[key + 1]; i++)
            reduce_item(b, w, &part, g->level, w->sorted[i]);
        int n = reduce_end(b->lister.c, w, &part, g->level);
        struct run *run = &w->runs[(*n_runs)++];
        *run = (struct run){key, n,
                            take_copy(b, w, w->reduced, (size_t)n * sizeof *run->at)};
        if (!run->at)
            return false;
    }
    return true;
}

static bool build_tile(const struct builder *b, struct worker *w, int tile)
{
    rf_list_items(&b->lister, tile, &w->items);
    int n_runs = 0;
    if (w->items.n == 0)
        return true;
    if (!build_full(b, w, tile))
        return false;
    for (int k = 0; k < b->lister.groups->n; k++) {
        const struct rf_group *g = &b->lister.groups->at[k];
        if (g->level > 0 &&
            w->count[g->first_key] < w->count[g->first_key + g->n_bins] &&
            !build_runs(b, w, tile, g, &n_runs))
            return false;
    }
    struct run *runs = take_copy(b, w, w->runs, (size_t)n_runs * sizeof *runs);
    if (!runs)
        return false;
    b->runs[tile] = (struct tile_runs){n_runs, runs};
    return true;
}

/* ---- coarse tiles --------------------------------------------------------------- */

/* Calls for the runs of group g in the tiles of full resolution under one of its own:
 * counts them by bin or, with `out`, moves them to their places. */
static void visit_runs(const struct builder *b, const struct rf_group *g, int tile,
                       int *bin, struct rf_splat *out)
{
    const struct rf_group *full = rf_full_group(&b->lister);
    int x0 = (tile % g->n_x) << g->level, y0 = (tile / g->n_x) << g->level;
    int x1 = rf_min_int(x0 + (1 << g->level), full->n_x);
    int y1 = rf_min_int(y0 + (1 << g->level), full->n_y);
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++) {
            const struct tile_runs *runs = &b->runs[y * full->n_x + x];
            for (int i = 0; i < runs->n; i++) {
                const struct run *run = &runs->at[i];
                int k = run->key - g->first_key;
                if (k < 0 || k >= g->n_bins)
                    continue;
                if (out)
                    memcpy(out + bin[k], run->at, (size_t)run->n * sizeof *out);
                bin[k] += run->n;
            }
        }
}

/* Joins the list of one tile of a coarse group; false: out of memory. */
static bool join_runs(const struct builder *b, struct worker *w,
                      const struct rf_group *g, int tile)
{
    struct rf_tile_list *list = &g->tiles[tile];
    int *bin = w->count;
    memset(bin, 0, ((size_t)g->n_bins + 1) * sizeof *bin);
    visit_runs(b, g, tile, bin + 1, NULL);
    for (int k = 0; k < g->n_bins; k++)
        bin[k + 1] += bin[k];
    int n = bin[g->n_bins];
    if (n == 0)
        return true;
    size_t n_bin = ((size_t)g->n_bins + 1) * sizeof *bin;
    struct rf_splat *out =
        rf_arena_take(&b->lister.groups->arena, &w->room, (size_t)n * sizeof *out);
    list->bin = rf_arena_take(&b->lister.groups->arena, &w->room, n_bin);
    if (!out || !list->bin)
        return false;
    memcpy(list->bin, bin, n_bin);
    visit_runs(b, g, tile, bin, out);
    list->at = out;
    list->n = n;
    return true;
}

/* ---- all ------------------------------------------------------------------------ */

static rf_result make_workers(struct builder *b, struct rf_error *error)
{
    const struct rf_context *context = b->lister.c->context;
    size_t n = b->lister.most, n_reduced = RF_TILE_W * RF_TILE_H * RF_N_KINDS;
    size_t n_keys = (size_t)b->n_keys + 1;
    size_t n_others = b->lister.source ? (size_t)b->lister.source->most_per_pixel *
                                             RF_TILE_W * RF_TILE_H
                                       : 0;
    size_t bytes = n_others * (sizeof(struct rf_sample) + sizeof(struct rf_splat)) +
                   n * 2 * sizeof(uint64_t) + (n + 1) * sizeof(struct rf_key_run) +
                   n_keys * (sizeof(int) + sizeof(struct run)) +
                   n_reduced * sizeof(struct rf_splat);
    bytes = (bytes + 127) / 64 * 64;
    b->workers = rf_calloc(context, (size_t)b->lister.c->n_threads, sizeof *b->workers);
    b->memory = rf_alloc(context, (size_t)b->lister.c->n_threads, bytes);
    if (!b->workers || !b->memory)
        return rf_fail_memory(error, (size_t)b->lister.c->n_threads, bytes);
    for (int i = 0; i < b->lister.c->n_threads; i++) {
        struct worker *w = &b->workers[i];
        w->runs = (struct run *)(b->memory + bytes * (size_t)i);
        w->reduced = (struct rf_splat *)(w->runs + n_keys);
        w->items.others = w->reduced + n_reduced;
        w->items.samples = (struct rf_sample *)(w->items.others + n_others);
        w->items.at = (uint64_t *)(w->items.samples + n_others);
        w->sorted = w->items.at + n;
        w->items.key_runs = (struct rf_key_run *)(w->sorted + n);
        w->count = (int *)(w->items.key_runs + n + 1);
        if (!rf_arena_take(&b->lister.groups->arena, &w->room, 0))
            return rf_fail_memory(error, 1, b->lister.groups->arena.chunk_bytes);
    }
    return RF_OK;
}

/* Notes that there is no memory for a list. */
static void note_short(struct builder *b)
{
    __atomic_store_n(&b->is_short, true, __ATOMIC_RELAXED);
}

static bool is_over(const struct builder *b)
{
    return __atomic_load_n(&b->is_short, __ATOMIC_RELAXED) ||
           rf_task_is_cancelled(b->lister.c->scene->task);
}

static void build_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    struct builder *b = data;
    for (int i = (int)begin; i < (int)end && !is_over(b); i++) {
        if (!build_tile(b, &b->workers[thread], i))
            note_short(b);
        rf_task_step(b->lister.c->scene->task);
    }
}

/* Joins the lists of coarse tiles, which are counted through all groups. */
static void join_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    struct builder *b = data;
    int64_t first = 0; /* of a group */
    for (int k = 0; k < b->lister.groups->n; k++) {
        const struct rf_group *g = &b->lister.groups->at[k];
        int64_t n = g->level > 0 ? (int64_t)g->n_x * g->n_y : 0;
        for (int64_t i = begin; i < end && i < first + n && !is_over(b); i++, begin++)
            if (!join_runs(b, &b->workers[thread], g, (int)(i - first)))
                note_short(b);
        first += n;
    }
}

static rf_result build_lists(struct builder *b, struct rf_error *error)
{
    const struct rf_context *context = b->lister.c->context;
    int64_t n_coarse = 0;
    for (int k = 0; k < b->lister.groups->n; k++) {
        const struct rf_group *g = &b->lister.groups->at[k];
        n_coarse += g->level > 0 ? (int64_t)g->n_x * g->n_y : 0;
    }
    rf_parallel(context, (int64_t)b->lister.n_tiles, 1, build_tiles, b);
    rf_parallel(context, n_coarse, 1, join_tiles, b);
    return b->is_short ? rf_fail_memory(error, b->lister.most, sizeof(struct rf_splat))
                       : RF_OK;
}

/* The largest radius of samples, which threads look for together. */
struct largest {
    const struct rf_samples *samples;
    bool lock;
    float most;
};

static void find_largest(void *data, int64_t begin, int64_t end, int thread)
{
    struct largest *l = data;
    float most = 0;
    for (int64_t i = begin; i < end; i++)
        most = rf_max_float(most, fabsf(l->samples->at[i].r));
    rf_spin_lock(&l->lock);
    l->most = rf_max_float(l->most, most);
    rf_spin_unlock(&l->lock);
}

static float largest_radius(const struct rf_composer *c,
                            const struct rf_samples *samples)
{
    struct largest largest = {.samples = samples};
    rf_parallel(c->context, (int64_t)samples->n, RF_EQUAL_PARTS, find_largest,
                &largest);
    return largest.most;
}

/* Groups without lists. */
static rf_result make_groups(struct builder *b, struct rf_error *error)
{
    struct rf_groups *groups = b->lister.groups;
    const struct rf_context *context = b->lister.c->context;
    size_t n_tiles = 0;
    groups->n = 2 * b->lister.max_level + 1;
    for (int k = 0; k < groups->n; k++) {
        struct rf_group *g = &groups->at[k];
        *g = rf_group_make(b->lister.c, abs(k - b->lister.max_level),
                           k < b->lister.max_level);
        g->first_key = b->n_keys;
        b->n_keys += g->n_bins;
        n_tiles += (size_t)g->n_x * (size_t)g->n_y;
    }
    b->lister.n_tiles =
        (size_t)rf_full_group(&b->lister)->n_x * (size_t)rf_full_group(&b->lister)->n_y;
    groups->arena =
        rf_arena_make(context, b->lister.c->scene->width, b->lister.c->scene->height);
    groups->tiles = rf_calloc(context, n_tiles, sizeof *groups->tiles);
    b->runs = rf_calloc(context, b->lister.n_tiles, sizeof *b->runs);
    b->lister.c->needed =
        rf_calloc(context, rf_footprint_count(b->lister.c->footprints), 1);
    if (!groups->tiles || !b->runs || !b->lister.c->needed)
        return rf_fail_memory(error, n_tiles, sizeof *groups->tiles);
    n_tiles = 0;
    for (int k = 0; k < groups->n; k++) {
        struct rf_group *g = &groups->at[k];
        g->tiles = groups->tiles + n_tiles;
        n_tiles += (size_t)g->n_x * (size_t)g->n_y;
    }
    return RF_OK;
}

rf_result rf_groups_build(struct rf_groups *groups, struct rf_composer *c,
                          const struct rf_samples *samples,
                          const struct rf_source *source, double progress_to,
                          struct rf_error *error)
{
    const struct rf_context *context = c->context;
    struct builder b = {.lister = {.c = c, .groups = groups, .samples = samples}};
    if (source->emission)
        b.lister.source = source;
    float largest =
        b.lister.source ? source->largest_radius : largest_radius(c, samples);
    b.lister.max_level = rf_level_up_to(&c->levels, largest);
    rf_result result = make_groups(&b, error);
    rf_task_phase(c->scene->task, progress_to, (int64_t)b.lister.n_tiles);
    if (result == RF_OK && (!b.lister.source || samples->n > 0))
        result = rf_lister_sort(&b.lister, error);
    if (b.lister.source)
        b.lister.most += (size_t)source->most_per_pixel * RF_TILE_W * RF_TILE_H;
    if (result == RF_OK)
        result = make_workers(&b, error);
    if (result == RF_OK)
        result = build_lists(&b, error);
    rf_free(context, b.memory);
    rf_free(context, b.workers);
    rf_free(context, b.lister.order);
    rf_free(context, b.lister.start);
    rf_free(context, b.runs);
    return result;
}

void rf_groups_free(struct rf_groups *groups, const struct rf_context *context)
{
    rf_arena_free(&groups->arena);
    rf_free(context, groups->tiles);
}

void rf_lists_free(struct rf_lists *lists, const struct rf_context *context)
{
    for (int k = 0; k < 2; k++) {
        rf_groups_free(&lists->groups[k], context);
        rf_free(context, lists->needed[k]);
    }
    *lists = (struct rf_lists){.n_footprints = 0};
}
