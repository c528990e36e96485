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
 * A kernel is one entry of the table in kernel_calls.c: a function that calls it on a
 * workspace of floats filled with noise. All of the workspace is compared afterwards,
 * so writing beside an output shows.
 */
#include "../testing.h"

#include <time.h>
#ifndef _WIN32
#include <sys/mman.h>
#include <unistd.h>
#endif

#include "kernel_calls.h"

/* ---- the checks ----------------------------------------------------------------- */

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
        for (int k = 0; k < n_kernels; k++)
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
    for (int k = 0; k < n_kernels; k++) {
        prepare(&noisy, k, 0);
        prepare(&first, k, 0);
        kernels[k].call(rf_kernels_at(0), &first, 0);
        bool does_write = memcmp(first.at, noisy.at, sizeof first.at) != 0;
        CHECK(does_write);
        if (!does_write)
            printf("#     %s\n", kernels[k].name);
    }
}

/* Bits are where the plain rule says, and none beyond n. */
static void bits_tell_what_pixels_are(void)
{
    enum { N = 150 };
    const struct rf_kernels *k = rf_kernels_at(0);
    float share[N], luminance[N], radius[N], darkest[N];
    uint64_t others[3] = {0}, positive[3] = {0}, found[3];
    for (int i = 0; i < N; i++) {
        share[i] = i % 7 ? 1 : 0.5f;
        luminance[i] = 8 * noise();
        radius[i] = 4 * noise() - 2;
        darkest[i] = noise() - 0.1f;
        float r2 = radius[i] * radius[i];
        float limit = 4 + 4 * (r2 < 1 ? r2 : 1);
        bool is_other = share[i] < 1 || luminance[i] > limit * darkest[i];
        others[i / 64] |= (uint64_t)is_other << i % 64;
        positive[i / 64] |= (uint64_t)(darkest[i] > 0) << i % 64;
    }
    CHECK(others[0] && ~others[0] && positive[0] && ~positive[0]);
    for (int n = 1; n <= N; n++) {
        int last = (n - 1) / 64;
        uint64_t all = UINT64_MAX >> (63 - (n - 1) % 64);
        k->find_others(share, luminance, radius, darkest, 4, 1, n, found);
        CHECK(found[last] == (others[last] & all) &&
              (last == 0 || found[0] == others[0]));
        k->find_above(darkest, 0, n, found);
        CHECK(found[last] == (positive[last] & all) &&
              (last == 0 || found[0] == positive[0]));
    }
}

/* With either result or both, in the sizes that are unrolled and others. */
static void check_extremes(int n_rows, int reach, int n)
{
    enum { MOST = 48, STRIDE = MOST + 2 * RF_ROW_MARGIN };
    float values[7][STRIDE], scratch[2 * STRIDE], results[4][MOST];
    const float *rows[7];
    for (int i = 0; i < 7 * STRIDE; i++)
        values[i / STRIDE][i % STRIDE] = noise();
    for (int i = 0; i < 7; i++)
        rows[i] = values[i] + RF_ROW_MARGIN;
    const struct rf_kernels *k = rf_kernels_at(0);
    k->extremes(rows, n_rows, reach, n, scratch, results[0], results[1]);
    k->extremes(rows, n_rows, reach, n, scratch, results[2], NULL);
    k->extremes(rows, n_rows, reach, n, scratch, NULL, results[3]);
    for (int x = 0; x < n; x++) {
        float least = 1, most = 0;
        for (int j = 0; j < n_rows; j++)
            for (int i = -reach; i <= reach; i++) {
                least = rf_min_float(least, rows[j][x + i]);
                most = rf_max_float(most, rows[j][x + i]);
            }
        CHECK(results[0][x] == least && results[2][x] == least);
        CHECK(results[1][x] == most && results[3][x] == most);
    }
}

static void extremes_are_those_of_all_around(void)
{
    for (int n = 1; n <= 48; n++) {
        check_extremes(5, 2, n);
        check_extremes(3, 1, n);
        check_extremes(7, 3, n);
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

/* They hold what the planes do, and it is told whether all of it is opaque. */
static void rows_become_surfaces(void)
{
    enum { N = 45 };
    const struct rf_kernels *k = rf_kernels_at(0);
    float plane[4][N], radius[N], luminance[N];
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
        for (int i = 0; i < N; i++) {
            float l = rf_luminance(plane[0][i], plane[1][i], plane[2][i]);
            CHECK(luminance[i] == l && s[i].r == radius[i]);
            for (int c = 0; c < 4; c++)
                CHECK(s[i].c[c] == plane[c][i]);
        }
        plane[3][odd < 0 ? 0 : odd] = 1;
    }
}

/* Quadruples become the surfaces that planes of the same pixels do. */
static void quadruples_are_planes(void)
{
    enum { N = 45 };
    const struct rf_kernels *k = rf_kernels_at(0);
    float rgba[4 * N], plane[4][N], radius[N], luminance[2][N];
    struct rf_surface s[2][N];
    for (int i = 0; i < 4 * N; i++)
        rgba[i] = plane[i % 4][i / 4] = i % 4 < 3 ? noise() : 1;
    for (int i = 0; i < N; i++)
        radius[i] = noise() - 0.5f;
    const float *planes[4] = {plane[0], plane[1], plane[2], plane[3]};
    k->load_row(planes, radius, N, s[0], luminance[0]);
    CHECK(k->load_rgba(rgba, radius, N, s[1], luminance[1]) == 0);
    CHECK(memcmp(s[0], s[1], sizeof s[0]) == 0);
    CHECK(memcmp(luminance[0], luminance[1], sizeof luminance[0]) == 0);
    const float odd[] = {0.5f, INFINITY, -INFINITY, NAN, -0.5f};
    for (int i = 0; i < 4 * N; i++)
        for (int j = 0; j < 5; j++) {
            float was = rgba[i];
            rgba[i] = odd[j];
            unsigned kind = i % 4 == 3 ? RF_ROW_FILM : 0;
            kind |= j > 0 && j < 4 ? RF_ROW_INFINITE : 0;
            kind |= i % 4 < 3 && odd[j] < 0 ? RF_ROW_NEGATIVE : 0;
            CHECK(k->load_rgba(rgba, radius, N, s[1], luminance[1]) == kind);
            rgba[i] = was;
        }
}

/* The searches clear their results themselves, so they are asked for more. */
static void searches_find_something(void)
{
    const struct vote_result *vote = (const void *)(first.at + 40000);
    const struct rf_hidden_window *window = (const void *)(first.at + 40000);
    prepare(&first, n_kernels - 1, 0);
    call_vote(rf_kernels_at(0), &first, 0);
    CHECK(vote->is_found && vote->n > 10 && vote->r > 4 && vote->r < 25);
    CHECK(vote->d2 > 0 && vote->d2 < 1000);
    prepare(&first, n_kernels - 1, 0);
    call_window(rf_kernels_at(0), &first, 0);
    CHECK(window->n > 10 && window->weight_sum > 0);
}

static bool has_same_votes(const struct rf_hidden_vote *a,
                           const struct rf_hidden_vote *b)
{
    size_t n = (size_t)a->n;
    return a->n == b->n && memcmp(a->room, b->room, n * sizeof *a->room) == 0 &&
           memcmp(a->weight, b->weight, n * sizeof *a->weight) == 0 &&
           memcmp(a->histogram, b->histogram, sizeof a->histogram) == 0;
}

/* The votes of a pixel counted in plain C: the radius of most, its distance. */
static void count_plainly(const struct rf_hidden_vote *vote, float s, float *r, int *d2)
{
    float best = 0, h[2 + RF_HIDDEN_BINS + 2] = {0};
    int bins[RF_HIDDEN_VOTES], winner = 0;
    for (int i = 0; i < vote->n; i++) {
        float room;
        memcpy(&room, &vote->room[i], sizeof room);
        bins[i] = 2 + (int)rf_min_float(2 * room, RF_HIDDEN_BINS - 1);
        h[bins[i]] += vote->weight[i];
    }
    for (int b = 2; b < 2 + RF_HIDDEN_BINS; b++) {
        float v = 0.5f * h[b - 1] + h[b] + 0.5f * h[b + 1];
        winner = v > best ? b : winner;
        best = rf_max_float(v, best);
    }
    *r = s + 0.5f * ((float)(winner - 2) + 0.5f);
    *d2 = INT32_MAX;
    for (int i = 0; i < vote->n; i++) {
        float at;
        memcpy(&at, &vote->d2[i], sizeof at);
        if (bins[i] - winner <= 2 && winner - bins[i] <= 2 && vote->weight[i] > 0)
            *d2 = rf_min_int(*d2, (int)at);
    }
}

/* Of candidates of one radius and of many. */
static void most_votes_win(void)
{
    static struct rf_hidden_vote vote;
    const struct rf_kernels *k = rf_kernels_at(0);
    for (int is_flat = 0; is_flat < 2; is_flat++) {
        int n_far = 0;
        prepare(&first, n_kernels - 1, 0);
        for (int i = 0; i < BACKS_W * BACKS_H; i++) { /* few stand out */
            float v = first.at[i];
            first.at[i] = v < 16 ? -INFINITY : is_flat ? 12.2f : v;
        }
        struct rf_backs backs = backs_of(&first);
        for (int i = 0; i < 120; i++) {
            struct rf_hidden_query query = {50 + i % 20, 26 + i / 20, 4, 1 / 400.0f,
                                            1 / 300.0f};
            struct rf_hidden_group group = group_of(&query, N_BLOCKS);
            float r, plain_r;
            int d2, plain_d2;
            if (!k->vote_blocks(&backs, &group, &query, &vote, &r, &d2))
                continue;
            count_plainly(&vote, query.s, &plain_r, &plain_d2);
            CHECK(r == plain_r && d2 == plain_d2);
            CHECK(vote.nearest <= d2);
            for (int b = 0; b < 2 + RF_HIDDEN_BINS; b++)
                CHECK(vote.histogram[b] == 0);
            n_far += d2 > vote.nearest;
        }
        CHECK((n_far > 0) == !is_flat);
    }
}

/* A group has a candidate wherever one of its pixels has, and not everywhere; what it
 * has learnt for one pixel loses no vote of another. */
static void groups_have_what_their_pixels_have(void)
{
    static struct rf_hidden_vote vote, alone;
    const struct rf_kernels *k = rf_kernels_at(0);
    int n_groups = 0, n_quads = 0, n_pixels = 0, d2, own_d2;
    float r, own_r;
    prepare(&first, n_kernels - 1, 0);
    for (int i = 0; i < BACKS_W * BACKS_H; i++) /* few stand out */
        first.at[i] -= i * 7 % 61 ? 12 : 0;
    struct rf_backs backs = backs_of(&first);
    for (int i = 0; i < 72; i++) {
        struct rf_hidden_query corner = group_query(i);
        struct rf_hidden_group group = group_of(&corner, N_BLOCKS);
        bool has_any = k->has_candidate(&backs, &group);
        bool has_one = false, quad_has_one[4] = {false};
        for (int p = 0; p < 16; p++) {
            struct rf_hidden_query query = corner;
            query.x += p % 4;
            query.y += p / 4;
            if (backs.r[query.y * BACKS_W + query.x] > query.s)
                continue; /* it would be one for itself */
            bool is_found = k->vote_blocks(&backs, &group, &query, &vote, &r, &d2);
            has_one |= is_found;
            quad_has_one[p / 8 * 2 + p % 4 / 2] |= is_found;
            struct rf_hidden_hit hits[N_BLOCKS];
            struct rf_hidden_group own = group;
            own.query = query; /* whose first pixel votes, in a group of its own */
            own.n_seen = own.n_hits = 0;
            own.hits = hits;
            CHECK(k->vote_blocks(&backs, &own, &query, &alone, &own_r, &own_d2) ==
                  is_found);
            CHECK(!is_found || (r == own_r && d2 == own_d2));
            CHECK(has_same_votes(&vote, &alone));
        }
        CHECK(has_any || !has_one);
        for (int q = 0; q < 4; q++) {
            struct rf_hidden_query quad = corner;
            quad.x += q % 2 * 2;
            quad.y += q / 2 * 2;
            bool may_have = k->quad_has_candidate(&backs, &group, &quad);
            CHECK(may_have || !quad_has_one[q]);
            n_quads += may_have;
        }
        /* Blocks from which on none has a candidate for its radius are not asked. */
        struct rf_hidden_block blocks[N_BLOCKS];
        memcpy(blocks, group.blocks, sizeof blocks);
        for (int b = 12; b < N_BLOCKS; b++)
            blocks[b].most = corner.s;
        struct rf_hidden_hit hits[N_BLOCKS];
        struct rf_hidden_group some = group_of(&corner, 12), all = some;
        all.n_blocks = N_BLOCKS;
        all.blocks = blocks;
        all.hits = hits;
        k->vote_blocks(&backs, &some, &corner, &vote, &r, &d2);
        k->vote_blocks(&backs, &all, &corner, &alone, &own_r, &own_d2);
        CHECK(has_same_votes(&vote, &alone));
        n_groups += has_any;
        n_pixels += has_one;
    }
    CHECK(n_groups < 60 && n_quads < 3 * n_groups && n_pixels > 10);
    printf("# %d groups of 72 and %d quads, %d of them with a pixel\n", n_groups,
           n_quads, n_pixels);
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
    rf_kernels_at(0)->divide(sum, coverage, 0, 1.5f, 5, out);
    for (int i = 0; i < 5; i++)
        CHECK(out[i] == want[i]);
    CHECK(out[5] == -7);
    rf_kernels_at(0)->divide(sum, coverage, -0.5f, 1.5f, 5, out);
    for (int i = 0; i < 5; i++)
        CHECK(out[i] == (i == 2 ? -0.5f : want[i]));
    rf_kernels_at(0)->divide(sum, coverage, -2, 1.5f, 5, out);
    CHECK(out[2] == -1);
}

/* Quotients of quadruples are those of planes; what is opaque has no sum of alpha. */
static void quotients_of_quadruples(void)
{
    enum { MOST = 20 };
    const struct rf_kernels *k = rf_kernels_at(0);
    static const float least[3] = {0, -0.25f, -INFINITY};
    float plane[4][MOST], coverage[MOST], quotient[4][MOST], rgba[4 * MOST + 1];
    for (int i = 0; i < MOST; i++) {
        for (int p = 0; p < 4; p++)
            plane[p][i] = 2 * noise() - 0.5f;
        coverage[i] = i % 5 ? noise() : 1e-7f;
    }
    for (int n = 1; n <= MOST; n++)
        for (int is_opaque = 0; is_opaque < 2; is_opaque++) {
            const float *sum[4] = {plane[0], plane[1], plane[2],
                                   is_opaque ? NULL : plane[3]};
            for (int p = 0; p < 4; p++)
                k->divide(plane[p], coverage, p == 3 ? 0 : least[p],
                          p == 3 ? 1 : INFINITY, n, quotient[p]);
            rgba[4 * n] = -7;
            k->divide_rgba(sum, coverage, least, n, rgba);
            for (int i = 0; i < 4 * n; i++)
                CHECK(rgba[i] == (i % 4 == 3 && is_opaque ? (float)(i / 4 % 5 != 0)
                                                          : quotient[i % 4][i / 4]));
            CHECK(rgba[4 * n] == -7);
        }
}

/* One pixel stands out, in a block or beside it. */
static void blocks_are_rough_where_radii_step(void)
{
    enum { SIDE = 20, STRIDE = SIDE + 8 };
    static float r[STRIDE * SIDE];
    struct rf_backs backs = {.width = SIDE, .height = SIDE, .stride = STRIDE, .r = r};
    for (int step = 0; step < SIDE * SIDE; step++) {
        int step_x = step % SIDE, step_y = step / SIDE;
        for (int i = 0; i < STRIDE * SIDE; i++)
            r[i] = i % STRIDE < SIDE ? 3 : -INFINITY;
        for (int is_unreliable = 0; is_unreliable < 2; is_unreliable++) {
            r[step_y * STRIDE + step_x] = is_unreliable ? -INFINITY : 4;
            for (int block = 0; block < 9; block++) {
                int dx = step_x - block % 3 * 8, dy = step_y - block / 3 * 8;
                bool is_in = dx >= 0 && dx < 8 && dy >= 0 && dy < 8;
                bool is_beside = ((dx == 8 || dx == -1) && dy >= 0 && dy < 8) ||
                                 ((dy == 8 || dy == -1) && dx >= 0 && dx < 8);
                float highest, lowest;
                bool is_rough = rf_kernels_at(0)->measure_block(
                    &backs, block % 3, block / 3, 0.5f, 0.5f, &highest, &lowest);
                CHECK(is_rough == (is_in || is_beside));
                CHECK(highest == (is_in && !is_unreliable ? 4 : 3) && lowest == 3);
            }
        }
    }
}

/* A pixel half as far from the focus as the light casts a square twice as large. */
static void a_pixel_casts_a_square(void)
{
    const struct rf_kernels *k = rf_kernels_at(0);
    prepare(&first, 0, 0);
    struct rf_shadows s = shadows_of(&first, 0);
    const float scale = 3; /* of a disc of 30 px: 10 lie between light and pixel */
    s.disc_r = 30;
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
    CHECK_NEAR(sum, scale * scale * 0.5f, 1e-5);
    /* The middle of the pixel, seen from the light, and so of the square. */
    CHECK_NEAR(sum_x / sum + 0.5, (-2 + 0.5 - 0.25) * (double)scale + 0.25, 1e-4);
    CHECK_NEAR(sum_y / sum + 0.5, (-1 + 0.5 - 0.75) * (double)scale + 0.75, 1e-4);
    s.blocked = NULL;
    CHECK(k->cast_shadows(&s, radius, share, 29, 38, 39));
    CHECK(!k->cast_shadows(&s, radius, share, 29, 10, 11)); /* out of the cone */
}

/* Pixels of one surface, which are drawn together, cast what they cast one by one. */
static void a_run_casts_what_its_pixels_do(void)
{
    enum { N = SHADOWS_W * SHADOWS_H };
    const struct rf_kernels *k = rf_kernels_at(0);
    static float whole[N];
    for (int variant = 0; variant < 12; variant++) {
        prepare(&first, 0, 0);
        struct rf_shadows s = shadows_of(&first, variant % 3);
        float share[64], radius[64];
        s.light_r = variant < 6 ? 20 : -5; /* behind the focus, before it */
        s.disc_r = s.light_r;
        s.extent_x = s.extent_y = 4;
        s.row = 64;
        for (int x = 0; x < 64; x++) {
            share[x] = x < 50 ? 0.75f : 0.5f;
            radius[x] = s.light_r - (x < 40 ? 12 : x < 44 ? 9 : 11);
        }
        memset(s.blocked, 0, N * sizeof(float));
        CHECK(k->cast_shadows(&s, radius, share, 33, 35, 56));
        memcpy(whole, s.blocked, sizeof whole);
        memset(s.blocked, 0, N * sizeof(float));
        float sum = 0;
        s.blocked[N] = 7;
        for (int x = 35; x < 56; x++)
            CHECK(k->cast_shadows(&s, radius, share, 33, x, x + 1));
        for (int i = 0; i < N; i++) {
            CHECK_NEAR(whole[i], s.blocked[i], 1e-5);
            sum += whole[i];
        }
        CHECK(sum > 1);
        CHECK(s.blocked[N] == 7);
    }
}

#ifndef _WIN32
/* Of pixels that are drawn together no share is read beyond the last one. */
static void a_run_reads_its_own_shares(void)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE,
                       MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    REQUIRE(pages != MAP_FAILED);
    REQUIRE(mprotect(pages + page, page, PROT_NONE) == 0);
    float *share = (float *)(pages + page) - 48, radius[64];
    const struct rf_kernels *level;
    for (int i = 0; (level = rf_kernels_at(i)); i++) {
        prepare(&first, 0, 0);
        struct rf_shadows s = shadows_of(&first, 0);
        s.row = 64;
        s.light_r = s.disc_r = 20;
        s.extent_x = s.extent_y = 4;
        for (int x = 0; x < 64; x++)
            radius[x] = 8;
        for (int x = 0; x < 48; x++)
            share[x] = 0.75f;
        memset(s.blocked, 0, SHADOWS_W * SHADOWS_H * sizeof(float));
        CHECK(level->cast_shadows(&s, radius, share, 33, 40, 48));
    }
    munmap(pages, 2 * page);
}
#endif

/* What is found at each place, by the rule for one. */
static void places_are_looked_for(void)
{
    const struct rf_kernels *k = rf_kernels_at(0);
    int n_rendered = 0, n_clear = 0;
    for (int variant = 0; variant < 4; variant++) {
        seed = 7;
        for (int i = 0; i < WORK_FLOATS; i++)
            first.at[i] = noise();
        for (int i = 0; i < SIGHT_W * SIGHT_H; i++)
            first.at[i] = i % 11 ? 3 * first.at[i] : INFINITY;
        struct rf_sight s = sight_of(&first);
        struct rf_sight_places p = places_of(&first, variant);
        struct rf_sight_found found, pixels;
        k->look_for_parts(&s, &p, RF_SIGHT_PARTS, 0.5f, &found);
        k->find_pixels(&s, &p, RF_SIGHT_PARTS, &pixels);
        CHECK(pixels.rendered == found.rendered && !pixels.clear);
        CHECK(memcmp(pixels.x, found.x, sizeof found.x) == 0);
        CHECK(memcmp(pixels.y, found.y, sizeof found.y) == 0);
        for (int i = 0; i < RF_SIGHT_PARTS; i++) {
            float shift = s.shift_scale * p.r[i] + s.shift_bias;
            float x = floorf(p.x[i] + rf_snap_px(s.lens[0] * shift));
            float y = floorf(p.y[i] - rf_snap_px(s.lens[1] * shift));
            bool is_rendered = x >= (float)s.x0 && x < (float)s.x1 &&
                               y >= (float)s.y0 && y < (float)s.y1;
            float near = is_rendered ? s.radius[(int)y * SIGHT_W + (int)x] : INFINITY;
            bool is_clear = near < INFINITY && near >= p.r[i] - 0.5f;
            CHECK((found.rendered >> i & 1) == is_rendered);
            CHECK((found.clear >> i & 1) == is_clear);
            CHECK(!is_rendered || (found.x[i] == (int)x && found.y[i] == (int)y));
            n_rendered += is_rendered;
            n_clear += is_clear;
        }
    }
    CHECK(n_clear > 0 && n_rendered > n_clear && n_rendered < 4 * RF_SIGHT_PARTS);
}

/* A plane is found, and a bump on it is how rough it is. */
static void slanted_radii_are_a_plane(void)
{
    const struct rf_kernels *k = rf_kernels_at(0);
    float low[64], high[64];
    struct rf_sight_plane plane;
    for (int i = 0; i < 64; i++)
        low[i] = high[i] = 3 + 0.25f * (float)(i % 8) - 0.5f * (float)(i / 8);
    high[20] += 0.75f;
    k->fit_plane(low, high, 8, 0.05f, &plane);
    CHECK(plane.lowest == -0.5f && plane.highest == 4.75f);
    CHECK_NEAR(plane.level, 2.125, 1e-5);
    CHECK_NEAR(plane.slope[0], 0.25, 1e-5);
    CHECK_NEAR(plane.slope[1], -0.5, 1e-5);
    CHECK_NEAR(plane.rough, 0.75, 1e-5);
    k->fit_plane(low, high, 8, 10, &plane);
    CHECK(plane.slope[0] == 0 && plane.rough == 5.25f && plane.level == 2.125f);
}

static void levels_are_found_by_name(void)
{
    const struct rf_kernels *level;
    for (int i = 0; (level = rf_kernels_at(i)); i++)
        CHECK(rf_kernels_find(level->name) == level);
    CHECK(rf_kernels_find("no such level") == NULL);
    CHECK(rf_kernels_find(NULL) != NULL);
}

/* ---- the benchmark -------------------------------------------------------------- */

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
        for (int k = 0; k < n_kernels; k++)
            if (argc < 3 || strcmp(argv[2], kernels[k].name) == 0)
                bench_kernel(k);
        return 0;
    }
    testing_begin(argc, argv);
    TEST(every_level_gives_the_same_bits);
    TEST(every_kernel_writes);
    TEST(bits_tell_what_pixels_are);
    TEST(extremes_are_those_of_all_around);
    TEST(mixed_pixels_are_flagged);
    TEST(rows_become_surfaces);
    TEST(quadruples_are_planes);
    TEST(searches_find_something);
    TEST(most_votes_win);
    TEST(groups_have_what_their_pixels_have);
    TEST(gaps_and_sides_are_those_of_the_radii);
    TEST(a_pixel_casts_a_square);
    TEST(a_run_casts_what_its_pixels_do);
#ifndef _WIN32
    TEST(a_run_reads_its_own_shares);
#endif
    TEST(quotients_are_limited);
    TEST(quotients_of_quadruples);
    TEST(blocks_are_rough_where_radii_step);
    TEST(places_are_looked_for);
    TEST(slanted_radii_are_a_plane);
    TEST(levels_are_found_by_name);
    return testing_end();
}
