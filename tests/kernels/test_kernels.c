/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The kernels of every instruction set that this machine has: the same bits as the
 * plainest one, nothing written beside their outputs, whatever the alignment. With
 * --bench also how fast they are, as dav1d's checkasm does:
 *
 *     test_kernels --bench [NAME]
 *
 * prints nanoseconds per call for every level and the ratio to the first one.
 *
 * A kernel is one entry of the table below: a function that calls it on a workspace of
 * floats filled with noise. All of the workspace is compared afterwards, so writing
 * beside an output shows.
 */
#include "../testing.h"

#include <stdint.h>
#include <stdlib.h>
#include <time.h>

#include "kernels.h"

enum { WORK_FLOATS = 1 << 17, N_SPLATS = 64, N_FOOTPRINTS = 3, MAX_SEGMENTS = 32 };

/* Everything that a kernel may read or write. */
struct workspace {
    float at[WORK_FLOATS];
    struct rf_accumulator acc;
};

/* The same for all levels and runs. */
static struct {
    struct rf_splat splats[N_SPLATS];
    struct rf_footprint footprints[N_FOOTPRINTS];
    struct rf_footprint *pointers[N_FOOTPRINTS];
    struct rf_segment segments[N_FOOTPRINTS][MAX_SEGMENTS];
    float weights[N_FOOTPRINTS][(MAX_SEGMENTS + 1) * 24];
} given;

static uint32_t seed;

static float noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) / 16777216.0f;
}

/* Rows of 24 weights, of which some are zero, as for a radius of 3, 6 or 10 px. */
static void make_footprint(struct rf_footprint *f, struct rf_segment *segments,
                           float *weights, int reach, int n_side_by_side)
{
    *f = (struct rf_footprint){.is_common = reach < 4,
                               .n_side_by_side = n_side_by_side,
                               .segments = segments,
                               .weights = weights,
                               .min_dx = -reach,
                               .max_dx = reach,
                               .min_dy = -reach,
                               .max_dy = reach};
    for (int dy = -reach; dy <= reach; dy++) {
        struct rf_segment *g = &segments[f->n_segments];
        int half = (int)sqrt(reach * reach - dy * dy);
        *g = (struct rf_segment){
            .dx = (int16_t)-half,
            .dy = (int16_t)dy,
            .n = (int16_t)((2 * half + n_side_by_side + 7) / 8 * 8),
            .cell = (int16_t)(f->is_common ? 2 : f->n_segments % 2),
            .row = (f->is_common ? 2 : f->n_segments % 2) * RF_TILE_H + dy,
            .weight = 24 * (f->n_segments + 1)};
        for (int i = 0; i < g->n; i++)
            weights[g->weight + i] = i <= 2 * half ? noise() - 0.1f : 0;
        f->n_segments++;
    }
}

static void make_given(void)
{
    seed = 5;
    for (int i = 0; i < N_FOOTPRINTS; i++) {
        given.pointers[i] = &given.footprints[i];
        make_footprint(&given.footprints[i], given.segments[i], given.weights[i],
                       (const int[]){3, 6, 10}[i], (const int[]){2, 1, 4}[i]);
    }
    for (int i = 0; i < N_SPLATS; i++) {
        struct rf_splat *s = &given.splats[i];
        *s = (struct rf_splat){.x = 100 + (int)(noise() * 88) - 12,
                               .y = 50 + (int)(noise() * 56) - 12,
                               .slot = i % N_FOOTPRINTS,
                               .cover = i % 7 ? 0.5f + noise() : 0};
        for (int c = 0; c < 4; c++)
            s->c[c] = noise() * (i % 11 ? 1 : 1000);
        if (i % 8 > 2) { /* six side by side */
            s->x = s[-1].x + 1;
            s->y = s[-1].y;
            s->slot = s[-1].slot;
        }
    }
}

static struct rf_accumulator *make_accumulator(struct workspace *w, int n_planes)
{
    w->acc = (struct rf_accumulator){.n_cells = 2,
                                     .n_planes = n_planes,
                                     .at = w->at,
                                     .share = {0.375f, 0.625f},
                                     .reach = RF_TILE_HALO,
                                     .first_row = RF_TILE_H,
                                     .last_row = -1};
    return &w->acc;
}

enum { ACC_FLOATS = 3 * RF_TILE_H * RF_MAX_PLANES * RF_ACC_STRIDE };

/* ---- the kernels ------------------------------------------------------------------
 */

/* Depths of 0 and below, and beyond infinity, are among them. */
static void call_radii(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_plain_depth depth = {.factor = variant < 4 ? 20 : -20,
                                   .offset = variant < 2 ? 0 : -1,
                                   .infinity = 15,
                                   .bias = 4,
                                   .scale = -8,
                                   .most = 5};
    int64_t n_hit = 3;
    int n = 501 + variant;
    w->at[12] = w->at[499 + variant] = 0;
    bool is_good = k->radii(&depth, w->at + variant, n, w->at + 10001, &n_hit);
    w->at[20000] = (float)n_hit;
    w->at[20001] = is_good;
}

static void call_spread(const struct rf_kernels *k, struct workspace *w, int variant)
{
    k->spread(make_accumulator(w, 4 + variant % 2), given.splats, N_SPLATS,
              given.pointers, 100, 50);
}

enum { PLACES_W = 80, N_PLACES = 400 };

/* Places by rows, runs of one footprint, every 17th of another kind; the tile lies
 * where some of its pixels reach the one that is spread over and some do not. */
static void call_places(const struct rf_kernels *k, struct workspace *w, int variant)
{
    static rf_place places[N_PLACES];
    const struct rf_surface *pixels = (const void *)(w->at + ACC_FLOATS);
    int x = variant < 2 ? 100 : 40, y = variant < 2 ? 50 : 61;
    struct rf_tile_surfaces surfaces = {pixels, 0, PLACES_W, given.splats, x, y};
    for (int i = 0; i < N_PLACES; i++) {
        int column = i % 40 + i % 40 / 7, row = i / 40 * 3;
        places[i] = rf_place_make(i / 9 % N_FOOTPRINTS, column, row,
                                  i % 17 ? 0 : 1 + i % N_SPLATS);
    }
    k->spread_places(make_accumulator(w, 4 + variant % 2), places, N_PLACES, &surfaces,
                     given.pointers, 100, 50);
}

static void call_others(const struct rf_kernels *k, struct workspace *w, int variant)
{
    uint64_t *out = (uint64_t *)(void *)(w->at + 30000);
    for (int i = 0; i < 2000; i++)
        w->at[20000 + i] = i % 9 ? 1 : w->at[20000 + i];
    for (int n = 1; n <= 64; n++)
        out[n] = k->find_others(w->at + 20000 + 3 * n, w->at + variant + n,
                                w->at + 1000, w->at + 2000, 1, 0.25f, n);
}

static void call_positive(const struct rf_kernels *k, struct workspace *w, int variant)
{
    uint64_t *out = (uint64_t *)(void *)(w->at + 30000);
    for (int i = 0; i < 2000; i++)
        w->at[i] = i % 3 ? w->at[i] : i % 2 ? 0 : -1;
    for (int n = 1; n <= 64; n++)
        out[n] = k->find_positive(w->at + variant + n, n);
}

static void call_flush(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_accumulator *acc = make_accumulator(w, 4 + variant % 2);
    float *t = w->at + ACC_FLOATS + 64;
    float *sum = t + 2 * RF_TILE_H * RF_TILE_W + 64;
    const size_t plane = (size_t)RF_TILE_H * RF_TILE_W;
    const struct rf_tile_state state = {.t = t,
                                        .t_row = RF_TILE_W,
                                        .t_plane = plane,
                                        .sum = sum,
                                        .row = RF_TILE_W,
                                        .plane = plane,
                                        .cell =
                                            variant < 2 ? 0 : RF_MAX_PLANES * plane};
    acc->first_row = 2;
    acc->last_row = RF_TILE_H - 1 - variant;
    acc->common_rows = 0xa5f0ff0fu;
    k->flush(acc, &state);
}

static void call_average(const struct rf_kernels *k, struct workspace *w, int variant)
{
    int level = 1 + variant, n_level = 61 >> variant;
    k->average(w->at + variant, 512, 1 << level, level, n_level, w->at + 20000,
               w->at + 24000);
}

static void call_magnify(const struct rf_kernels *k, struct workspace *w, int variant)
{
    int level = 1 + variant, n_level = 40;
    k->magnify(w->at + variant, w->at + 300, 0.25f * (float)variant, n_level, level,
               w->at + 20000, w->at + 24000, (n_level << level) - 5);
}

static void call_merge(const struct rf_kernels *k, struct workspace *w, int variant)
{
    int n_planes = 4 + variant % 2, n = 61 + variant;
    float *sum[RF_MAX_PLANES];
    const float *colour[RF_MAX_PLANES];
    for (int p = 0; p < RF_MAX_PLANES; p++) {
        sum[p] = w->at + 2000 + 200 * p + variant;
        colour[p] = w->at + 4000 + 200 * p;
    }
    k->merge(w->at, sum, colour, w->at + 6000, w->at + 7000, n_planes, n);
}

static void call_extremes(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *rows[7];
    int n = 200 + 3 * variant, reach = variant % 3 + 1;
    for (int i = 0; i < 7; i++)
        rows[i] = w->at + 100 + 400 * i;
    k->extremes(rows, 1 + 2 * variant, reach, n, w->at + 20000,
                variant == 1 ? NULL : w->at + 30000,
                variant == 2 ? NULL : w->at + 31000);
}

/* Slanted planes with a step between them, and more noise from left to right. */
static void call_edges(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *rows[3];
    unsigned char *flags = (unsigned char *)(w->at + 20000);
    for (int i = 0; i < 3; i++)
        rows[i] = w->at + 100 + 400 * i;
    for (int i = 0; i < 3 * 400; i++) {
        int x = i % 400;
        float noise_px = w->at[100 + i] * (float)x / 1000;
        w->at[100 + i] = noise_px + (float)x * 0.2f + (float)(x / 37);
    }
    for (int i = 0; i < 300; i++) {
        w->at[10000 + i] = 0;
        w->at[11000 + i] = 0.4f;
        flags[i] = (unsigned char)(i % 5 + variant);
    }
    k->keep_edges(rows, w->at + 10000, w->at + 11000, 0.3f, 250 + variant, 2, flags);
}

static void call_mixed(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *at = w->at + variant;
    const struct rf_around around = {at, at + 300, at + 600, at + 900, at + 1200};
    k->find_mixed(&around, 1.5f, 1.25f, 0.5f, 250 + variant, 1, 2,
                  (unsigned char *)(w->at + 20000));
}

static void call_gaps(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *rows[3];
    unsigned char *flags = (unsigned char *)(w->at + 20000);
    for (int i = 0; i < 3; i++)
        rows[i] = w->at + 100 + 400 * i;
    for (int i = 0; i < 300; i++)
        flags[i] = (unsigned char)(i % 5 + variant);
    for (int i = 160; i < 200; i++) /* groups without the bit are passed over */
        flags[i] = 0;
    k->find_gaps(rows, 0.25f, 250 + variant, 2, flags, w->at + 30000, w->at + 31000);
}

static void call_sides(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *rows[7];
    for (int i = 0; i < 7; i++)
        rows[i] = w->at + 100 + 400 * i + variant;
    for (int x = 0; x < 200; x++)
        k->find_sides(rows, x, 0.3f, 0.1f, 0.8f + 0.1f * (float)variant,
                      (struct rf_sides *)(w->at + 20000) + x);
}

enum { SHADOWS_W = 61, SHADOWS_H = 47 };

/* A light at the pixel (40, 30), with one view or two. */
static struct rf_shadows shadows_of(struct workspace *w, int variant)
{
    static unsigned char view_at[RF_LENS_GRID][RF_LENS_GRID];
    static unsigned char cell_x[SHADOWS_W], cell_y[SHADOWS_H];
    for (int i = 0; i < RF_LENS_GRID * RF_LENS_GRID; i++)
        view_at[i / RF_LENS_GRID][i % RF_LENS_GRID] = i % RF_LENS_GRID > 20;
    for (int x = 0; x < SHADOWS_W; x++)
        cell_x[x] = (unsigned char)(x * (RF_LENS_GRID - 1) / SHADOWS_W);
    for (int y = 0; y < SHADOWS_H; y++)
        cell_y[y] = (unsigned char)(y + 3);
    return (struct rf_shadows){.light_x = 0.25f,
                               .light_y = 0.75f,
                               .light_r = 20,
                               .x = 40,
                               .y = 30,
                               .seen_x = 42.5f,
                               .seen_y = 31,
                               .extent_x = 0.8f,
                               .extent_y = 1,
                               .nearer = 0.5f,
                               .lens_x = 0.125f * (float)variant,
                               .lens_y = -0.25f,
                               .shift_scale = 1,
                               .shift_bias = 0.5f,
                               .left = -30,
                               .top = -20,
                               .width = SHADOWS_W,
                               .height = SHADOWS_H,
                               .blocked = w->at + 40000,
                               .view_at = variant == 2 ? view_at[0] : NULL,
                               .cell_x = cell_x,
                               .cell_y = cell_y,
                               .view = 1};
}

/* Surfaces from before the light, and none at every fifth pixel. */
static void prepare_shadows(struct workspace *w)
{
    for (int i = 0; i < 64 * 96; i++)
        w->at[i] = i % 5 ? 24 * w->at[i] - 2 : INFINITY;
    memset(w->at + 40000, 0, SHADOWS_W * SHADOWS_H * sizeof *w->at);
}

static void call_shadows(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_shadows s = shadows_of(w, variant);
    for (int y = 0; y < 64; y++)
        k->cast_shadows(&s, w->at + 96 * y, w->at + 20000 + 96 * y, y, 3, 83);
}

/* One pixel is not finite. */
static void call_unpack(const struct rf_kernels *k, struct workspace *w, int variant)
{
    float *planes[4];
    for (int c = 0; c < 4; c++)
        planes[c] = w->at + 10000 + 300 * c + variant;
    if (variant == 2)
        w->at[4 * 77 + 1] = NAN;
    w->at[20000] = k->unpack(w->at, 193 + variant, planes);
}

static void call_pack(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *planes[4];
    for (int c = 0; c < 4; c++)
        planes[c] = w->at + 300 * c + variant;
    k->pack(planes, 193 + variant, w->at + 10000);
}

/* One pixel of the second variant is not opaque; the third has no alpha. */
static void call_load_row(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *planes[4];
    for (int c = 0; c < 4; c++)
        planes[c] = w->at + 300 * c + variant;
    for (int x = 0; x < 300; x++)
        w->at[900 + x] = variant == 1 && x == 77 ? 0.5f : 1;
    planes[3] = variant == 2 ? NULL : planes[3];
    w->at[20000] = k->load_row(planes, w->at + 2000, 193 + variant,
                               (struct rf_surface *)(w->at + 10000), w->at + 9000);
}

static void call_unload_row(const struct rf_kernels *k, struct workspace *w,
                            int variant)
{
    k->unload_row((const struct rf_surface *)(w->at + variant), 193 + variant,
                  w->at + 10000 + variant, w->at + 11000);
}

static void call_shrink(const struct rf_kernels *k, struct workspace *w, int variant)
{
    k->shrink(w->at + variant, 512, 1 << variant, variant, 61 >> variant, w->at + 20000,
              w->at + 24000);
}

static void call_detail(const struct rf_kernels *k, struct workspace *w, int variant)
{
    for (int i = 0; i < 200; i += 3)
        w->at[i] *= -4;
    w->at[20000] = k->detail(w->at + variant, w->at + 1000, variant < 3 ? 0.75f : 1e9f,
                             193 + variant, w->at + 10000);
}

static void call_join(const struct rf_kernels *k, struct workspace *w, int variant)
{
    k->join(w->at + variant, w->at + 1000, w->at + 2000,
            variant == 1 ? NULL : w->at + 3000, variant == 2 ? 0.5f : INFINITY,
            193 + variant, w->at + 10000 + variant);
}

static void call_divide(const struct rf_kernels *k, struct workspace *w, int variant)
{
    for (int i = 0; i < 200; i += 3)
        w->at[1000 + i] *= i % 2 ? 1e-7f : -1;
    k->divide(w->at + variant, w->at + 1000, variant == 1 ? 1 : INFINITY, 193 + variant,
              w->at + 10000 + variant);
}

static void call_log_row(const struct rf_kernels *k, struct workspace *w, int variant)
{
    w->at[3] = 0;
    w->at[5] = -2;
    w->at[6] = 1e30f;
    w->at[7] = 1e-38f;
    k->log_row(w->at + variant, 256);
}

enum { BACKS_W = 128, BACKS_H = 64 };

/* Surfaces of 128 x 64 pixels, some of them unreliable. */
static void prepare_backs(struct workspace *w)
{
    for (int i = 0; i < BACKS_W * BACKS_H; i++)
        w->at[i] = i % 13 ? 20 * w->at[i] : -INFINITY;
}

static struct rf_backs backs_of(struct workspace *w)
{
    return (struct rf_backs){.width = BACKS_W,
                             .height = BACKS_H,
                             .stride = BACKS_W,
                             .r = w->at,
                             .log_luminance = w->at + BACKS_W * BACKS_H};
}

/* Whole pixels of one radius but for some, in a picture that ends within a block. */
static void call_rough(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    backs.width -= 3;
    backs.height -= 5;
    for (int i = 0; i < BACKS_W * BACKS_H; i++) {
        int x = i % BACKS_W;
        w->at[i] = x >= backs.width || i / BACKS_W >= backs.height ? -INFINITY
                   : i % 171 == 7                                  ? 5.6f
                                                                   : 5;
        w->at[20000 + i] = i % 173 == 5 ? 0.5f : 1;
    }
    for (int i = 0; i < BACKS_W / 8 * BACKS_H / 8; i++)
        w->at[40000 + i] =
            k->is_rough(&backs, w->at + 20000, i % (BACKS_W / 8), i / (BACKS_W / 8),
                        variant == 1 ? 0.5f : 0.7f, variant == 2 ? 0.5f : 0.7f);
}

enum { N_BLOCKS = 24 };

static void list_blocks(struct rf_hidden_block blocks[N_BLOCKS])
{
    int n = 0;
    for (int ring = 0; ring < 3; ring++)
        for (int i = 0; i < 8; i++)
            blocks[n++] =
                (struct rf_hidden_block){(int16_t)(7 - ring + i % 3 * ring),
                                         (int16_t)(3 - ring + i / 3 * ring), ring, 25};
}

/* The first n blocks for a group that a query belongs to. */
static struct rf_hidden_group group_of(const struct rf_hidden_query *query, int n)
{
    static struct rf_hidden_block blocks[N_BLOCKS];
    static struct rf_hidden_hit hits[N_BLOCKS];
    list_blocks(blocks);
    return (struct rf_hidden_group){
        .query = *query, .n_blocks = n, .blocks = blocks, .hits = hits};
}

static void call_vote(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    struct rf_hidden_query query = {60 + variant, 30, 4, 1 / 400.0f, 1 / 300.0f};
    struct rf_hidden_group group = group_of(&query, N_BLOCKS);
    static struct rf_hidden_vote vote;
    memset(&vote, 0, sizeof vote);
    vote.nearest = INT32_MAX;
    for (int i = 0; i < RF_HIDDEN_BINS + 4; i++)
        vote.nearest2[i] = INT32_MAX;
    k->vote_blocks(&backs, &group, &query, &vote);
    memcpy(w->at + 40000, &vote, sizeof vote);
}

/* A query for the group of 4 x 4 pixels number i, which may find something or not. */
static struct rf_hidden_query group_query(int i)
{
    return (struct rf_hidden_query){40 + i % 12 * 4, 16 + i / 12 * 4,
                                    14.5f + 0.1f * (float)(i % 7), 1, 1 / 1.5f};
}

static void call_candidate(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    for (int i = 0; i < 72; i++) {
        struct rf_hidden_query query = group_query(i);
        struct rf_hidden_group group = group_of(&query, N_BLOCKS - 8 * variant);
        w->at[40000 + i] = k->has_candidate(&backs, &group);
    }
}

static void call_window(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    struct rf_hidden_query query = {60, 30 - 20 * variant, 4, 1 / 400.0f, 1 / 300.0f};
    struct rf_hidden_window *out = (void *)(w->at + 40000);
    memset(out, 0, sizeof *out);
    k->gather_window(&backs, &query, 10, 9 + 8 * (float)variant, out);
    /* What lies beyond the pixels found is not defined. */
    memset(out->index + out->n, 0,
           sizeof out->index - sizeof(int32_t) * (size_t)out->n);
    memset(out->weight + out->n, 0,
           sizeof out->weight - sizeof(float) * (size_t)out->n);
}

/* Variants differ in alignment, numbers of planes, levels and the like. */
static const struct {
    const char *name;
    void (*call)(const struct rf_kernels *kernels, struct workspace *w, int variant);
    int n_variants;
    void (*prepare)(struct workspace *w); /* NULL: noise will do */
} kernels[] = {
    {"radii", call_radii, 6, NULL},
    {"spread", call_spread, 2, NULL},
    {"spread_places", call_places, 4, NULL},
    {"find_others", call_others, 4, NULL},
    {"find_positive", call_positive, 4, NULL},
    {"flush", call_flush, 4, NULL},
    {"average", call_average, 3, NULL},
    {"magnify", call_magnify, 4, NULL},
    {"merge", call_merge, 4, NULL},
    {"extremes", call_extremes, 4, NULL},
    {"keep_edges", call_edges, 2, NULL},
    {"find_mixed", call_mixed, 4, NULL},
    {"find_gaps", call_gaps, 2, NULL},
    {"find_sides", call_sides, 2, NULL},
    {"cast_shadows", call_shadows, 3, prepare_shadows},
    {"unpack", call_unpack, 4, NULL},
    {"pack", call_pack, 4, NULL},
    {"load_row", call_load_row, 4, NULL},
    {"unload_row", call_unload_row, 4, NULL},
    {"shrink", call_shrink, 4, NULL},
    {"detail", call_detail, 4, NULL},
    {"join", call_join, 4, NULL},
    {"divide", call_divide, 4, NULL},
    {"is_rough", call_rough, 3, prepare_backs},
    {"log_row", call_log_row, 4, NULL},
    {"has_candidate", call_candidate, 2, prepare_backs},
    {"vote_blocks", call_vote, 3, prepare_backs},
    {"gather_window", call_window, 2, prepare_backs},
};

enum { N_KERNELS = sizeof kernels / sizeof *kernels };

/* ---- the checks -------------------------------------------------------------------
 */

static struct workspace first, other, noisy;

static void prepare(struct workspace *w, int k, uint32_t start)
{
    seed = start;
    for (int i = 0; i < WORK_FLOATS; i++)
        w->at[i] = noise();
    /* The accumulator must be zero between bins where nothing was spread. */
    for (int i = 0; i < ACC_FLOATS; i += 3)
        w->at[i] = 0;
    if (kernels[k].prepare)
        kernels[k].prepare(w);
}

/* True where both workspaces hold the same bits; says where they do not. */
static bool is_same(const char *kernel, const char *level, int variant)
{
    for (int i = 0; i < WORK_FLOATS; i++) {
        if (memcmp(&first.at[i], &other.at[i], sizeof(float)) == 0)
            continue;
        printf("#     %s, %s, variant %d: float %d is %.9g, not %.9g\n", kernel, level,
               variant, i, (double)other.at[i], (double)first.at[i]);
        return false;
    }
    return first.acc.first_row == other.acc.first_row &&
           first.acc.last_row == other.acc.last_row &&
           first.acc.common_rows == other.acc.common_rows;
}

static void every_level_gives_the_same_bits(void)
{
    const struct rf_kernels *plain = rf_kernels_at(0), *level;
    REQUIRE(plain);
    CHECK_STR(plain->name, "generic");
    for (int i = 0; (level = rf_kernels_at(i)); i++) {
        printf("# %s\n", level->name);
        for (int k = 0; k < N_KERNELS; k++)
            for (int v = 0; v < kernels[k].n_variants; v++) {
                prepare(&first, k, (uint32_t)v);
                memcpy(&other, &first, sizeof other);
                kernels[k].call(plain, &first, v);
                kernels[k].call(level, &other, v);
                CHECK(is_same(kernels[k].name, level->name, v));
            }
    }
}

/* A kernel that does nothing would pass the comparison. */
static void every_kernel_writes(void)
{
    for (int k = 0; k < N_KERNELS; k++) {
        prepare(&noisy, k, 0);
        prepare(&first, k, 0);
        kernels[k].call(rf_kernels_at(0), &first, 0);
        bool does_write = memcmp(first.at, noisy.at, sizeof first.at) != 0;
        CHECK(does_write);
        if (!does_write)
            printf("#     %s\n", kernels[k].name);
    }
}

/* What a splat leaves does not depend on how it is told. */
static void places_spread_as_splats_do(void)
{
    static struct rf_splat splats[N_SPLATS];
    static struct rf_surface surfaces[32 * 64];
    static rf_place places[N_SPLATS];
    const struct rf_tile_surfaces tile = {surfaces + 5, -5, 64, given.splats, 100, 50};
    const struct rf_kernels *k = rf_kernels_at(0);
    for (int i = 0; i < N_SPLATS; i++) {
        int x = 2 + i % 16 / 4 * 14 + i % 4, y = 3 + i / 16 * 5;
        int slot = i / 7 % N_FOOTPRINTS;
        bool is_other = i % 13 == 4;
        struct rf_surface *at = &surfaces[64 * y + x];
        *at = (struct rf_surface){{noise(), noise(), noise(), noise()}, noise()};
        splats[i] = (struct rf_splat){100 + x, 50 + y, slot, 1, {0}};
        memcpy(splats[i].c, at->c, sizeof at->c);
        if (is_other) {
            splats[i].cover = given.splats[i].cover;
            memcpy(splats[i].c, given.splats[i].c, sizeof splats[i].c);
        }
        places[i] = rf_place_make(slot, x, y, is_other ? i + 1 : 0);
    }
    for (int i = 0; i < 6; i++) { /* a tile to the left, about them, to the right */
        int n_planes = 4 + i % 2, x0 = (const int[]){40, 90, 127}[i / 2];
        memset(&first, 0, sizeof first);
        memset(&other, 0, sizeof other);
        k->spread(make_accumulator(&first, n_planes), splats, N_SPLATS, given.pointers,
                  x0, 48);
        k->spread_places(make_accumulator(&other, n_planes), places, N_SPLATS, &tile,
                         given.pointers, x0, 48);
        CHECK(is_same("spread_places", "as splats", i));
    }
}

/* Bits are where the plain rule says, and none beyond n. */
static void bits_tell_what_pixels_are(void)
{
    const struct rf_kernels *k = rf_kernels_at(0);
    float share[64], luminance[64], radius[64], darkest[64];
    uint64_t others = 0, positive = 0;
    for (int i = 0; i < 64; i++) {
        share[i] = i % 7 ? 1 : 0.5f;
        luminance[i] = 8 * noise();
        radius[i] = 4 * noise() - 2;
        darkest[i] = noise() - 0.1f;
        float r2 = radius[i] * radius[i];
        float limit = 4 + 4 * (r2 < 1 ? r2 : 1);
        bool is_other = share[i] < 1 || luminance[i] > limit * darkest[i];
        others |= (uint64_t)is_other << i;
        positive |= (uint64_t)(darkest[i] > 0) << i;
    }
    CHECK(others && ~others && positive && ~positive);
    for (int n = 1; n <= 64; n++) {
        uint64_t all = UINT64_MAX >> (64 - n);
        CHECK(k->find_others(share, luminance, radius, darkest, 4, 1, n) ==
              (others & all));
        CHECK(k->find_positive(darkest, n) == (positive & all));
    }
}

/* Flags are where the plain rules say, and 0 beyond the row. */
static void mixed_pixels_are_flagged(void)
{
    enum { N = 45, PADDED = 48 };
    const struct rf_kernels *k = rf_kernels_at(0);
    float rows[5][PADDED];
    unsigned char flags[PADDED];
    int n_flags[4] = {0};
    for (int i = 0; i < 5 * PADDED; i++)
        rows[i / PADDED][i % PADDED] = noise();
    const struct rf_around around = {rows[0], rows[1], rows[2], rows[3], rows[4]};
    k->find_mixed(&around, 2, 1.3f, 0.1f, N, 1, 4, flags);
    for (int i = 0; i < PADDED; i++) {
        bool is_fringe =
            rows[2][i] > 2 * (rows[1][i] + 1e-4f) && rows[2][i] > 1.3f * rows[0][i];
        bool is_edge = rows[4][i] - rows[3][i] >= 0.1f;
        CHECK(flags[i] == (i < N ? is_fringe + 4 * is_edge : 0));
        n_flags[is_fringe + 2 * is_edge]++;
    }
    CHECK(n_flags[0] && n_flags[1] && n_flags[2] && n_flags[3]);
}

/* What pixels are made of comes back, and says whether all of it is opaque. */
static void rows_come_back(void)
{
    enum { N = 45 };
    const struct rf_kernels *k = rf_kernels_at(0);
    float plane[4][N], radius[N], luminance[N], radii[N], luminances[N];
    struct rf_surface s[N];
    for (int i = 0; i < 4 * N; i++)
        plane[i / N][i % N] = i / N < 3 ? noise() : 1;
    for (int i = 0; i < N; i++)
        radius[i] = noise() - 0.5f;
    for (int odd = -1; odd < N; odd++) { /* the pixel that is not opaque */
        const float *planes[4] = {plane[0], plane[1], plane[2],
                                  odd < 0 ? NULL : plane[3]};
        plane[3][odd < 0 ? 0 : odd] = odd < 0 ? 1 : 0.75f;
        CHECK(k->load_row(planes, radius, N, s, luminance) == (odd >= 0));
        k->unload_row(s, N, radii, luminances);
        for (int i = 0; i < N; i++) {
            float l = rf_luminance(plane[0][i], plane[1][i], plane[2][i]);
            CHECK(luminance[i] == l && luminances[i] == l && radii[i] == radius[i]);
            for (int c = 0; c < 4; c++)
                CHECK(s[i].c[c] == plane[c][i]);
        }
        plane[3][odd < 0 ? 0 : odd] = 1;
    }
}

/* The searches clear their results themselves, so they are asked for more. */
static void searches_find_something(void)
{
    const struct rf_hidden_vote *vote = (const void *)(first.at + 40000);
    const struct rf_hidden_window *window = (const void *)(first.at + 40000);
    prepare(&first, N_KERNELS - 1, 0);
    call_vote(rf_kernels_at(0), &first, 0);
    CHECK(vote->top > 10 && vote->nearest > 0 && vote->nearest < 1000);
    prepare(&first, N_KERNELS - 1, 0);
    call_window(rf_kernels_at(0), &first, 0);
    CHECK(window->n > 10 && window->weight_sum > 0);
}

/* A group has a candidate wherever one of its pixels has, and not everywhere; what it
 * has learnt for one pixel loses no vote of another. */
static void groups_have_what_their_pixels_have(void)
{
    static struct rf_hidden_vote vote, alone;
    const struct rf_kernels *k = rf_kernels_at(0);
    int n_groups = 0, n_pixels = 0;
    prepare(&first, N_KERNELS - 1, 0);
    for (int i = 0; i < BACKS_W * BACKS_H; i++) /* few stand out */
        first.at[i] -= i * 7 % 61 ? 12 : 0;
    struct rf_backs backs = backs_of(&first);
    for (int i = 0; i < 72; i++) {
        struct rf_hidden_query corner = group_query(i);
        struct rf_hidden_group group = group_of(&corner, N_BLOCKS);
        bool has_any = k->has_candidate(&backs, &group);
        bool has_one = false;
        for (int p = 0; p < 16; p++) {
            struct rf_hidden_query query = corner;
            query.x += p % 4;
            query.y += p / 4;
            if (backs.r[query.y * BACKS_W + query.x] > query.s)
                continue; /* it would be one for itself */
            k->vote_blocks(&backs, &group, &query, &vote);
            has_one |= vote.nearest < INT32_MAX;
            struct rf_hidden_hit hits[N_BLOCKS];
            struct rf_hidden_group own = group;
            own.query = query; /* whose first pixel votes, in a group of its own */
            own.n_seen = own.n_hits = 0;
            own.hits = hits;
            k->vote_blocks(&backs, &own, &query, &alone);
            size_t n = (size_t)vote.top * sizeof *vote.histogram;
            CHECK(vote.top == alone.top && vote.nearest == alone.nearest &&
                  memcmp(vote.histogram, alone.histogram, n) == 0);
        }
        CHECK(has_any || !has_one);
        n_groups += has_any;
        n_pixels += has_one;
    }
    CHECK(n_groups < 60 && n_pixels > 10);
    printf("# %d groups of 72, %d of them with a pixel\n", n_groups, n_pixels);
}

/* Against sorting and counting in plain C. */
static void gaps_and_sides_are_those_of_the_radii(void)
{
    const struct rf_kernels *k = rf_kernels_at(0);
    const float *rows[7];
    struct rf_sides sides;
    prepare(&first, 0, 0);
    memset(first.at + 20000, 2, 256);
    for (int i = 0; i < 3000; i++) /* where the noise is 0 no side is whole */
        first.at[i] = first.at[i] > 0 ? first.at[i] : 0.2f + 1e-4f * (float)i;
    for (int i = 0; i < 7; i++)
        rows[i] = first.at + 100 + 400 * i;
    k->find_gaps(rows + 2, 0.25f, 200, 2, (unsigned char *)(first.at + 20000),
                 first.at + 30000, first.at + 31000);
    for (int x = 0; x < 200; x++) {
        float v[9], gap = 0, middle = 0;
        for (int i = 0; i < 9; i++) {
            int n = i;
            for (; n > 0 && v[n - 1] > rows[2 + i / 3][x + i % 3 - 1]; n--)
                v[n] = v[n - 1];
            v[n] = rows[2 + i / 3][x + i % 3 - 1];
        }
        for (int i = 1; i < 9; i++)
            if (v[i] - v[i - 1] > gap) {
                gap = v[i] - v[i - 1];
                middle = 0.5f * (v[i] + v[i - 1]);
            }
        CHECK(first.at[30000 + x] == gap && first.at[31000 + x] == middle);
        CHECK(((unsigned char *)(first.at + 20000))[x] == (gap >= 0.25f ? 2 : 0));
        middle = x % 3 ? middle : x % 2 ? 0.03f : 0.95f; /* all on one side, mostly */
        k->find_sides(rows, x, middle, 0.1f, 0.9f, &sides);
        for (int bit = 0; bit < 25; bit++) {
            const float *const *at = rows + 1 + bit / 5;
            int column = x + bit % 5 - 2, n_far = 0;
            float r = at[0][column];
            for (int i = 0; i < 9; i++)
                n_far += at[i / 3 - 1][column + i % 3 - 1] > middle;
            CHECK((sides.far >> bit & 1) == (r > middle));
            CHECK((sides.interior >> bit & 1) == (n_far == 0 || n_far == 9));
            CHECK((sides.usual >> bit & 1) == (r >= 0.1f && r <= 0.9f));
        }
    }
}

static void quotients_are_limited(void)
{
    static const float sum[] = {1, 2, -1, 3, 3}, coverage[] = {2, 1, 1, 0, 1e-7f};
    static const float want[] = {0.5f, 1.5f, 0, 0, 0};
    float out[6] = {-7, -7, -7, -7, -7, -7};
    rf_kernels_at(0)->divide(sum, coverage, 1.5f, 5, out);
    for (int i = 0; i < 5; i++)
        CHECK(out[i] == want[i]);
    CHECK(out[5] == -7);
}

/* Of a block or beside it, one pixel that stands out or is mixed. */
static void blocks_are_rough_where_radii_step(void)
{
    enum { SIDE = 20 };
    static float r[24 * 24 + 8], share[SIDE * SIDE];
    struct rf_backs backs = {.width = SIDE, .height = SIDE, .stride = 24, .r = r};
    for (int step = 0; step < SIDE * SIDE; step++) {
        int step_x = step % SIDE, step_y = step / SIDE;
        for (int i = 0; i < 24 * 24; i++)
            r[i] = i % 24 < SIDE && i / 24 < SIDE ? 3 : -INFINITY;
        for (int i = 0; i < SIDE * SIDE; i++)
            share[i] = 1;
        for (int is_mixed = 0; is_mixed < 2; is_mixed++) {
            r[step_y * 24 + step_x] = is_mixed ? 3 : 4;
            share[step] = is_mixed ? 0.5f : 1;
            for (int block = 0; block < 9; block++) {
                int dx = step_x - block % 3 * 8, dy = step_y - block / 3 * 8;
                bool is_in = dx >= 0 && dx < 8 && dy >= 0 && dy < 8;
                bool is_beside = (dx == 8 && dy >= 0 && dy < 8) ||
                                 (dy == 8 && dx >= 0 && dx < 8);
                bool is_rough = rf_kernels_at(0)->is_rough(&backs, share, block % 3,
                                                           block / 3, 0.5f, 0.5f);
                CHECK(is_rough == (is_in || (is_beside && !is_mixed)));
            }
        }
        share[step] = 1;
    }
}

/* A pixel half as far from the focus as the light casts a square twice as large. */
static void a_pixel_casts_a_square(void)
{
    const struct rf_kernels *k = rf_kernels_at(0);
    prepare(&first, 0, 0);
    struct rf_shadows s = shadows_of(&first, 0);
    s.lens_y = 0;
    float share[64], radius[64];
    for (int x = 0; x < 64; x++) {
        share[x] = 0.5f;
        radius[x] = x == 42 ? 19.75f : 10;
    }
    memset(s.blocked, 0, SHADOWS_W * SHADOWS_H * sizeof(float));
    CHECK(k->cast_shadows(&s, radius, share, 29, 38, 39));
    CHECK(!k->cast_shadows(&s, radius, share, 30, 42, 43)); /* too near to the light */
    float sum = 0, sum_x = 0, sum_y = 0;
    for (int i = 0; i < SHADOWS_W * SHADOWS_H; i++) {
        CHECK(s.blocked[i] >= 0 && s.blocked[i] <= 0.5f);
        sum += s.blocked[i];
        sum_x += s.blocked[i] * (float)(i % SHADOWS_W + s.left);
        sum_y += s.blocked[i] * (float)(i / SHADOWS_W + s.top);
    }
    CHECK_NEAR(sum, 4 * 0.5, 1e-5);
    /* The middle of the pixel, seen from the light, and so of the square. */
    CHECK_NEAR(sum_x / sum + 0.5, (-2 + 0.5 - 0.25) * 2 + 0.25, 1e-4);
    CHECK_NEAR(sum_y / sum + 0.5, (-1 + 0.5 - 0.75) * 2 + 0.75, 1e-4);
    s.blocked = NULL;
    CHECK(k->cast_shadows(&s, radius, share, 29, 38, 39));
    CHECK(!k->cast_shadows(&s, radius, share, 29, 10, 11)); /* out of the cone */
}

static void levels_are_found_by_name(void)
{
    const struct rf_kernels *level;
    for (int i = 0; (level = rf_kernels_at(i)); i++)
        CHECK(rf_kernels_find(level->name) == level);
    CHECK(rf_kernels_find("no such level") == NULL);
    CHECK(rf_kernels_find(NULL) != NULL);
}

/* ---- the benchmark ----------------------------------------------------------------
 */

static double cpu_ns(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (double)t.tv_sec * 1e9 + (double)t.tv_nsec;
}

enum { BENCH_ROUNDS = 60, BENCH_CALLS = 40, MAX_LEVELS = 8 };

/* The least time of a call on each level; levels take turns. */
static void bench_kernel(int k)
{
    const struct rf_kernels *level;
    double best[MAX_LEVELS];
    for (int i = 0; i < MAX_LEVELS; i++)
        best[i] = 1e30;
    for (int round = 0; round < BENCH_ROUNDS; round++)
        for (int i = 0; (level = rf_kernels_at(i)) && i < MAX_LEVELS; i++) {
            prepare(&first, k, 0);
            double start = cpu_ns();
            for (int c = 0; c < BENCH_CALLS; c++)
                kernels[k].call(level, &first, 0);
            best[i] = fmin(best[i], (cpu_ns() - start) / BENCH_CALLS);
        }
    printf("%-14s", kernels[k].name);
    for (int i = 0; (level = rf_kernels_at(i)) && i < MAX_LEVELS; i++)
        printf("  %s %.0f ns (%.2f)", level->name, best[i], best[0] / best[i]);
    printf("\n");
}

int main(int argc, char **argv)
{
    make_given();
    if (argc > 1 && strcmp(argv[1], "--bench") == 0) {
        for (int k = 0; k < N_KERNELS; k++)
            if (argc < 3 || strcmp(argv[2], kernels[k].name) == 0)
                bench_kernel(k);
        return 0;
    }
    testing_begin(argc, argv);
    TEST(every_level_gives_the_same_bits);
    TEST(every_kernel_writes);
    TEST(places_spread_as_splats_do);
    TEST(bits_tell_what_pixels_are);
    TEST(mixed_pixels_are_flagged);
    TEST(rows_come_back);
    TEST(searches_find_something);
    TEST(groups_have_what_their_pixels_have);
    TEST(gaps_and_sides_are_those_of_the_radii);
    TEST(a_pixel_casts_a_square);
    TEST(quotients_are_limited);
    TEST(blocks_are_rough_where_radii_step);
    TEST(levels_are_found_by_name);
    return testing_end();
}
