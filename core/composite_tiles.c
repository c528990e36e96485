/* SPDX-License-Identifier: Apache-2.0 */
/* The saturating sums of tiles, and how coarse levels come into the picture. */
#include <stdlib.h>

#include "composer.h"

/* ---- tiles --------------------------------------------------------------------- */

/* Has a tile up to `reach` tiles from this one samples? */
static bool has_near(const struct rf_group *g, int tx, int ty, int reach)
{
    int x0 = rf_max_int(tx - reach, 0), x1 = rf_min_int(tx + reach, g->n_x - 1);
    int y0 = rf_max_int(ty - reach, 0), y1 = rf_min_int(ty + reach, g->n_y - 1);
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++)
            if (g->tiles[y * g->n_x + x].n)
                return true;
    return false;
}

static bool has_neighbours(const struct rf_group *g, int tx, int ty)
{
    return has_near(g, tx, ty, 1);
}

/* Is there any T left in n pixels? What is used up is 0. */
static bool is_open(const float *t, int n)
{
    uint32_t any = 0;
    for (int i = 0; i < n; i++) {
        uint32_t bits;
        memcpy(&bits, t + i, sizeof bits);
        any |= bits;
    }
    return any != 0;
}

/* Has every pixel of the tile been covered? */
static bool is_used_up(const struct rf_tile_state *s, int n_cells)
{
    for (int cell = 0; cell < n_cells; cell++)
        for (int y = 0; y < RF_TILE_H; y++)
            if (is_open(s->t + s->t_plane * (size_t)cell + s->t_row * (size_t)y,
                        RF_TILE_W))
                return false;
    return true;
}

static const rf_place *first_from_row(const rf_place *from, const rf_place *end, int y)
{
    while (from < end) {
        const rf_place *middle = from + (end - from) / 2;
        if (rf_place_y(*middle) < y)
            from = middle + 1;
        else
            end = middle;
    }
    return from;
}

/* Pixels of the level that footprints of bin b reach at the most. */
static int reach_of(const struct rf_composer *c, const struct rf_group *g, int b)
{
    int first = g->first_bin + b, px = RF_BIN_PX * rf_max_int(-first, first + 1);
    return rf_footprints_reach(c->footprints, (double)px / (1 << g->level));
}

/* Spreads the part of n places that can reach a tile. */
static void spread_places(const struct rf_composer *c, const struct rf_tile_list *l,
                          const rf_place *at, const rf_place *end, int x0, int y0,
                          struct rf_accumulator *acc)
{
    int y = y0 - l->surfaces.y, y1 = y + RF_TILE_H;
    if (rf_place_y(*at) < y - acc->reach)
        at = first_from_row(at, end, y - acc->reach);
    if (end > at && rf_place_y(end[-1]) >= y1 + acc->reach)
        end = first_from_row(at, end, y1 + acc->reach);
    if (end > at)
        c->kernels->spread_places(acc, at, (int)(end - at), &l->surfaces,
                                  c->footprints->table, x0, y0);
}

/* Spreads the part of a list's bin that can reach a tile. */
static void spread_list(const struct rf_composer *c, const struct rf_tile_list *l,
                        int b, int x0, int y0, struct rf_accumulator *acc)
{
    int from = l->bin[b], to = l->bin[b + 1];
    if (to > from && l->places)
        spread_places(c, l, l->places + from, l->places + to, x0, y0, acc);
    else if (to > from)
        c->kernels->spread(acc, l->at + from, to - from, c->footprints->table, x0, y0);
}

/* Composites all bins of the samples around a tile into its state. */
static void composite_tile(const struct rf_composer *c, const struct rf_group *g,
                           int tx, int ty, struct rf_accumulator *acc,
                           const struct rf_tile_state *state)
{
    for (int b = 0; b < g->n_bins; b++) {
        acc->reach = reach_of(c, g, b);
        for (int y = rf_max_int(ty - 1, 0); y <= rf_min_int(ty + 1, g->n_y - 1); y++)
            for (int x = rf_max_int(tx - 1, 0); x <= rf_min_int(tx + 1, g->n_x - 1);
                 x++) {
                const struct rf_tile_list *l = &g->tiles[y * g->n_x + x];
                if (l->n)
                    spread_list(c, l, b, tx * RF_TILE_W, ty * RF_TILE_H, acc);
            }
        if (acc->last_row < 0)
            continue;
        c->kernels->flush(acc, state);
        if (is_used_up(state, c->canvas.n_cells))
            return;
    }
}

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

static void fill(float *tile, size_t stride, float value)
{
    for (int y = 0; y < RF_TILE_H; y++, tile += stride)
        for (int x = 0; x < RF_TILE_W; x++)
            tile[x] = value;
}

typedef float four_floats __attribute__((vector_size(16), aligned(4)));

/* Stores that the compiler makes no memset() of, which would be slower for one row. */
static void clear(float *tile, size_t stride)
{
    const four_floats none = {0};
    for (int y = 0; y < RF_TILE_H; y++, tile += stride)
        for (int x = 0; x < RF_TILE_W; x += 16) {
            four_floats *at = (four_floats *)(tile + x);
            at[0] = none;
            at[1] = none;
            at[2] = none;
            at[3] = none;
        }
}

/* To a tile nothing has come. */
static void begin_tile(const struct rf_composer *c, const struct rf_tile_state *s)
{
    for (int cell = 0; cell < c->canvas.n_cells; cell++)
        fill(s->t + s->t_plane * (size_t)cell, s->t_row,
             (float)c->footprints->cells.share[cell]);
    for (int p = 0; p < c->canvas.n_planes; p++)
        clear(s->sum + s->plane * (size_t)p, s->row);
}

void rf_begin_canvas(const struct rf_composer *c)
{
    const struct rf_group g = rf_group_make(c, 0, false);
#pragma omp parallel for num_threads(c->n_threads) schedule(static)
    for (int i = 0; i < g.n_x * g.n_y; i++) {
        struct rf_tile_state state = state_of(&g, i, c->canvas.t, c->canvas.sum);
        if (!c->canvas.is_begun[i])
            begin_tile(c, &state);
        c->canvas.is_begun[i] = 1;
    }
}

/* Level 0: straight into the canvas. */
void rf_run_full_tile(const struct rf_composer *c, const struct rf_group *g, int tile)
{
    int tx = tile % g->n_x, ty = tile / g->n_x;
    if (!has_neighbours(g, tx, ty))
        return;
    struct rf_tile_state state = state_of(g, tile, c->canvas.t, c->canvas.sum);
    if (!c->canvas.is_begun[tile])
        begin_tile(c, &state);
    else if (is_used_up(&state, c->canvas.n_cells))
        return;
    c->canvas.is_begun[tile] = 1;
    composite_tile(c, g, tx, ty, &c->acc[rf_thread_num()], &state);
}

struct rf_tile_state rf_run_lone_tile(const struct rf_composer *c,
                                      const struct rf_group *const sets[2], int tile)
{
    const size_t plane = (size_t)RF_TILE_H * RF_TILE_W;
    float *own = c->tiles + c->n_tile * (size_t)rf_thread_num();
    struct rf_tile_state state = {.t = own,
                                  .t_row = RF_TILE_W,
                                  .t_plane = plane,
                                  .sum = own + plane * (size_t)c->canvas.n_cells,
                                  .row = RF_TILE_W,
                                  .plane = plane};
    begin_tile(c, &state);
    for (int k = 0; k < 2; k++) {
        const struct rf_group *g = sets[k];
        if (!g || (k > 0 && is_used_up(&state, c->canvas.n_cells)))
            continue;
        int tx = tile % g->n_x, ty = tile / g->n_x;
        if (has_neighbours(g, tx, ty))
            composite_tile(c, g, tx, ty, &c->acc[rf_thread_num()], &state);
    }
    return state;
}

/* ---- coarse levels ------------------------------------------------------------- */

/* Tile columns of one row of tiles, or of two, that hold or are reached by samples. */
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
        if (has_neighbours(g, tx, ty)) {
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

/* Pixels x0 to x1 - 1 of a row of the level, each of n_rows rows of the canvas. */
struct level_part {
    int cell, y, n_rows, x0, x1;
    float *out; /* of the row */
};

/* T of a canvas that nothing has come to, averaged. */
static void average_fresh(const struct rf_composer *c, const struct rf_group *g,
                          const struct level_part *part)
{
    enum { N = RF_FOOTPRINT_LANES };
    float t[N << FINE_LEVEL], row[N << FINE_LEVEL], mean[N];
    for (int x = 0; x < N << g->level; x++)
        t[x] = (float)c->footprints->cells.share[part->cell];
    c->kernels->average(t, 0, part->n_rows, g->level, N, row, mean);
    for (int x = part->x0; x < part->x1; x++)
        part->out[x] = mean[0];
}

/* T of the canvas averaged. The last block of a row or column may lie partly outside
 * the picture. */
static void average_part(const struct rf_composer *c, const struct rf_group *g,
                         const struct level_part *part, float *row)
{
    const float *t = c->canvas.t + c->canvas.plane * (size_t)part->cell +
                     c->canvas.stride * ((size_t)part->y << g->level);
    int last = rf_min_int(part->x1, c->scene->width >> g->level); /* whole blocks */
    c->kernels->average(t + ((size_t)part->x0 << g->level), c->canvas.stride,
                        part->n_rows, g->level, last - part->x0, row,
                        part->out + part->x0);
    if (part->x1 > last) {
        int n = c->scene->width - (last << g->level);
        float sum = 0;
        t += (size_t)last << g->level;
        for (int j = 0; j < part->n_rows; j++)
            for (int i = 0; i < n; i++)
                sum += rf_max_float(t[c->canvas.stride * (size_t)j + (size_t)i], 0);
        sum /= (float)(n * part->n_rows);
        part->out[last] = sum > RF_USED_UP ? sum : 0;
    }
}

/* T of the canvas averaged to one row of the level, in its active tiles. */
static void average_row(const struct rf_composer *c, const struct rf_group *g,
                        const struct level *level, int cell, int y, float *row)
{
    struct span tiles = level->row[y / RF_TILE_H];
    int x1 = rf_min_int(tiles.end * RF_TILE_W, g->width), y0 = y << g->level;
    bool is_fine = g->level <= FINE_LEVEL;
    int n = is_fine ? RF_TILE_W >> g->level : x1; /* pixels of a tile of the canvas */
    const unsigned char *is_begun =
        c->canvas.is_begun +
        (size_t)(y0 / RF_TILE_H) * (c->canvas.stride / (size_t)RF_TILE_W);
    struct level_part part = {
        .cell = cell,
        .y = y,
        .n_rows = rf_min_int(1 << g->level, c->scene->height - y0),
        .x1 = tiles.first * RF_TILE_W,
        .out = level->t + g->plane * (size_t)cell + g->stride * (size_t)y};
    while (part.x1 < x1) {
        part.x0 = part.x1;
        bool is_fresh = is_fine && !is_begun[part.x0 / n];
        while (part.x1 < x1 && is_fresh == (is_fine && !is_begun[part.x1 / n]))
            part.x1 += n;
        part.x1 = rf_min_int(part.x1, x1);
        if (is_fresh)
            average_fresh(c, g, &part);
        else
            average_part(c, g, &part, row);
    }
}

/* Gives a tile a copy of its t, which is asked for again as it was. */
static void take_t(const struct rf_composer *c, struct rf_tile_state *s)
{
    const size_t plane = (size_t)RF_TILE_H * RF_TILE_W;
    float *copy = c->tiles + c->n_tile * (size_t)rf_thread_num();
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
                           const struct level *level, int tile)
{
    int tx = tile % g->n_x, ty = tile / g->n_x;
    int n_cells = c->canvas.n_cells, n_planes = c->canvas.n_planes;
    struct rf_tile_state state = state_of(g, tile, level->t, level->sum);
    state.cell = g->plane * (size_t)n_planes;
    if (!has_near(g, tx, ty, 2))
        return;
    for (int p = 0; p < n_cells * n_planes; p++)
        clear(state.sum + state.plane * (size_t)p, state.row);
    if (!has_neighbours(g, tx, ty) || is_used_up(&state, n_cells))
        return;
    take_t(c, &state);
    composite_tile(c, g, tx, ty, &c->acc[rf_thread_num()], &state);
    for (int i = 0; i < n_cells * RF_TILE_H; i++) {
        int cell = i / RF_TILE_H, y = i % RF_TILE_H;
        some_of(g, level, cell, ty * RF_TILE_H + y)[tx] =
            c->kernels->find_some(state.sum + state.cell * (size_t)cell +
                                      state.row * (size_t)y,
                                  state.plane, n_planes);
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
    int low = (at + size) / size - 1;
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
        if (is_inner)
            in = row + first - 1;
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
    int n_x = (int)(c->canvas.stride / RF_TILE_W);
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
            begin_tile(c, s);
        c->canvas.is_begun[tile] = 1;
        unsigned parts = wanted & c->kernels->find_open(t);
        if (parts)
            c->kernels->merge(t, s->sum + s->row * (size_t)y, s->plane,
                              widen(c, g, level, cell, at.low, x0, &rows),
                              widen(c, g, level, cell, at.high, x0, &rows), at.k, parts,
                              c->canvas.n_planes);
    }
}

/* Adds the sums of a level to a tile of the canvas. */
static void merge_tile(const struct rf_composer *c, const struct rf_group *g,
                       const struct level *level, const struct rf_group *full, int tile)
{
    struct rf_tile_state state = state_of(full, tile, c->canvas.t, c->canvas.sum);
    for (int cell = 0; cell < c->canvas.n_cells; cell++)
        merge_cell(c, g, level, cell, tile, &state);
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
    if (has_near(g, tile % g->n_x, tile / g->n_x, 2))
        for (int cell = 0; cell < c->canvas.n_cells; cell++)
            clear(state.t + state.t_plane * (size_t)cell, state.t_row);
}

rf_result rf_run_level(const struct rf_composer *c, const struct rf_group *g,
                       struct rf_error *error)
{
    if (g->level > FINE_LEVEL)
        rf_begin_canvas(c);
    int n_cells = c->canvas.n_cells;
    size_t stride = c->canvas.stride;
    struct rf_group full = rf_group_make(c, 0, false);
    struct level level;
    bool has_level = allocate_level(c, g, &level);
    float *rows = rf_alloc(c->context, stride * (size_t)c->n_threads, sizeof *rows);
    rf_result result = RF_OK;
    if (!has_level || !rows)
        result = rf_fail_memory(error, g->plane * (size_t)n_cells, sizeof(float));
    if (result == RF_OK) {
#pragma omp parallel num_threads(c->n_threads)
        {
            float *row = rows + stride * (size_t)rf_thread_num();
#pragma omp for schedule(static)
            for (int i = 0; i < g->n_x * g->n_y; i++)
                clear_t(c, g, &level, i);
#pragma omp for schedule(static)
            for (int i = 0; i < n_cells * g->height; i++)
                average_row(c, g, &level, i / g->height, i % g->height, row);
#pragma omp for schedule(dynamic, 1)
            for (int i = 0; i < g->n_x * g->n_y; i++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    run_level_tile(c, g, &level, i);
                    rf_task_step(c->scene->task);
                }
#pragma omp for schedule(dynamic, 8)
            for (int i = 0; i < full.n_x * full.n_y; i++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    merge_tile(c, g, &level, &full, i);
                    rf_task_step(c->scene->task);
                }
        }
    }
    rf_free(c->context, rows);
    free_level(c, &level);
    return result;
}
