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
#include <stdlib.h>

#include "composer.h"

enum { N_CHUNKS = 16 }; /* of the counting sort: fixed, so that order is */

/* ---- what threads work with ----------------------------------------------------- */

/* Sums of the samples of one bin that share a block and a kind. */
struct block_sum {
    float c[4], w, rw;
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

/* Samples in turn that share a key: from that item on to the next run's. */
struct key_run {
    int first, key;
};

struct worker {
    /* What a source emits for one tile, of coarse levels and of full resolution. */
    struct rf_sample *samples;
    struct rf_splat *others;
    uint64_t *items;           /* of its samples, see struct tile_samples */
    uint64_t *sorted;
    struct key_run *key_runs;
    int *count; /* n_keys + 1: where a key ends, later where it begins */
    struct run *runs;
    struct rf_splat *reduced; /* RF_N_KINDS tiles of them */
    struct rf_room room;
    struct reducer reducer;
};

struct builder {
    struct rf_composer *c;
    struct rf_groups *groups;
    int max_level, n_keys;
    size_t n_tiles;                 /* of full resolution */
    size_t most;                    /* samples of one of them */
    const struct rf_source *source; /* emits, if not NULL; beside the samples: */
    const struct rf_samples *samples;
    uint32_t *order;
    size_t *start; /* in `order`, per tile */
    struct tile_runs *runs;
    struct worker *workers;
    char *memory; /* of the workers */
};

static const struct rf_group *full_group(const struct builder *b)
{
    return &b->groups->at[b->max_level];
}

static int floor_int(float v)
{
    int i = (int)v;
    return i - (v < (float)i);
}

static int bin_of(const struct rf_group *g, float r)
{
    int bin = floor_int(r / RF_BIN_PX) - g->first_bin;
    return rf_min_int(rf_max_int(bin, 0), g->n_bins - 1);
}

static int key_of(const struct builder *b, float r)
{
    int level = rf_min_int(rf_level_of(b->c->split, r), b->max_level);
    const struct rf_group *g = &b->groups->at[b->max_level + (r < 0 ? -level : level)];
    return g->first_key + bin_of(g, r);
}

/* ---- samples in an array -------------------------------------------------------- */

static size_t tile_of(const struct builder *b, const struct rf_sample *p)
{
    const struct rf_group *g = full_group(b);
    int x = rf_min_int(rf_max_int(floor_int(p->x), 0), g->width - 1);
    int y = rf_min_int(rf_max_int(floor_int(p->y), 0), g->height - 1);
    return (size_t)(y / RF_TILE_H) * (size_t)g->n_x + (size_t)(x / RF_TILE_W);
}

/*
 * A stable counting sort of the samples by tile: start[tile] receives where a tile
 * begins, `order` the samples' indices. The chunks' number is fixed.
 */
static rf_result sort_samples(struct builder *b, struct rf_error *error)
{
    const struct rf_context *context = b->c->context;
    size_t n_keys = b->n_tiles, n = b->samples->n;
    b->start = rf_alloc(context, n_keys + 1, sizeof *b->start);
    b->order = rf_alloc(context, n, sizeof *b->order);
    size_t *count = rf_calloc(context, n_keys * N_CHUNKS, sizeof *count);
    uint32_t *keys = rf_alloc(context, n, sizeof *keys);
    if (!b->start || !b->order || !count || !keys) {
        rf_free(context, count);
        rf_free(context, keys);
        return rf_fail_memory(error, 2 * n, sizeof *keys);
    }
#pragma omp parallel for num_threads(b->c->n_threads) schedule(static, 1)
    for (int chunk = 0; chunk < N_CHUNKS; chunk++) {
        size_t from = n * (size_t)chunk / N_CHUNKS;
        size_t to = n * (size_t)(chunk + 1) / N_CHUNKS;
        for (size_t i = from; i < to; i++) {
            keys[i] = (uint32_t)tile_of(b, &b->samples->at[i]);
            count[(size_t)chunk * n_keys + keys[i]]++;
        }
    }
    size_t sum = 0;
    for (size_t key = 0; key < n_keys; key++) {
        b->start[key] = sum;
        for (size_t chunk = 0; chunk < N_CHUNKS; chunk++) {
            size_t m = count[chunk * n_keys + key];
            count[chunk * n_keys + key] = sum;
            sum += m;
        }
        b->most = sum - b->start[key] > b->most ? sum - b->start[key] : b->most;
    }
    b->start[n_keys] = sum;
#pragma omp parallel for num_threads(b->c->n_threads) schedule(static, 1)
    for (int chunk = 0; chunk < N_CHUNKS; chunk++) {
        size_t from = n * (size_t)chunk / N_CHUNKS;
        size_t to = n * (size_t)(chunk + 1) / N_CHUNKS;
        for (size_t i = from; i < to; i++)
            b->order[count[(size_t)chunk * n_keys + keys[i]]++] = (uint32_t)i;
    }
    rf_free(context, count);
    rf_free(context, keys);
    return RF_OK;
}

/* ---- the samples of one tile ---------------------------------------------------- */

/*
 * The samples of a tile, items: places of a source, whose other samples are `others`,
 * runs of its places, or samples of an array.
 */
struct tile_samples {
    int n, n_key_runs, n_samples, n_others; /* of the worker */
    bool has_array;
    struct rf_tile_surfaces surfaces; /* of a source */
};

/* A sample of an array: its index as the slot of a place outside the tile. */
enum { ARRAY_ROW = 255 };

static uint64_t array_item(uint32_t i)
{
    return rf_place_make((int32_t)i, 0, ARRAY_ROW, 0);
}

/* The sample that an item of a coarse level is; NULL: a run of surfaces. */
static const struct rf_sample *sample_of(const struct builder *b,
                                         const struct worker *w, uint64_t item)
{
    if (rf_place_y(item) == ARRAY_ROW)
        return &b->samples->at[(uint32_t)rf_place_slot(item)];
    return rf_place_other(item) ? &w->samples[rf_place_other(item) - 1] : NULL;
}

static int32_t splat_slot(const struct rf_composer *c, float r, int phase,
                          enum rf_footprint_kind kind, int level)
{
    int index = rf_radius_index(c->footprints, r);
    size_t slot = rf_footprint_slot(c->footprints, index, phase, kind, level);
    /* Threads may find the same footprint at once. */
    if (!__atomic_load_n(&c->needed[slot], __ATOMIC_RELAXED))
        __atomic_store_n(&c->needed[slot], 1, __ATOMIC_RELAXED);
    return (int32_t)slot;
}

static struct rf_splat full_splat(const struct rf_composer *c,
                                  const struct rf_sample *p)
{
    int phase =
        c->footprints->n_phases == 1 ? 0 : rf_phase_of(c->footprints, p->x, p->y);
    struct rf_splat s = {
        .x = floor_int(p->x),
        .y = floor_int(p->y),
        .slot = splat_slot(c, p->r, phase, p->kind, 0),
        .cover = p->kind == RF_SHARP ? p->w : 0,
    };
    for (int n = 0; n < 4; n++)
        s.c[n] = p->c[n] * p->w;
    return s;
}

/*
 * A radius with its key: pixels repeat them. At full resolution also its slot, of a
 * coarse level the radii that certainly have the same key, without the limits.
 */
struct known_radius {
    float r;
    int key;
    bool is_full;
    int32_t slot;
    float low, high;
};

static bool is_full_key(const struct rf_group *full, int key)
{
    return key >= full->first_key && key < full->first_key + full->n_bins;
}

/* The radii of a coarse level and bin, of which r is one. */
static void know_range(const struct builder *b, float r, struct known_radius *known)
{
    int level = rf_min_int(rf_level_of(b->c->split, r), b->max_level);
    const struct rf_group *g = &b->groups->at[b->max_level + (r < 0 ? -level : level)];
    int bin = floor_int(r / RF_BIN_PX);
    float outer = ldexpf(b->c->split, level), inner = outer / 2;
    known->low = known->high = r;
    if (bin - g->first_bin != bin_of(g, r))
        return;
    known->low = rf_max_float((float)bin * RF_BIN_PX, r < 0 ? -outer : inner);
    known->high = rf_min_float((float)(bin + 1) * RF_BIN_PX, r < 0 ? -inner : outer);
}

static void know_radius(const struct builder *b, const struct rf_group *full, float r,
                        struct known_radius *known)
{
    known->r = r;
    known->key = key_of(b, r);
    known->is_full = is_full_key(full, known->key);
    if (known->is_full)
        known->slot =
            splat_slot(b->c, r, rf_centre_phase(b->c->footprints), RF_SHARP, 0);
    else
        know_range(b, r, known);
}

/* Of the items that follow. */
static inline void set_key(struct worker *w, struct tile_samples *s, int key)
{
    if (s->n_key_runs == 0 || w->key_runs[s->n_key_runs - 1].key != key)
        w->key_runs[s->n_key_runs++] = (struct key_run){s->n, key};
}

static inline void put_item(struct worker *w, struct tile_samples *s, uint64_t item,
                            int key)
{
    set_key(w, s, key);
    w->items[s->n++] = item;
}

/* The samples of a pixel that emits others than its surface. */
static void emit_pixel(const struct builder *b, const struct rf_group *full,
                       struct worker *w, int x, int y, struct tile_samples *s)
{
    const struct rf_source *source = b->source;
    struct rf_sample *at = w->samples + s->n_samples;
    int n = source->emit(source->user, s->surfaces.x + x, s->surfaces.y + y, at);
    for (int i = 0; i < n; i++, at++) {
        int key = key_of(b, at->r), other;
        int32_t slot = 0;
        if (is_full_key(full, key)) {
            struct rf_splat *splat = &w->others[s->n_others];
            *splat = full_splat(b->c, at);
            slot = splat->slot;
            other = ++s->n_others;
        } else {
            w->samples[s->n_samples] = *at;
            other = ++s->n_samples;
        }
        put_item(w, s, rf_place_make(slot, x, y, other), key);
    }
}

/* The radii of n pixels of row y of a tile, those of `plain`, in place or in `own`. */
static const float *radii_of_row(const struct rf_source *source,
                                 const struct rf_tile_surfaces *t, int y,
                                 uint64_t plain, float own[RF_TILE_W])
{
    ptrdiff_t row = t->y + y - source->y;
    if (source->radius)
        return source->radius + (ptrdiff_t)source->radius_stride * row + t->x -
               source->x;
    for (; plain; plain &= plain - 1) {
        int x = __builtin_ctzll(plain);
        own[x] = rf_tile_surface(t, x, y)->r;
    }
    return own;
}

typedef int32_t truths __attribute__((vector_size(16)));

/* Which of four radii are `same` or lie between two others. */
static inline truths are_alike(const float *radius, float low, float high, float same)
{
    rf_quad r = *(const rf_quad *)radius;
    return (((rf_quad){low, low, low, low} < r) &
            (r < (rf_quad){high, high, high, high})) |
           (r == (rf_quad){same, same, same, same});
}

/* The first pixel from x0 on whose radius is not alike, x1 if there is none. */
static inline int alike_end(const float *radius, int x0, int x1, float low, float high,
                            float same)
{
    int x = x0;
    for (; x + 8 <= x1; x += 8) {
        truths all = are_alike(radius + x, low, high, same) &
                     are_alike(radius + x + 4, low, high, same);
        if (!(all[0] & all[1] & all[2] & all[3]))
            break;
    }
    while (x < x1 && ((low < radius[x] && radius[x] < high) || radius[x] == same))
        x++;
    return x;
}

/*
 * The surfaces of pixels x0 to x1 - 1 of row y of a tile, an item each, while they are
 * of full resolution; returns where they end. The first one's radius is known.
 */
static int put_places(const struct builder *b, const struct rf_group *full,
                      struct worker *w, int x0, int x1, int y, const float *radius,
                      struct known_radius *known, struct tile_samples *s)
{
    uint64_t *items = w->items + s->n - x0, item = rf_place_make(known->slot, 0, y, 0);
    int x = x0;
    set_key(w, s, known->key);
    for (;;) {
        int end = alike_end(radius, x + 1, x1, NAN, NAN, known->r);
        for (; x < end; x++)
            items[x] = item | rf_place_make(0, x, 0, 0);
        s->n = (int)(items + x - w->items);
        if (x == x1)
            return x;
        know_radius(b, full, radius[x], known);
        if (!known->is_full)
            return x;
        item = rf_place_make(known->slot, 0, y, 0);
        set_key(w, s, known->key);
    }
}

/* Asks for surfaces of a row: they are summed when all of the tile are listed. */
static void prefetch_surfaces(const struct rf_tile_surfaces *t, int x0, int x1, int y)
{
    const char *at = (const char *)rf_tile_surface(t, x0, y);
    const char *end = (const char *)rf_tile_surface(t, x1, y);
    for (; at < end; at += 64)
        __builtin_prefetch(at);
    __builtin_prefetch(end - 1);
}

/* The same of a coarse level: an item for all that share a key, its slot their number.
 */
static int put_run(struct worker *w, int x0, int x1, int y, const float *radius,
                   const struct known_radius *known, struct tile_samples *s)
{
    int x = alike_end(radius, x0 + 1, x1, known->low, known->high, known->r);
    prefetch_surfaces(&s->surfaces, x0, x, y);
    put_item(w, s, rf_place_make(x - x0, x0, y, 0), known->key);
    return x;
}

/* The surfaces of pixels x0 to x1 - 1 of row y of a tile. */
static void put_plain(const struct builder *b, const struct rf_group *full,
                      struct worker *w, int x0, int x1, int y, const float *radius,
                      struct known_radius *known, struct tile_samples *s)
{
    while (x0 < x1) {
        if (radius[x0] != known->r)
            know_radius(b, full, radius[x0], known);
        x0 = known->is_full ? put_places(b, full, w, x0, x1, y, radius, known, s)
                            : put_run(w, x0, x1, y, radius, known, s);
    }
}

/* The samples of a source in n pixels of row y of a tile, after those of other rows. */
static void survey_row(const struct builder *b, const struct rf_group *full,
                       struct worker *w, int y, int n, struct known_radius *known,
                       struct tile_samples *s)
{
    const struct rf_tile_surfaces *t = &s->surfaces;
    struct rf_emission e = b->source->survey(b->source->user, t->x, t->y + y, n);
    float own[RF_TILE_W];
    const float *radius =
        e.plain ? radii_of_row(b->source, t, y, e.plain, own) : NULL;
    for (uint64_t any = e.plain | e.other; any;) {
        int x = __builtin_ctzll(any);
        if (e.other >> x & 1) {
            emit_pixel(b, full, w, x, y, s);
            any &= any - 1;
            continue;
        }
        uint64_t rest = ~(e.plain >> x);
        int x1 = rest ? x + __builtin_ctzll(rest) : RF_TILE_W;
        put_plain(b, full, w, x, x1, y, radius, known, s);
        any = x1 < 64 ? any >> x1 << x1 : 0;
    }
}

/* The samples of a source in a tile. */
static void survey_tile(const struct builder *b, struct worker *w, int tile,
                        struct tile_samples *s)
{
    const struct rf_group *g = full_group(b);
    const struct rf_source *source = b->source;
    int x0 = tile % g->n_x * RF_TILE_W, y0 = tile / g->n_x * RF_TILE_H;
    struct known_radius known = {.r = NAN};
    s->surfaces = (struct rf_tile_surfaces){
        .at = source->surfaces,
        .first = (ptrdiff_t)(y0 - source->y) * g->width + x0 - source->x,
        .width = (size_t)g->width,
        .others = w->others,
        .x = x0,
        .y = y0};
    int n_x = rf_min_int(g->width - x0, RF_TILE_W);
    int n_y = rf_min_int(g->height - y0, RF_TILE_H);
    for (int y = 0; y < n_y; y++)
        survey_row(b, g, w, y, n_x, &known, s);
}

/* The samples of a tile with their keys. */
static struct tile_samples samples_of(const struct builder *b, struct worker *w,
                                      int tile)
{
    struct tile_samples s = {.n = 0};
    if (b->source)
        survey_tile(b, w, tile, &s);
    if (!b->start)
        return s;
    s.has_array = b->start[tile + 1] > b->start[tile];
    for (size_t i = b->start[tile]; i < b->start[tile + 1]; i++) {
        uint32_t at = b->order[i];
        put_item(w, &s, array_item(at), key_of(b, b->samples->at[at].r));
    }
    return s;
}

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

/* Adds an item of a coarse level; the surfaces of a run block by block. */
static void reduce_item(const struct builder *b, struct worker *w,
                        const struct part *part, int level,
                        const struct tile_samples *s, uint64_t item)
{
    const struct rf_sample *p = sample_of(b, w, item);
    if (p) {
        struct block_sum *sum = block_of(&w->reducer, part, level, floor_int(p->x),
                                         floor_int(p->y), p->kind);
        add_to_block(sum, p->w, p->r, p->c);
        return;
    }
    int x = rf_place_x(item), y = rf_place_y(item), end = x + rf_place_slot(item);
    const struct rf_surface *row = rf_tile_surface(&s->surfaces, 0, y);
    int first = ((s->surfaces.y + y) >> level) - part->y0;
    first = (first * part->width + (x >> level)) * RF_N_KINDS + RF_SHARP;
    for (int block = first; x < end; block += RF_N_KINDS) {
        int stop = rf_min_int(((x >> level) + 1) << level, end);
        add_surfaces(sum_at(&w->reducer, block), row + x, stop - x);
        x = stop;
    }
}

/* Empties the reducer into splats; returns how many. */
static int reduce_end(const struct rf_composer *c, struct reducer *reducer,
                      const struct part *part, int level, struct rf_splat *out)
{
    int centre = rf_centre_phase(c->footprints);
    float size = (float)(1 << level), scale = 1 / (size * size);
    for (int i = 0; i < reducer->n_touched; i++) {
        int block = reducer->touched[i], at = block / RF_N_KINDS;
        enum rf_footprint_kind kind = (enum rf_footprint_kind)(block % RF_N_KINDS);
        struct block_sum *b = &reducer->sum[block];
        out[i] = (struct rf_splat){
            .x = part->x0 + at % part->width,
            .y = part->y0 + at / part->width,
            .slot = splat_slot(c, b->rw / b->w / size, centre, kind, level),
            .cover = kind == RF_SHARP ? b->w * scale : 0,
        };
        for (int n = 0; n < 4; n++)
            out[i].c[n] = b->c[n] * scale;
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
    void *memory = rf_arena_take(&b->groups->arena, &w->room, n_bytes);
    return memory ? memcpy(memory, from, n_bytes) : NULL;
}

/* Counts a tile's samples by key: they will be count[key] .. count[key + 1]. */
static void count_keys(const struct builder *b, struct worker *w,
                       const struct tile_samples *s)
{
    int *count = w->count;
    memset(count, 0, ((size_t)b->n_keys + 1) * sizeof *count);
    w->key_runs[s->n_key_runs].first = s->n;
    for (const struct key_run *r = w->key_runs; r < w->key_runs + s->n_key_runs; r++)
        count[r->key + 1] += r[1].first - r->first;
    for (int k = 0; k < b->n_keys; k++)
        count[k + 1] += count[k];
}

/* Sorts them, those of full resolution into `places`, the others into w->sorted. */
static void sort_tile(const struct builder *b, struct worker *w,
                      const struct tile_samples *s, uint64_t *places)
{
    const struct rf_group *full = full_group(b);
    int *count = w->count, from = count[full->first_key];
    for (const struct key_run *r = w->key_runs; r < w->key_runs + s->n_key_runs; r++) {
        int n = r[1].first - r->first, to = count[r->key];
        uint64_t *out = is_full_key(full, r->key) ? places - from : w->sorted;
        memcpy(out + to, w->items + r->first, (size_t)n * sizeof *out);
        count[r->key] += n;
    }
    for (int k = b->n_keys; k > 0; k--)
        count[k] = count[k - 1];
    count[0] = 0;
}

static struct rf_splat plain_splat(const struct tile_samples *s, uint64_t place)
{
    int x = rf_place_x(place), y = rf_place_y(place);
    struct rf_splat splat = {.x = s->surfaces.x + x,
                             .y = s->surfaces.y + y,
                             .slot = rf_place_slot(place),
                             .cover = 1};
    memcpy(splat.c, rf_tile_surface(&s->surfaces, x, y)->c, sizeof splat.c);
    return splat;
}

/* The list of n sorted samples as splats; some may come from an array. */
static bool keep_splats(const struct builder *b, struct worker *w, const uint64_t *at,
                        int n, const struct tile_samples *s, struct rf_tile_list *list)
{
    struct rf_splat *out =
        rf_arena_take(&b->groups->arena, &w->room, (size_t)n * sizeof *out);
    for (int i = 0; out && i < n; i++) {
        int other = rf_place_other(at[i]);
        out[i] = rf_place_y(at[i]) == ARRAY_ROW
                     ? full_splat(b->c, sample_of(b, w, at[i]))
                 : other ? w->others[other - 1]
                         : plain_splat(s, at[i]);
    }
    list->at = out;
    return out != NULL;
}

/*
 * Sorts a tile's samples and makes the list of those of full resolution, as places of a
 * source where that is the smaller list; false: out of memory.
 */
static bool build_full(const struct builder *b, struct worker *w, int tile,
                       const struct tile_samples *s)
{
    const struct rf_group *g = full_group(b);
    struct rf_tile_list *list = &g->tiles[tile];
    count_keys(b, w, s);
    int from = w->count[g->first_key], n = w->count[g->first_key + g->n_bins] - from;
    bool has_splats = s->has_array || s->n_others > n / 4 * 3;
    uint64_t *places = w->sorted + from;
    if (n > 0 && !has_splats) {
        places = rf_arena_take(&b->groups->arena, &w->room, (size_t)n * sizeof *places);
        list->places = places;
        list->surfaces = s->surfaces;
        list->surfaces.others =
            take_copy(b, w, w->others, (size_t)s->n_others * sizeof *w->others);
        if (!places || !list->surfaces.others)
            return false;
    }
    sort_tile(b, w, s, places);
    if (n == 0)
        return true;
    list->bin = take_copy(b, w, w->count + g->first_key,
                          ((size_t)g->n_bins + 1) * sizeof *list->bin);
    if (!list->bin || (has_splats && !keep_splats(b, w, places, n, s, list)))
        return false;
    for (int k = 0; k <= g->n_bins; k++)
        list->bin[k] -= from;
    list->n = n;
    return true;
}

/* What a tile of full resolution has for the coarse group g. */
static bool build_runs(const struct builder *b, struct worker *w, int tile,
                       const struct rf_group *g, const struct tile_samples *s,
                       int *n_runs)
{
    struct part part = part_of(full_group(b), tile, g->level);
    for (int key = g->first_key; key < g->first_key + g->n_bins; key++) {
        if (w->count[key] == w->count[key + 1])
            continue;
        for (int i = w->count[key]; i < w->count[key + 1]; i++)
            reduce_item(b, w, &part, g->level, s, w->sorted[i]);
        int n = reduce_end(b->c, &w->reducer, &part, g->level, w->reduced);
        struct run *run = &w->runs[(*n_runs)++];
        *run = (struct run){
            key, n, take_copy(b, w, w->reduced, (size_t)n * sizeof *run->at)};
        if (!run->at)
            return false;
    }
    return true;
}

static bool build_tile(const struct builder *b, struct worker *w, int tile)
{
    struct tile_samples s = samples_of(b, w, tile);
    int n_runs = 0;
    if (s.n == 0)
        return true;
    if (!build_full(b, w, tile, &s))
        return false;
    for (int k = 0; k < b->groups->n; k++) {
        const struct rf_group *g = &b->groups->at[k];
        if (g->level > 0 &&
            w->count[g->first_key] < w->count[g->first_key + g->n_bins] &&
            !build_runs(b, w, tile, g, &s, &n_runs))
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
    const struct rf_group *full = full_group(b);
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
        rf_arena_take(&b->groups->arena, &w->room, (size_t)n * sizeof *out);
    list->bin = rf_arena_take(&b->groups->arena, &w->room, n_bin);
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
    const struct rf_context *context = b->c->context;
    size_t n = b->most, n_reduced = RF_TILE_W * RF_TILE_H * RF_N_KINDS;
    size_t n_keys = (size_t)b->n_keys + 1;
    size_t n_others =
        b->source ? (size_t)b->source->most_per_pixel * RF_TILE_W * RF_TILE_H : 0;
    size_t bytes = n_others * (sizeof(struct rf_sample) + sizeof(struct rf_splat)) +
                   n * 2 * sizeof(uint64_t) + (n + 1) * sizeof(struct key_run) +
                   n_keys * (sizeof(int) + sizeof(struct run)) +
                   n_reduced * sizeof(struct rf_splat);
    bytes = (bytes + 127) / 64 * 64;
    b->workers = rf_calloc(context, (size_t)b->c->n_threads, sizeof *b->workers);
    b->memory = rf_alloc(context, (size_t)b->c->n_threads, bytes);
    if (!b->workers || !b->memory)
        return rf_fail_memory(error, (size_t)b->c->n_threads, bytes);
    for (int i = 0; i < b->c->n_threads; i++) {
        struct worker *w = &b->workers[i];
        w->runs = (struct run *)(b->memory + bytes * (size_t)i);
        w->reduced = (struct rf_splat *)(w->runs + n_keys);
        w->others = w->reduced + n_reduced;
        w->samples = (struct rf_sample *)(w->others + n_others);
        w->items = (uint64_t *)(w->samples + n_others);
        w->sorted = w->items + n;
        w->key_runs = (struct key_run *)(w->sorted + n);
        w->count = (int *)(w->key_runs + n + 1);
        if (!rf_arena_take(&b->groups->arena, &w->room, 0))
            return rf_fail_memory(error, 1, b->groups->arena.chunk_bytes);
    }
    return RF_OK;
}

static rf_result build_lists(struct builder *b, struct rf_error *error)
{
    struct rf_task *task = b->c->scene->task;
    bool is_short = false; /* of memory */
#pragma omp parallel num_threads(b->c->n_threads) reduction(|| : is_short)
    {
        struct worker *w = &b->workers[rf_thread_num()];
#pragma omp for schedule(dynamic, 1)
        for (int i = 0; i < (int)b->n_tiles; i++)
            if (!is_short && !rf_task_is_cancelled(task)) {
                is_short = !build_tile(b, w, i);
                rf_task_step(task);
            }
        for (int k = 0; k < b->groups->n; k++) {
            const struct rf_group *g = &b->groups->at[k];
            if (g->level == 0)
                continue;
#pragma omp for schedule(dynamic, 1) nowait
            for (int i = 0; i < g->n_x * g->n_y; i++)
                if (!is_short && !rf_task_is_cancelled(task))
                    is_short = !join_runs(b, w, g, i);
        }
    }
    return is_short ? rf_fail_memory(error, b->most, sizeof(struct rf_splat)) : RF_OK;
}

static float largest_radius(const struct rf_composer *c,
                            const struct rf_samples *samples)
{
    float most = 0;
#pragma omp parallel for num_threads(c->n_threads) schedule(static) reduction(max      \
                                                                              : most)
    for (size_t i = 0; i < samples->n; i++)
        most = rf_max_float(most, fabsf(samples->at[i].r));
    return most;
}

/* Groups without lists. */
static rf_result make_groups(struct builder *b, struct rf_error *error)
{
    struct rf_groups *groups = b->groups;
    const struct rf_context *context = b->c->context;
    size_t n_tiles = 0;
    groups->n = 2 * b->max_level + 1;
    for (int k = 0; k < groups->n; k++) {
        struct rf_group *g = &groups->at[k];
        *g = rf_group_make(b->c, abs(k - b->max_level), k < b->max_level);
        g->first_key = b->n_keys;
        b->n_keys += g->n_bins;
        n_tiles += (size_t)g->n_x * (size_t)g->n_y;
    }
    b->n_tiles = (size_t)full_group(b)->n_x * (size_t)full_group(b)->n_y;
    groups->arena = rf_arena_make(context, b->c->scene->width, b->c->scene->height);
    groups->tiles = rf_calloc(context, n_tiles, sizeof *groups->tiles);
    b->runs = rf_calloc(context, b->n_tiles, sizeof *b->runs);
    b->c->needed = rf_calloc(context, rf_footprint_count(b->c->footprints), 1);
    if (!groups->tiles || !b->runs || !b->c->needed)
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
    struct builder b = {.c = c, .groups = groups, .samples = samples};
    if (source->survey)
        b.source = source;
    float largest = b.source ? source->largest_radius : largest_radius(c, samples);
    b.max_level = rf_level_of(c->split, largest);
    rf_result result = make_groups(&b, error);
    rf_task_phase(c->scene->task, progress_to, (int64_t)b.n_tiles);
    if (result == RF_OK && (!b.source || samples->n > 0))
        result = sort_samples(&b, error);
    if (b.source)
        b.most += (size_t)source->most_per_pixel * RF_TILE_W * RF_TILE_H;
    if (result == RF_OK)
        result = make_workers(&b, error);
    if (result == RF_OK)
        result = build_lists(&b, error);
    rf_free(context, b.memory);
    rf_free(context, b.workers);
    rf_free(context, b.order);
    rf_free(context, b.start);
    rf_free(context, b.runs);
    return result;
}

void rf_groups_free(struct rf_groups *groups, const struct rf_composer *c)
{
    rf_arena_free(&groups->arena);
    rf_free(c->context, groups->tiles);
}
