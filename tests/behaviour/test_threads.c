/* SPDX-License-Identifier: Apache-2.0 */
/* The same bits for any number of threads, and one filter used by many threads. */
#include <pthread.h>
#include <stdio.h>

#include "physics/frames.h"
#include "testing.h"

static size_t n_methods;

static void same_bits_for_1_2_and_7_threads(void)
{
    static const double radii[] = {0.7, 6, 25};
    for (size_t m = 0; m < n_methods; m++)
        for (int k = 0; k < 3; k++)
            for (int blades = 0; blades < 6; blades += 5) {
                struct frame f = frame_make(130, 99, 3);
                struct rf_params params;
                scene_params(&params, (int)m);
                params.blades = blades;
                frame_fill_scene(&f, radii[k]);
                REQUIRE(frame_filter(&f, &params, 1, NULL) == RF_OK);
                float *one = malloc(frame_bytes(&f));
                memcpy(one, f.out, frame_bytes(&f));
                /* The mean of one view is that view. */
                CHECK((memcmp(one, f.colour, frame_bytes(&f)) == 0) ==
                      (m == RF_METHOD_ACCUMULATE));
                for (int threads = 2; threads <= 7; threads += 5) {
                    memset(f.out, 0, frame_bytes(&f));
                    REQUIRE(frame_filter(&f, &params, threads, NULL) == RF_OK);
                    CHECK(memcmp(one, f.out, frame_bytes(&f)) == 0);
                }
                free(one);
                frame_free(&f);
            }
}

/* More threads than rows. */
static void more_threads_than_work(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(9, 3, 3);
        struct rf_params params;
        scene_params(&params, (int)m);
        frame_fill_scene(&f, 2);
        REQUIRE(frame_filter(&f, &params, 1, NULL) == RF_OK);
        uint64_t one = hash_bytes(0, f.out, frame_bytes(&f));
        REQUIRE(frame_filter(&f, &params, 64, NULL) == RF_OK);
        CHECK(hash_bytes(0, f.out, frame_bytes(&f)) == one);
        frame_free(&f);
    }
}

/* Coarse levels are composited band by band by few threads, at once by many. */
static void bands_of_coarse_levels_leave_no_seam(void)
{
    struct frame f = frame_make(70, 1500, 3);
    struct rf_params params;
    scene_params(&params, RF_METHOD_LAYERED);
    frame_fill_scene(&f, 20);
    REQUIRE(frame_filter(&f, &params, 1, NULL) == RF_OK);
    uint64_t one = hash_bytes(0, f.out, frame_bytes(&f));
    REQUIRE(frame_filter(&f, &params, 16, NULL) == RF_OK);
    CHECK(hash_bytes(0, f.out, frame_bytes(&f)) == one);
    frame_free(&f);
}

enum { N_WORKERS = 4, N_ROUNDS = 3 };

struct worker {
    pthread_t thread;
    const struct rf_filter *filter;
    struct frame frame;
    uint64_t hashes[N_ROUNDS];
};

static void *work(void *user)
{
    struct worker *w = user;
    struct frame *f = &w->frame;
    struct rf_view view = {
        .colour = rf_image_packed(f->colour, f->width, f->height, f->channels),
        .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
    struct rf_image out = rf_image_packed(f->out, f->width, f->height, f->channels);
    for (int i = 0; i < N_ROUNDS; i++) {
        memset(f->out, 0, frame_bytes(f));
        if (rf_filter_process(w->filter, &view, 1, &out, NULL, NULL) == RF_OK)
            w->hashes[i] = hash_bytes(0, f->out, frame_bytes(f));
    }
    return NULL;
}

/* One filter, four threads, a picture each; the same bits as one after the other. */
static void one_filter_in_many_threads(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_context_params run = {.size = sizeof run, .n_threads = 2};
        struct rf_context *context;
        struct rf_filter *filter;
        struct rf_params params;
        struct worker workers[N_WORKERS] = {0};
        scene_params(&params, (int)m);
        REQUIRE(rf_context_create(&context, &run, NULL) == RF_OK);
        REQUIRE(rf_filter_create(&filter, context, &params, 90, 70, NULL) == RF_OK);
        for (int i = 0; i < N_WORKERS; i++) {
            workers[i].filter = filter;
            workers[i].frame = frame_make(90, 70, 3);
            frame_fill_scene(&workers[i].frame, 3 + 4 * i);
            workers[i].frame.colour[0] = (float)i / N_WORKERS;
            REQUIRE(pthread_create(&workers[i].thread, NULL, work, &workers[i]) == 0);
        }
        for (int i = 0; i < N_WORKERS; i++)
            pthread_join(workers[i].thread, NULL);
        for (int i = 0; i < N_WORKERS; i++) {
            struct worker alone = workers[i];
            work(&alone);
            CHECK(alone.hashes[0] != 0);
            for (int k = 0; k < N_ROUNDS; k++)
                CHECK(workers[i].hashes[k] == alone.hashes[0]);
            frame_free(&workers[i].frame);
        }
        CHECK(workers[0].hashes[0] != workers[1].hashes[0]);
        rf_filter_destroy(filter);
        rf_context_destroy(context);
    }
}

/* A filter keeps nothing of the frame before. */
static void a_filter_has_no_memory(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_context *context;
        struct rf_filter *filter;
        struct rf_params params;
        struct worker a = {0}, b = {0};
        scene_params(&params, (int)m);
        REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
        REQUIRE(rf_filter_create(&filter, context, &params, 80, 60, NULL) == RF_OK);
        a.filter = b.filter = filter;
        a.frame = frame_make(80, 60, 3);
        b.frame = frame_make(80, 60, 1); /* another number of channels */
        frame_fill_scene(&a.frame, 12);
        frame_fill_scene(&b.frame, 2);
        work(&a);
        uint64_t before = a.hashes[0];
        work(&b);
        work(&a);
        CHECK(before != 0 && b.hashes[0] != 0);
        CHECK(a.hashes[0] == before && a.hashes[1] == before);
        rf_filter_destroy(filter);
        rf_context_destroy(context);
        frame_free(&a.frame);
        frame_free(&b.frame);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rf_method_list(&n_methods);
    TEST(same_bits_for_1_2_and_7_threads);
    TEST(more_threads_than_work);
    TEST(bands_of_coarse_levels_leave_no_seam);
    TEST(one_filter_in_many_threads);
    TEST(a_filter_has_no_memory);
    return testing_end();
}
