/* SPDX-License-Identifier: Apache-2.0 */
#include "../testing.h"

#include "kernel_calls.h"

struct given given;
uint32_t seed;

float noise(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float)(seed >> 8) / 16777216.0f;
}

/*
 * Rows of 24 weights, of which some are zero, as for a radius of 3, 6 or 10 px; those
 * below the middle may be those above it, and those to its right those to its left. One
 * lies beside its sample.
 */
static void make_footprint(struct rf_footprint *f, struct rf_segment *segments,
                           float *weights, int reach, int n_side_by_side,
                           bool is_mirrored, bool is_even, int shift)
{
    *f = (struct rf_footprint){.is_common = reach < 4,
                               .is_even = is_even,
                               .n_mirrored = is_mirrored ? reach : 0,
                               .n_side_by_side = n_side_by_side,
                               .segments = segments,
                               .weights = weights,
                               .min_dx = shift - reach,
                               .max_dx = shift + reach,
                               .min_dy = -reach,
                               .max_dy = reach};
    for (int dy = -reach; dy <= reach; dy++) {
        struct rf_segment *g = &segments[f->n_segments];
        int half = (int)sqrt(reach * reach - dy * dy);
        *g = (struct rf_segment){
            .dx = (int16_t)(shift - half),
            .dy = (int16_t)dy,
            .n = (int16_t)((2 * half + n_side_by_side + 7) / 8 * 8),
            .n_used = (int16_t)(2 * half + 1),
            .cell = (int16_t)(f->is_common ? 2 : f->n_segments % 2),
            .row = (f->is_common ? 2 : f->n_segments % 2) * RF_TILE_H + dy,
            .weight = 24 * (f->n_segments + 1)};
        float *weight = weights + g->weight;
        for (int i = 0; i < g->n; i++)
            weight[i] = i <= 2 * half ? noise() - 0.1f : 0;
        for (int i = 0; i < half && is_even; i++)
            weight[2 * half - i] = weight[i];
        if (is_mirrored && dy > 0)
            g->weight = segments[reach - dy].weight;
        g->sum = rf_segment_sum(g, weights, is_even);
        f->n_segments++;
    }
}

void make_given(void)
{
    seed = 5;
    for (int i = 0; i < N_FOOTPRINTS; i++) {
        given.pointers[i] = &given.footprints[i];
        make_footprint(&given.footprints[i], given.segments[i], given.weights[i],
                       (const int[]){3, 6, 10, 7}[i], (const int[]){2, 1, 4, 3}[i],
                       i % 2 == 0, i == 0, i == 3 ? -4 : 0);
    }
    for (int i = 0; i < 3 * RF_N_SLANTS; i++)
        given.factors[i] = i % 3 == 2 ? 1 : 0.5f + noise();
    for (int i = 0; i < N_SPLATS; i++) {
        struct rf_splat *s = &given.splats[i];
        *s = (struct rf_splat){.x = 100 + (int)(noise() * 88) - 12,
                               .y = 50 + (int)(noise() * 56) - 12,
                               .slant = i % 3 ? 0 : i % 24 - 12,
                               .slot = i % N_FOOTPRINTS,
                               .cover = i % 7 ? 0.5f + noise() : 0};
        for (int c = 0; c < 4; c++)
            s->c[c] = noise() * (i % 11 ? 1 : 1000);
        if (i % 24 > 2 && i % 24 != 9) { /* 14 and 7 side by side */
            s->x = s[-1].x + 1;
            s->y = s[-1].y;
            s->slot = s[-1].slot;
            s->slant = i % 24 == 18 ? 3 : s[-1].slant;
        }
    }
}

struct rf_spread_sums *make_accumulator(struct workspace *w, int n_planes)
{
    w->acc = (struct rf_spread_sums){.n_cells = 2,
                                     .n_planes = n_planes,
                                     .first_colour = n_planes == RF_LONE_PLANES,
                                     .at = w->at,
                                     .share = {0.375f, 0.625f},
                                     .factors = given.factors,
                                     .reach = RF_TILE_HALO,
                                     .first_row = RF_TILE_H,
                                     .last_row = -1};
    return &w->acc;
}

/* ---- the kernels ---------------------------------------------------------------- */

/* Depths of 0 and below, and beyond infinity, are among them. */
static void call_radii(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_plain_depth depth = {.factor = variant < 4 ? 20 : -20,
                                   .offset = variant < 2 ? 0 : -1,
                                   .infinity = 15,
                                   .bias = 4,
                                   .scale = -8,
                                   .most = 5};
    int64_t n_known = 3;
    int n = 501 + variant;
    w->at[12] = w->at[499 + variant] = 0;
    bool is_good =
        k->radii(&depth, w->at + variant, n, w->at + 10001, &n_known, w->at + 20002);
    w->at[20000] = (float)n_known;
    w->at[20001] = is_good;
}

/* Three colours or four with coverage, and one alone. */
static int planes_of(int variant)
{
    return (const int[]){4, RF_MAX_PLANES, RF_LONE_PLANES}[variant % 3];
}

static void call_spread(const struct rf_kernels *k, struct workspace *w, int variant)
{
    k->spread(make_accumulator(w, planes_of(variant)), given.splats, N_SPLATS,
              given.pointers, 100, 50);
}

enum { PLACES_W = 80, N_PLACES = 250 };

/* Places by rows, runs of 1 to 13 surfaces, every fourth of another kind; the tile lies
 * where some of its pixels reach the one that is spread over and some do not. */
static void call_places(const struct rf_kernels *k, struct workspace *w, int variant)
{
    static rf_packed places[N_PLACES];
    const struct rf_surface *pixels = (const void *)(w->at + ACC_FLOATS);
    int x = variant < 3 ? 100 : 40, y = variant < 3 ? 50 : 61, column = 0, row = 0;
    struct rf_tile_surfaces surfaces = {pixels, 0, PLACES_W, given.splats, x, y};
    for (int i = 0; i < N_PLACES; i++) {
        int n = i % 4 ? i * 7 % 13 + 1 : 1;
        if (column + n > RF_TILE_W) {
            column = 0;
            row = (row + 1) % RF_TILE_H;
        }
        places[i] = rf_packed_make(i / 3 % N_FOOTPRINTS, column, row,
                                   i % 4 == 0 ? 1 + i % N_SPLATS
                                              : rf_packed_run(n, i % 3 * 30 - 30));
        column += n + i % 5 / 4;
    }
    k->spread_places(make_accumulator(w, planes_of(variant)), places, N_PLACES,
                     &surfaces, given.pointers, 100, 50);
}

/* Shares most of which are 1, and values some of which are 0 or below. */
static void prepare_pixels(struct workspace *w)
{
    for (int i = 0; i < 2000; i++) {
        w->at[20000 + i] = i % 9 ? 1 : w->at[20000 + i];
        w->at[i] = i % 3 ? w->at[i] : i % 2 ? 0 : -1;
    }
}

static void call_others(const struct rf_kernels *k, struct workspace *w, int variant)
{
    uint64_t *out = (uint64_t *)(void *)(w->at + 30000);
    for (int n = 1; n <= 320; n += 11)
        k->find_others(w->at + 20000 + 3 * n, w->at + variant + n, w->at + 1000,
                       w->at + 2000, 1, 0.25f, n, out + 5 * n);
}

static void call_above(const struct rf_kernels *k, struct workspace *w, int variant)
{
    uint64_t *out = (uint64_t *)(void *)(w->at + 30000);
    for (int n = 1; n <= 320; n += 11)
        k->find_above(w->at + variant + n, 0.1f * (float)variant, n, out + 5 * n);
}

static void call_flush(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_spread_sums *acc = make_accumulator(w, planes_of(variant));
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
                                            variant < 3 ? 0 : RF_MAX_PLANES * plane};
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

static void call_some(const struct rf_kernels *k, struct workspace *w, int variant)
{
    uint64_t *out = (uint64_t *)(void *)(w->at + 30000);
    for (int i = 0; i < 2000; i++)
        w->at[i] = i % 7 ? 0 : i % 5 ? -0.0f : w->at[i];
    *out = k->find_some(w->at + variant, 200, 4 + variant % 2);
}

static void call_open(const struct rf_kernels *k, struct workspace *w, int variant)
{
    for (int i = 0; i < RF_TILE_W; i++)
        w->at[i] = i % 11 == 5 ? w->at[i] : variant ? -w->at[i] : 0;
    w->at[30000] = (float)k->find_open(w->at);
}

static void call_stretch(const struct rf_kernels *k, struct workspace *w, int variant)
{
    int level = 1 + variant;
    k->stretch(w->at + variant, level, RF_TILE_W % (1 << level), w->at + 24000);
}

/* Between rows of noise, with T and coverage that are nothing here and there. */
static void call_merge(const struct rf_kernels *k, struct workspace *w, int variant)
{
    int n_planes = planes_of(variant);
    for (int i = 0; i < 1000; i += 3)
        w->at[4000 + i] = 0;
    for (int i = 0; i < RF_TILE_W; i += 5)
        w->at[i] = 0;
    k->merge(w->at, w->at + 2000, 200, w->at + 4000, w->at + 5000,
             0.25f * (float)variant, variant < 3 ? 0xff : 0x5a, n_planes);
}

/* 3, 5 and 7 rows, both results and each alone. */
static void call_extremes(const struct rf_kernels *k, struct workspace *w, int variant)
{
    const float *rows[7];
    int n = 200 + 3 * variant, reach = variant % 3 + 1;
    for (int i = 0; i < 7; i++)
        rows[i] = w->at + 100 + 400 * i;
    k->extremes(rows, 2 * reach + 1, reach, n, w->at + 20000,
                variant / 3 == 1 ? NULL : w->at + 30000,
                variant / 3 == 2 ? NULL : w->at + 31000);
}

/* Slopes of all kinds, steps between them, and what is flat. */
static void call_slants(const struct rf_kernels *k, struct workspace *w, int variant)
{
    int16_t *out = (int16_t *)(void *)(w->at + 20000);
    const float *rows[5];
    for (int i = 0; i < 5; i++)
        rows[i] = w->at + 100 + 400 * i;
    for (int i = 0; i < 5 * 400; i++) {
        int x = i % 400, y = i / 400;
        float slope = 0.3f * (float)(x / 31 - 5), noise_px = 0.01f * w->at[100 + i];
        w->at[100 + i] = (float)x * slope + (float)(y * x / 60) * 0.1f + noise_px +
                         (float)(x / 37 + y / 3 * (x / 90));
    }
    for (int n = 1; n <= 300; n += 13)
        out[320 * n + 319] =
            k->find_slants(rows, 0.02f * (float)variant, n + variant, out + 320 * n);
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

struct rf_shadows shadows_of(struct workspace *w, int variant)
{
    static unsigned char views[2][SHADOWS_W + RF_SHADOW_MARGIN];
    static unsigned char views_row[SHADOWS_H];
    for (int x = 0; x < SHADOWS_W; x++) {
        views[0][x] = x > 20;
        views[1][x] = x < 41;
    }
    for (int y = 0; y < SHADOWS_H; y++)
        views_row[y] = y > 25;
    return (struct rf_shadows){.light_x = 0.25f,
                               .light_y = 0.75f,
                               .light_r = 20,
                               .disc_r = 23,
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
                               .views = variant == 2 ? views[0] : NULL,
                               .views_row = views_row,
                               .view = 1};
}

/* Surfaces from before the light, some in runs, and none at every fifth pixel. */
static void prepare_shadows(struct workspace *w)
{
    for (int i = 0; i < 64 * 96; i++)
        w->at[i] = i % 40 < 15 ? 9 : i % 5 ? 24 * w->at[i] - 2 : INFINITY;
    memset(w->at + 40000, 0, SHADOWS_W * SHADOWS_H * sizeof *w->at);
}

static void call_shadows(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_shadows s = shadows_of(w, variant);
    s.row = 96;
    s.join = variant == 1 ? 1 : 0;
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

/* Pixels that are opaque, film, not finite, and both of that. */
static void call_load_rgba(const struct rf_kernels *k, struct workspace *w, int variant)
{
    float *rgba = w->at + variant;
    for (int x = 0; x < 200; x++)
        rgba[4 * x + 3] = variant & 1 && x == 77 ? 0.5f : 1;
    if (variant & 2)
        rgba[4 * 190 + 1] = INFINITY;
    w->at[20000] =
        (float)k->load_rgba(rgba, w->at + 2000, 193 + variant,
                            (struct rf_surface *)(w->at + 10000), w->at + 9000);
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
    k->divide(w->at + variant, w->at + 1000, -0.2f * (float)variant,
              variant == 1 ? 1 : INFINITY, 193 + variant, w->at + 10000 + variant);
}

/* What quotients have at the least. */
static const float LEAST[3] = {0, -0.1f, -INFINITY};

static void call_divide_add(const struct rf_kernels *k, struct workspace *w,
                            int variant)
{
    const float *sum[4];
    float *out[4];
    for (int i = 0; i < 200; i += 3)
        w->at[4000 + i] *= i % 2 ? 1e-7f : -1;
    for (int c = 0; c < 4; c++) {
        sum[c] = c == 3 && variant % 2 ? NULL : w->at + 900 * c + variant;
        out[c] = c == variant ? NULL : w->at + 10000 + 300 * c;
    }
    k->divide_add(sum, w->at + 4000, LEAST, 0.3f, 193 + variant, out);
}

/* With alpha and without. */
static void call_divide_rgba(const struct rf_kernels *k, struct workspace *w,
                             int variant)
{
    for (int i = 0; i < 200; i += 3)
        w->at[4000 + i] *= i % 2 ? 1e-7f : -1;
    const float *sum[4];
    for (int c = 0; c < 4; c++)
        sum[c] = c == 3 && variant % 2 ? NULL : w->at + 900 * c + variant;
    k->divide_rgba(sum, w->at + 4000, LEAST, 193 + variant, w->at + 10000 + variant);
}

static void call_log_row(const struct rf_kernels *k, struct workspace *w, int variant)
{
    w->at[3] = 0;
    w->at[5] = -2;
    w->at[6] = 1e30f;
    w->at[7] = 1e-38f;
    k->log_row(w->at + variant, 256);
}

/* Surfaces of 128 x 64 pixels, some of them unreliable. */
static void prepare_backs(struct workspace *w)
{
    for (int i = 0; i < BACKS_W * BACKS_H; i++)
        w->at[i] = i % 13 && i % BACKS_W < BACKS_W - 8 ? 20 * w->at[i] : -INFINITY;
}

struct rf_backs backs_of(struct workspace *w)
{
    return (struct rf_backs){
        .width = BACKS_W - 8, .height = BACKS_H, .stride = BACKS_W, .r = w->at};
}

/* Pixels of one radius but for some, in a picture that ends within a block. */
static void call_measure(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    float *out = w->at + 40000;
    backs.width -= 3;
    backs.height -= 5;
    for (int i = 0; i < BACKS_W * BACKS_H; i++)
        w->at[i] = i % BACKS_W >= backs.width ? -INFINITY
                   : i % 171 == 7             ? 5.6f
                   : i % 173 == 5             ? -INFINITY
                                              : 5;
    for (int i = 0; i < (BACKS_W / 8 - 1) * BACKS_H / 8; i++, out += 3)
        out[2] = k->measure_block(&backs, i % (BACKS_W / 8 - 1), i / (BACKS_W / 8 - 1),
                                  variant == 1 ? 0.5f : 0.7f,
                                  variant == 2 ? 0.5f : 0.7f, &out[0], &out[1]);
}

static void list_blocks(struct rf_hidden_block blocks[N_BLOCKS])
{
    int n = 0;
    for (int ring = 0; ring < 3; ring++)
        for (int i = 0; i < 8; i++)
            blocks[n++] = (struct rf_hidden_block){(int16_t)(7 - ring + i % 3 * ring),
                                                   (int16_t)(3 - ring + i / 3 * ring),
                                                   ring, 25, 25};
}

struct rf_hidden_group group_of(const struct rf_hidden_query *query, int n)
{
    static struct rf_hidden_block blocks[N_BLOCKS];
    static struct rf_hidden_hit hits[N_BLOCKS];
    list_blocks(blocks);
    return (struct rf_hidden_group){
        .query = *query, .n_blocks = n, .blocks = blocks, .hits = hits};
}

void call_vote(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    struct rf_hidden_query query = {60 + variant, 30, 4, 1 / 400.0f, 1 / 300.0f};
    struct rf_hidden_group group = group_of(&query, N_BLOCKS);
    struct vote_result *out = (void *)(w->at + 40000);
    static struct rf_hidden_vote vote;
    memset(&vote, 0, sizeof vote);
    *out = (struct vote_result){0};
    out->is_found = k->vote_blocks(&backs, &group, &query, &vote, &out->r, &out->d2);
    /* What lies beyond the candidates is not defined. */
    out->n = vote.n;
    memcpy(out->room, vote.room, sizeof *out->room * (size_t)vote.n);
    memcpy(out->weight, vote.weight, sizeof *out->weight * (size_t)vote.n);
    memcpy(out->histogram, vote.histogram, sizeof out->histogram);
}

struct rf_hidden_query group_query(int i)
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
        query.x += 2 * (i % 2);
        query.y += 2 * (i / 2 % 2);
        w->at[40100 + i] = k->quad_has_candidate(&backs, &group, &query);
    }
}

void call_window(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_backs backs = backs_of(w);
    struct rf_hidden_query query = {60, 30 - 9 * variant, 4, 1 / 400.0f, 1 / 300.0f};
    struct rf_hidden_window *out = (void *)(w->at + 40000);
    memset(out, 0, sizeof *out);
    k->gather_window(&backs, &query, 10, 8 + 9 * (float)variant, (void *)w->at, out);
    /* What lies beyond the pixels found is not defined. */
    memset(out->index + out->n, 0,
           sizeof out->index - sizeof(int32_t) * (size_t)out->n);
    memset(out->weight + out->n, 0,
           sizeof out->weight - sizeof(float) * (size_t)out->n);
}

/* Colours of noise, some of them lamps; in some variants there are less than eight. */
static void call_average_window(const struct rf_kernels *k, struct workspace *w,
                                int variant)
{
    static struct rf_hidden_window window;
    static struct rf_marks mixed[2];
    const struct rf_surfaces surfaces = {.near = (void *)(w->at + 1000),
                                         .far = (void *)(w->at + 2000),
                                         .mixed = mixed,
                                         .share = w->at + 3000};
    mixed[0] = (struct rf_marks){0x842108421084210, 0};
    mixed[1] = (struct rf_marks){0x11, (size_t)__builtin_popcountll(mixed[0].bits)};
    window.n = (const int[]){64, 5, 35}[variant];
    window.weight_sum = (float)window.n;
    for (int i = 0; i < window.n; i++) {
        window.index[i] = i * 7 % 101;
        w->at[1000 + 5 * i] *= i % 9 ? 1 : 50;
        w->at[3000 + i] += i % 2 ? 1 : 0;
    }
    memset(window.weight, 0, sizeof window.weight);
    memcpy(window.weight, w->at, sizeof(float) * (size_t)window.n);
    k->average_window(&surfaces, &window, 1.5f, w->at + 40000);
}

/* Places of noise in and around the picture; in some variants eight lie side by side.
 */
struct rf_sight sight_of(const struct workspace *w)
{
    return (struct rf_sight){.radius = w->at,
                             .stride = SIGHT_W,
                             .lens = {0.5f, -0.25f},
                             .shift_scale = 0.75f,
                             .shift_bias = 1.25f,
                             .x0 = 5,
                             .y0 = 3,
                             .x1 = SIGHT_W - 4,
                             .y1 = SIGHT_H - 2};
}

struct rf_sight_places places_of(const struct workspace *w, int variant)
{
    struct rf_sight_places p;
    for (int i = 0; i < RF_SIGHT_PARTS; i++) {
        const float *at = w->at + 30000 + 16 * variant + i;
        bool is_run = i >= 8 && variant % 2;
        p.x[i] = is_run ? 20.5f + (float)i : (SIGHT_W + 8) * at[0] - 4;
        p.y[i] = is_run ? 9.5f : (SIGHT_H + 8) * at[100] - 4;
        p.r[i] = is_run ? 2 : 3 * at[200];
    }
    p.x[1] = -INFINITY;
    p.y[2] = 1e30f;
    return p;
}

static void call_place(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_sight sight = sight_of(w);
    struct rf_sight_places p = places_of(w, variant);
    k->place_parts(&sight, 16 - 8 * (variant % 2), &p);
    memcpy(w->at + 40000, &p, sizeof p);
}

static void call_place_row(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_sight sight = sight_of(w);
    struct rf_sight_places p = {.x = {0}};
    k->place_row(&sight, 3 * variant, 2 + variant, &p);
    memcpy(w->at + 40000, &p, sizeof p);
}

static void call_look(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_sight sight = sight_of(w);
    struct rf_sight_places p = places_of(w, variant);
    struct rf_sight_found found = {.rendered = 0};
    for (int i = 0; i < SIGHT_W * SIGHT_H; i++)
        w->at[i] = i % 11 ? 3 * w->at[i] : INFINITY;
    k->look_for_parts(&sight, &p, 16 - variant / 2, 0.5f, &found);
    memcpy(w->at + 40000, &found, sizeof found);
}

static void call_find_pixels(const struct rf_kernels *k, struct workspace *w,
                             int variant)
{
    struct rf_sight sight = sight_of(w);
    struct rf_sight_places p = places_of(w, variant);
    struct rf_sight_found found = {.rendered = 0};
    k->find_pixels(&sight, &p, 16 - variant / 2, &found);
    memcpy(w->at + 40000, &found, sizeof found);
}

static void call_finite(const struct rf_kernels *k, struct workspace *w, int variant)
{
    for (int i = 0; i < 64; i++)
        w->at[i] = i % 5 ? w->at[i] : INFINITY;
    uint64_t found = k->find_finite_from(w->at + 3, w->at[7], 61 - 19 * variant);
    memcpy(w->at + 40000, &found, sizeof found);
}

static void call_fit(const struct rf_kernels *k, struct workspace *w, int variant)
{
    struct rf_sight_plane plane;
    k->fit_plane(w->at + 3, w->at + 1000 * variant, 11, variant == 2 ? 10 : 0.05f,
                 &plane);
    memcpy(w->at + 40000, &plane, sizeof plane);
}

const struct kernel kernels[] = {
    {"radii", call_radii, 6, NULL},
    {"spread", call_spread, 3, NULL},
    {"spread_places", call_places, 6, NULL},
    {"find_others", call_others, 4, prepare_pixels},
    {"find_above", call_above, 4, prepare_pixels},
    {"find_slants", call_slants, 4, NULL},
    {"flush", call_flush, 6, NULL},
    {"average", call_average, 3, NULL},
    {"find_some", call_some, 4, NULL},
    {"find_open", call_open, 2, NULL},
    {"stretch", call_stretch, 8, NULL},
    {"merge", call_merge, 6, NULL},
    {"magnify", call_magnify, 4, NULL},
    {"extremes", call_extremes, 9, NULL},
    {"keep_edges", call_edges, 2, NULL},
    {"find_mixed", call_mixed, 4, NULL},
    {"find_gaps", call_gaps, 2, NULL},
    {"find_sides", call_sides, 2, NULL},
    {"cast_shadows", call_shadows, 3, prepare_shadows},
    {"unpack", call_unpack, 4, NULL},
    {"pack", call_pack, 4, NULL},
    {"load_row", call_load_row, 4, NULL},
    {"load_rgba", call_load_rgba, 4, NULL},
    {"shrink", call_shrink, 4, NULL},
    {"detail", call_detail, 4, NULL},
    {"join", call_join, 4, NULL},
    {"divide", call_divide, 4, NULL},
    {"divide_add", call_divide_add, 4, NULL},
    {"divide_rgba", call_divide_rgba, 4, NULL},
    {"place_parts", call_place, 2, NULL},
    {"place_row", call_place_row, 2, NULL},
    {"look_for_parts", call_look, 4, NULL},
    {"find_pixels", call_find_pixels, 4, NULL},
    {"find_finite_from", call_finite, 4, NULL},
    {"fit_plane", call_fit, 3, NULL},
    {"measure_block", call_measure, 3, prepare_backs},
    {"log_row", call_log_row, 4, NULL},
    {"has_candidate", call_candidate, 2, prepare_backs},
    {"vote_blocks", call_vote, 3, prepare_backs},
    {"average_window", call_average_window, 3, NULL},
    {"gather_window", call_window, 4, prepare_backs},
};

const int n_kernels = sizeof kernels / sizeof *kernels;
