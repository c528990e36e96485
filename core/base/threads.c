/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A pool of threads.
 *
 * A loop is published in a list; a thread with nothing to do joins the first that wants
 * one more, and takes parts of it until none is left. So the caller never waits for a
 * thread that has not come: it takes the parts itself, and at the end waits only for
 * those that are at their last. A loop inside a body is one more in the list.
 *
 * A thread that has nothing to do looks for a short time whether something comes before
 * it sleeps, about as long as it takes to wake it: so it never wastes more than twice
 * what one would who knew when the next loop comes.
 */
#include "base/threads.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/system_threads.h"

enum {
    PARTS_PER_THREAD = 4, /* of a loop in equal parts */
    /*
     * Looks before a thread sleeps, some 45 us where each takes 11 ns. 20 loops of 50 us
     * with gaps of 30 us on two processors: 69 us each without, 55 us with enough.
     */
    SPINS = 4000
};

/* ---- loops ---------------------------------------------------------------------- */

struct rf_loop rf_loop_make(int64_t count, int64_t grain, int n_threads,
                            rf_body_fn body, void *data)
{
    int64_t n_parts = (int64_t)n_threads * PARTS_PER_THREAD;
    if (grain <= 0)
        grain = (count + n_parts - 1) / n_parts;
    return (struct rf_loop){
        .count = count, .grain = grain > 0 ? grain : 1, .body = body, .data = data};
}

int64_t rf_loop_parts(const struct rf_loop *loop)
{
    return loop->count > 0 ? (loop->count - 1) / loop->grain + 1 : 0;
}

void rf_loop_run(struct rf_loop *loop, int thread)
{
    for (;;) {
        int64_t begin = __atomic_fetch_add(&loop->next, loop->grain, __ATOMIC_RELAXED);
        if (begin >= loop->count)
            return;
        int64_t left = loop->count - begin;
        loop->body(loop->data, begin, begin + (left < loop->grain ? left : loop->grain),
                   thread);
    }
}

/* ---- the pool ------------------------------------------------------------------- */

/* A loop that threads may join, on the stack of its caller. */
struct job {
    struct rf_loop *loop;
    int n_threads, n_joined; /* that may take part; that did, the caller among them */
    int n_inside;            /* atomic: of the others, those that are still at it */
    struct job *next;
};

struct rf_threads {
    int64_t process; /* atomic: whose threads these are; minus it: being started */
    int n_threads;   /* wanted, the caller's among them */
    int n_workers;   /* that were started */
    int n_spins;
    struct rf_mutex lock; /* of what follows */
    struct rf_condition has_job, has_left;
    struct job *jobs;
    unsigned n_published; /* atomic: loops so far */
    int n_asleep;
    bool is_ending;
    struct rf_thread workers[];
};

size_t rf_threads_bytes(int n_threads)
{
    return sizeof(struct rf_threads) + (size_t)n_threads * sizeof(struct rf_thread);
}

struct rf_threads *rf_threads_init(void *memory, int n_threads)
{
    struct rf_threads *threads = memory;
    *threads = (struct rf_threads){.n_threads = n_threads};
    return threads;
}

int rf_threads_count(const struct rf_threads *threads)
{
    bool is_started =
        __atomic_load_n(&threads->process, __ATOMIC_ACQUIRE) == rf_system_process();
    return is_started ? threads->n_workers + 1 : threads->n_threads;
}

/* Nobody joins a job any more. Under the lock. */
static void close_job(struct rf_threads *threads, const struct job *job)
{
    for (struct job **at = &threads->jobs; *at; at = &(*at)->next)
        if (*at == job) {
            *at = job->next;
            return;
        }
}

/* Joins a job, if there is one; NULL: there is none. Under the lock. */
static struct job *join_job(struct rf_threads *threads, int *thread)
{
    struct job *job = threads->jobs;
    if (!job)
        return NULL;
    *thread = job->n_joined++;
    if (job->n_joined == job->n_threads)
        close_job(threads, job);
    __atomic_fetch_add(&job->n_inside, 1, __ATOMIC_RELAXED);
    return job;
}

/* Leaves a job, of which nothing is left to take. Under the lock. */
static void leave_job(struct rf_threads *threads, struct job *job)
{
    close_job(threads, job);
    if (__atomic_sub_fetch(&job->n_inside, 1, __ATOMIC_RELEASE) == 0)
        rf_condition_wake_all(&threads->has_left);
}

/* Sleeps until a loop is published after the first n_seen. Under the lock. */
static void sleep_for_job(struct rf_threads *threads)
{
    const unsigned n_seen = threads->n_published;
    rf_mutex_unlock(&threads->lock);
    for (int i = 0; i < threads->n_spins; i++) {
        if (__atomic_load_n(&threads->n_published, __ATOMIC_RELAXED) != n_seen)
            break;
        rf_system_pause();
    }
    rf_mutex_lock(&threads->lock);
    threads->n_asleep++;
    while (!threads->jobs && !threads->is_ending && threads->n_published == n_seen)
        rf_condition_wait(&threads->has_job, &threads->lock);
    threads->n_asleep--;
}

static void work(void *data)
{
    struct rf_threads *threads = data;
    rf_mutex_lock(&threads->lock);
    while (!threads->is_ending) {
        int thread;
        struct job *job = join_job(threads, &thread);
        if (!job) {
            sleep_for_job(threads);
            continue;
        }
        rf_mutex_unlock(&threads->lock);
        rf_loop_run(job->loop, thread);
        rf_mutex_lock(&threads->lock);
        leave_job(threads, job);
    }
    rf_mutex_unlock(&threads->lock);
}

bool rf_threads_start(struct rf_threads *threads)
{
    const int64_t own = rf_system_process();
    for (;;) {
        int64_t process = __atomic_load_n(&threads->process, __ATOMIC_ACQUIRE);
        if (process == own)
            return false;
        if (process == -own)
            rf_system_pause(); /* another thread starts them */
        else if (__atomic_compare_exchange_n(&threads->process, &process, -own, false,
                                             __ATOMIC_ACQUIRE, __ATOMIC_RELAXED))
            break;
    }
    /* What a parent process had of these is lost with its threads. */
    rf_mutex_init(&threads->lock);
    rf_condition_init(&threads->has_job);
    rf_condition_init(&threads->has_left);
    threads->jobs = NULL;
    threads->n_workers = threads->n_asleep = 0;
    threads->is_ending = false;
    threads->n_spins = threads->n_threads > rf_system_processors() ? 0 : SPINS;
    int n = 0;
    while (n < threads->n_threads - 1 &&
           rf_thread_start(&threads->workers[n], work, threads))
        n++;
    threads->n_workers = n;
    __atomic_store_n(&threads->process, own, __ATOMIC_RELEASE);
    return true;
}

void rf_threads_end(struct rf_threads *threads)
{
    if (__atomic_load_n(&threads->process, __ATOMIC_ACQUIRE) != rf_system_process())
        return;
    rf_mutex_lock(&threads->lock);
    threads->is_ending = true;
    rf_condition_wake_all(&threads->has_job);
    rf_mutex_unlock(&threads->lock);
    for (int i = 0; i < threads->n_workers; i++)
        rf_thread_join(&threads->workers[i]);
    rf_condition_destroy(&threads->has_left);
    rf_condition_destroy(&threads->has_job);
    rf_mutex_destroy(&threads->lock);
    threads->process = 0;
}

static void publish(struct rf_threads *threads, struct job *job)
{
    rf_mutex_lock(&threads->lock);
    /* At the end: who came first is helped first. */
    struct job **at = &threads->jobs;
    while (*at)
        at = &(*at)->next;
    *at = job;
    __atomic_store_n(&threads->n_published, threads->n_published + 1, __ATOMIC_RELAXED);
    const int n_wanted = job->n_threads - 1, n_asleep = threads->n_asleep;
    rf_mutex_unlock(&threads->lock);
    if (n_asleep > n_wanted)
        for (int i = 0; i < n_wanted; i++)
            rf_condition_wake(&threads->has_job);
    else if (n_asleep > 0)
        rf_condition_wake_all(&threads->has_job);
}

static bool is_left(const struct job *job)
{
    return __atomic_load_n(&job->n_inside, __ATOMIC_ACQUIRE) == 0;
}

/* Waits for those that are at their last part. */
static void wait_for_others(struct rf_threads *threads, struct job *job)
{
    rf_mutex_lock(&threads->lock);
    close_job(threads, job);
    rf_mutex_unlock(&threads->lock);
    for (int i = 0; i < threads->n_spins && !is_left(job); i++)
        rf_system_pause();
    if (is_left(job))
        return;
    rf_mutex_lock(&threads->lock);
    while (!is_left(job))
        rf_condition_wait(&threads->has_left, &threads->lock);
    rf_mutex_unlock(&threads->lock);
}

void rf_threads_run(struct rf_threads *threads, int n_threads, struct rf_loop *loop)
{
    const int64_t n_parts = rf_loop_parts(loop);
    struct job job = {.loop = loop, .n_joined = 1};
    if (n_parts > 1 && n_threads > 1) {
        rf_threads_start(threads);
        job.n_threads = n_threads < rf_threads_count(threads)
                            ? n_threads
                            : rf_threads_count(threads);
        if (n_parts < job.n_threads)
            job.n_threads = (int)n_parts;
    }
    if (job.n_threads > 1)
        publish(threads, &job);
    rf_loop_run(loop, 0);
    if (job.n_threads > 1)
        wait_for_others(threads, &job);
}
