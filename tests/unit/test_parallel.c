/* SPDX-License-Identifier: Apache-2.0 */
/* The pool of threads: every step once, from any caller, in a forked child too. */
#include <pthread.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#ifndef _WIN32
#include <sys/wait.h>
#endif

#include "base/system_threads.h"
#include "base/threads.h"
#include "testing.h"

enum { MOST_STEPS = 5000, MOST_THREADS = 16 };

static struct rf_threads *make_pool(int n_threads)
{
    void *memory = malloc(rf_threads_bytes(n_threads));
    return memory ? rf_threads_init(memory, n_threads) : NULL;
}

static void free_pool(struct rf_threads *pool)
{
    rf_threads_end(pool);
    free(pool);
}

/* How often each step was run, and which threads are in the loop. */
struct tally {
    int n_steps[MOST_STEPS];
    bool is_inside[MOST_THREADS];
    int n_threads, most; /* allowed; steps at once */
    int n_wrong;         /* threads that were there already, or parts too long */
};

static void count_steps(void *data, int64_t begin, int64_t end, int thread)
{
    struct tally *t = data;
    bool is_wrong =
        thread < 0 || thread >= t->n_threads || end - begin > t->most || begin >= end;
    if (!is_wrong && __atomic_test_and_set(&t->is_inside[thread], __ATOMIC_ACQUIRE))
        is_wrong = true;
    for (int64_t i = begin; i < end; i++)
        __atomic_fetch_add(&t->n_steps[i], 1, __ATOMIC_RELAXED);
    if (is_wrong)
        __atomic_fetch_add(&t->n_wrong, 1, __ATOMIC_RELAXED);
    else
        __atomic_clear(&t->is_inside[thread], __ATOMIC_RELEASE);
}

/* Does a loop run each of its steps once? */
static bool runs_all(struct rf_threads *pool, int n_threads, int count, int grain)
{
    struct tally *t = calloc(1, sizeof *t);
    if (!t)
        return false;
    struct rf_loop loop = rf_loop_make(count, grain, n_threads, count_steps, t);
    t->n_threads = n_threads;
    t->most = grain ? grain : count;
    rf_threads_run(pool, n_threads, &loop);
    bool is_good = t->n_wrong == 0;
    for (int i = 0; i < MOST_STEPS; i++)
        is_good = is_good && t->n_steps[i] == (i < count);
    free(t);
    return is_good;
}

static void every_step_once(void)
{
    static const int threads[] = {1, 2, 3, MOST_THREADS};
    static const int counts[] = {0, 1, 2, 7, 64, MOST_STEPS};
    static const int grains[] = {0, 1, 3, 16, 2 * MOST_STEPS};
    for (int t = 0; t < 4; t++) {
        struct rf_threads *pool = make_pool(threads[t]);
        REQUIRE(pool);
        for (int c = 0; c < 6; c++)
            for (int g = 0; g < 5; g++)
                for (int n = 0; n <= t; n++)
                    CHECK(runs_all(pool, threads[n], counts[c], grains[g]));
        free_pool(pool);
    }
}

static void a_pool_begins_and_ends(void)
{
    struct rf_threads *pool = make_pool(3);
    REQUIRE(pool);
    CHECK(rf_threads_count(pool) == 3);
    CHECK(rf_threads_start(pool));
    CHECK(!rf_threads_start(pool));
    CHECK(rf_threads_count(pool) == 3);
    rf_threads_end(pool);
    rf_threads_end(pool);
    CHECK(runs_all(pool, 3, 100, 1)); /* a new beginning */
    free_pool(pool);
    pool = make_pool(4);
    REQUIRE(pool);
    free_pool(pool); /* that was never started */
}

/* Threads that wait for each other in a loop. */
struct meeting {
    int n_wanted, n_inside, n_met;
    int n_of[MOST_THREADS]; /* parts that a thread has run */
    bool is_over;           /* set by the last to leave, after a while */
};

/* Waits until as many threads are inside as are wanted, so that the loop needs them. */
static void meet(void *data, int64_t begin, int64_t end, int thread)
{
    struct meeting *m = data;
    __atomic_fetch_add(&m->n_of[thread], 1, __ATOMIC_RELAXED);
    __atomic_fetch_add(&m->n_inside, 1, __ATOMIC_RELAXED);
    time_t start = time(NULL);
    while (__atomic_load_n(&m->n_inside, __ATOMIC_RELAXED) < m->n_wanted)
        if (time(NULL) - start > 20)
            return;
    __atomic_fetch_add(&m->n_met, 1, __ATOMIC_RELAXED);
    if (thread > 0) {
        usleep(2000); /* the caller waits for this, too */
        __atomic_store_n(&m->is_over, true, __ATOMIC_RELAXED);
    }
}

/* Do n threads run a loop of n parts together, each with a number of its own? */
static bool do_meet(struct rf_threads *pool, int n)
{
    struct meeting m = {.n_wanted = n};
    struct rf_loop loop = rf_loop_make(n, 1, n, meet, &m);
    rf_threads_run(pool, n, &loop);
    bool is_good = m.n_met == n && m.is_over;
    for (int i = 0; i < n; i++)
        is_good = is_good && m.n_of[i] == 1;
    return is_good;
}

static void threads_take_part(void)
{
    struct rf_threads *pool = make_pool(5);
    REQUIRE(pool);
    for (int i = 0; i < 20; i++) {
        CHECK(do_meet(pool, 2 + i % 4));
        if (i % 5 == 0)
            usleep(5000); /* long enough for the others to sleep */
    }
    free_pool(pool);
}

struct nest {
    struct rf_threads *pool;
    int n_bad;
};

static void run_inner(void *data, int64_t begin, int64_t end, int thread)
{
    struct nest *nest = data;
    for (int64_t i = begin; i < end; i++)
        if (!runs_all(nest->pool, 4, 300, 7))
            __atomic_fetch_add(&nest->n_bad, 1, __ATOMIC_RELAXED);
}

static void a_loop_in_a_loop(void)
{
    struct rf_threads *pool = make_pool(4);
    REQUIRE(pool);
    struct nest nest = {pool, 0};
    struct rf_loop loop = rf_loop_make(40, 1, 4, run_inner, &nest);
    rf_threads_run(pool, 4, &loop);
    CHECK(nest.n_bad == 0);
    free_pool(pool);
}

static void *call_often(void *data)
{
    struct nest *nest = data;
    for (int i = 0; i < 300; i++)
        if (!runs_all(nest->pool, 3, 100 + i, i % 9))
            __atomic_fetch_add(&nest->n_bad, 1, __ATOMIC_RELAXED);
    return NULL;
}

static void many_callers(void)
{
    struct rf_threads *pool = make_pool(3);
    REQUIRE(pool);
    struct nest nest = {pool, 0};
    pthread_t callers[5];
    for (int i = 0; i < 5; i++)
        REQUIRE(pthread_create(&callers[i], NULL, call_often, &nest) == 0);
    for (int i = 0; i < 5; i++)
        pthread_join(callers[i], NULL);
    CHECK(nest.n_bad == 0);
    free_pool(pool);
}

#ifndef _WIN32
static void a_forked_child_has_threads_of_its_own(void)
{
    struct rf_threads *pool = make_pool(2);
    REQUIRE(pool);
    CHECK(runs_all(pool, 2, 100, 1));
    pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        alarm(90);
        bool is_good = do_meet(pool, 2) && runs_all(pool, 2, 100, 1);
        free_pool(pool);
        _exit(is_good ? 0 : 1);
    }
    int status = -1;
    CHECK(waitpid(child, &status, 0) == child && status == 0);
    CHECK(runs_all(pool, 2, 100, 1));
    /* One that ends what it never used. */
    child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        alarm(90);
        free_pool(pool);
        _exit(0);
    }
    CHECK(waitpid(child, &status, 0) == child && status == 0);
    free_pool(pool);
}

static double cpu_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* CPU time, which no other program changes: threads that spin would take 1.5 s. */
static void an_idle_pool_sleeps(void)
{
    struct rf_threads *pool = make_pool(4);
    REQUIRE(pool);
    CHECK(runs_all(pool, 4, 100, 1));
    double before = cpu_s();
    usleep(500000);
    CHECK(cpu_s() - before < 0.1);
    free_pool(pool);
}
#endif

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_step_once);
    TEST(a_pool_begins_and_ends);
    TEST(threads_take_part);
    TEST(a_loop_in_a_loop);
    TEST(many_callers);
#ifndef _WIN32
    TEST(a_forked_child_has_threads_of_its_own);
    TEST(an_idle_pool_sleeps);
#endif
    return testing_end();
}
