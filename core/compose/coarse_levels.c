/* SPDX-License-Identifier: Apache-2.0 */
/*
 * How coarse levels come into the picture: composite.c says what is computed.
 *
 * A level is composited in bands of its rows of tiles, each of which is merged into the
 * canvas while it is in the caches; only the last row of the band before must stay. How
 * high bands are makes no difference for the bits: rows of tiles do not ask each other,
 * and a row of the canvas changes when all is averaged that looks at it.
 */
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

/* Tile columns of a row of tiles that hold or are reached by samples. */
struct span {
    int first, end;
};

/*
 * Tiles of one coarse level: per cell the sums of its samples, and T before it. They are
 * defined where tiles are active, and in tiles beside those; of the rows of tiles only
 * the last n_kept.
 */
struct level {
    float *at;        /* [tile][cell][plane][y][x], T after the planes of the sums */
    size_t n_floats;  /* of these */
    int n_kept;       /* a row of tiles takes the place of the one so many before it */
    uint64_t *some;   /* [cell][y][tile]: a bit per pixel, where a sum is not 0 */
    struct span *row; /* active tiles of each row of tiles */
};

/* Floats of a plane; with whole pages rows of all planes would share one place of the
 * caches. */
enum { PLANE = RF_TILE_H * RF_TILE_W + 16 };

/* Plane p of a cell in tile (tx, ty), where it is kept; T is the one after the sums. */
static float *plane_at(const struct rf_composer *c, const struct rf_group *g,
                       const struct level *level, int cell, int p, int tx, int ty)
{
    size_t tile = (size_t)(ty % level->n_kept) * (size_t)g->n_x + (size_t)tx;
    size_t n_planes = (size_t)c->canvas.n_planes + 1;
    size_t first = (tile * (size_t)c->canvas.n_cells + (size_t)cell) * n_planes;
    return level->at + PLANE * (first + (size_t)p);
}

static struct rf_tile_state state_of(const struct rf_composer *c,
                                     const struct rf_group *g,
                                     const struct level *level, int tile)
{
    int tx = tile % g->n_x, ty = tile / g->n_x, n_planes = c->canvas.n_planes;
    const size_t cell = PLANE * ((size_t)n_planes + 1);
    return (struct rf_tile_state){.t = plane_at(c, g, level, 0, n_planes, tx, ty),
                                  .t_row = RF_TILE_W,
                                  .t_plane = cell,
                                  .sum = plane_at(c, g, level, 0, 0, tx, ty),
                                  .row = RF_TILE_W,
                                  .plane = PLANE,
                                  .cell = cell};
}

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

/* The same for levels whose pixels are more than one tile; `row` has room for three rows
 * of the canvas, of which it returns the last. */
static const float *average_coarse(const struct rf_composer *c, int level, int cell,
                                   int y0, int n_rows, float *row)
{
    size_t width = c->canvas.stride;
    float *out = row + 2 * width;
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
    return out;
}

/* T of pixel (x, y) of the level. */
static float *t_at(const struct rf_composer *c, const struct rf_group *g,
                   const struct level *level, int cell, int x, int y)
{
    return plane_at(c, g, level, cell, c->canvas.n_planes, x / RF_TILE_W,
                    y / RF_TILE_H) +
           y % RF_TILE_H * RF_TILE_W + x % RF_TILE_W;
}

/* T of the canvas averaged to one row of the level, in its active tiles. */
static void average_row(const struct rf_composer *c, const struct rf_group *g,
                        const struct level *level, int cell, int y, float *row)
{
    struct span tiles = level->row[y / RF_TILE_H];
    int y0 = y << g->level, n_rows = rf_min_int(1 << g->level, c->scene->height - y0);
    if (tiles.first >= tiles.end)
        return;
    if (g->level > FINE_LEVEL) {
        const float *means = average_coarse(c, g->level, cell, y0, n_rows, row);
        for (int x = 0; x < g->width; x++)
            *t_at(c, g, level, cell, x, y) = means[x];
        return;
    }
    int first = tiles.first << g->level; /* of the canvas' tiles */
    int end = rf_min_int(tiles.end << g->level, c->canvas.n_x);
    const float *fresh_mean = NULL; /* the same in all tiles that nothing has come to */
    for (int tx = first; tx < end; tx++) {
        float fresh[RF_TILE_W];
        float *to = t_at(c, g, level, cell, tx * RF_TILE_W >> g->level, y);
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
    struct rf_tile_state state = state_of(c, g, level, tile);
    if (!rf_has_near(g, tx, ty, 2))
        return;
    for (int i = 0; i < n_cells * n_planes; i++)
        rf_clear_tile(plane_at(c, g, level, i / n_planes, i % n_planes, tx, ty),
                      RF_TILE_W);
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

/* A pixel of the tile beside one; the one below it, which is asked for next, is nowhere
 * near. */
static inline __attribute__((always_inline)) float pixel_beside(const float *at)
{
    __builtin_prefetch(at + RF_TILE_W);
    return *at;
}

/*
 * n pixels of row y of a plane of the level from x on, all but the first and the last in
 * one tile; beyond its sides lies what is at them. In place, or in `own`.
 */
static const float *level_row(const struct rf_composer *c, const struct rf_group *g,
                              const struct level *level, int cell, int p, int x, int y,
                              int n, float *own)
{
    const int tx = (x + 1) / RF_TILE_W, ty = y / RF_TILE_H;
    const int row = y % RF_TILE_H * RF_TILE_W, first = row + (x + 1) % RF_TILE_W;
    const int end = first + n - 2; /* within the tile; then of its row */
    const float *in = plane_at(c, g, level, cell, p, tx, ty);
    const bool has_right = x + n <= g->width;
    if (first > row && end < row + RF_TILE_W && has_right)
        return in + first - 1;
    int n_here = rf_min_int(n - 2, g->width - (x + 1));
    if (n_here == RF_TILE_W / 2) /* of level 1, of which most are: no call */
        memcpy(own + 1, in + first, RF_TILE_W / 2 * sizeof *own);
    else
        memcpy(own + 1, in + first, (size_t)n_here * sizeof *own);
    if (first > row)
        own[0] = in[first - 1];
    else if (tx > 0)
        own[0] = pixel_beside(plane_at(c, g, level, cell, p, tx - 1, ty) + row +
                              RF_TILE_W - 1);
    else
        own[0] = in[first];
    if (has_right)
        own[n - 1] =
            end < row + RF_TILE_W
                ? in[end]
                : pixel_beside(plane_at(c, g, level, cell, p, tx + 1, ty) + row);
    for (int i = n_here + 1; i < n && !has_right; i++)
        own[i] = own[n_here];
    return own;
}

/* Row y of the level as wide as a tile of the canvas that begins at x0. */
static const float *widen(const struct rf_composer *c, const struct rf_group *g,
                          const struct level *level, int cell, int y, int x0,
                          struct wide_rows *rows)
{
    float *out = rows->at[y % 2], own[RF_TILE_W / 2 + 2];
    int first = x0 >> g->level, n = rf_max_int(RF_TILE_W >> g->level, 1) + 2;
    if (rows->y[y % 2] == y)
        return out;
    rows->y[y % 2] = y;
    for (int p = 0; p <= c->canvas.n_planes; p++)
        c->kernels->stretch(level_row(c, g, level, cell, p, first - 1, y, n, own),
                            g->level, x0 - (first << g->level), out + RF_TILE_W * p);
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

/*
 * Tiles of a band for each thread, at the least: so many that threads wait little for
 * each other at its end. Bands are worth 27 MB of 315 and 6 % of the time of one view
 * (docs/notebook/performance.md).
 */
enum { BAND_TILES = 16 };

/* Rows of tiles in a band. */
static int band_rows(const struct rf_composer *c, const struct rf_group *g)
{
    int n_rows = (BAND_TILES * c->n_threads + g->n_x - 1) / g->n_x;
    return rf_min_int(n_rows, g->n_y);
}

static bool allocate_level(const struct rf_composer *c, const struct rf_group *g,
                           struct level *level)
{
    size_t n_cells = (size_t)c->canvas.n_cells;
    size_t n_words = (size_t)(g->n_x * g->n_y) * RF_TILE_H * n_cells;
    int n_kept = rf_min_int(band_rows(c, g) + 1, g->n_y);
    size_t n_tiles = (size_t)n_kept * (size_t)g->n_x;
    size_t n_planes = n_cells * ((size_t)c->canvas.n_planes + 1);
    const size_t n_floats = n_tiles * n_planes * PLANE;
    *level =
        (struct level){.at = rf_alloc(c->context, n_floats, sizeof(float)),
                       .n_floats = n_floats,
                       .n_kept = n_kept,
                       .some = rf_calloc(c->context, n_words, sizeof *level->some),
                       .row = rf_alloc(c->context, (size_t)g->n_y, sizeof *level->row)};
    if (!level->at || !level->some || !level->row)
        return false;
    for (int ty = 0; ty < g->n_y; ty++)
        level->row[ty] = active_tiles(g, ty);
    return true;
}

static void free_level(const struct rf_composer *c, struct level *level)
{
    rf_free(c->context, level->row);
    rf_free(c->context, level->some);
    rf_free(c->context, level->at);
}

/* A tile without samples near it is not looked at. */
static void clear_t(const struct rf_composer *c, const struct rf_group *g,
                    const struct level *level, int tile)
{
    struct rf_tile_state state = state_of(c, g, level, tile);
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
    int first_row, end_row; /* of a band, pixels of the level */
    float *rows;            /* n_row floats for each thread */
    size_t n_row;
};

static void clear_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    const int first = r->first_row / RF_TILE_H * r->g->n_x;
    for (int64_t i = begin; i < end; i++)
        clear_t(r->c, r->g, &r->level, first + (int)i);
}

static void average_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    int n = r->end_row - r->first_row;
    for (int i = (int)begin; i < (int)end; i++)
        average_row(r->c, r->g, &r->level, i / n, r->first_row + i % n,
                    r->rows + r->n_row * (size_t)thread);
}

static void run_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct running *r = data;
    struct rf_task *task = r->c->scene->task;
    const int first = r->first_row / RF_TILE_H * r->g->n_x;
    for (int64_t i = begin; i < end && !rf_task_is_cancelled(task); i++) {
        run_level_tile(r->c, r->g, &r->level, first + (int)i, thread);
        rf_task_step(task);
    }
}

/* Tiles of the canvas, from a row of them on. */
struct merging {
    const struct running *running;
    int first_row;
};

static void merge_tiles(void *data, int64_t begin, int64_t end, int thread)
{
    const struct merging *m = data;
    const struct running *r = m->running;
    struct rf_task *task = r->c->scene->task;
    const int first = m->first_row * r->c->canvas.n_x;
    for (int64_t i = begin; i < end && !rf_task_is_cancelled(task); i++) {
        merge_tile(r->c, r->g, &r->level, r->is_visible, first + (int)i);
        rf_task_step(task);
    }
}

/* The first row of tiles of the canvas that looks at rows of the level from end_row on. */
static int merged_rows(const struct running *r, int n_rows)
{
    const int height = r->c->scene->height, level = r->g->level;
    int ty = 0;
    for (; ty < n_rows; ty++) {
        int last = rf_min_int((ty + 1) * RF_TILE_H, height) - 1;
        if (between_at(last, level, r->g->height).high >= r->end_row)
            break;
    }
    return ty;
}

/* Composites a band, and merges what is complete by then. */
static void run_band(struct running *r, struct merging *m)
{
    const struct rf_context *context = r->c->context;
    const struct rf_group full = rf_group_make(r->c, 0, false);
    const int n_rows = r->end_row - r->first_row;
    const int64_t n_tiles = (int64_t)((n_rows + RF_TILE_H - 1) / RF_TILE_H) * r->g->n_x;
    rf_parallel(context, n_tiles, RF_EQUAL_PARTS, clear_tiles, r);
    rf_parallel(context, (int64_t)r->c->canvas.n_cells * n_rows, RF_EQUAL_PARTS,
                average_rows, r);
    rf_parallel(context, n_tiles, 1, run_tiles, r);
    const int end = merged_rows(r, full.n_y);
    rf_parallel(context, (int64_t)full.n_x * (end - m->first_row), 8, merge_tiles, m);
    m->first_row = end;
}

rf_result rf_run_level(const struct rf_composer *c, const struct rf_group *g,
                       bool is_visible, struct rf_error *error)
{
    const struct rf_context *context = c->context;
    struct running r = {
        .c = c, .g = g, .is_visible = is_visible, .n_row = 3 * c->canvas.stride};
    struct merging merging = {&r, 0};
    const int n_band = band_rows(c, g) * RF_TILE_H;
    bool has_level = allocate_level(c, g, &r.level);
    r.rows = rf_alloc(context, r.n_row * (size_t)context->n_threads, sizeof *r.rows);
    rf_result result = RF_OK;
    if (!has_level || !r.rows)
        result = rf_fail_memory(error, r.level.n_floats, sizeof(float));
    for (; result == RF_OK && r.first_row < g->height; r.first_row = r.end_row) {
        r.end_row = rf_min_int(r.first_row + n_band, g->height);
        run_band(&r, &merging);
    }
    rf_free(context, r.rows);
    free_level(c, &r.level);
    return result;
}
