/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Samples on their way into tiles: which level each belongs to, a counting sort by
 * level and tile, and the lists of every tile by bins of the radius; at coarse levels
 * the samples of a block and bin become one.
 */
#include <stdlib.h>

#include "composer.h"

enum {
    REACH_PX = 8, /* half extent of a footprint from which the resolution falls */
    BIN_PX = 2,
    N_CHUNKS = 16, /* of the counting sort: fixed, so that order is */
};

/* ---- levels -------------------------------------------------------------------- */

float rf_level_split(const struct rf_shape *shape)
{
    double extent[2];
    /* An ellipse that is wider than its radius must not outgrow the tile's halo. */
    rf_shape_extent(shape, extent);
    return (float)(REACH_PX / fmax(fmax(extent[0], extent[1]),
                                   fmax(shape->size[0], shape->size[1])));
}

int rf_level_of(float split, float r)
{
    int l = 0;
    for (r = fabsf(r); r >= split && l < RF_MAX_LEVEL; l++)
        split *= 2;
    return l;
}

struct rf_group rf_group_make(const struct rf_composer *c, int level, bool is_near)
{
    struct rf_group g = {.level = level, .is_near = is_near};
    int round_up = (1 << level) - 1;
    g.width = (c->scene->width + round_up) >> level;
    g.height = (c->scene->height + round_up) >> level;
    g.n_x = (g.width + RF_TILE_W - 1) / RF_TILE_W;
    g.n_y = (g.height + RF_TILE_H - 1) / RF_TILE_H;
    g.stride = (size_t)g.n_x * RF_TILE_W;
    g.plane = g.stride * (size_t)g.n_y * RF_TILE_H;
    double outer_px = ldexp(c->split, level), inner_px = level ? outer_px / 2 : 0;
    int outer = (int)ceil(outer_px / BIN_PX), inner = (int)floor(inner_px / BIN_PX);
    g.first_bin = level == 0 || is_near ? -outer : inner;
    g.n_bins = level ? outer - inner : 2 * outer;
    return g;
}

/* ---- sorting ------------------------------------------------------------------- */

struct sorter {
    const struct rf_composer *c;
    struct rf_group *groups;
    int max_level;
    size_t n_keys;
};

static size_t sample_key(const struct sorter *s, const struct rf_sample *p)
{
    int level = rf_min_int(rf_level_of(s->c->split, p->r), s->max_level);
    const struct rf_group *g =
        &s->groups[p->r < 0 ? s->max_level - level : s->max_level + level];
    int x = (int)floorf(p->x), y = (int)floorf(p->y);
    x = rf_min_int(rf_max_int(x, 0), s->c->scene->width - 1) >> level;
    y = rf_min_int(rf_max_int(y, 0), s->c->scene->height - 1) >> level;
    return g->first_key + (size_t)(y / RF_TILE_H) * (size_t)g->n_x +
           (size_t)(x / RF_TILE_W);
}

/*
 * A stable counting sort of the samples by group and tile: start[key] receives where a
 * key begins, `order` the samples' indices. The chunks' number is fixed.
 */
static rf_result sort_samples(const struct sorter *s, const struct rf_samples *samples,
                              uint32_t *order, size_t *start, struct rf_error *error)
{
    const struct rf_context *context = s->c->context;
    size_t n_keys = s->n_keys;
    size_t *count = rf_calloc(context, n_keys * N_CHUNKS, sizeof *count);
    uint32_t *keys = rf_alloc(context, samples->n, sizeof *keys);
    if (!count || !keys) {
        rf_free(context, count);
        rf_free(context, keys);
        return rf_fail_memory(error, samples->n, sizeof *keys);
    }
#pragma omp parallel for num_threads(s->c->n_threads) schedule(static, 1)
    for (int chunk = 0; chunk < N_CHUNKS; chunk++) {
        size_t from = samples->n * (size_t)chunk / N_CHUNKS;
        size_t to = samples->n * (size_t)(chunk + 1) / N_CHUNKS;
        for (size_t i = from; i < to; i++) {
            keys[i] = (uint32_t)sample_key(s, &samples->at[i]);
            count[(size_t)chunk * n_keys + keys[i]]++;
        }
    }
    size_t sum = 0;
    for (size_t key = 0; key < n_keys; key++) {
        start[key] = sum;
        for (size_t chunk = 0; chunk < N_CHUNKS; chunk++) {
            size_t n = count[chunk * n_keys + key];
            count[chunk * n_keys + key] = sum;
            sum += n;
        }
    }
    start[n_keys] = sum;
#pragma omp parallel for num_threads(s->c->n_threads) schedule(static, 1)
    for (int chunk = 0; chunk < N_CHUNKS; chunk++) {
        size_t from = samples->n * (size_t)chunk / N_CHUNKS;
        size_t to = samples->n * (size_t)(chunk + 1) / N_CHUNKS;
        for (size_t i = from; i < to; i++)
            order[count[(size_t)chunk * n_keys + keys[i]]++] = (uint32_t)i;
    }
    rf_free(context, count);
    rf_free(context, keys);
    return RF_OK;
}

/* ---- the samples of one tile --------------------------------------------------- */

/* Sums of the samples of one bin that share a block and a kind. */
struct block_sum {
    float c[4], w, rw;
};

struct reducer {
    struct block_sum sum[RF_TILE_W * RF_TILE_H * RF_N_KINDS];
    int touched[RF_TILE_W * RF_TILE_H * RF_N_KINDS];
    int n_touched;
};

static int bin_of(const struct rf_group *g, float r)
{
    int b = (int)floorf(r / BIN_PX) - g->first_bin;
    return rf_min_int(rf_max_int(b, 0), g->n_bins - 1);
}

static int32_t splat_slot(const struct rf_composer *c, float r, int level, int phase,
                          enum rf_footprint_kind kind)
{
    int index = rf_radius_index(&c->footprints, ldexpf(r, -level));
    return (int32_t)rf_footprint_slot(&c->footprints, index, phase, kind, level);
}

static struct rf_splat full_splat(const struct rf_composer *c,
                                  const struct rf_sample *p)
{
    struct rf_splat s = {
        .x = (int32_t)floorf(p->x),
        .y = (int32_t)floorf(p->y),
        .slot =
            splat_slot(c, p->r, 0, rf_phase_of(&c->footprints, p->x, p->y), p->kind),
        .cover = p->kind == RF_SHARP ? p->w : 0,
    };
    for (int n = 0; n < 4; n++)
        s.c[n] = p->c[n] * p->w;
    return s;
}

static void reduce_add(struct reducer *reducer, const struct rf_group *g,
                       const struct rf_sample *p, int x0, int y0)
{
    int x = ((int)floorf(p->x) >> g->level) - x0;
    int y = ((int)floorf(p->y) >> g->level) - y0;
    x = rf_min_int(rf_max_int(x, 0), RF_TILE_W - 1);
    y = rf_min_int(rf_max_int(y, 0), RF_TILE_H - 1);
    int block = (y * RF_TILE_W + x) * RF_N_KINDS + (int)p->kind;
    struct block_sum *b = &reducer->sum[block];
    if (b->w == 0)
        reducer->touched[reducer->n_touched++] = block;
    for (int n = 0; n < 4; n++)
        b->c[n] += p->w * p->c[n];
    b->w += p->w;
    b->rw += p->w * p->r;
}

/* Empties the reducer into splats; returns how many. */
static int reduce_end(const struct rf_composer *c, struct reducer *reducer,
                      const struct rf_group *g, int x0, int y0, struct rf_splat *out)
{
    int n_phases = c->footprints.n_phases;
    int center = n_phases > 1 ? n_phases / 2 * n_phases + n_phases / 2 : 0;
    float area = (float)(1 << g->level) * (float)(1 << g->level);
    for (int i = 0; i < reducer->n_touched; i++) {
        int block = reducer->touched[i], at = block / RF_N_KINDS;
        enum rf_footprint_kind kind = (enum rf_footprint_kind)(block % RF_N_KINDS);
        struct block_sum *b = &reducer->sum[block];
        out[i] = (struct rf_splat){
            .x = x0 + at % RF_TILE_W,
            .y = y0 + at / RF_TILE_W,
            .slot = splat_slot(c, b->rw / b->w, g->level, center, kind),
            .cover = kind == RF_SHARP ? b->w / area : 0,
        };
        for (int n = 0; n < 4; n++)
            out[i].c[n] = b->c[n] / area;
        *b = (struct block_sum){0};
    }
    int n = reducer->n_touched;
    reducer->n_touched = 0;
    return n;
}

/* Orders one tile's samples by bin, merging those of a block at coarse levels. */
static void build_list(const struct rf_composer *c, const struct rf_group *g, int tile,
                       const struct rf_sample *samples, uint32_t *order, int n,
                       uint32_t *scratch, struct reducer *reducer)
{
    struct rf_tile_list *list = &g->tiles[tile];
    int *bin = list->bin;
    memset(bin, 0, ((size_t)g->n_bins + 1) * sizeof *bin);
    for (int i = 0; i < n; i++)
        bin[bin_of(g, samples[order[i]].r) + 1]++;
    for (int b = 0; b < g->n_bins; b++)
        bin[b + 1] += bin[b];
    for (int i = 0; i < n; i++)
        scratch[bin[bin_of(g, samples[order[i]].r)]++] = order[i];
    for (int b = g->n_bins; b > 0; b--)
        bin[b] = bin[b - 1];
    bin[0] = 0;
    struct rf_splat *out = c->splats + list->first;
    if (g->level == 0) {
        for (int i = 0; i < n; i++)
            out[i] = full_splat(c, &samples[scratch[i]]);
        list->n = n;
        return;
    }
    int x0 = tile % g->n_x * RF_TILE_W, y0 = tile / g->n_x * RF_TILE_H, used = 0;
    for (int b = 0; b < g->n_bins; b++) {
        for (int i = bin[b]; i < bin[b + 1]; i++)
            reduce_add(reducer, g, &samples[scratch[i]], x0, y0);
        bin[b] = used;
        used += reduce_end(c, reducer, g, x0, y0, out + used);
    }
    bin[g->n_bins] = used;
    list->n = used;
}

/* Threads may find the same footprint at once. */
static void note_footprints(const struct rf_composer *c,
                            const struct rf_tile_list *list)
{
    for (int i = 0; i < list->n; i++)
        __atomic_store_n(&c->needed[c->splats[list->first + (size_t)i].slot], 1,
                         __ATOMIC_RELAXED);
}

/* The sorted samples become the lists of every tile of every group. */
static rf_result build_lists(struct rf_composer *c, struct sorter *s, int n_groups,
                             const struct rf_samples *samples, uint32_t *order,
                             const size_t *start, int *bins, struct rf_error *error)
{
    uint32_t *scratch = rf_alloc(c->context, samples->n, sizeof *scratch);
    struct reducer *reducers =
        rf_calloc(c->context, (size_t)c->n_threads, sizeof *reducers);
    if (!scratch || !reducers) {
        rf_free(c->context, scratch);
        rf_free(c->context, reducers);
        return rf_fail_memory(error, samples->n, sizeof *scratch);
    }
    for (int k = 0; k < n_groups; k++) {
        struct rf_group *g = &s->groups[k];
        int n_tiles = g->n_x * g->n_y;
#pragma omp parallel for num_threads(c->n_threads) schedule(dynamic, 4)
        for (int i = 0; i < n_tiles; i++) {
            size_t from = start[g->first_key + (size_t)i];
            size_t to = start[g->first_key + (size_t)i + 1];
            g->tiles[i] = (struct rf_tile_list){
                .first = from, .bin = bins + (size_t)i * (size_t)(g->n_bins + 1)};
            if (to > from)
                build_list(c, g, i, samples->at, order + from, (int)(to - from),
                           scratch + from, &reducers[rf_thread_num()]);
            note_footprints(c, &g->tiles[i]);
        }
        bins += (size_t)n_tiles * (size_t)(g->n_bins + 1);
        rf_task_step(c->scene->task);
    }
    rf_free(c->context, scratch);
    rf_free(c->context, reducers);
    return RF_OK;
}

static int max_level(const struct rf_composer *c, const struct rf_samples *samples)
{
    float most = 0;
#pragma omp parallel for num_threads(c->n_threads) schedule(static) reduction(max      \
                                                                              : most)
    for (size_t i = 0; i < samples->n; i++)
        most = rf_max_float(most, fabsf(samples->at[i].r));
    return rf_level_of(c->split, most);
}

rf_result rf_groups_build(struct rf_groups *groups, struct rf_composer *c,
                          const struct rf_samples *samples, double progress_to,
                          struct rf_error *error)
{
    struct sorter s = {
        .c = c, .groups = groups->at, .max_level = max_level(c, samples)};
    size_t n_bins = 0;
    groups->n = 2 * s.max_level + 1;
    for (int k = 0; k < groups->n; k++) {
        struct rf_group *g = &groups->at[k];
        *g = rf_group_make(c, abs(k - s.max_level), k < s.max_level);
        g->first_key = s.n_keys;
        size_t n_tiles = (size_t)g->n_x * (size_t)g->n_y;
        s.n_keys += n_tiles;
        n_bins += n_tiles * (size_t)(g->n_bins + 1);
    }
    const struct rf_context *context = c->context;
    groups->tiles = rf_calloc(context, s.n_keys, sizeof *groups->tiles);
    groups->bins = rf_alloc(context, n_bins, sizeof *groups->bins);
    size_t *start = rf_alloc(context, s.n_keys + 1, sizeof *start);
    uint32_t *order = rf_alloc(context, samples->n, sizeof *order);
    c->splats = rf_alloc(context, samples->n, sizeof *c->splats);
    c->needed = rf_calloc(context, rf_footprint_count(&c->footprints), 1);
    rf_result result =
        groups->tiles && groups->bins && start && order && c->splats && c->needed
            ? RF_OK
            : rf_fail_memory(error, samples->n, sizeof *c->splats);
    for (int k = 0; k < groups->n; k++)
        groups->at[k].tiles = groups->tiles + groups->at[k].first_key;
    rf_task_phase(c->scene->task, progress_to, 1 + groups->n);
    if (result == RF_OK)
        result = sort_samples(&s, samples, order, start, error);
    rf_task_step(c->scene->task);
    if (result == RF_OK)
        result =
            build_lists(c, &s, groups->n, samples, order, start, groups->bins, error);
    rf_free(context, order);
    rf_free(context, start);
    return result;
}

void rf_groups_free(struct rf_groups *groups, struct rf_composer *c)
{
    rf_free(c->context, c->needed);
    rf_free(c->context, c->splats);
    rf_free(c->context, groups->bins);
    rf_free(c->context, groups->tiles);
}
