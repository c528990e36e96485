/* SPDX-License-Identifier: Apache-2.0 */
/* Depth that renderers averaged or multiplied by alpha: found, said and undone. */
#include <math.h>
#include <stdlib.h>

#include "rackfocus/rackfocus.h"
#include "testing.h"

enum { WIDTH = 64, HEIGHT = 32, N = WIDTH * HEIGHT };

static float depth[N], truth[N], colour[4 * N];

/* `channels` of the colours, 0: they are not known. */
static struct rf_depth_channel channel_of(int channels)
{
    return (struct rf_depth_channel){
        depth, rf_image_packed(channels ? colour : NULL, WIDTH, HEIGHT, channels),
        WIDTH, HEIGHT, 1e9};
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
    struct rf_depth_channel channel = channel_of(0);
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

/* Depths of a row with a gap of nothing in it, averaged over a Gaussian as Mitsuba does: no
 * pixel of the gap is 0. What is left lies on one side or is 0. */
static void gaps_of_nothing_are_no_near_things(void)
{
    static const float row[] = {10,    9.98f, 8.67f, 4.06f, 0.31f,
                                0.27f, 3.65f, 6.1f,  6.8f};
    static const float wire[] = {10, 10, 9, 4, 1.2f, 1.2f, 4, 6.5f, 6.8f};
    struct rf_depth_channel channel = channel_of(0);
    size_t n = 0;
    for (int i = 0; i < N; i++) {
        const int x = i % WIDTH - 20;
        const float *at = i / WIDTH < HEIGHT / 2 ? row : wire;
        depth[i] = x < 0 ? 10 : x < 9 ? at[x] : 6.8f;
    }
    REQUIRE(rf_depth_snap(NULL, &channel, &n, NULL) == RF_OK);
    for (int i = 0; i < N; i++) {
        const int y = i / WIDTH;
        const float z = depth[i];
        if (y < HEIGHT / 2 - 8)
            CHECK(z == 0 || z > 6);
        else if (y > HEIGHT / 2 + 8 && i % WIDTH == 24)
            CHECK(z == 1.2f); /* a thin thing before both, which is not that near */
    }
    CHECK(depth[24] == 0 && depth[22] > 9);
}

/* A ball of the distance 4 at its rim, round towards the middle, and a floor up to a horizon,
 * before a wall that is `far` away, averaged over 4 x 4 samples. Surfaces beside what is
 * twenty times as far are no thin things before nothing: none becomes the wall or 0. */
static void near_surfaces_before_far_ones_stay(void)
{
    enum { SUB = 4 };
    static const float fars[] = {100, 1000, 0};
    for (int k = 0; k < 3; k++) {
        struct rf_depth_channel channel = channel_of(0);
        size_t n = 0;
        bool is_whole[N];
        for (int i = 0; i < N; i++) {
            float sum = 0;
            int n_ball = 0, n_floor = 0;
            for (int j = 0; j < SUB * SUB; j++) {
                const float x = (float)(i % WIDTH) + (0.5f + (float)(j % SUB)) / SUB;
                const float row = (float)(i / WIDTH) + (0.5f + (float)(j / SUB)) / SUB;
                const float away = hypotf(x - 20, row - 14) / 11;
                n_ball += away < 1;
                n_floor += away >= 1 && row > 18;
                sum += away < 1   ? 4 - 0.5f * sqrtf(1 - away * away)
                       : row > 18 ? 40 / (row - 18)
                                  : fars[k];
            }
            depth[i] = sum / (SUB * SUB);
            is_whole[i] = n_ball == SUB * SUB || n_floor == SUB * SUB;
            truth[i] = depth[i];
        }
        REQUIRE(rf_depth_snap(NULL, &channel, &n, NULL) == RF_OK);
        CHECK(n > 0);
        for (int i = 0; i < N; i++)
            CHECK(!is_whole[i] || depth[i] > 0.5f * truth[i]);
    }
}

/* Averages with nothing along the border and along a thing, below another at 8: alike from
 * row to row, and no surface. */
static void averages_with_nothing_are_no_surface(void)
{
    static const float rows[3][4] = {{2.9f, 3.7f, 3.2f, 4.5f},
                                     {0.065f, 0.157f, 1.7f, 8.1f},
                                     {1e-4f, 0.18f, 4, 9.7f}};
    struct rf_depth_channel channel = channel_of(0);
    size_t n = 0;
    for (int i = 0; i < N; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const float *row = rows[y < 9 ? 0 : y > 11 ? 2 : y - 9];
        depth[i] = y < 9 ? 8 : x < 4 ? row[x] * (1 + 0.01f * (float)(y % 3)) : 10;
        depth[i] = y > 20 && x < 4 ? 0 : depth[i];
    }
    REQUIRE(rf_depth_snap(NULL, &channel, &n, NULL) == RF_OK);
    for (int i = 0; i < N; i++)
        CHECK(depth[i] == 0 || depth[i] > 7);
}

/* A thing at 6 of `width` px between 2 and 10, `light` times as bright as both. */
static void make_between(int width, float light)
{
    for (int i = 0; i < N; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const bool is_there = x >= 20 && x < 20 + width && y >= 10 && y < 10 + width;
        depth[i] = is_there ? 6 : x < 20 ? 2 : x == 20 ? 5 : 10;
        for (int c = 0; c < 3; c++)
            colour[3 * i + c] = is_there ? light : 1;
    }
}

/* Lamps of a pixel or two, whose depth decides how large their discs are. */
static void small_things_between_two_sides_stay(void)
{
    for (int width = 1; width <= 2; width++)
        for (int is_lamp = 0; is_lamp < 2; is_lamp++) {
            struct rf_depth_channel channel = channel_of(3);
            size_t n = 0;
            make_between(width, is_lamp ? 100 : 1);
            REQUIRE(rf_depth_snap(NULL, &channel, &n, NULL) == RF_OK);
            const bool is_known = is_lamp || width == 2;
            for (int i = 0; i < width * width; i++) {
                const float z = depth[(10 + i / width) * WIDTH + 20 + i % width];
                CHECK(is_known ? z == 6 : z == 2 || z == 10);
            }
            CHECK(depth[5 * WIDTH + 20] == 2 && n > 20); /* averages beside it */
        }
    /* The rim of a lamp that is wide enough for a side is an average as others. */
    struct rf_depth_channel channel = channel_of(3);
    size_t n = 0;
    make_averaged();
    for (int i = 0; i < N; i++)
        colour[3 * i] = colour[3 * i + 1] = colour[3 * i + 2] = i % WIDTH < 20    ? 500
                                                                : i % WIDTH == 20 ? 300
                                                                                  : 1;
    REQUIRE(rf_depth_snap(NULL, &channel, &n, NULL) == RF_OK);
    CHECK(memcmp(depth, truth, sizeof depth) == 0);
}

static void depth_times_alpha_is_divided_by_it(void)
{
    struct rf_depth_channel channel = channel_of(4);
    struct rf_depth_stats stats = {.size = sizeof stats};
    for (int i = 0; i < N; i++) {
        const float alpha = i % WIDTH == 30 ? 0.4f : i % WIDTH > 30 ? 0 : 1;
        colour[4 * i + 3] = alpha;
        truth[i] = alpha > 0 ? 4 : 0;
        depth[i] = 4 * alpha;
    }
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(stats.is_premultiplied && stats.n_divided > 0);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(depth[i], truth[i], 1e-6);
}

/* How much of a thing of distance 2 is seen in column x: it ends at 20, and a thin one
 * lies at 40, whose neighbours show a third of it. */
static float share_at(int x)
{
    static const float end[3] = {0.7f, 0.3f, 0.1f}, thin[3] = {0.1f, 0.9f, 0.1f};
    if (x < 20)
        return 1;
    if (x < 23)
        return end[x - 20];
    return x >= 39 && x <= 41 ? thin[x - 39] : 0;
}

static int slant = 3; /* px that stripes move to the left from row to row */

/*
 * Before a far wall whose stripes are `stripe` px wide, `behind` away. The depth is near
 * where anything of the near thing is seen if `is_wide`, else where most of it is.
 */
/* Of what is near and of what is behind, which may be brighter than white. */
static float near_light = 1, far_light = 1;

static void make_edges(int channels, int stripe, float behind, bool is_wide)
{
    static const float near[3] = {0.6f, 0.1f, 0.05f}, light[3] = {0.4f, 0.5f, 0.6f};
    for (int i = 0; i < N; i++) {
        const int x = i % WIDTH, y = i / WIDTH;
        const float share = share_at(x), far = (x + slant * y) / stripe % 2 ? 1 : 0.3f;
        for (int c = 0; c < channels; c++)
            colour[i * channels + c] =
                c == 3 ? 1
                       : near_light * share * near[c] +
                             far_light * (1 - share) * far * light[c];
        truth[i] = share > 0.5f ? 2 : behind;
        depth[i] = share > (is_wide ? 0 : 0.5f) ? 2 : behind;
    }
}

static void wide_depth_is_narrowed(void)
{
    static const struct {
        int channels, stripe;
        float behind;
    } cases[] = {
        {3, 1000, 10}, {4, 1000, 10}, {1, 1000, 10}, {3, 1000, 0}, {4, 1000, INFINITY}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct rf_depth_channel channel = channel_of(cases[i].channels);
        struct rf_depth_stats stats = {.size = sizeof stats};
        make_edges(cases[i].channels, cases[i].stripe, cases[i].behind, true);
        REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
        CHECK(stats.is_widened && !stats.is_mixed && !stats.is_premultiplied);
        CHECK(stats.near_shares[0] < 0.2 && stats.near_shares[1] < 0.4);
        CHECK(stats.n_narrowed == 4 * HEIGHT);
        CHECK(memcmp(depth, truth, sizeof depth) == 0);
    }
}

/* A thing of which the depth lies 2 px to the right looks so on its right side alone. */
static void moved_depth_is_not_narrowed(void)
{
    struct rf_depth_channel channel = channel_of(3);
    struct rf_depth_stats stats = {.size = sizeof stats};
    for (int by = 0; by <= 2; by += 2) {
        for (int i = 0; i < N; i++) {
            /* Its left side is seen in one row of eight. */
            const int x = i % WIDTH;
            const int left = i / WIDTH % 8 ? -9 : 15;
            const float light = x >= left && x < 35 ? 0.8f : 0.1f;
            for (int c = 0; c < 3; c++)
                colour[i * 3 + c] = light;
            /* Both sides reach 2 px over what is behind them, or one does. */
            depth[i] = truth[i] = x >= left - 2 + 2 * by && x < 37 ? 2 : 10;
        }
        REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
        CHECK(stats.is_widened == !by && (stats.n_narrowed > 0) == !by);
        CHECK((memcmp(depth, truth, sizeof depth) == 0) == !!by);
    }
}

/* A pixel of which a sky fills a third is no pixel of the sky, and a lamp's likewise. */
static void brightness_does_not_tell_width(void)
{
    static const float lights[][2] = {{10, 10}, {1, 10}, {10, 1}, {300, 1}};
    for (int i = 0; i < 4; i++)
        for (int is_wide = 0; is_wide < 2; is_wide++) {
            struct rf_depth_channel channel = channel_of(3);
            struct rf_depth_stats stats = {.size = sizeof stats};
            near_light = lights[i][0];
            far_light = lights[i][1];
            make_edges(3, 1000, 10, is_wide);
            REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
            CHECK(stats.is_widened == is_wide);
            printf("# %g %g %d: %.2f %.2f %.2f\n", (double)near_light,
                   (double)far_light, is_wide, stats.near_shares[0],
                   stats.near_shares[1], stats.near_shares[2]);
        }
    near_light = far_light = 1;
}

/* Before stripes that are 4 px wide, what is behind a pixel may have either colour. */
static void wide_depth_is_narrowed_before_texture(void)
{
    struct rf_depth_channel channel = channel_of(3);
    struct rf_depth_stats stats = {.size = sizeof stats, .near_shares = {0.15, 0.4, 0}};
    size_t n_changed = 0, n_wrong = 0;
    make_edges(3, 4, 10, true);
    REQUIRE(rf_depth_narrow(NULL, &channel, &stats, &n_changed, NULL) == RF_OK);
    for (int i = 0; i < N; i++)
        n_wrong += depth[i] != truth[i];
    CHECK(n_wrong <= 4 * HEIGHT / 6);
    /* Upright ones, of which the pixel beside the step has the other colour. */
    slant = 0;
    make_edges(3, 2, 10, true);
    REQUIRE(rf_depth_narrow(NULL, &channel, &stats, &n_changed, NULL) == RF_OK);
    CHECK(memcmp(depth, truth, sizeof depth) == 0);
    slant = 3;
}

/* It is refused where it is, and nowhere else. */
static void what_is_no_depth_does_not_spread(void)
{
    struct rf_depth_channel channel = channel_of(3);
    struct rf_depth_stats stats = {.size = sizeof stats};
    make_edges(3, 1000, 10, true);
    for (int y = 8; y < 12; y++)
        for (int x = 23; x < 30; x++)
            depth[y * WIDTH + x] = y % 2 ? NAN : -1;
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(stats.is_widened);
    for (int i = 0; i < N; i++) {
        const bool was_depth =
            i / WIDTH < 8 || i / WIDTH >= 12 || i % WIDTH < 23 || i % WIDTH >= 30;
        CHECK((depth[i] >= 0) == was_depth);
    }
}

/* Stripes of 3 light and 2 dark pixels, the last two before a dark wall. */
static void texture_is_no_width(void)
{
    struct rf_depth_channel channel = channel_of(3);
    struct rf_depth_stats stats = {.size = sizeof stats};
    for (int i = 0; i < N; i++) {
        const bool is_near = i % WIDTH < 20, is_dark = i % WIDTH % 5 >= 3;
        depth[i] = truth[i] = is_near ? 2 : 10;
        for (int c = 0; c < 3; c++)
            colour[i * 3 + c] = !is_near ? 0.05f : is_dark ? 0.07f : 0.9f;
    }
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    printf("# shares %.2f %.2f %.2f\n", stats.near_shares[0], stats.near_shares[1],
           stats.near_shares[2]);
    CHECK(!stats.is_widened && stats.n_narrowed == 0);
    CHECK(memcmp(depth, truth, sizeof depth) == 0);
}

static void other_depth_is_not_narrowed(void)
{
    struct rf_depth_channel channel = channel_of(3), without = channel_of(0);
    struct rf_depth_stats stats = {.size = sizeof stats};
    make_edges(3, 1000, 10, false);
    REQUIRE(rf_depth_repair(NULL, &channel, &stats, NULL) == RF_OK);
    CHECK(!stats.is_widened && stats.n_narrowed == 0 && stats.near_shares[0] > 0.6);
    CHECK(memcmp(depth, truth, sizeof depth) == 0);
    make_edges(3, 1000, 10, true);
    REQUIRE(rf_depth_measure(NULL, &without, &stats, NULL) == RF_OK);
    CHECK(!stats.is_widened && isnan(stats.near_shares[0]));
    CHECK(rf_depth_narrow(NULL, &without, &stats, &stats.n_narrowed, NULL) ==
          RF_ERROR_ARGUMENT);
}

/* Slants and what has the colour of what is behind it stay as they are. */
static void what_nothing_tells_stays(void)
{
    struct rf_depth_channel channel = channel_of(3);
    struct rf_depth_stats stats = {.size = sizeof stats,
                                   .near_shares = {0.2, 0.6, 0.02}};
    size_t n_changed = 0;
    for (int i = 0; i < N; i++) {
        truth[i] = depth[i] = powf(1.2f, (float)(i % WIDTH));
        for (int c = 0; c < 3; c++)
            colour[3 * i + c] = (float)(i % WIDTH) / WIDTH;
    }
    REQUIRE(rf_depth_narrow(NULL, &channel, &stats, &n_changed, NULL) == RF_OK);
    CHECK(n_changed == 0 && memcmp(depth, truth, sizeof depth) == 0);
    make_edges(3, 1000, 10, true);
    for (int i = 0; i < 3 * N; i++)
        colour[i] = 0.5f;
    REQUIRE(rf_depth_narrow(NULL, &channel, &stats, &n_changed, NULL) == RF_OK);
    /* As often as not, the last pixel of the near depth shows what is behind it. */
    CHECK(n_changed == 3 * HEIGHT);
}

/* In strips of any height the same is measured, but for steps across their borders,
 * along which none is looked for. */
static void strips_add_up(void)
{
    struct rf_depth_channel channel = channel_of(3);
    struct rf_depth_stats whole = {.size = sizeof whole}, sum = {.size = sizeof sum};
    struct rf_depth_tally *tally;
    make_edges(3, 1000, 10, true);
    depth[5] = NAN;
    depth[7] = INFINITY;
    depth[9] = -1;
    REQUIRE(rf_depth_measure(NULL, &channel, &whole, NULL) == RF_OK);
    REQUIRE(rf_depth_tally_create(&tally, NULL, &channel, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y += 5) {
        struct rf_depth_channel strip = channel;
        strip.depth += y * WIDTH;
        strip.colour.data = colour + 3 * y * WIDTH;
        strip.height = HEIGHT - y < 5 ? HEIGHT - y : 5;
        rf_depth_tally_add(tally, &strip);
    }
    rf_depth_tally_finish(tally, &sum);
    CHECK(whole.n_nan == 1 && whole.n_no_hit == 1 && whole.n_negative == 1);
    CHECK(whole.n_pixels == sum.n_pixels && sum.n_nan == 1 && sum.n_no_hit == 1);
    CHECK(whole.median == sum.median && whole.mixed_share == sum.mixed_share);
    CHECK(whole.is_widened && sum.is_widened);
    CHECK(memcmp(whole.near_shares, sum.near_shares, sizeof sum.near_shares) == 0);
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
    struct rf_depth_channel channel = channel_of(0), none = {.width = 0};
    struct rf_depth_stats stats = {.size = 0};
    struct rf_depth_tally *tally;
    struct rf_error error;
    CHECK(rf_depth_measure(NULL, &channel, &stats, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_measure(NULL, NULL, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_repair(NULL, &channel, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_snap(NULL, &channel, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_tally_create(&tally, NULL, &none, &error) == RF_ERROR_ARGUMENT);
}

/* Colours that have not the size of the depth are refused, and not read. */
static void colours_of_another_size_are_errors(void)
{
    static float few[4 * 8 * 8];
    struct rf_depth_channel channel = channel_of(0);
    struct rf_depth_stats stats = {.size = sizeof stats};
    struct rf_error error;
    size_t n = 0;
    make_averaged();
    channel.colour = rf_image_packed(few, 8, 8, 4);
    CHECK(rf_depth_measure(NULL, &channel, &stats, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "colour");
    CHECK(rf_depth_repair(NULL, &channel, &stats, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_snap(NULL, &channel, &n, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_narrow(NULL, &channel, &stats, &n, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_fill(NULL, &channel, &n, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_depth_divide_by_alpha(&channel) == 0);
    CHECK(n == 0);
    struct rf_depth_tally *tally;
    REQUIRE(rf_depth_tally_create(&tally, NULL, &channel, NULL) == RF_OK);
    rf_depth_tally_add(tally, &channel);
    rf_depth_tally_finish(tally, &stats);
    CHECK(stats.is_mixed && !stats.is_premultiplied);
}

static void memory_comes_from_the_context(void)
{
    struct rf_context *context;
    struct rf_depth_channel channel = channel_of(0);
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
    TEST(gaps_of_nothing_are_no_near_things);
    TEST(near_surfaces_before_far_ones_stay);
    TEST(averages_with_nothing_are_no_surface);
    TEST(wide_depth_is_narrowed);
    TEST(moved_depth_is_not_narrowed);
    TEST(brightness_does_not_tell_width);
    TEST(wide_depth_is_narrowed_before_texture);
    TEST(what_is_no_depth_does_not_spread);
    TEST(texture_is_no_width);
    TEST(other_depth_is_not_narrowed);
    TEST(what_nothing_tells_stays);
    TEST(small_things_between_two_sides_stay);
    TEST(depth_times_alpha_is_divided_by_it);
    TEST(strips_add_up);
    TEST(mist_becomes_linear);
    TEST(wrong_arguments_are_errors);
    TEST(colours_of_another_size_are_errors);
    TEST(memory_comes_from_the_context);
    return testing_end();
}
