/* SPDX-License-Identifier: Apache-2.0 */
/* Slopes of the radius, rounded to slants. */
#include "compose/slants.h"
#include "kernels/data.h"
#include "kernels/kernels.h"
#include "testing.h"

enum { WIDTH = 96, HEIGHT = 5 };

static float radius[HEIGHT][WIDTH + 16];
static int16_t slants[WIDTH + 8];

/* Finds the slants of the middle row; is there any? */
static bool find(float least)
{
    const float *rows[HEIGHT];
    for (int y = 0; y < HEIGHT; y++)
        rows[y] = radius[y] + 8;
    return rf_kernels_at(0)->find_slants(rows, least, WIDTH, slants);
}

static void fill(float right, float down)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH + 16; x++)
            radius[y][x] = 3 + right * (float)x + down * (float)y;
}

static void every_slant_is_that_of_its_slope(void)
{
    for (int slant = -RF_MOST_SLANT; slant <= RF_MOST_SLANT; slant++) {
        float slope[2];
        rf_slant_slope(slant, slope);
        CHECK(rf_slant_of(slope) == slant);
        CHECK(fabsf(slope[0]) <= 1.01f && fabsf(slope[1]) <= 1.01f);
        CHECK((slant == 0) == (slope[0] == 0 && slope[1] == 0));
    }
}

static void a_plane_has_one_slant(void)
{
    static const float slopes[][2] = {
        {0.1f, 0}, {0, -0.3f}, {0.5f, 0.2f}, {-0.05f, 0.9f}};
    for (int i = 0; i < 4; i++) {
        fill(slopes[i][0], slopes[i][1]);
        CHECK(find(0.02f));
        for (int x = 0; x < WIDTH; x++)
            CHECK(slants[x] == rf_slant_of(slopes[i]));
    }
}

static void what_is_nearly_flat_or_too_steep_has_none(void)
{
    fill(0.019f, 0.01f);
    CHECK(!find(0.02f));
    fill(1.2f, 0);
    CHECK(!find(0.02f));
}

/* To both sides of an edge slopes are those of each surface, up to the edge. */
static void an_edge_ends_no_slope(void)
{
    enum { EDGE = 40 };
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH + 16; x++)
            radius[y][x] = x < EDGE + 8 ? 50 - 0.3f * (float)x : 2 + 0.2f * (float)x;
    CHECK(find(0.02f));
    for (int x = 0; x < WIDTH; x++)
        CHECK(slants[x] == rf_slant_of((float[]){x < EDGE ? -0.3f : 0.2f, 0}));
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_slant_is_that_of_its_slope);
    TEST(a_plane_has_one_slant);
    TEST(what_is_nearly_flat_or_too_steep_has_none);
    TEST(an_edge_ends_no_slope);
    return testing_end();
}
