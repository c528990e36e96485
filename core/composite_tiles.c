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
    static const int REACH = 4; /* of the kernel, with the rounding of the radius */
    int first = g->first_bin + b;
    float r = 2.0f * (float)rf_max_int(-first, first + 1) / (float)(1 << g->level);
    double most = 0;
    for (int k = 0; k < 2; k++)
        most = fmax(most, c->reach[k][0] + (double)r * c->reach[k][1]);
    return (int)ceil(most) + REACH;
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

static struct span span_of_both(struct span a, struct span b)
{
    return (struct span){rf_min_int(a.first, b.first), rf_max_int(a.end, b.end)};
}

/* Where the bits of a row of the level are. */
static uint64_t *some_of(const struct rf_group *g, const struct level *level, int cell,
                         int y)
{
    size_t row = (size_t)cell * (size_t)(g->n_y * RF_TILE_H) + (size_t)y;
    return level->some + row * (size_t)g->n_x;
}

/* T of the canvas averaged over the blocks of one row of the level, in its active
 * tiles. The last block of a row or column may lie partly outside the picture. */
static void average_row(const struct rf_composer *c, const struct rf_group *g,
                        const struct level *level, int cell, int y, float *row)
{
    struct span tiles = level->row[y / RF_TILE_H];
    if (tiles.first >= tiles.end)
        return;
    int y0 = y << g->level, n_rows = 1 << g->level;
    n_rows = rf_min_int(n_rows, c->scene->height - y0);
    int x0 = tiles.first * RF_TILE_W, x1 = rf_min_int(tiles.end * RF_TILE_W, g->width);
    const float *t = c->canvas.t + c->canvas.plane * (size_t)cell +
                     c->canvas.stride * (size_t)y0 + ((size_t)x0 << g->level);
    float *out = level->t + g->plane * (size_t)cell + g->stride * (size_t)y + x0;
    int last = rf_min_int(x1, c->scene->width >> g->level); /* whole blocks */
    c->kernels->average(t, c->canvas.stride, n_rows, g->level, last - x0, row, out);
    if (x1 > last) {
        int n = c->scene->width - (last << g->level);
        float sum = 0;
        t += (size_t)(last - x0) << g->level;
        for (int j = 0; j < n_rows; j++)
            for (int i = 0; i < n; i++)
                sum += rf_max_float(t[c->canvas.stride * (size_t)j + (size_t)i], 0);
        sum /= (float)(n * n_rows);
        out[last - x0] = sum > RF_USED_UP ? sum : 0;
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

/* Which pixels of a tile's row have a sum that is not 0. */
static uint64_t find_some(const float *sum, size_t plane, int n_planes)
{
    uint32_t any[RF_TILE_W];
    memcpy(any, sum, sizeof any);
    for (int p = 1; p < n_planes; p++)
        for (int x = 0; x < RF_TILE_W; x++) {
            uint32_t bits;
            memcpy(&bits, sum + plane * (size_t)p + x, sizeof bits);
            any[x] |= bits;
        }
    uint64_t some = 0;
    for (int x = 0; x < RF_TILE_W; x++)
        some |= (uint64_t)(any[x] << 1 != 0) << x; /* -0 is nothing, too */
    return some;
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
            find_some(state.sum + state.cell * (size_t)cell + state.row * (size_t)y,
                      state.plane, n_planes);
    }
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

/* Pixels that are looked at together, to pass over those that are used up. */
enum { OPEN_PX = 32 };

/* A row of the canvas that a level is added to, from its first active tile on. */
struct merged_row {
    int n, unit, level; /* pixels, those looked at together */
    const float *t;
    const uint64_t *some[2]; /* of the two rows of the level that it lies between */
    int n_words;
};

/* Has the level anything for a unit? Its sums lie a pixel farther when magnified. */
static bool has_some(const struct merged_row *m, int x)
{
    int low = x >> m->level, high = (x + m->unit - 1) >> m->level, word = low / 64;
    uint64_t before = 0, at = m->some[0][word] | m->some[1][word], after = 0;
    if (word > 0)
        before = m->some[0][word - 1] | m->some[1][word - 1];
    if (word + 1 < m->n_words)
        after = m->some[0][word + 1] | m->some[1][word + 1];
    at |= at << 1 | at >> 1 | before >> 63 | after << 63;
    return at << (63 - high % 64) >> (63 - high % 64) >> low % 64 != 0;
}

static bool is_wanted(const struct merged_row *m, int x)
{
    return has_some(m, x) && is_open(m->t + x, rf_min_int(m->unit, m->n - x));
}

/* The first run of units from x on to which the level adds, which ends at *end; n
 * where there is none. */
static int find_wanted(const struct merged_row *m, int x, int *end)
{
    while (x < m->n && !is_wanted(m, x))
        x += m->unit;
    *end = x;
    while (*end < m->n && is_wanted(m, *end))
        *end += m->unit;
    *end = rf_min_int(*end, m->n);
    return rf_min_int(x, m->n);
}

/* Adds the sums of a level to one row of the canvas. */
static void merge_row(const struct rf_composer *c, const struct rf_group *g,
                      const struct level *level, int y, float *rows)
{
    int n_planes = c->canvas.n_planes;
    size_t row = c->canvas.stride, size = (size_t)1 << g->level;
    struct between at_y = between_at(y, g->level, g->height);
    struct span tiles = span_of_both(level->row[at_y.low / RF_TILE_H],
                                     level->row[at_y.high / RF_TILE_H]);
    if (tiles.first >= tiles.end)
        return;
    size_t first = (size_t)tiles.first * RF_TILE_W; /* column of the level */
    int n_level = rf_min_int(tiles.end * RF_TILE_W, g->width) - (int)first;
    int n = rf_min_int(n_level * (int)size, (int)(row - first * size));
    n = (n + RF_FOOTPRINT_LANES - 1) / RF_FOOTPRINT_LANES * RF_FOOTPRINT_LANES;
    size_t at = row * (size_t)y + first * size; /* in the canvas */
    struct merged_row m = {.n = n,
                           .unit = rf_max_int(OPEN_PX, (int)size),
                           .level = g->level,
                           .n_words = tiles.end - tiles.first};
    float *sum[RF_MAX_PLANES];
    const float *magnified[RF_MAX_PLANES + 1];
    for (int cell = 0; cell < c->canvas.n_cells; cell++) {
        float *t = c->canvas.t + c->canvas.plane * (size_t)cell + at;
        m.t = t;
        m.some[0] = some_of(g, level, cell, at_y.low) + tiles.first;
        m.some[1] = some_of(g, level, cell, at_y.high) + tiles.first;
        for (int x = 0, end; (x = find_wanted(&m, x, &end)) < n; x = end) {
            /* Of the level, with a column to each side to lie between. */
            int low = rf_max_int((x >> g->level) - 1, 0);
            int high = rf_min_int(((end - 1) >> g->level) + 2, n_level);
            int before = x - (low << g->level);
            for (int p = 0; p <= n_planes; p++) {
                const float *plane =
                    p < n_planes ? level->sum + g->plane * (size_t)(cell * n_planes + p)
                                 : level->t + g->plane * (size_t)cell;
                const float *from = plane + first + (size_t)low;
                float *out = rows + row * (size_t)(p + 1);
                c->kernels->magnify(from + g->stride * (size_t)at_y.low,
                                    from + g->stride * (size_t)at_y.high, at_y.k,
                                    high - low, g->level, rows, out, before + end - x);
                magnified[p] = out + before;
            }
            for (int p = 0; p < n_planes; p++)
                sum[p] = c->canvas.sum + c->canvas.plane * (size_t)p + at + (size_t)x;
            c->kernels->merge(t + x, sum, magnified, magnified[n_planes - 1],
                              magnified[n_planes], n_planes, end - x);
        }
    }
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
    rf_begin_canvas(c);
    int n_cells = c->canvas.n_cells;
    size_t n_rows = c->canvas.stride * N_ROWS;
    struct level level;
    bool has_level = allocate_level(c, g, &level);
    float *rows = rf_alloc(c->context, n_rows * (size_t)c->n_threads, sizeof *rows);
    rf_result result = RF_OK;
    if (!has_level || !rows)
        result = rf_fail_memory(error, g->plane * (size_t)n_cells, sizeof(float));
    if (result == RF_OK) {
#pragma omp parallel num_threads(c->n_threads)
        {
            float *row = rows + n_rows * (size_t)rf_thread_num();
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
            for (int y = 0; y < c->scene->height; y++)
                if (!rf_task_is_cancelled(c->scene->task)) {
                    merge_row(c, g, &level, y, row);
                    rf_task_step(c->scene->task);
                }
        }
    }
    rf_free(c->context, rows);
    free_level(c, &level);
    return result;
}
