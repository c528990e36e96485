/* SPDX-License-Identifier: Apache-2.0 */
/* How coarse levels come into the picture: composite.c says what is computed. */
#include "compose/coarse_levels.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/error.h"
#include "base/fetch.h"
#include "base/math.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/close_insides.h"
#include "compose/composer.h"
#include "compose/composite_tiles.h"
#include "compose/levels.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "rackfocus/rackfocus.h"

/* The state of a tile of planes that begin at t and sum. */
static struct rf_tile_state state_of(const struct rf_group *g, int tile, float *t,
                                     float *sum)
{
    size_t at = g->stride * (size_t)(tile / g->n_x * RF_TILE_H) +
                (size_t)(tile % g->n_x * RF_TILE_W);
    return (struct rf_tile_state){.t = t + at,
                                  .t_row = g->stride,
                                  .t_plane = g->plane,
                                  .sum = sum + at,
                                  .row = g->stride,
                                  .plane = g->plane};
}

/* Tile columns of a row of tiles that hold or are reached by samples. */
struct span {
    int first, end;
};

/*
 * Planes of one coarse level: T before it, and per cell the sums of its samples. Both
 * are defined in active tiles and in those beside them.
 */
struct level {
    float *t;         /* [cell][y][x] */
    float *sum;       /* [cell][plane][y][x] */
    uint64_t *some;   /* [cell][y][tile]: a bit per pixel, where a sum is not 0 */
    struct span *row; /* active tiles of each row of tiles */
};

static struct span active_tiles(const struct rf_group *g, int ty)
{
    struct span s = {g->n_x, 0};
    for (int tx = 0; tx < g->n_x; tx++)
        if (rf_has_near(g, tx, ty, 1)) {
            s.first = rf_min_int(s.first, tx);
            s.end = tx + 1;
        }
    return s;
}

/* Where the bits of a row of the level are. */
static uint64_t *some_of(const struct rf_group *g, const struct level *level, int cell,
                         int y)
{
    size_t row = (size_t)cell * (size_t)(g->n_y * RF_TILE_H) + (size_t)y;
    return level->some + row * (size_t)g->n_x;
}

/* The coarsest level of which a pixel lies in one tile of the canvas. */
enum { FINE_LEVEL = 5 };

/* T of n_rows rows of the canvas, n pixels of a cell from (x, y) on, in one tile. */
struct block_row {
    const float *t;
    size_t stride;
    int n_rows, n;
};

/* T averaged over blocks of 2^level columns, the last of which may have fewer. */
static void average_blocks(const struct rf_composer *c, const struct block_row *from,
                           int level, float *row, float *out)
{
    int last = from->n >> level, n = from->n - (last << level); /* whole blocks, rest */
    c->kernels->average(from->t, from->stride, from->n_rows, level, last, row, out);
    float sum = 0;
    for (int j = 0; j < from->n_rows && n; j++)
        for (int i = 0; i < n; i++)
            sum += rf_max_float(
                from->t[from->stride * (size_t)j + (size_t)((last << level) + i)], 0);
    sum /= (float)(n * from->n_rows);
    if (n)
        out[last] = sum > RF_USED_UP ? sum : 0;
}

/* T of a cell in row y of a tile that something has come to, and the rows after it. */
static struct block_row open_rows(const struct rf_composer *c, int tile, int cell,
                                  int y, int n_rows, int n)
{
    struct rf_tile_state s = rf_canvas_tile(c, tile);
    const float *t = s.t + s.t_plane * (size_t)cell + s.t_row * (size_t)(y % RF_TILE_H);
    return (struct block_row){t, s.t_row, n_rows, n};
}

/* T of n_rows rows of a cell in a tile; where nothing has come to it, T of its first
 * row, put into `fresh`, stands for all. */
static struct block_row block_row_of(const struct rf_composer *c, int tile, int cell,
                                     int y, int n_rows, float fresh[RF_TILE_W])
{
    int n = c->scene->width - tile % c->canvas.n_x * RF_TILE_W;
    n = rf_min_int(n, RF_TILE_W);
    if (c->canvas.is_begun[tile])
        return open_rows(c, tile, cell, y, n_rows, n);
    for (int x = 0; x < RF_TILE_W; x++)
        fresh[x] = (float)c->footprints->zones.at->cells.share[cell];
    return (struct block_row){fresh, 0, n_rows, n};
}

/* Asks for the rows of the next tile. */
static void fetch_block_row(const struct rf_composer *c, int tile, int cell, int y,
                            int n_rows)
{
    struct block_row rows = open_rows(c, tile, cell, y, n_rows, RF_TILE_W);
    for (int i = 0; i < n_rows && c->canvas.is_begun[tile]; i++)
        rf_fetch(rows.t + rows.stride * (size_t)i, rows.n);
}

/* The same for levels whose pixels are more than one tile; `row` has room for two rows
 * of the canvas. */
static void average_coarse(const struct rf_composer *c, int level, int cell, int y0,
                           int n_rows, float *row, float *out)
{
    size_t width = c->canvas.stride;
    memset(row, 0, width * sizeof *row);
    for (int y = y0; y < y0 + n_rows; y++)
        for (int tx = 0; tx < c->canvas.n_x; tx++) {
            float fresh[RF_TILE_W];
            struct block_row from =
                block_row_of(c, y / RF_TILE_H * c->canvas.n_x + tx, cell, y, 1, fresh);
            for (int x = 0; x < from.n; x++)
                row[tx * RF_TILE_W + x] += rf_max_float(from.t[x], 0) / (float)n_rows;
        }
    const struct block_row sums = {row, width, 1, c->scene->width};
    average_blocks(c, &sums, level, row + width, out);
}

/* T of the canvas averaged to one row of the level, in its active tiles. */
static void average_row(const struct rf_composer *c, const struct rf_group *g,
                        const struct level *level, int cell, int y, float *row)
{
    struct span tiles = level->row[y / RF_TILE_H];
    int y0 = y << g->level, n_rows = rf_min_int(1 << g->level, c->scene->height - y0);
    float *out = level->t + g->plane * (size_t)cell + g->stride * (size_t)y;
    if (tiles.first >= tiles.end)
        return;
    if (g->level > FINE_LEVEL) {
        average_coarse(c, g->level, cell, y0, n_rows, row, out);
        return;
    }
    int first = tiles.first << g->level; /* of the canvas' tiles */
    int end = rf_min_int(tiles.end << g->level, c->canvas.n_x);
    const float *fresh_mean = NULL; /* the same in all tiles that nothing has come to */
    for (int tx = first; tx < end; tx++) {
        float fresh[RF_TILE_W], *to = out + (tx * RF_TILE_W >> g->level);
        int tile = y0 / RF_TILE_H * c->canvas.n_x + tx;
        bool is_fresh = !c->canvas.is_begun[tile];
        if (tx + 1 < end)
            fetch_block_row(c, tile + 1, cell, y0, n_rows);
        if (fresh_mean && is_fresh && (tx + 1) * RF_TILE_W <= c->scene->width) {
            for (int x = 0; x < RF_TILE_W >> g->level; x++)
                to[x] = *fresh_mean;
            continue;
        }
        struct block_row from = block_row_of(c, tile, cell, y0, n_rows, fresh);
        average_blocks(c, &from, g->level, row, to);
        if (is_fresh)
            fresh_mean = to;
    }
}

/* Gives a tile a copy of its t, which is asked for again as it was. */
static void take_t(const struct rf_composer *c, struct rf_tile_state *s, int thread)
{
    const size_t plane = (size_t)RF_TILE_H * RF_TILE_W;
    float *copy = c->tiles + c->n_tile * (size_t)thread;
    for (int cell = 0; cell < c->canvas.n_cells; cell++)
        for (int y = 0; y < RF_TILE_H; y++)
            memcpy(copy + plane * (size_t)cell + (size_t)y * RF_TILE_W,
                   s->t + s->t_plane * (size_t)cell + s->t_row * (size_t)y,
                   RF_TILE_W * sizeof *copy);
    s->t = copy;
    s->t_row = RF_TILE_W;
    s->t_plane = plane;
}

static void run_level_tile(const struct rf_composer *c, const struct rf_group *g,
                           const struct level *level, int tile, int thread)
{
    int tx = tile % g->n_x, ty = tile / g->n_x;
    int n_cells = c->canvas.n_cells, n_planes = c->canvas.n_planes;
    struct rf_tile_state state = state_of(g, tile, level->t, level->sum);
    state.cell = g->plane * (size_t)n_planes;
    if (!rf_has_near(g, tx, ty, 2))
        return;
    for (int p = 0; p < n_cells * n_planes; p++)
        rf_clear_tile(state.sum + state.plane * (size_t)p, state.row);
    if (!rf_has_near(g, tx, ty, 1) || rf_is_used_up(&state, n_cells))
        return;
    take_t(c, &state, thread);
    rf_composite_tile(c, g, tx, ty, &c->acc[thread], &state);
    for (int i = 0; i < n_cells * RF_TILE_H; i++) {
        int cell = i / RF_TILE_H, y = i % RF_TILE_H;
        some_of(g, level, cell, ty * RF_TILE_H + y)[tx] = c->kernels->find_some(
            state.sum + state.cell * (size_t)cell + state.row * (size_t)y, state.plane,
            n_planes);
    }
}

/* A place between two pixels of the level. */
struct between {
    int low, high;
    float k; /* of high */
};

/* Where pixel x lies among n pixels of the level: at (x + 1/2) / 2^level - 1/2. */
static struct between between_at(int x, int level, int n)
{
    int size = 2 << level, at = 2 * x + 1 - size / 2; /* in units of 1 / size */
    int low = ((at + size) >> (level + 1)) - 1;       /* rounded down: at > -size */
    return (struct between){rf_max_int(low, 0), rf_min_int(low + 1, n - 1),
                            (float)(at - low * size) / (float)size};
}

/* 64 bits of a row of n_words from bit `first` on, which may lie before it. */
static uint64_t bits_from(const uint64_t *row, int n_words, int first)
{
    int word = (first + 64) / 64 - 1, shift = (first + 64) % 64;
    uint64_t bits = word >= 0 && word < n_words ? row[word] >> shift : 0;
    if (shift && word + 1 < n_words)
        bits |= row[word + 1] << (64 - shift);
    return bits;
}

/* A bit for each pair of 32 bits: is any of them set? */
static uint64_t join_pairs(uint64_t v)
{
    v = (v | v >> 1) & 0x55555555;
    v = (v | v >> 1) & 0x33333333;
    v = (v | v >> 2) & 0x0f0f0f0f;
    v = (v | v >> 4) & 0x00ff00ff;
    return (v | v >> 8) & 0xffff;
}

/*
 * A bit for each eight pixels of a tile's row, from x0 on, to which the level may add:
 * its sums lie a pixel farther when magnified.
 */
static unsigned find_wanted(const struct rf_group *g, const struct level *level,
                            int cell, const struct between *at_y, int x0)
{
    enum { N = RF_FOOTPRINT_LANES, N_PARTS = RF_TILE_W / N };
    int first = x0 >> g->level;
    uint64_t some = bits_from(some_of(g, level, cell, at_y->low), g->n_x, first - 1) |
                    bits_from(some_of(g, level, cell, at_y->high), g->n_x, first - 1);
    some |= some >> 1 | some >> 2; /* of each pixel and those beside it */
    unsigned wanted = 0;
    if (g->level > 3)
        for (int i = 0; i < N_PARTS; i++)
            wanted |= (some >> (((x0 + N * i) >> g->level) - first) & 1) << i;
    else if (g->level == 3)
        wanted = (unsigned)some;
    else
        wanted = (unsigned)join_pairs(g->level == 2 ? some : join_pairs(some));
    return wanted & ((1u << N_PARTS) - 1);
}

/* Two rows of a level, each a tile's row of colours, coverage and T. */
struct wide_rows {
    int y[2]; /* which rows; -1: none yet */
    float at[2][(RF_MAX_PLANES + 1) * RF_TILE_W];
};

/* Row y of the level as wide as a tile of the canvas that begins at x0. */
static const float *widen(const struct rf_composer *c, const struct rf_group *g,
                          const struct level *level, int cell, int y, int x0,
                          struct wide_rows *rows)
{
    float *out = rows->at[y % 2], ends[RF_TILE_W / 2 + 2];
    int n_planes = c->canvas.n_planes, first = x0 >> g->level;
    int n = rf_max_int(RF_TILE_W >> g->level, 1) + 2;
    bool is_inner = first > 0 && first + n - 2 < g->width;
    if (rows->y[y % 2] == y)
        return out;
    rows->y[y % 2] = y;
    for (int p = 0; p <= n_planes; p++) {
        const float *plane = p < n_planes
                                 ? level->sum + g->plane * (size_t)(cell * n_planes + p)
                                 : level->t + g->plane * (size_t)cell;
        const float *row = plane + g->stride * (size_t)y, *in = ends;
        if (is_inner) {
            in = row + first - 1;
            if (y + 1 < g->height)
                rf_fetch(in + g->stride, n);
        }
        for (int i = 0; i < n && !is_inner; i++)
            ends[i] = row[rf_min_int(rf_max_int(first - 1 + i, 0), g->width - 1)];
        c->kernels->stretch(in, g->level, x0 - (first << g->level),
                            out + RF_TILE_W * p);
    }
    return out;
}

/* Has a cell of the level anything for n_rows rows of a tile of the canvas? */
static bool is_touched(const struct rf_group *g, const struct level *level, int cell,
                       int x0, int y0, int n_rows)
{
    int from = between_at(y0, g->level, g->height).low;
    int to = between_at(y0 + n_rows - 1, g->level, g->height).high;
    uint64_t some = 0;
    for (int y = from; y <= to; y++)
        some |= bits_from(some_of(g, level, cell, y), g->n_x, (x0 >> g->level) - 1);
    int n = rf_max_int(RF_TILE_W >> g->level, 1) + 2;
    return some << (64 - n) != 0;
}

/* Adds a cell's sums of a level to a tile of the canvas, which begins where any are. */
static void merge_cell(const struct rf_composer *c, const struct rf_group *g,
                       const struct level *level, int cell, int tile,
                       const struct rf_tile_state *s)
{
    int n_x = c->canvas.n_x;
    int x0 = tile % n_x * RF_TILE_W, y0 = tile / n_x * RF_TILE_H;
    int n_rows = rf_min_int(RF_TILE_H, c->scene->height - y0);
    unsigned wanted = 0;
    struct between before = {-1, -1, 0};
    struct wide_rows rows;
    rows.y[0] = rows.y[1] = -1;
    if (!is_touched(g, level, cell, x0, y0, n_rows))
        return;
    for (int y = 0; y < n_rows; y++) {
        struct between at = between_at(y0 + y, g->level, g->height);
        float *t = s->t + s->t_plane * (size_t)cell + s->t_row * (size_t)y;
        if (at.low != before.low || at.high != before.high)
            wanted = find_wanted(g, level, cell, &at, x0);
        before = at;
        if (!wanted)
            continue;
        if (!c->canvas.is_begun[tile])
            rf_begin_tile(c, s);
        c->canvas.is_begun[tile] = 1;
        unsigned parts = wanted & c->kernels->find_open(t);
        if (parts)
            c->kernels->merge(t, s->sum + s->row * (size_t)y, s->plane,
                              widen(c, g, level, cell, at.low, x0, &rows),
                              widen(c, g, level, cell, at.high, x0, &rows), at.k, parts,
                              c->canvas.n_planes);
    }
}

/* Closes the insides of surfaces of a tile of the canvas up to the end of a level. */
static void close_insides(const struct rf_composer *c, const struct rf_group *g,
                          int tile, const struct rf_tile_state *s)
{
    float inner = rf_level_from(&c->levels, g->level, g->is_near);
    float outer = c->levels.limit[g->is_near][g->level];
    rf_close_insides(c, tile % c->canvas.n_x, tile / c->canvas.n_x,
                     g->is_near ? -2 * outer : inner / 2, g->is_near ? -inner : outer,
                     s);
}

/* Adds the sums of a level to a tile of the canvas. */
static void merge_tile(const struct rf_composer *c, const struct rf_group *g,
                       const struct level *level, bool is_visible, int tile)
{
    struct rf_tile_state state = rf_canvas_tile(c, tile);
    for (int cell = 0; cell < c->canvas.n_cells; cell++)
        merge_cell(c, g, level, cell, tile, &state);
    if (is_visible && c->canvas.is_begun[tile])
        close_insides(c, g, tile, &state);
}

static bool allocate_level(const struct rf_composer *c, const struct rf_group *g,
                           struct level *level)
{
    size_t n_cells = (size_t)c->canvas.n_cells, n_planes = (size_t)c->canvas.n_planes;
    size_t n_words = (size_t)(g->n_x * g->n_y) * RF_TILE_H * n_cells;
    *level = (struct level){
        .t = rf_alloc(c->context, g->plane * n_cells, sizeof(float)),
        .sum = rf_alloc(c->context, g->plane * n_cells * n_planes, sizeof(float)),
        .some = rf_calloc(c->context, n_words, sizeof *level->some),
        .row = rf_alloc(c->context, (size_t)g->n_y, sizeof *level->row)};
    if (!level->t || !level->sum || !level->some || !level->row)
        return false;
    for (int ty = 0; ty < g->n_y; ty++)
        level->row[ty] = active_tiles(g, ty);
    return true;
}

static void free_level(const struct rf_composer *c, struct level *level)
{
    rf_free(c->context, level->row);
    rf_free(c->context, level->some);
    rf_free(c->context, level->sum);
    rf_free(c->context, level->t);
}

/* A tile without samples near it is not looked at. */
static void clear_t(const struct rf_composer *c, const struct rf_group *g,
                    const struct level *level, int tile)
{
    struct rf_tile_state state = state_of(g, tile, level->t, level->sum);
    if (rf_has_near(g, tile % g->n_x, tile / g->n_x, 2))
        for (int cell = 0; cell < c->canvas.n_cells; cell++)
            rf_clear_tile(state.t + state.t_plane * (size_t)cell, state.t_row);
}

/* What the threads share that run a level. */
struct running {
    const struct rf_composer *c;
    const struct rf_group *g;
    struct level level;
    bool is_visible;
    float *rows; /* n_row floats for each thread */
    size_t n_row;
};

static void clear_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    for (int64_t i = begin; i < end; i++)
        clear_t(r->c, r->g, &r->level, (int)i);
}

static void average_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    int height = r->g->height;
    for (int i = (int)begin; i < (int)end; i++)
        average_row(r->c, r->g, &r->level, i / height, i % height,
                    r->rows + r->n_row * (size_t)thread);
}

static void run_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    struct rf_task *task = r->c->scene->task;
    for (int64_t i = begin; i < end && !rf_task_is_cancelled(task); i++) {
        run_level_tile(r->c, r->g, &r->level, (int)i, thread);
        rf_task_step(task);
    }
}

static void merge_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    struct rf_task *task = r->c->scene->task;
    for (int64_t i = begin; i < end && !rf_task_is_cancelled(task); i++) {
        merge_tile(r->c, r->g, &r->level, r->is_visible, (int)i);
        rf_task_step(task);
    }
}

rf_result rf_run_level(const struct rf_composer *c, const struct rf_group *g,
                       bool is_visible, struct rf_error *error)
{
    const struct rf_context *context = c->context;
    const int64_t n_tiles = (int64_t)g->n_x * g->n_y;
    struct running r = {
        .c = c, .g = g, .is_visible = is_visible, .n_row = 2 * c->canvas.stride};
    struct rf_group full = rf_group_make(c, 0, false);
    bool has_level = allocate_level(c, g, &r.level);
    r.rows = rf_alloc(context, r.n_row * (size_t)context->n_threads, sizeof *r.rows);
    rf_result result = RF_OK;
    if (!has_level || !r.rows)
        result =
            rf_fail_memory(error, g->plane * (size_t)c->canvas.n_cells, sizeof(float));
    if (result == RF_OK) {
        rf_parallel(context, n_tiles, RF_EQUAL_PARTS, clear_tiles, &r);
        rf_parallel(context, (int64_t)c->canvas.n_cells * g->height, RF_EQUAL_PARTS,
                    average_rows, &r);
        rf_parallel(context, n_tiles, 1, run_tiles, &r);
        rf_parallel(context, (int64_t)full.n_x * full.n_y, 8, merge_tiles, &r);
    }
    rf_free(context, r.rows);
    free_level(c, &r.level);
    return result;
}
