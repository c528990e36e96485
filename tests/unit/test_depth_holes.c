/* SPDX-License-Identifier: Apache-2.0 */
/* Depth that fog made holes in: found, told from gaps before a sky, filled. */
#include <math.h>
#include <stdlib.h>

#include "rackfocus/rackfocus.h"
#include "testing.h"

enum { WIDTH = 256, HEIGHT = 160, N = WIDTH * HEIGHT };

static const float SKY = 1e10f;

static float depth[N], truth[N], colour[3 * N];

static struct rf_depth_channel channel_of(void)
{
    return (struct rf_depth_channel){depth, rf_image_packed(colour, WIDTH, HEIGHT, 3),
                                     WIDTH, HEIGHT, 1e9};
}

static float chance(void)
{
    static uint32_t state = 1;
    state = state * 1664525u + 1013904223u;
    return (float)(state >> 8) / (float)(1 << 24);
}

static void paint(int i, float z, float light)
{
    truth[i] = depth[i] = z;
    for (int c = 0; c < 3; c++)
        colour[3 * i + c] = light * (0.6f + 0.2f * (float)c) + 0.02f * chance();
}

/* A floor that recedes, a box before it, sky above. */
static void make_scene(void)
{
    for (int i = 0; i < N; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const bool is_box = x > 60 && x < 160 && y > 30 && y < 120;
        if (is_box)
            paint(i, 3, 0.7f);
        else if (y >= 60)
            paint(i, 400 / (float)(y - 40), 0.2f);
        else
            paint(i, SKY, 1);
    }
}

/* Holes in a share of surfaces that grows with their distance, as fog has it. */
static void add_fog(float density)
{
    for (int i = 0; i < N; i++)
        if (truth[i] < SKY && chance() > expf(-density * truth[i]))
            depth[i] = SKY;
}

static struct rf_depth_stats measured(void)
{
    const struct rf_depth_channel channel = channel_of();
    struct rf_depth_stats stats = {.size = sizeof stats};
    CHECK(rf_depth_measure(NULL, &channel, &stats, NULL) == RF_OK);
    return stats;
}

static void fog_is_found_and_filled(void)
{
    struct rf_depth_channel channel = channel_of();
    for (float density = 0.01f; density < 0.2f; density *= 3) {
        struct rf_depth_stats stats = {.size = sizeof stats};
        size_t n_holes = 0, n_right = 0, n_sky = 0, n_wrong_sky = 0;
        make_scene();
        add_fog(density);
        for (int i = 0; i < N; i++)
            n_holes += depth[i] != truth[i];
        REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
        CHECK(stats.is_speckled && stats.hole_share > 0.02);
        for (int i = 0; i < N; i++) {
            n_right += truth[i] < SKY && fabsf(depth[i] - truth[i]) < 0.05f * truth[i];
            n_sky += truth[i] == SKY;
            n_wrong_sky += truth[i] == SKY && depth[i] != SKY;
        }
        CHECK(stats.n_filled <= n_holes + n_wrong_sky &&
              stats.n_filled >= n_holes * 98 / 100);
        CHECK(n_right >= (N - n_sky) * 99 / 100);
        CHECK(n_wrong_sky * 1000 < n_sky);
        /* What is mended is not mended again. */
        REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
        CHECK(!stats.is_speckled && stats.n_filled == 0);
    }
}

/* Is the picture left as it is? */
static bool stays(void)
{
    struct rf_depth_channel channel = channel_of();
    struct rf_depth_stats stats = {.size = sizeof stats};
    CHECK(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    return !stats.is_speckled && stats.n_filled == 0;
}

static void gaps_before_a_sky_stay(void)
{
    make_scene();
    CHECK(stays() && measured().n_holes == 0);
    for (int i = 0; i < N; i++) /* wires */
        paint(i, i % WIDTH % 7 == 3 ? 4 : SKY, i % WIDTH % 7 == 3 ? 0.1f : 1);
    CHECK(stays());
    for (int i = 0; i < N; i++) { /* slats: gaps of a pixel */
        const bool is_gap = i % WIDTH % 9 == 5;
        paint(i, is_gap ? SKY : 4, is_gap ? 1 : 0.1f);
    }
    CHECK(stays() && measured().n_holes > 1000);
    for (int i = 0; i < N; i++) { /* a plate with holes of a pixel */
        const bool is_gap = i % WIDTH % 6 == 3 && i / WIDTH % 6 == 3;
        paint(i, is_gap ? SKY : 4, is_gap ? 1 : 0.1f);
    }
    CHECK(stays() && measured().n_holes > 500);
}

static void paint_leaf(float x0, float y0, float radius, float z)
{
    const int left = (int)fmaxf(x0 - radius, 0), top = (int)fmaxf(y0 - radius, 0);
    const int right = (int)fminf(x0 + radius, WIDTH - 1);
    const int bottom = (int)fminf(y0 + radius, HEIGHT - 1);
    for (int y = top; y <= bottom; y++)
        for (int x = left; x <= right; x++) {
            const float dx = (float)x - x0, dy = (float)y - y0;
            if (dx * dx + dy * dy < radius * radius)
                paint(y * WIDTH + x, z, 0.1f);
        }
}

static void leaves_before_a_sky_stay(void)
{
    for (float radius = 1; radius < 6; radius *= 1.5f) {
        for (int i = 0; i < N; i++)
            paint(i, SKY, 1);
        const int n_leaves = (int)(N / (2 * radius * radius));
        for (int k = 0; k < n_leaves; k++) {
            const float x0 = chance() * WIDTH, y0 = chance() * HEIGHT;
            paint_leaf(x0, y0, radius, 5 + 0.3f * chance());
        }
        CHECK(stays());
    }
}

/* One object of a few squares in fog's likeness is no fog: the picture's other surfaces
 * have no holes. */
static void a_part_of_the_picture_is_no_fog(void)
{
    make_scene();
    for (int i = 0; i < N; i++)
        if (i % WIDTH < 60 && i / WIDTH > 130 && chance() < 0.5f)
            depth[i] = SKY;
    CHECK(measured().n_holes > 100 && stays());
    make_scene();
    add_fog(0.05f);
    CHECK(measured().is_speckled);
    struct rf_depth_channel without = channel_of();
    struct rf_depth_stats stats = {.size = sizeof stats};
    without.colour.data = NULL; /* what cannot be told from the sky */
    REQUIRE(rf_depth_measure(NULL, &without, &stats, NULL) == RF_OK);
    CHECK(!stats.is_speckled && stats.n_holes > 100);
}

/* The verdict does not depend on strips, a window with its margin has the whole's bits. */
static void strips_and_windows_agree(void)
{
    static float whole[N], part[N];
    const int x0 = 70, y0 = 40, columns = 90, rows = 70, m = RF_DEPTH_FILL_REACH;
    struct rf_depth_channel channel = channel_of();
    struct rf_depth_tally *tally;
    struct rf_depth_stats sum = {.size = sizeof sum};
    size_t n_whole = 0, n_part = 0;
    make_scene();
    add_fog(0.05f);
    const struct rf_depth_stats stats = measured();
    REQUIRE(rf_depth_tally_create(&tally, NULL, &channel, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y += 13) {
        struct rf_depth_channel strip = channel;
        strip.depth += y * WIDTH;
        strip.colour.data = colour + 3 * y * WIDTH;
        strip.height = HEIGHT - y < 13 ? HEIGHT - y : 13;
        rf_depth_tally_add(tally, &strip);
    }
    rf_depth_tally_finish(tally, &sum);
    CHECK(stats.is_speckled && sum.is_speckled && stats.n_holes == sum.n_holes);
    CHECK(stats.hole_share == sum.hole_share);

    const int w = columns + 2 * m, h = rows + 2 * m;
    for (int i = 0; i < w * h; i++)
        part[i] = depth[(y0 - m + i / w) * WIDTH + x0 - m + i % w];
    struct rf_depth_channel window = {part, channel.colour, w, h, 1e9};
    window.colour.data = colour + 3 * ((y0 - m) * WIDTH + x0 - m);
    window.colour.width = w;
    window.colour.height = h;
    REQUIRE(rf_depth_fill(NULL, &window, &n_part, NULL) == RF_OK && n_part > 0);
    REQUIRE(rf_depth_fill(NULL, &channel, &n_whole, NULL) == RF_OK);
    memcpy(whole, depth, sizeof whole);
    for (int y = 0; y < rows; y++)
        CHECK(memcmp(part + (y + m) * w + m, whole + (y0 + y) * WIDTH + x0,
                     columns * sizeof(float)) == 0);
}

static void what_is_no_depth_stays(void)
{
    struct rf_depth_channel channel = channel_of();
    size_t n_changed = 0, n_sky = 0;
    make_scene();
    depth[100 * WIDTH + 20] = NAN;
    depth[100 * WIDTH + 30] = -1;
    depth[100 * WIDTH + 40] = 0; /* nothing hit, in some renderers */
    REQUIRE(rf_depth_fill(NULL, &channel, &n_changed, NULL) == RF_OK);
    CHECK(isnan(depth[100 * WIDTH + 20]) && depth[100 * WIDTH + 30] == -1);
    CHECK(fabsf(depth[100 * WIDTH + 40] - truth[100 * WIDTH + 40]) < 0.1f);
    for (int i = 0; i < N; i++) /* but for corners of the sky */
        n_sky += truth[i] == SKY && depth[i] != SKY;
    CHECK(n_changed == 1 + n_sky && n_sky < 20);
    CHECK(rf_depth_fill(NULL, &channel, NULL, NULL) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_fill(NULL, NULL, &n_changed, NULL) == RF_ERROR_ARGUMENT);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(fog_is_found_and_filled);
    TEST(gaps_before_a_sky_stay);
    TEST(leaves_before_a_sky_stay);
    TEST(a_part_of_the_picture_is_no_fog);
    TEST(strips_and_windows_agree);
    TEST(what_is_no_depth_stays);
    return testing_end();
}
