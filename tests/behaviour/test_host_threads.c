/* SPDX-License-Identifier: Apache-2.0 */
/* A host's own threads: the same bits, whatever the host does with the tasks. */
#include <pthread.h>
#include <stdio.h>

#include "physics/frames.h"
#include "testing.h"

enum { N_THREADS = 5, N_HOSTS = 4 };

typedef void (*task_fn)(void *data, int32_t index);

/* What a host was asked for. */
struct host {
    int n_calls, n_nested, n_wrong;
};

static _Thread_local bool is_in_task;

struct call {
    pthread_t thread;
    task_fn task;
    void *data;
    int32_t index;
};

static void *run_call(void *user)
{
    struct call *call = user;
    is_in_task = true;
    call->task(call->data, call->index);
    is_in_task = false;
    return NULL;
}

static void note_call(struct host *host, int32_t n_tasks)
{
    host->n_calls++;
    host->n_nested += is_in_task;
    host->n_wrong += n_tasks < 2 || n_tasks > N_THREADS;
}

/* Runs tasks from `first` on with a thread each. */
static void run_threads(int32_t first, int32_t n_tasks, task_fn task, void *data)
{
    struct call calls[N_THREADS];
    for (int32_t i = first; i < n_tasks; i++) {
        calls[i] = (struct call){.task = task, .data = data, .index = i};
        if (pthread_create(&calls[i].thread, NULL, run_call, &calls[i]) != 0)
            abort();
    }
    for (int32_t i = first; i < n_tasks; i++)
        pthread_join(calls[i].thread, NULL);
}

static void on_other_threads(void *user, int32_t n_tasks, task_fn task, void *data)
{
    note_call(user, n_tasks);
    run_threads(0, n_tasks, task, data);
}

static void on_some_threads(void *user, int32_t n_tasks, task_fn task, void *data)
{
    note_call(user, n_tasks);
    run_call(&(struct call){.task = task, .data = data, .index = 0});
    run_threads(1, n_tasks, task, data);
}

static void backwards_on_this(void *user, int32_t n_tasks, task_fn task, void *data)
{
    note_call(user, n_tasks);
    for (int32_t i = n_tasks - 1; i >= 0; i--)
        run_call(&(struct call){.task = task, .data = data, .index = i});
}

static void not_at_all(void *user, int32_t n_tasks, task_fn task, void *data)
{
    note_call(user, n_tasks);
}

static void (*const hosts[N_HOSTS])(void *, int32_t, task_fn, void *) = {
    on_other_threads, on_some_threads, backwards_on_this, not_at_all};

/* Progress that must rise from 0 to 1, and may be cancelled at 0.3. */
struct watch {
    double last;
    bool cancels, is_good;
};

static bool see(void *user, double fraction)
{
    struct watch *w = user;
    w->is_good = w->is_good && fraction >= w->last && (w->last >= 0 || fraction == 0);
    w->last = fraction;
    return !w->cancels || fraction < 0.3;
}

static rf_result filter_on(int which, struct host *host, struct frame *f,
                           const struct rf_params *params, struct watch *watch)
{
    struct rf_context_params run = {.size = sizeof run,
                                    .n_threads = N_THREADS,
                                    .parallel_for = hosts[which],
                                    .user = host};
    const struct rf_progress progress = {see, watch};
    struct rf_context *context;
    struct rf_filter *filter;
    if (rf_context_create(&context, &run, NULL) != RF_OK ||
        rf_filter_create(&filter, context, params, f->width, f->height, NULL) != RF_OK)
        return RF_ERROR_ARGUMENT;
    CHECK(rf_context_threads(context) == N_THREADS);
    struct rf_view view = {
        .colour = rf_image_packed(f->colour, f->width, f->height, f->channels),
        .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
    struct rf_image out = rf_image_packed(f->out, f->width, f->height, f->channels);
    rf_result result = rf_filter_process(filter, &view, 1, &out, &progress, NULL);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

static void the_same_bits(void)
{
    size_t n_methods;
    rf_method_list(&n_methods);
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(130, 99, 3);
        struct rf_params params;
        scene_params(&params, (int)m);
        frame_fill_scene(&f, 9);
        REQUIRE(frame_filter(&f, &params, 1, NULL) == RF_OK);
        uint64_t one = hash_bytes(0, f.out, frame_bytes(&f));
        for (int i = 0; i < N_HOSTS; i++) {
            struct host host = {0};
            struct watch watch = {.last = -1, .is_good = true};
            memset(f.out, 0, frame_bytes(&f));
            REQUIRE(filter_on(i, &host, &f, &params, &watch) == RF_OK);
            CHECK(hash_bytes(0, f.out, frame_bytes(&f)) == one);
            CHECK(host.n_calls > 0 && host.n_nested == 0 && host.n_wrong == 0);
            CHECK(watch.is_good && watch.last == 1);
        }
        frame_free(&f);
    }
}

static void cancelling(void)
{
    struct frame f = frame_make(300, 200, 3);
    struct rf_params params;
    scene_params(&params, RF_METHOD_LAYERED);
    frame_fill_scene(&f, 20);
    /* Not where the calling thread runs no task: nobody asks it until all is done. */
    for (int i = 1; i < N_HOSTS; i++) {
        struct host host = {0};
        struct watch watch = {.last = -1, .cancels = true, .is_good = true};
        CHECK(filter_on(i, &host, &f, &params, &watch) == RF_ERROR_CANCELLED);
        CHECK(watch.is_good && watch.last >= 0.3 && watch.last < 1);
    }
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(the_same_bits);
    TEST(cancelling);
    return testing_end();
}
