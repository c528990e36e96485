/* SPDX-License-Identifier: Apache-2.0 */
/* Progress: on the calling thread, monotone, 0 first and 1 last; false cancels. */
#include <pthread.h>
#include <stdio.h>

#include "physics/failing_memory.h"
#include "physics/frames.h"
#include "testing.h"

static size_t n_methods;

struct record {
    pthread_t caller;
    double cancel_at; /* above 1: never */
    double first, last;
    int n_calls, n_after_cancel;
    bool is_monotone, is_caller, has_cancelled;
    bool once;               /* only the first call at cancel_at and beyond cancels */
    const struct frame *out; /* whose hash at 1 is taken; NULL: none */
    uint64_t hash;
    double cancelled_at; /* the fraction that was answered with false */
};

static bool report(void *user, double fraction)
{
    struct record *r = user;
    if (r->n_calls++ == 0)
        r->first = fraction;
    else
        r->is_monotone = r->is_monotone && fraction >= r->last;
    r->last = fraction;
    r->is_caller = r->is_caller && pthread_equal(pthread_self(), r->caller);
    r->n_after_cancel += r->has_cancelled;
    if (fraction == 1 && r->out)
        r->hash = hash_bytes(0, r->out->out, frame_bytes(r->out));
    if (r->once && r->has_cancelled)
        return true;
    if (!r->has_cancelled && fraction >= r->cancel_at)
        r->cancelled_at = fraction;
    r->has_cancelled = r->has_cancelled || fraction >= r->cancel_at;
    return fraction < r->cancel_at;
}

static struct record record_for(double cancel_at)
{
    return (struct record){.caller = pthread_self(),
                           .cancel_at = cancel_at,
                           .first = -1,
                           .last = -1,
                           .is_monotone = true,
                           .is_caller = true};
}

struct bench {
    struct rf_context *context;
    struct rf_filter *filter;
    struct frame frame;
};

static bool bench_make(struct bench *b, size_t method, int n_threads, double r_px)
{
    struct rf_context_params run = {.size = sizeof run, .n_threads = n_threads};
    struct rf_params params;
    scene_params(&params, (int)method);
    b->frame = frame_make(140, 110, 3);
    frame_fill_scene(&b->frame, r_px);
    if (r_px == 0)
        for (size_t i = 0; i < frame_pixels(&b->frame); i++)
            b->frame.depth[i] = PLAIN_FOCUS;
    return rf_context_create(&b->context, &run, NULL) == RF_OK &&
           rf_filter_create(&b->filter, b->context, &params, 140, 110, NULL) == RF_OK;
}

static rf_result bench_run(struct bench *b, struct record *record,
                           struct rf_error *error)
{
    struct rf_view view = {.colour = rf_image_packed(b->frame.colour, 140, 110, 3),
                           .depth = rf_image_packed(b->frame.depth, 140, 110, 1)};
    struct rf_image out = rf_image_packed(b->frame.out, 140, 110, 3);
    struct rf_progress progress = {.report = report, .user = record};
    return rf_filter_process(b->filter, &view, 1, &out, &progress, error);
}

static void bench_free(struct bench *b)
{
    rf_filter_destroy(b->filter);
    rf_context_destroy(b->context);
    frame_free(&b->frame);
}

static void monotone_from_0_to_1_on_the_calling_thread(void)
{
    static const int threads[] = {1, 2, 7};
    for (size_t m = 0; m < n_methods; m++)
        for (int k = 0; k < 3; k++)
            for (double r = 0; r < 20; r += 8) {
                struct bench b;
                struct record record = record_for(2);
                REQUIRE(bench_make(&b, m, threads[k], r));
                CHECK(bench_run(&b, &record, NULL) == RF_OK);
                CHECK(record.first == 0);
                CHECK(record.last == 1);
                CHECK(record.is_monotone);
                CHECK(record.is_caller);
                CHECK(record.n_calls >= (r > 0 && threads[k] == 1 ? 5 : 2));
                bench_free(&b);
            }
}

/* A band of scatter takes long where radii are large: it asks on the way. */
static void scatter_asks_within_a_band(void)
{
    struct bench b;
    struct record record = record_for(2);
    REQUIRE(bench_make(&b, RF_METHOD_SCATTER, 1, 9));
    CHECK(bench_run(&b, &record, NULL) == RF_OK);
    CHECK(record.n_calls >= 20); /* 110 rows are four bands */
    CHECK(record.is_monotone && record.is_caller);
    bench_free(&b);
}

static void check_cancel(size_t method, int n_threads, double at)
{
    struct bench b;
    struct record record = record_for(at);
    struct rf_error error = {0};
    REQUIRE(bench_make(&b, method, n_threads, 9));
    rf_result result = bench_run(&b, &record, &error);
    CHECK(result == RF_ERROR_CANCELLED);
    CHECK(error.code == RF_ERROR_CANCELLED);
    CHECK(error.message[0] != '\0');
    CHECK(record.n_after_cancel == 0);
    CHECK(record.is_monotone && record.is_caller);
    if (at == 0)
        CHECK(record.n_calls == 1);
    /* The filter can be used again, with the same result as a fresh one. */
    record = record_for(2);
    CHECK(bench_run(&b, &record, NULL) == RF_OK);
    uint64_t again = hash_bytes(0, b.frame.out, frame_bytes(&b.frame));
    struct rf_params params;
    scene_params(&params, (int)method);
    CHECK(frame_filter(&b.frame, &params, 1, NULL) == RF_OK);
    CHECK(hash_bytes(0, b.frame.out, frame_bytes(&b.frame)) == again);
    bench_free(&b);
}

static void cancel_at_0_and_on_the_way(void)
{
    for (size_t m = 0; m < n_methods; m++)
        for (int threads = 1; threads <= 2; threads++) {
            check_cancel(m, threads, 0);
            /* With one thread every fraction comes by. */
            if (threads == 1) {
                check_cancel(m, threads, 0.1);
                check_cancel(m, threads, 0.5);
            }
        }
}

/* At 1 there is nothing left to cancel: the picture is complete. */
static void cancel_at_1_is_too_late(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct bench b;
        struct record record = record_for(1);
        struct rf_params params;
        REQUIRE(bench_make(&b, m, 2, 9));
        CHECK(bench_run(&b, &record, NULL) == RF_OK);
        uint64_t hash = hash_bytes(0, b.frame.out, frame_bytes(&b.frame));
        scene_params(&params, (int)m);
        CHECK(frame_filter(&b.frame, &params, 1, NULL) == RF_OK);
        CHECK(hash_bytes(0, b.frame.out, frame_bytes(&b.frame)) == hash);
        bench_free(&b);
    }
}

/* Parameters and light that make a frame of several pictures, put together at last. */
enum together { DIOPTER_LEFT, DIOPTER_RIGHT, CHROMA, DARK, MIRROR, N_TOGETHER };

static bool together_make(struct bench *b, enum together kind)
{
    static const double sides[] = {-1.6,
                                   1.6}; /* beyond the picture, but for a border */
    struct rf_params params;
    scene_params(&params, kind == CHROMA ? RF_METHOD_SCATTER : RF_METHOD_LAYERED);
    if (kind <= DIOPTER_RIGHT) {
        params.split_diopter = 95;
        params.split_offset = sides[kind];
        params.split_softness = 1.6;
    }
    params.axial_chroma = kind == CHROMA ? 1 : 0;
    params.white = kind == DARK ? 0.25 : 1;
    b->frame = frame_make(140, 110, 3);
    frame_fill_scene(&b->frame, 9);
    return rf_context_create(&b->context, NULL, NULL) == RF_OK &&
           rf_filter_create(&b->filter, b->context, &params, 140, 110, NULL) == RF_OK;
}

/* Filters with a mirror that shows half of the light twice as far away. */
static rf_result together_run(struct bench *b, enum together kind,
                              const struct rf_progress *progress)
{
    static float light[140 * 110 * 3], far[140 * 110];
    for (size_t i = 0; i < frame_pixels(&b->frame); i++) {
        far[i] = 2 * b->frame.depth[i];
        for (size_t c = 0; c < 3; c++)
            light[3 * i + c] = 0.5f * b->frame.colour[3 * i + c];
    }
    struct rf_seen_light seen = {rf_image_packed(light, 140, 110, 3),
                                 rf_image_packed(far, 140, 110, 1)};
    struct rf_view view = {.colour = rf_image_packed(b->frame.colour, 140, 110, 3),
                           .depth = rf_image_packed(b->frame.depth, 140, 110, 1),
                           .seen = &seen,
                           .n_seen = kind == MIRROR};
    struct rf_image out = rf_image_packed(b->frame.out, 140, 110, 3);
    return rf_filter_process(b->filter, &view, 1, &out, progress, NULL);
}

/* Of a frame of several pictures, too, 0 comes first, and 1 when it is whole. */
static void whole_at_1_of_several_pictures(void)
{
    for (int kind = 0; kind < N_TOGETHER; kind++) {
        struct bench b;
        struct record record = record_for(2);
        struct rf_progress progress = {report, &record}, none = {NULL, NULL};
        REQUIRE(together_make(&b, kind));
        record.out = &b.frame;
        CHECK(together_run(&b, kind, &progress) == RF_OK);
        uint64_t hash = hash_bytes(0, b.frame.out, frame_bytes(&b.frame));
        CHECK(record.first == 0 && record.last == 1 && record.is_monotone);
        CHECK(record.hash == hash);
        CHECK(together_run(&b, kind, &none) == RF_OK);
        CHECK(hash_bytes(0, b.frame.out, frame_bytes(&b.frame)) == hash);
        bench_free(&b);
    }
}

/* A single false cancels, also where it comes as one of the pictures is done. */
static void one_false_cancels_several_pictures(void)
{
    for (int kind = 0; kind < N_TOGETHER; kind++)
        for (int i = 0; i < 20; i++) {
            struct bench b;
            struct record record = record_for(i / 20.0);
            struct rf_progress progress = {report, &record};
            record.once = true;
            REQUIRE(together_make(&b, kind));
            rf_result result = together_run(&b, kind, &progress);
            CHECK(result == (record.cancelled_at < 1 ? RF_ERROR_CANCELLED : RF_OK));
            bench_free(&b);
        }
}

/* A pane before a wall, with a step in it. */
static void deep_fill(size_t *first, struct rf_deep_sample *samples)
{
    for (int i = 0; i < 140 * 110; i++) {
        const float far = i % 140 < 70 ? PLAIN_FOCUS : 104;
        first[i] = 2 * (size_t)i;
        samples[2 * i] = (struct rf_deep_sample){97, 97, {0.2f, 0.1f, 0, 0.5f}, 0.5f};
        samples[2 * i + 1] = (struct rf_deep_sample){far, far, {0.1f, 0.4f, 1, 1}, 1};
    }
    first[140 * 110] = 2 * 140 * 110;
}

/* Wherever it is cancelled: what is not made is not read. */
static void deep_frames_are_cancelled(void)
{
    static size_t first[140 * 110 + 1];
    static struct rf_deep_sample samples[2 * 140 * 110];
    const struct rf_deep deep = {140, 110, first, samples};
    struct memory memory = {.lock = PTHREAD_MUTEX_INITIALIZER};
    const struct rf_context_params how = {.size = sizeof how,
                                          .allocate = memory_allocate,
                                          .release = memory_release,
                                          .user = &memory};
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct frame frame = frame_make(140, 110, 4);
    deep_fill(first, samples);
    scene_params(&params, RF_METHOD_LAYERED);
    REQUIRE(rf_context_create(&context, &how, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, 140, 110, NULL) == RF_OK);
    for (int i = 0; i < 40; i++) {
        struct record record = record_for(i / 40.0);
        const struct rf_progress progress = {report, &record};
        struct rf_image out = rf_image_packed(frame.out, 140, 110, 4);
        rf_result result = rf_filter_process_deep(filter, &deep, &out, &progress, NULL);
        CHECK(result == (record.cancelled_at < 1 ? RF_ERROR_CANCELLED : RF_OK));
    }
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    CHECK(memory.n_live == 0);
    frame_free(&frame);
}

/* A caller that is not the main thread gets its calls there. */
static void *in_thread(void *user)
{
    struct record *record = user;
    struct bench b;
    *record = record_for(2);
    if (bench_make(&b, RF_METHOD_SCATTER, 3, 5)) {
        bench_run(&b, record, NULL);
        bench_free(&b);
    }
    return NULL;
}

static void the_calling_thread_need_not_be_the_main_one(void)
{
    struct record record = {0};
    pthread_t thread;
    REQUIRE(pthread_create(&thread, NULL, in_thread, &record) == 0);
    pthread_join(thread, NULL);
    CHECK(record.last == 1 && record.is_caller && record.is_monotone);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rf_method_list(&n_methods);
    TEST(monotone_from_0_to_1_on_the_calling_thread);
    TEST(scatter_asks_within_a_band);
    TEST(cancel_at_0_and_on_the_way);
    TEST(cancel_at_1_is_too_late);
    TEST(whole_at_1_of_several_pictures);
    TEST(one_false_cancels_several_pictures);
    TEST(deep_frames_are_cancelled);
    TEST(the_calling_thread_need_not_be_the_main_one);
    return testing_end();
}
