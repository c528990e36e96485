/* SPDX-License-Identifier: Apache-2.0 */
/* The arithmetic of the statistics. */
#include "pixels/stats.h"
#include "testing.h"

static void updates_are_counted(void)
{
    struct stats s = {0};
    stats_start(&s, 100);
    for (int i = 1; i <= 21; i++) {
        stats_input(&s, 100 + 0.05 * i);
        stats_input(&s, 100 + 0.05 * i + 0.01); /* comes before the first is used */
        stats_change(&s, (uint64_t)i);
        stats_shown(&s, (uint64_t)i, 100 + 0.05 * i + 0.03, 8, 2, true, i % 2 == 0);
    }
    CHECK(s.n == 21);
    CHECK_NEAR(stats_rate(&s), 20, 1e-9);
    CHECK_NEAR(stats_latency_ms(&s, 0.5), 30, 1e-2);
    CHECK_NEAR(s.filter_ms, 21 * 8, 1e-9);
    CHECK(s.n_previews == 21 && s.n_small == 10);
}

static void the_same_state_is_one_update(void)
{
    struct stats s = {0};
    stats_start(&s, 1);
    stats_input(&s, 1);
    stats_change(&s, 1);
    stats_shown(&s, 1, 1.1, 8, 2, true, false);
    stats_shown(&s, 1, 2.0, 80, 2, false, false); /* its best picture */
    CHECK(s.n == 1);
    stats_change(&s, 2); /* no input made it */
    stats_shown(&s, 2, 3, 8, 2, true, false);
    CHECK(s.n == 1);
    CHECK_NEAR(stats_latency_ms(&s, 1), 100, 1e-2);
}

/* A mouse that moves by less than a step of the slider waits for no picture. */
static void input_without_effect(void)
{
    struct stats s = {0};
    stats_start(&s, 1);
    stats_input(&s, 1);
    stats_no_change(&s);
    stats_input(&s, 2);
    stats_change(&s, 1);
    stats_shown(&s, 1, 2.05, 8, 2, true, false);
    CHECK_NEAR(stats_latency_ms(&s, 1), 50, 1e-2);
}

static void shares_of_latency(void)
{
    struct stats s = {0};
    stats_start(&s, 1);
    CHECK(isnan(stats_latency_ms(&s, 0.5)));
    for (int i = 1; i <= 100; i++) {
        stats_input(&s, i);
        stats_change(&s, (uint64_t)i);
        stats_shown(&s, (uint64_t)i, i + 0.001 * i, 0, 0, true, false);
    }
    CHECK_NEAR(stats_latency_ms(&s, 0.5), 50, 1e-2);
    CHECK_NEAR(stats_latency_ms(&s, 0.95), 95, 1e-2);
    CHECK_NEAR(stats_latency_ms(&s, 1), 100, 1e-2);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(updates_are_counted);
    TEST(the_same_state_is_one_update);
    TEST(input_without_effect);
    TEST(shares_of_latency);
    return testing_end();
}
