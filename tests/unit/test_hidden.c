/* SPDX-License-Identifier: Apache-2.0 */
/* What is estimated behind surfaces: a post in the middle of a wall. */
#include "api/filter.h"
#include "base/context.h"
#include "base/math.h"
#include "base/task.h"
#include "input/frame.h"
#include "kernels/data.h"
#include "surfaces/hidden.h"
#include "surfaces/surfaces.h"
#include "testing.h"

#include <math.h>
#include <string.h>

enum { SIDE = 32, POST = 14, POST_END = 22, N = SIDE * SIDE, STRIDE = SIDE + 16 };

static const float POST_R = -6, WALL_R = 5;
static struct rf_surface near[N], far[N], hidden[N];
static bool is_found[N];
static struct rf_marks mixed[N / 64];
static float share[N], before[STRIDE * SIDE], radius[STRIDE * SIDE];
static const struct rf_known *known;

/*
 * The columns to both sides of the post are mixed, `share` its part of them; the wall
 * has another colour in one row of those.
 */
static void search(float wall, float mixed_share, float mixed_wall)
{
    struct rf_params params = {0};
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_task task = {.last = -1};
    for (int i = 0; i < N; i++) {
        int x = i % SIDE;
        bool is_post = x >= POST && x < POST_END;
        bool is_mixed = x == POST || x == POST_END - 1;
        near[i] = (struct rf_surface){{0.1f, 0.1f, 0.1f, 1}, is_post ? POST_R : WALL_R};
        if (!is_post)
            near[i].c[0] = near[i].c[1] = near[i].c[2] = wall;
        float back = i / SIDE == SIDE / 2 ? mixed_wall : wall;
        far[i] = (struct rf_surface){{back, back, back, 1}, WALL_R};
        share[i] = is_mixed ? mixed_share : 1;
        mixed[i / 64] = (struct rf_marks){UINT64_MAX, (size_t)i / 64 * 64};
    }
    struct rf_surfaces surfaces = {.width = SIDE,
                                   .height = SIDE,
                                   .near = near,
                                   .far = far,
                                   .mixed = mixed,
                                   .share = share};
    rf_params_init(&params);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, SIDE, SIDE, NULL) == RF_OK);
    struct rf_estimates found, same;
    REQUIRE(rf_find_hidden(&filter->frame, &surfaces, NULL, known, &found, &task,
                           NULL) == RF_OK);
    /* With radii at hand; they stay as they are. */
    for (int i = 0; i < STRIDE * SIDE; i++) {
        int x = rf_min_int(rf_max_int(i % STRIDE - 8, 0), SIDE - 1);
        int at = i / STRIDE * SIDE + x;
        before[i] = radius[i] = share[at] > RF_OCCLUDER_SHARE ? near[at].r : INFINITY;
    }
    struct rf_radii radii = {radius + 8, STRIDE};
    REQUIRE(rf_find_hidden(&filter->frame, &surfaces, &radii, known, &same, &task,
                           NULL) == RF_OK);
    CHECK(memcmp(before, radius, sizeof before) == 0);
    for (int i = 0; i < N; i++) {
        int x = i % SIDE, y = i / SIDE;
        CHECK(rf_found_at(&found, x, y, 1) == rf_found_at(&same, x, y, 1));
        CHECK(!rf_found_at(&found, x, y, 1) ||
              memcmp(&found.at[i], &same.at[i], sizeof *found.at) == 0);
        uint64_t bits = rf_found_at(&found, x, y, SIDE - x);
        CHECK((bits & 1) == rf_found_at(&found, x, y, 1) && bits >> (SIDE - x) == 0);
        CHECK((bits >> (SIDE - 1 - x)) == rf_found_at(&found, SIDE - 1, y, 1));
    }
    rf_estimates_free(&same, context);
    memcpy(hidden, found.at, sizeof hidden);
    for (int i = 0; i < N; i++)
        is_found[i] = rf_found_at(&found, i % SIDE, i / SIDE, 1);
    rf_estimates_free(&found, context);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

static const struct rf_surface *at(int x)
{
    return &hidden[SIDE / 2 * SIDE + x];
}

static void the_wall_goes_on_behind_the_post(void)
{
    search(0.5f, 0.5f, 0.5f);
    for (int x = POST; x < POST_END; x++) {
        CHECK(is_found[SIDE / 2 * SIDE + x]);
        CHECK_NEAR(at(x)->c[0], 0.5, 1e-3);
        CHECK_NEAR(at(x)->r, WALL_R, 1e-3);
    }
    CHECK(!is_found[SIDE / 2 * SIDE + POST - 1]); /* nothing is behind the wall */
}

/* Somebody shows the upper half of the wall. */
static bool is_in_upper_half(void *user, int x, int y, float r)
{
    (void)user;
    CHECK(x >= POST && x < POST_END);
    CHECK_NEAR(r, WALL_R, 0.5); /* as exact as votes are */
    return y < SIDE / 2;
}

static void what_is_shown_is_not_estimated(void)
{
    const struct rf_known upper_half = {is_in_upper_half, NULL};
    known = &upper_half;
    search(0.5f, 0.5f, 0.5f);
    known = NULL;
    for (int y = 0; y < SIDE; y++)
        for (int x = POST; x < POST_END; x++)
            CHECK(is_found[y * SIDE + x] == (y >= SIDE / 2));
}

/* Though the wall around it has another colour. */
static void behind_a_mixed_pixel_is_its_far_part(void)
{
    search(0.5f, 0.5f, 0.8f);
    CHECK(at(POST)->c[0] == 0.8f && at(POST)->r == WALL_R);
}

/* A far part of which too little is seen is not to be trusted. */
static void a_sliver_is_not(void)
{
    search(0.5f, 0.95f, 0.8f);
    CHECK_NEAR(at(POST)->c[0], 0.5, 1e-3);
}

/* What is left of a pixel has an unsure colour, so it hardly counts for others. */
static void far_parts_count_by_their_share(void)
{
    search(0.5f, 0.8f, 0.8f);
    CHECK(at(POST + 1)->c[0] < 0.62f); /* 0.7 if they were whole */
}

/* Or a lamp at the edge would be seen twice. */
static void a_hidden_lamp_is_dimmed(void)
{
    search(0.5f, 0.5f, 40);
    CHECK(at(POST)->c[0] > 0.5f && at(POST)->c[0] < 12);
}

enum { WIDE = 96, HIGH = 48, WIDE_POST = 24, WIDE_END = 72, FROM = 40, BLOCK = 8 };

static struct rf_surface wide[WIDE * HIGH], answers[WIDE * HIGH];

/* Finds what is behind the surfaces of `wide`; a radius of NAN: nothing. */
static void search_wide(void)
{
    static float pure[WIDE * HIGH];
    static struct rf_marks none[WIDE * HIGH / 64];
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_estimates found;
    struct rf_task task = {.last = -1};
    for (int i = 0; i < WIDE * HIGH; i++)
        pure[i] = 1;
    struct rf_surfaces surfaces = {
        .width = WIDE, .height = HIGH, .near = wide, .mixed = none, .share = pure};
    rf_params_init(&params);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, WIDE, HIGH, NULL) == RF_OK);
    REQUIRE(rf_find_hidden(&filter->frame, &surfaces, NULL, NULL, &found, &task,
                           NULL) == RF_OK);
    for (int i = 0; i < WIDE * HIGH; i++)
        answers[i] = rf_found_at(&found, i % WIDE, i / WIDE, 1)
                         ? found.at[i]
                         : (struct rf_surface){.r = NAN};
    rf_estimates_free(&found, context);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* Counts which of 8 x 8 pixels 20 px inside a wide post have the answer of their first.
 */
static void count_alike(float wall_r, int *n)
{
    for (int i = 0; i < WIDE * HIGH; i++) {
        int x = i % WIDE, y = i / WIDE;
        bool is_post = x >= WIDE_POST && x < WIDE_END;
        float c = is_post ? 0.1f : 0.2f + 0.1f * (float)((7 * x + 3 * y) % 5);
        wide[i] = (struct rf_surface){{c, c, c, 1}, is_post ? -26 : wall_r};
    }
    search_wide();
    for (int i = 0; i < BLOCK * BLOCK; i++) {
        int at = (16 + i / BLOCK) * WIDE + FROM + i % BLOCK;
        CHECK(!isnan(answers[at].r));
        *n += memcmp(&answers[at], &answers[16 * WIDE + FROM], sizeof *answers) == 0;
    }
}

/* 8 x 8 pixels share an answer that blur hides, but none that is nearly in focus. */
static void blocks_do_not_show(void)
{
    int n_blurred = 0, n_nearly_sharp = 0;
    count_alike(6, &n_blurred);
    count_alike(1, &n_nearly_sharp);
    CHECK(n_blurred == BLOCK * BLOCK);
    CHECK(n_nearly_sharp > 0 && n_nearly_sharp <= BLOCK * BLOCK / 4);
}

enum { THIN_POST = 40, THIN_END = 54 };

/* How far below a straight edge through the middle of the post pixel i is, px. */
static float below_edge(int i, float slope)
{
    float x = (float)(i % WIDE) - (THIN_POST + THIN_END - 1) / 2.0f;
    float y = (float)(i / WIDE) - HIGH / 2.0f;
    return (y - slope * x) / sqrtf(1 + slope * slope);
}

/* A post before the straight edge of something, which stands before a sky. */
static void search_behind_edge(float post_r, float r, float sky_r, float slope)
{
    for (int i = 0; i < WIDE * HIGH; i++) {
        bool is_post = i % WIDE >= THIN_POST && i % WIDE < THIN_END;
        bool is_below = below_edge(i, slope) > 0;
        float c = is_post ? 0.1f : is_below ? 0.3f : 0.8f;
        wide[i] = (struct rf_surface){{c, c, c, 1},
                                      is_post    ? post_r
                                      : is_below ? r
                                                 : sky_r};
    }
    search_wide();
}

static bool is_on_post(int i)
{
    return i % WIDE >= THIN_POST && i % WIDE < THIN_END && i / WIDE >= BLOCK &&
           i / WIDE < HIGH - BLOCK;
}

/* It does not bend along the middle of the post, as the nearest pixels have it. */
static void a_straight_edge_goes_on(void)
{
    static const float slopes[] = {-1, -0.6f, -0.25f, 0.25f, 0.6f, 1};
    for (size_t k = 0; k < sizeof slopes / sizeof *slopes; k++) {
        int n = 0, n_wrong = 0;
        search_behind_edge(-15, 0, 15, slopes[k]);
        for (int i = 0; i < WIDE * HIGH; i++) {
            float below = below_edge(i, slopes[k]);
            if (!is_on_post(i) || fabsf(below) < 2)
                continue;
            float r = below > 0 ? 0 : 15, c = below > 0 ? 0.3f : 0.8f;
            n++;
            n_wrong +=
                fabsf(answers[i].r - r) > 0.1f || fabsf(answers[i].c[0] - c) > 1e-3f;
        }
        CHECK(n_wrong < n / 50); /* lines are some degrees apart */
    }
}

/*
 * The lens sees a sky in focus through the blurred edge of what stands before it. On the
 * left of the post that is nearer to all pixels than the sky.
 */
static void what_is_clearer_is_kept_behind_a_blurred_edge(void)
{
    int n = 0, n_wrong = 0;
    search_behind_edge(-25, -12, 0, 0.6f);
    for (int i = 0; i < WIDE * HIGH; i++)
        if (is_on_post(i) && i % WIDE >= THIN_POST + 4 && below_edge(i, 0.6f) < 4) {
            n++;
            n_wrong += fabsf(answers[i].r) > 0.1f;
        }
    CHECK(n_wrong < n / 50);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(the_wall_goes_on_behind_the_post);
    TEST(what_is_shown_is_not_estimated);
    TEST(behind_a_mixed_pixel_is_its_far_part);
    TEST(a_sliver_is_not);
    TEST(far_parts_count_by_their_share);
    TEST(a_hidden_lamp_is_dimmed);
    TEST(blocks_do_not_show);
    TEST(a_straight_edge_goes_on);
    TEST(what_is_clearer_is_kept_behind_a_blurred_edge);
    return testing_end();
}
