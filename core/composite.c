/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Compositing (recipe step 6), at a cost that does not grow with the radius.
 *
 * Samples gather in fixed bins of 2 px of signed radius, near to far. For each pixel p
 * and sub-aperture c, with T(p, c) what is still uncovered,
 *
 *   w = min(coverage of the bin, T),  out += colour w / coverage,  T -= w
 *
 * a saturating sum: a continuous surface that a bin border cuts adds up to exactly 1
 * (the kernel rounds a coverage of 95 % of T or more up to T).
 *
 * Levels. |r| < 8 px (less for shapes wider than high) is spread at full resolution.
 * Level l = 1, 2, ... takes 8 2^(l-1)
 * <= |r| < 8 2^l at 1/2^l resolution, where the radius is again 4 to 8 px: the samples
 * of a block and bin become one. Each level starts from T averaged down to it, T_l, and
 * gives sums S_l with coverage W_l; at full resolution, bilinearly magnified,
 *
 *   w = T min(1, W_l / T_l),  out += S_l w / W_l,  T -= w
 *
 * The order is: near levels, coarse to fine; level 0; far levels, fine to coarse; first
 * for the visible samples and then for the hidden ones, which so fill only what is
 * left. Averaging down and magnifying widen a footprint by 4^l / 4 px^2 per axis (box
 * and tent), so its radius is shortened to keep the second moment r^2/4.
 *
 * Work is cut into tiles of 64 x 32 px of the level; a tile is one thread's from its
 * first bin to its last, and the order of sums in it is fixed.
 */
#include <stdlib.h>

#include "composite.h"
#include "kernels/kernels.h"

enum {
    MAX_LEVEL = 12,
    REACH_PX = 8, /* half extent of a footprint from which the resolution falls */
    BIN_PX = 2,
    N_CHUNKS = 16, /* of the counting sort: fixed, so that order is */
};

/* Lists of one tile's samples, ordered by bin. */
struct tile_list {
    size_t first; /* in composer.splats */
    int n;
    int *bin; /* n_bins + 1 offsets into the list; NULL where empty */
};

/* All samples of one level and side of the focus. */
struct group {
    int level;
    bool is_near;
    int width, height, n_x, n_y; /* of the level: pixels, tiles */
    size_t stride, plane;        /* of its planes, which are whole tiles; floats */
    int n_bins, first_bin;
    size_t first_key; /* of its tiles in the sort */
    struct tile_list *tiles;
};

/* Full-resolution state of the compositing, in whole tiles. */
struct canvas {
    int n_cells, n_planes;
    size_t stride, plane; /* floats */
    float *t;   /* [cell][y][x], what is still uncovered; starts at the cell's share */
    float *sum; /* [plane][y][x], colours and coverage */
};

struct composer {
    const struct rf_scene *scene;
    const struct rf_context *context;
    const struct rf_kernels *kernels;
    struct canvas canvas;
    struct rf_footprints footprints;
    struct rf_accumulator *acc; /* one per thread */
    float *tiles;               /* per thread: t and sums of a tile */
    size_t tile_floats;
    struct rf_splat *splats;
    float split; /* radius from which the resolution falls, px */
    int n_threads;
};

/* ---- levels -------------------------------------------------------------------- */

static int level_of(const struct composer *c, float r)
{
    float limit = c->split;
    int l = 0;
    for (r = fabsf(r); r >= limit && l < MAX_LEVEL; l++)
        limit *= 2;
    return l;
}

static struct group make_group(const struct composer *c, int level, bool is_near)
{
    struct group g = {.level = level, .is_near = is_near};
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
    const struct composer *c;
    struct group *groups;
    int max_level;
    size_t n_keys;
};

static size_t sample_key(const struct sorter *s, const struct rf_sample *p)
{
    int level = rf_min_int(level_of(s->c, p->r), s->max_level);
    const struct group *g =
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

static int bin_of(const struct group *g, float r)
{
    int b = (int)floorf(r / BIN_PX) - g->first_bin;
    return rf_min_int(rf_max_int(b, 0), g->n_bins - 1);
}

static int32_t splat_slot(const struct composer *c, float r, int level, int phase,
                          enum rf_footprint_kind kind)
{
    int index = rf_radius_index(&c->footprints, ldexpf(r, -level));
    return (int32_t)rf_footprint_slot(&c->footprints, index, phase, kind, level);
}

static struct rf_splat full_splat(const struct composer *c, const struct rf_sample *p)
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

static void reduce_add(struct reducer *reducer, const struct group *g,
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
static int reduce_end(const struct composer *c, struct reducer *reducer,
                      const struct group *g, int x0, int y0, struct rf_splat *out)
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
static void build_list(const struct composer *c, const struct group *g, int tile,
                       const struct rf_sample *samples, uint32_t *order, int n,
                       uint32_t *scratch, struct reducer *reducer)
{
    struct tile_list *list = &g->tiles[tile];
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

/* ---- tiles --------------------------------------------------------------------- */

static bool has_neighbours(const struct group *g, int tx, int ty)
{
    for (int y = rf_max_int(ty - 1, 0); y <= rf_min_int(ty + 1, g->n_y - 1); y++)
        for (int x = rf_max_int(tx - 1, 0); x <= rf_min_int(tx + 1, g->n_x - 1); x++)
            if (g->tiles[y * g->n_x + x].n)
                return true;
    return false;
}

static bool is_used_up(const float *t, size_t n)
{
    float most = 0;
    for (size_t i = 0; i < n; i++)
        most = t[i] > most ? t[i] : most;
    return most < 1e-6f;
}

/* Composites all bins of the samples around a tile into its state. */
static void composite_tile(const struct composer *c, const struct group *g, int tx,
                           int ty, struct rf_accumulator *acc,
                           const struct rf_tile_state *state)
{
    size_t n_t = (size_t)c->canvas.n_cells * RF_TILE_H * RF_TILE_W;
    for (int b = 0; b < g->n_bins; b++) {
        for (int y = rf_max_int(ty - 1, 0); y <= rf_min_int(ty + 1, g->n_y - 1); y++)
            for (int x = rf_max_int(tx - 1, 0); x <= rf_min_int(tx + 1, g->n_x - 1);
                 x++) {
                const struct tile_list *l = &g->tiles[y * g->n_x + x];
                if (l->n && l->bin[b + 1] > l->bin[b])
                    c->kernels->spread(acc, c->splats + l->first + l->bin[b],
                                       l->bin[b + 1] - l->bin[b], c->footprints.table,
                                       tx * RF_TILE_W, ty * RF_TILE_H);
            }
        if (acc->last_row < 0)
            continue;
        c->kernels->flush(acc, state);
        if (is_used_up(state->t, n_t))
            return;
    }
}

/* Copies a tile of n planes between the picture and packed tiles, either way. */
static void move_planes(float *planes, int n, const struct group *g, int tx, int ty,
                        float *tiles, bool is_load)
{
    for (int p = 0; p < n; p++) {
        float *at = planes + g->plane * (size_t)p +
                    g->stride * (size_t)(ty * RF_TILE_H) + (size_t)(tx * RF_TILE_W);
        float *tile = tiles + (size_t)p * RF_TILE_H * RF_TILE_W;
        for (int y = 0; y < RF_TILE_H; y++, at += g->stride, tile += RF_TILE_W)
            memcpy(is_load ? tile : at, is_load ? at : tile, RF_TILE_W * sizeof *tile);
    }
}

static float *thread_tile(const struct composer *c)
{
    return c->tiles + c->tile_floats * (size_t)rf_thread_num();
}

/* Level 0: straight into the canvas. */
static void run_full_tile(const struct composer *c, const struct group *g, int tile)
{
    int tx = tile % g->n_x, ty = tile / g->n_x;
    if (!has_neighbours(g, tx, ty))
        return;
    int n_cells = c->canvas.n_cells, n_planes = c->canvas.n_planes;
    size_t n_t = (size_t)n_cells * RF_TILE_H * RF_TILE_W;
    float *t = thread_tile(c), *sum = t + n_t;
    move_planes(c->canvas.t, n_cells, g, tx, ty, t, true);
    if (is_used_up(t, n_t))
        return;
    move_planes(c->canvas.sum, n_planes, g, tx, ty, sum, true);
    struct rf_tile_state state = {t, sum, 0};
    composite_tile(c, g, tx, ty, &c->acc[rf_thread_num()], &state);
    move_planes(c->canvas.t, n_cells, g, tx, ty, t, false);
    move_planes(c->canvas.sum, n_planes, g, tx, ty, sum, false);
}

/* ---- coarse levels ------------------------------------------------------------- */

/* Planes of one coarse level: T before it, and per cell the sums of its samples. */
struct level {
    float *t;   /* [cell][y][x] */
    float *sum; /* [cell][plane][y][x] */
};

/* Tile columns of one row of tiles, or of two, that hold or are reached by samples. */
struct span {
    int first, end;
};

static struct span active_tiles(const struct group *g, int ty0, int ty1)
{
    struct span s = {g->n_x, 0};
    for (int ty = ty0; ty <= ty1; ty++)
        for (int tx = 0; tx < g->n_x; tx++)
            if (has_neighbours(g, tx, ty)) {
                s.first = rf_min_int(s.first, tx);
                s.end = rf_max_int(s.end, tx + 1);
            }
    return s;
}

/* T of the canvas averaged over the blocks of one row of the level, in its active
 * tiles. The last block of a row or column may lie partly outside the picture. */
static void average_row(const struct composer *c, const struct group *g, int cell,
                        int y, float *row, float *plane)
{
    struct span tiles = active_tiles(g, y / RF_TILE_H, y / RF_TILE_H);
    if (tiles.first >= tiles.end)
        return;
    int y0 = y << g->level, n_rows = 1 << g->level;
    n_rows = rf_min_int(n_rows, c->scene->height - y0);
    int x0 = tiles.first * RF_TILE_W, x1 = rf_min_int(tiles.end * RF_TILE_W, g->width);
    const float *t = c->canvas.t + c->canvas.plane * (size_t)cell +
                     c->canvas.stride * (size_t)y0 + ((size_t)x0 << g->level);
    float *out = plane + g->plane * (size_t)cell + g->stride * (size_t)y + x0;
    int last = rf_min_int(x1, c->scene->width >> g->level); /* whole blocks */
    c->kernels->average(t, c->canvas.stride, n_rows, g->level, last - x0, row, out);
    if (x1 > last) {
        int n = c->scene->width - (last << g->level);
        float sum = 0;
        t += (size_t)(last - x0) << g->level;
        for (int j = 0; j < n_rows; j++)
            for (int i = 0; i < n; i++)
                sum += rf_max_float(t[c->canvas.stride * (size_t)j + (size_t)i], 0);
        out[last - x0] = sum / (float)(n * n_rows);
    }
}

static void run_level_tile(const struct composer *c, const struct group *g,
                           const struct level *level, int tile)
{
    int tx = tile % g->n_x, ty = tile / g->n_x;
    if (!has_neighbours(g, tx, ty))
        return;
    int n_cells = c->canvas.n_cells, n_planes = c->canvas.n_planes;
    size_t n_t = (size_t)n_cells * RF_TILE_H * RF_TILE_W;
    float *t = thread_tile(c), *sum = t + n_t;
    move_planes(level->t, n_cells, g, tx, ty, t, true);
    if (is_used_up(t, n_t))
        return;
    memset(sum, 0, n_t * (size_t)n_planes * sizeof *sum);
    struct rf_tile_state state = {t, sum, (size_t)n_planes * RF_TILE_H * RF_TILE_W};
    composite_tile(c, g, tx, ty, &c->acc[rf_thread_num()], &state);
    move_planes(level->sum, n_cells * n_planes, g, tx, ty, sum, false);
}

/* A place between two pixels of the level. */
struct between {
    int low, high;
    float k; /* of high */
};

static struct between between_at(int x, int level, int n)
{
    float at = ((float)x + 0.5f) / (float)(1 << level) - 0.5f;
    int low = (int)floorf(at);
    return (struct between){rf_max_int(low, 0), rf_min_int(low + 1, n - 1),
                            at - (float)low};
}

/* Rows that a thread works with: planes of a level, T, and one of the level's width. */
enum { N_ROWS = RF_MAX_PLANES + 2 };

/* Adds the sums of a level to one row of the canvas. */
static void merge_row(const struct composer *c, const struct group *g,
                      const struct level *level, int y, float *rows)
{
    int n_planes = c->canvas.n_planes;
    size_t row = c->canvas.stride, size = (size_t)1 << g->level;
    struct between at_y = between_at(y, g->level, g->height);
    struct span tiles = active_tiles(g, at_y.low / RF_TILE_H, at_y.high / RF_TILE_H);
    if (tiles.first >= tiles.end)
        return;
    size_t first = (size_t)tiles.first * RF_TILE_W; /* column of the level */
    int n_level = rf_min_int(tiles.end * RF_TILE_W, g->width) - (int)first;
    int n = rf_min_int(n_level * (int)size, (int)(row - first * size));
    n = (n + RF_FOOTPRINT_LANES - 1) / RF_FOOTPRINT_LANES * RF_FOOTPRINT_LANES;
    size_t at = row * (size_t)y + first * size; /* in the canvas */
    float *sum[RF_MAX_PLANES];
    const float *magnified[RF_MAX_PLANES + 1];
    for (int p = 0; p < n_planes; p++)
        sum[p] = c->canvas.sum + c->canvas.plane * (size_t)p + at;
    for (int cell = 0; cell < c->canvas.n_cells; cell++) {
        for (int p = 0; p <= n_planes; p++) {
            const float *plane =
                p < n_planes ? level->sum + g->plane * (size_t)(cell * n_planes + p)
                             : level->t + g->plane * (size_t)cell;
            float *out = rows + row * (size_t)(p + 1);
            c->kernels->magnify(plane + g->stride * (size_t)at_y.low + first,
                                plane + g->stride * (size_t)at_y.high + first, at_y.k,
                                n_level, g->level, rows, out, n);
            magnified[p] = out;
        }
        c->kernels->merge(c->canvas.t + c->canvas.plane * (size_t)cell + at, sum,
                          magnified, magnified[n_planes - 1], magnified[n_planes],
                          n_planes, n);
    }
}

static rf_result run_level(const struct composer *c, const struct group *g,
                           struct rf_error *error)
{
    int n_cells = c->canvas.n_cells, n_planes = c->canvas.n_planes;
    size_t n_sum = g->plane * (size_t)n_cells * (size_t)n_planes;
    size_t n_rows = c->canvas.stride * N_ROWS;
    struct level level = {
        .t = rf_calloc(c->context, g->plane * (size_t)n_cells, sizeof(float)),
        .sum = rf_calloc(c->context, n_sum, sizeof(float))};
    float *rows = rf_alloc(c->context, n_rows * (size_t)c->n_threads, sizeof *rows);
    rf_result result = level.t && level.sum && rows
                           ? RF_OK
                           : rf_fail_memory(error, n_sum, sizeof(float));
    if (result == RF_OK) {
#pragma omp parallel num_threads(c->n_threads)
        {
            float *row = rows + n_rows * (size_t)rf_thread_num();
#pragma omp for schedule(static)
            for (int i = 0; i < n_cells * g->height; i++)
                average_row(c, g, i / g->height, i % g->height, row, level.t);
#pragma omp for schedule(dynamic, 1)
            for (int i = 0; i < g->n_x * g->n_y; i++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    run_level_tile(c, g, &level, i);
                    rf_task_step(c->scene->task);
                }
#pragma omp for schedule(dynamic, 8)
            for (int y = 0; y < c->scene->height; y++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    merge_row(c, g, &level, y, row);
                    rf_task_step(c->scene->task);
                }
        }
    }
    rf_free(c->context, rows);
    rf_free(c->context, level.sum);
    rf_free(c->context, level.t);
    return result;
}

/* ---- one set of samples -------------------------------------------------------- */

static void mark_footprint(const struct composer *c, unsigned char *needed,
                           const struct group *g)
{
    for (int i = 0; i < g->n_x * g->n_y; i++) {
        const struct tile_list *l = &g->tiles[i];
        for (int k = 0; k < l->n; k++)
            needed[c->splats[l->first + (size_t)k].slot] = 1;
    }
}

/* Builds every footprint that the splats of the groups use. */
static rf_result build_footprints(struct composer *c, const struct group *groups,
                                  int n_groups, double progress_to,
                                  struct rf_error *error)
{
    size_t n_slots = rf_footprint_count(&c->footprints);
    unsigned char *needed = rf_calloc(c->context, n_slots, 1);
    if (!needed)
        return rf_fail_memory(error, n_slots, 1);
    for (int i = 0; i < n_groups; i++)
        mark_footprint(c, needed, &groups[i]);
    rf_result result =
        rf_footprints_build(&c->footprints, needed, c->scene->task, progress_to, error);
    rf_free(c->context, needed);
    return result;
}

/* The sorted samples become the lists of every tile of every group. */
static rf_result build_lists(struct composer *c, struct sorter *s, int n_groups,
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
        struct group *g = &s->groups[k];
        int n_tiles = g->n_x * g->n_y;
#pragma omp parallel for num_threads(c->n_threads) schedule(dynamic, 4)
        for (int i = 0; i < n_tiles; i++) {
            size_t from = start[g->first_key + (size_t)i];
            size_t to = start[g->first_key + (size_t)i + 1];
            g->tiles[i] = (struct tile_list){
                .first = from, .bin = bins + (size_t)i * (size_t)(g->n_bins + 1)};
            if (to > from)
                build_list(c, g, i, samples->at, order + from, (int)(to - from),
                           scratch + from, &reducers[rf_thread_num()]);
        }
        bins += (size_t)n_tiles * (size_t)(g->n_bins + 1);
        rf_task_step(c->scene->task);
    }
    rf_free(c->context, scratch);
    rf_free(c->context, reducers);
    return RF_OK;
}

static bool has_samples(const struct group *g)
{
    for (int i = 0; i < g->n_x * g->n_y; i++)
        if (g->tiles[i].n > 0)
            return true;
    return false;
}

static rf_result run_groups(struct composer *c, const struct group *groups,
                            int n_groups, double progress_to, struct rf_error *error)
{
    struct rf_task *task = c->scene->task;
    double middle = task->to + 0.1 * (progress_to - task->to);
    rf_result result = build_footprints(c, groups, n_groups, middle, error);
    int64_t n_steps = 0;
    for (int k = 0; k < n_groups; k++)
        if (has_samples(&groups[k]))
            n_steps += groups[k].n_x * groups[k].n_y +
                       (groups[k].level ? c->scene->height : 0);
    rf_task_phase(task, progress_to, n_steps);
    for (int k = 0; k < n_groups && result == RF_OK && !rf_task_is_cancelled(task);
         k++) {
        const struct group *g = &groups[k];
        int n_tiles = g->n_x * g->n_y;
        bool is_filled = has_samples(g);
        if (is_filled && g->level > 0)
            result = run_level(c, g, error);
        else if (is_filled) {
#pragma omp parallel for num_threads(c->n_threads) schedule(dynamic, 1)
            for (int i = 0; i < n_tiles; i++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    run_full_tile(c, g, i);
                    rf_task_step(c->scene->task);
                }
        }
    }
    return result;
}

static int max_level(const struct composer *c, const struct rf_samples *samples)
{
    float most = 0;
#pragma omp parallel for num_threads(c->n_threads) schedule(static) reduction(max      \
                                                                              : most)
    for (size_t i = 0; i < samples->n; i++)
        most = rf_max_float(most, fabsf(samples->at[i].r));
    return level_of(c, most);
}

static rf_result run_samples(struct composer *c, const struct rf_samples *samples,
                             double progress_to, struct rf_error *error)
{
    if (samples->n == 0 || rf_task_is_cancelled(c->scene->task))
        return RF_OK;
    struct group groups[2 * MAX_LEVEL + 1];
    struct sorter s = {.c = c, .groups = groups, .max_level = max_level(c, samples)};
    int n_groups = 2 * s.max_level + 1;
    size_t n_bins = 0;
    for (int k = 0; k < n_groups; k++) {
        int level = abs(k - s.max_level);
        groups[k] = make_group(c, level, k < s.max_level);
        groups[k].first_key = s.n_keys;
        size_t n_tiles = (size_t)groups[k].n_x * (size_t)groups[k].n_y;
        s.n_keys += n_tiles;
        n_bins += n_tiles * (size_t)(groups[k].n_bins + 1);
    }
    const struct rf_context *context = c->context;
    struct tile_list *tiles = rf_calloc(context, s.n_keys, sizeof *tiles);
    int *bins = rf_alloc(context, n_bins, sizeof *bins);
    size_t *start = rf_alloc(context, s.n_keys + 1, sizeof *start);
    uint32_t *order = rf_alloc(context, samples->n, sizeof *order);
    c->splats = rf_alloc(context, samples->n, sizeof *c->splats);
    rf_result result = tiles && bins && start && order && c->splats
                           ? RF_OK
                           : rf_fail_memory(error, samples->n, sizeof *c->splats);
    for (int k = 0; k < n_groups && result == RF_OK; k++)
        groups[k].tiles = tiles + groups[k].first_key;
    struct rf_task *task = c->scene->task;
    rf_task_phase(task, task->to + 0.05 * (progress_to - task->to), 1 + n_groups);
    if (result == RF_OK)
        result = sort_samples(&s, samples, order, start, error);
    rf_task_step(task);
    if (result == RF_OK)
        result = build_lists(c, &s, n_groups, samples, order, start, bins, error);
    rf_free(context, order);
    rf_free(context, start);
    if (result == RF_OK)
        result = run_groups(c, groups, n_groups, progress_to, error);
    rf_free(context, c->splats);
    rf_free(context, bins);
    rf_free(context, tiles);
    return result;
}

/* ---- all ----------------------------------------------------------------------- */

static void finish(const struct composer *c, float *const planes[4])
{
    const struct rf_scene *scene = c->scene;
    const float *coverage = c->canvas.sum + c->canvas.plane * (size_t)scene->n_colours;
#pragma omp parallel for num_threads(c->n_threads) schedule(static)
    for (int y = 0; y < scene->height; y++)
        for (int p = 0; p < scene->n_colours; p++) {
            size_t at = c->canvas.stride * (size_t)y;
            const float *sum = c->canvas.sum + c->canvas.plane * (size_t)p + at;
            float *out = planes[p] + (size_t)y * (size_t)scene->width;
            for (int x = 0; x < scene->width; x++) {
                float w = coverage[at + (size_t)x];
                float v = w > 1e-6f ? sum[x] / w : 0;
                v = v > 0 ? v : 0;
                out[x] = p == 3 && v > 1 ? 1 : v; /* alpha */
            }
        }
}

static rf_result allocate(struct composer *c, struct rf_error *error)
{
    struct canvas *canvas = &c->canvas;
    struct group full = make_group(c, 0, false);
    size_t n = full.plane;
    canvas->stride = full.stride;
    canvas->plane = full.plane;
    size_t n_t = (size_t)canvas->n_cells * RF_TILE_H * RF_TILE_W;
    size_t n_acc = n_t / RF_TILE_W * RF_ACC_STRIDE * (size_t)canvas->n_planes;
    c->tile_floats = n_t * (size_t)(canvas->n_planes + 1);
    canvas->t = rf_alloc(c->context, n * (size_t)canvas->n_cells, sizeof(float));
    canvas->sum = rf_calloc(c->context, n * (size_t)canvas->n_planes, sizeof(float));
    c->tiles =
        rf_alloc(c->context, c->tile_floats * (size_t)c->n_threads, sizeof(float));
    c->acc = rf_calloc(c->context, (size_t)c->n_threads, sizeof *c->acc);
    float *acc = rf_calloc(c->context, n_acc * (size_t)c->n_threads, sizeof(float));
    if (!canvas->t || !canvas->sum || !c->tiles || !c->acc || !acc) {
        rf_free(c->context, acc);
        rf_free(c->context, c->acc);
        c->acc = NULL;
        return rf_fail_memory(error, n * (size_t)(canvas->n_cells + canvas->n_planes),
                              sizeof(float));
    }
    for (int i = 0; i < c->n_threads; i++)
        c->acc[i] = (struct rf_accumulator){.n_cells = canvas->n_cells,
                                            .n_planes = canvas->n_planes,
                                            .at = acc + n_acc * (size_t)i,
                                            .first_row = RF_TILE_H,
                                            .last_row = -1};
#pragma omp parallel for num_threads(c->n_threads) schedule(static) collapse(2)
    for (int cell = 0; cell < canvas->n_cells; cell++)
        for (size_t i = 0; i < n; i++)
            canvas->t[n * (size_t)cell + i] = (float)c->footprints.cells.share[cell];
    return RF_OK;
}

static rf_result composite(struct rf_scene *scene, float *const planes[4],
                           struct rf_error *error)
{
    const struct rf_filter *filter = scene->filter;
    struct composer c = {.scene = scene,
                         .context = filter->context,
                         .kernels = filter->context->kernels,
                         .n_threads = filter->context->n_threads,
                         .canvas = {.n_cells = filter->params.sub_apertures,
                                    .n_planes = scene->n_colours + 1}};
    double from = scene->task->to, extent[2];
    double room = scene->progress_to - from, kept = scene->highlights.n ? 0.2 : 0;
    /* An ellipse that is wider than its radius must not outgrow the tile's halo. */
    rf_shape_extent(&filter->shape, extent);
    c.split = (float)(REACH_PX / fmax(fmax(extent[0], extent[1]), 1));
    rf_result result =
        rf_footprints_init(&c.footprints, c.context, &filter->shape, c.canvas.n_cells,
                           c.split + 1, scene->n_phases, error);
    if (result == RF_OK)
        result = allocate(&c, error);
    rf_task_poll(scene->task);
    if (result == RF_OK)
        result = run_samples(&c, &scene->visible, from + 0.6 * room, error);
    if (result == RF_OK)
        result = run_samples(&c, &scene->hidden, from + (1 - kept) * room, error);
    if (result == RF_OK)
        finish(&c, planes);
    if (result == RF_OK)
        result = rf_add_highlights(scene, planes, error);
    if (c.acc)
        rf_free(c.context, c.acc[0].at);
    rf_free(c.context, c.acc);
    rf_free(c.context, c.tiles);
    rf_free(c.context, c.canvas.sum);
    rf_free(c.context, c.canvas.t);
    rf_footprints_free(&c.footprints);
    return result;
}

rf_result rf_composite_crop(struct rf_scene *scene, struct rf_work *work,
                            struct rf_error *error)
{
    const struct rf_context *context = work->filter->context;
    size_t n = (size_t)scene->width * (size_t)scene->height;
    size_t width = (size_t)work->filter->width;
    scene->n_colours = work->n_planes == 4 ? 4 : 3;
    float *memory = rf_alloc(context, n * (size_t)scene->n_colours, sizeof *memory);
    if (!memory)
        return rf_fail_memory(error, n * (size_t)scene->n_colours, sizeof *memory);
    float *planes[4];
    for (int p = 0; p < scene->n_colours; p++)
        planes[p] = memory + n * (size_t)p;
    rf_result result = composite(scene, planes, error);
#pragma omp parallel for num_threads(context->n_threads) schedule(static)
    for (int y = 0; y < (result == RF_OK ? work->filter->height : 0); y++) {
        size_t at = (size_t)(y + scene->border) * (size_t)scene->width;
        for (int p = 0; p < work->n_planes; p++)
            memcpy(work->colour[p] + (size_t)y * width,
                   planes[p] + at + (size_t)scene->border, width * sizeof(float));
    }
    rf_free(context, memory);
    return result;
}
