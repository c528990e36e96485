/* SPDX-License-Identifier: Apache-2.0 */
/* Threads, locks and conditions. */
#include "clock.h"
#include "testing.h"
#include "thread.h"

enum { N_THREADS = 4, N_TIMES = 20000 };

struct shared {
    struct os_lock lock;
    struct os_condition changed;
    int count, n_ready;
};

static void count_up(void *user)
{
    struct shared *shared = user;
    for (int i = 0; i < N_TIMES; i++) {
        os_lock_take(&shared->lock);
        shared->count++;
        os_lock_release(&shared->lock);
    }
}

static void wait_for_go(void *user)
{
    struct shared *shared = user;
    os_lock_take(&shared->lock);
    shared->n_ready++;
    os_condition_wake_all(&shared->changed);
    while (shared->count == 0)
        os_condition_wait(&shared->changed, &shared->lock);
    shared->n_ready--;
    os_lock_release(&shared->lock);
}

static void begin(struct shared *shared)
{
    *shared = (struct shared){0};
    os_lock_init(&shared->lock);
    os_condition_init(&shared->changed);
}

static void end(struct shared *shared)
{
    os_condition_destroy(&shared->changed);
    os_lock_destroy(&shared->lock);
}

static void a_lock_keeps_others_out(void)
{
    struct os_thread threads[N_THREADS];
    struct shared shared;
    begin(&shared);
    for (int i = 0; i < N_THREADS; i++)
        CHECK(os_thread_start(&threads[i], count_up, &shared) == 0);
    for (int i = 0; i < N_THREADS; i++)
        os_thread_join(&threads[i]);
    CHECK(shared.count == N_THREADS * N_TIMES);
    end(&shared);
}

static void all_that_wait_are_woken(void)
{
    struct os_thread threads[N_THREADS];
    struct shared shared;
    begin(&shared);
    for (int i = 0; i < N_THREADS; i++)
        CHECK(os_thread_start(&threads[i], wait_for_go, &shared) == 0);
    os_lock_take(&shared.lock);
    while (shared.n_ready < N_THREADS)
        os_condition_wait(&shared.changed, &shared.lock);
    shared.count = 1;
    os_condition_wake_all(&shared.changed);
    os_lock_release(&shared.lock);
    for (int i = 0; i < N_THREADS; i++)
        os_thread_join(&threads[i]);
    CHECK(shared.n_ready == 0);
    end(&shared);
}

static void waiting_ends_at_its_time(void)
{
    struct shared shared;
    begin(&shared);
    os_lock_take(&shared.lock);
    const double until_s = os_clock_s() + 0.05;
    while (os_condition_wait_until(&shared.changed, &shared.lock, until_s))
        ;
    CHECK(os_clock_s() >= until_s);
    CHECK(!os_condition_wait_until(&shared.changed, &shared.lock, until_s - 1));
    os_lock_release(&shared.lock);
    end(&shared);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_lock_keeps_others_out);
    TEST(all_that_wait_are_woken);
    TEST(waiting_ends_at_its_time);
    return testing_end();
}
