/* SPDX-License-Identifier: Apache-2.0 */
/* Pixels that ask together learn what each of them learns alone. */
#include "surfaces/insides.h"

#include <math.h>
#include <stdint.h>

#include "base/math.h"
#include "kernels/hidden_kernels.h"
#include "surfaces/hidden_blocks.h"
#include "testing.h"

enum { BLOCK = RF_HIDDEN_BLOCK, WIDTH = 93, HEIGHT = 77, STRIDE = WIDTH + BLOCK };
enum { N_X = (WIDTH + BLOCK - 1) / BLOCK, N_Y = (HEIGHT + BLOCK - 1) / BLOCK };

static float radius[STRIDE * HEIGHT];
static struct rf_hidden_facts blocks[N_X * N_Y];
static struct rf_inside_edges edges[N_X * N_Y];

static float radius_at(int x, int y)
{
    return radius[STRIDE * y + x];
}

/* A rough slope from 9 px before the focus to 2 px, and a wall behind, to its right and in a corner. */
static void draw(void)
{
    uint32_t seed = 1;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < STRIDE; x++) {
            seed = seed * 1664525 + 1013904223;
            const float rough = (float)(seed >> 8) / (1 << 24);
            const bool is_wall = x > WIDTH - 12 - y / 8 || x + 2 * y < 50;
            radius[STRIDE * y + x] =
                is_wall ? 6 : -9 + 7.0f * (float)y / HEIGHT - 0.3f * rough;
        }
}

static bool is_edge(int x, int y)
{
    for (int k = 0; k < 4; k++) {
        const int to_x = x + (const int[]){-1, 1, 0, 0}[k];
        const int to_y = y + (const int[]){0, 0, -1, 1}[k];
        if (to_x >= 0 && to_x < WIDTH && to_y >= 0 && to_y < HEIGHT &&
            fabsf(radius_at(to_x, to_y) - radius_at(x, y)) > 0.7f)
            return true;
    }
    return false;
}

static void measure(void)
{
    for (int i = 0; i < N_X * N_Y; i++) {
        blocks[i] = (struct rf_hidden_facts){.highest = -INFINITY, .lowest = INFINITY};
        edges[i] = (struct rf_inside_edges){0, INFINITY};
    }
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const int at = y / BLOCK * N_X + x / BLOCK;
            const float r = radius_at(x, y);
            blocks[at].lowest = rf_min_float(r, blocks[at].lowest);
            blocks[at].highest = rf_max_float(r, blocks[at].highest);
            if (!is_edge(x, y))
                continue;
            edges[at].bits |= (uint64_t)1 << (y % BLOCK * BLOCK + x % BLOCK);
            edges[at].lowest = rf_min_float(r, edges[at].lowest);
        }
}

static uint64_t before(int bx, int by, float r)
{
    uint64_t bits = 0;
    for (int i = 0; i < BLOCK * BLOCK; i++) {
        const int x = bx * BLOCK + i % BLOCK, y = by * BLOCK + i / BLOCK;
        if (x < WIDTH && y < HEIGHT && radius_at(x, y) < rf_min_float(r, 0))
            bits |= (uint64_t)1 << i;
    }
    return bits;
}

/* What each pixel of a block learns that asks alone, without a hint. */
static uint64_t met_alone(const struct rf_insides *s, int bx, int by, uint64_t bits,
                          float r)
{
    uint64_t met = 0;
    for (; bits; bits &= bits - 1) {
        struct rf_inside_hint none = {0};
        met |= rf_inside_find_met(s, 0, bx, by, bits & -bits, r, &none);
    }
    return met;
}

/* No hint, wherever it is, says of a pixel that is met that it is not. */
static void check_hints(const struct rf_insides *s, int bx, int by, float r,
                        uint64_t asking, uint64_t met)
{
    enum { AWAY = 13 };
    for (int i = 0; i < 4 * AWAY * AWAY; i += 3) {
        struct rf_inside_hint hint = {bx * BLOCK + BLOCK / 2 + i % (2 * AWAY) - AWAY,
                                      by * BLOCK + BLOCK / 2 + i / (2 * AWAY) - AWAY,
                                      true};
        if (hint.x >= 0 && hint.x < WIDTH && hint.y >= 0 && hint.y < HEIGHT)
            CHECK((met & ~rf_inside_drop_hinted(s, 0, bx, by, asking, r, &hint)) == 0);
    }
}

static void check_block(const struct rf_insides *s, int bx, int by, float r,
                        struct rf_inside_hint *hint, int n_found[2])
{
    const uint64_t asking = before(bx, by, r);
    const uint64_t alone = met_alone(s, bx, by, asking, r);
    const uint64_t left = rf_inside_drop_hinted(s, 0, bx, by, asking, r, hint);
    struct rf_inside_hint none = {0};
    CHECK(rf_inside_find_met(s, 0, bx, by, asking, r, &none) == alone);
    if (alone)
        check_hints(s, bx, by, r, asking, alone);
    CHECK((alone & ~rf_inside_may_be_met(s, 0, bx, by, r)) == 0);
    CHECK(rf_inside_find_met(s, 0, bx, by, left, r, hint) == alone);
    for (int i = 0; i < BLOCK * BLOCK; i++)
        if (asking >> i & 1)
            n_found[alone >> i & 1]++;
}

static void check_lens(const struct rf_reach *reach, int border)
{
    const struct rf_insides s = {.blocks = blocks,
                                 .edges = edges,
                                 .n_x = N_X,
                                 .n_y = N_Y,
                                 .extent = INFINITY,
                                 .reach = *reach,
                                 .radius = radius,
                                 .stride = STRIDE,
                                 .width = WIDTH,
                                 .height = HEIGHT,
                                 .border = border};
    for (float r = -6; r <= 2; r += 2) {
        struct rf_inside_hint hint = {0};
        int n_found[2] = {0, 0};
        for (int by = 0; by < N_Y; by++)
            for (int bx = 0; bx < N_X; bx++)
                check_block(&s, bx, by, r, &hint, n_found);
        CHECK(n_found[0] > 100 && n_found[1] > 100);
    }
}

static void a_block_learns_what_its_pixels_do(void)
{
    static const struct rf_reach disc = {
        1, {-1, -1, -1.42f, -1.42f}, {1, 1, 1.42f, 1.42f}};
    /* A cell from a point at its rim, and from one beside it. */
    static const struct rf_reach cell = {
        0.9f, {0, -0.3f, -0.3f, -0.2f}, {0.8f, 0.4f, 1.1f, 0.9f}};
    static const struct rf_reach beside = {
        0.9f, {0.1f, -0.3f, 0, -0.2f}, {0.8f, 0.4f, 1.1f, 0.9f}};
    draw();
    measure();
    check_lens(&disc, 0);
    check_lens(&disc, 3);
    check_lens(&cell, 5);
    check_lens(&beside, 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_block_learns_what_its_pixels_do);
    return testing_end();
}
