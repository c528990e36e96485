/* SPDX-License-Identifier: Apache-2.0 */
/* Depth that renderers averaged or multiplied by alpha: found, said and undone. */
#include <math.h>
#include <stdlib.h>

#include "rackfocus/rackfocus.h"
#include "testing.h"

enum { WIDTH = 64, HEIGHT = 32, N = WIDTH * HEIGHT };

static float depth[N], truth[N], alpha[N];

static struct rf_depth_channel channel_of(const float *alphas)
{
    return (struct rf_depth_channel){depth, alphas, 1, WIDTH, HEIGHT, 1e9};
}

/* A surface at 2 before one at 10, and a pixel between them that is the mean. */
static void make_averaged(void)
{
    for (int i = 0; i < N; i++) {
        int x = i % WIDTH;
        truth[i] = x < 20 ? 2 : 10;
        depth[i] = x == 20 ? 5 : truth[i];
    }
    for (int y = 0; y < HEIGHT; y++)
        truth[y * WIDTH + 20] = 2; /* 5 is nearer to it */
}

static void averages_are_found_and_undone(void)
{
    struct rf_depth_channel channel = channel_of(NULL);
    struct rf_depth_stats stats = {.size = sizeof stats};
    make_averaged();
    REQUIRE(rf_depth_measure(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(stats.is_mixed && !stats.is_premultiplied);
    CHECK(stats.kind == RF_DEPTH_PLANAR && stats.kind_reason);
    CHECK(stats.n_pixels == N && stats.min == 2 && stats.max == 10);
    CHECK(stats.n_snapped == 0);
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(stats.n_snapped == HEIGHT && stats.n_divided == 0);
    CHECK(memcmp(depth, truth, sizeof depth) == 0);
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(!stats.is_mixed && stats.n_snapped == 0);
}

static void depth_times_alpha_is_divided_by_it(void)
{
    struct rf_depth_channel channel = channel_of(alpha);
    struct rf_depth_stats stats = {.size = sizeof stats};
    for (int i = 0; i < N; i++) {
        alpha[i] = i % WIDTH == 30 ? 0.4f : i % WIDTH > 30 ? 0 : 1;
        truth[i] = alpha[i] > 0 ? 4 : 0;
        depth[i] = 4 * alpha[i];
    }
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(stats.is_premultiplied && stats.n_divided > 0);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(depth[i], truth[i], 1e-6);
}

/* In strips of any height the same is measured, but for steps across their borders,
 * along which none is looked for. */
static void strips_add_up(void)
{
    struct rf_depth_channel channel = channel_of(NULL);
    struct rf_depth_stats whole = {.size = sizeof whole}, sum = {.size = sizeof sum};
    struct rf_depth_tally *tally;
    make_averaged();
    depth[5] = NAN;
    depth[7] = INFINITY;
    depth[9] = -1;
    REQUIRE(rf_depth_measure(NULL, &channel, &whole, NULL) == RF_OK);
    REQUIRE(rf_depth_tally_create(&tally, NULL, &channel, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y += 5) {
        struct rf_depth_channel strip = channel;
        strip.depth += y * WIDTH;
        strip.height = HEIGHT - y < 5 ? HEIGHT - y : 5;
        rf_depth_tally_add(tally, &strip);
    }
    rf_depth_tally_finish(tally, &sum);
    CHECK(whole.n_nan == 1 && whole.n_no_hit == 1 && whole.n_negative == 1);
    CHECK(whole.n_pixels == sum.n_pixels && sum.n_nan == 1 && sum.n_no_hit == 1);
    CHECK(whole.median == sum.median && whole.mixed_share == sum.mixed_share);
    CHECK(whole.min == sum.min && whole.max == sum.max && whole.kind == sum.kind);
}

static void mist_becomes_linear(void)
{
    float t[3] = {0.25f, 0.25f, 0.25f};
    rf_depth_undo_mist(&t[0], 1, RF_MIST_LINEAR);
    rf_depth_undo_mist(&t[1], 1, RF_MIST_QUADRATIC);
    rf_depth_undo_mist(&t[2], 1, RF_MIST_INVERSE);
    CHECK(t[0] == 0.25f && t[1] == 0.5f && t[2] == 0.0625f);
}

static void wrong_arguments_are_errors(void)
{
    struct rf_depth_channel channel = channel_of(NULL), none = {.width = 0};
    struct rf_depth_stats stats = {.size = 0};
    struct rf_depth_tally *tally;
    struct rf_error error;
    CHECK(rf_depth_measure(NULL, &channel, &stats, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_measure(NULL, NULL, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_repair(NULL, &channel, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_snap(NULL, &channel, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_tally_create(&tally, NULL, &none, &error) == RF_ERROR_ARGUMENT);
}

static void memory_comes_from_the_context(void)
{
    struct rf_context *context;
    struct rf_depth_channel channel = channel_of(NULL);
    struct rf_depth_stats stats = {.size = sizeof stats};
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    make_averaged();
    CHECK(rf_depth_repair(context, &channel, &stats, NULL) == RF_OK);
    CHECK(memcmp(depth, truth, sizeof depth) == 0);
    rf_context_destroy(context);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(averages_are_found_and_undone);
    TEST(depth_times_alpha_is_divided_by_it);
    TEST(strips_add_up);
    TEST(mist_becomes_linear);
    TEST(wrong_arguments_are_errors);
    TEST(memory_comes_from_the_context);
    return testing_end();
}
