/* SPDX-License-Identifier: Apache-2.0 */
/* The background thread: a preview at once, the best picture after it, cancelling. */
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

#include "clock.h"
#include "pixels/display.h"
#include "testing.h"
#include "filtering/worker.h"

static struct {
    pthread_mutex_t lock;
    pthread_cond_t changed;
    int n;
} woken = {PTHREAD_MUTEX_INITIALIZER, PTHREAD_COND_INITIALIZER, 0};

static void wake(void *user)
{
    (void)user;
    pthread_mutex_lock(&woken.lock);
    woken.n++;
    pthread_cond_signal(&woken.changed);
    pthread_mutex_unlock(&woken.lock);
}

/* The next shot of this kind; NULL after a minute. */
static struct shot *wait_shot(struct worker *worker, bool is_pinhole)
{
    const double end_s = os_clock_s() + 60;
    while (os_clock_s() < end_s) {
        struct shot *shot = worker_take(worker, is_pinhole);
        if (shot)
            return shot;
        usleep(1000);
    }
    return NULL;
}

static struct shot *wait_best(struct worker *worker, uint64_t id)
{
    for (;;) {
        struct shot *shot = wait_shot(worker, false);
        if (!shot || (shot->id == id && shot->quality == SHOT_BEST))
            return shot;
        shot_free(shot);
    }
}

/* A disc at 3 before a striped wall at 12. */
static struct input *make_input(int32_t width, int32_t height)
{
    const size_t n = (size_t)width * (size_t)height;
    struct input *input = input_create(width, height, 3, 1);
    float *colour = malloc(3 * n * sizeof(float)), *depth = malloc(n * sizeof(float));
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            const bool is_near = hypot(x - width / 2, y - height / 2) < height / 4;
            depth[i] = is_near ? 3 : 12;
            for (size_t c = 0; c < 3; c++)
                colour[3 * i + c] =
                    is_near ? 0.7f : 0.2f + 0.2f * (float)((x / 3 + y / 5) % 3);
        }
    input->views[0] =
        (struct rf_view){.colour = rf_image_packed(colour, width, height, 3),
                         .depth = rf_image_packed(depth, width, height, 1)};
    return input;
}

static struct job make_job(struct input *input, uint64_t id)
{
    struct job job = {.id = id, .input = input, .wants_filter = true};
    rf_params_init(&job.params);
    job.params.focus_distance = 12;
    job.params.lens_radius = 0.05;
    job.params.focal_length_px = 400;
    return job;
}

static void the_best_is_the_filter(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(120, 80);
    const struct job job = make_job(input, 1);
    worker_ask(worker, &job);
    struct shot *best = wait_best(worker, 1);
    REQUIRE(best != NULL);
    CHECK_STR(best->method, "layered");
    CHECK(best->times == 1 && best->width == 120 && best->height == 80);

    float out[120 * 80 * 3];
    uint8_t want[120 * 80 * 4];
    const struct rf_image image = rf_image_packed(out, 120, 80, 3);
    struct tone *tone = tone_create();
    CHECK(rf_apply(&job.params, &input->views[0].colour, &input->views[0].depth, &image,
                   NULL) == RF_OK);
    display_picture(tone, out, 3, 120 * 80, 0, want);
    CHECK(memcmp(best->rgba, want, sizeof(want)) == 0);
    tone_destroy(tone);
    shot_free(best);
    worker_stop(worker);
    input_drop(input);
}

static void exposure_needs_no_filter(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(120, 80);
    struct job job = make_job(input, 1);
    worker_ask(worker, &job);
    struct shot *best = wait_best(worker, 1);
    REQUIRE(best != NULL);
    const double filter_ms = best->filter_ms;
    shot_free(best);
    job.id = 2;
    job.exposure = -1;
    worker_ask(worker, &job);
    /* The kept picture is shown again: no preview comes between. */
    best = wait_shot(worker, false);
    REQUIRE(best != NULL);
    CHECK(best->quality == SHOT_BEST && best->filter_ms == filter_ms);
    shot_free(best);
    worker_stop(worker);
    input_drop(input);
}

static void newer_work_cancels_the_best(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(1600, 1000);
    struct worker_state state;
    struct job job = make_job(input, 1);
    job.params.lens_radius = 0.4; /* seconds of work */
    worker_ask(worker, &job);
    do {
        shot_free(worker_take(worker, false));
        usleep(1000);
        worker_state(worker, &state);
    } while (!state.is_best || state.fraction < 0.05);
    job.id = 2;
    job.params.lens_radius = 0.001;
    worker_ask(worker, &job);
    struct shot *shot;
    do
        shot = wait_shot(worker, false);
    while (shot && shot->id == 1 && (shot_free(shot), true));
    REQUIRE(shot != NULL);
    CHECK(shot->id == 2);
    worker_state(worker, &state);
    CHECK(state.n_cancelled == 1);
    printf("# cancelled after %.1f ms\n", state.cancel_ms);
    shot_free(shot);
    worker_stop(worker);
    input_drop(input);
}

static void large_pictures_have_small_previews(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(3001, 2003);
    const struct job job = make_job(input, 1);
    worker_ask(worker, &job);
    struct shot *preview = wait_shot(worker, false);
    REQUIRE(preview != NULL);
    CHECK(preview->quality == SHOT_PREVIEW && preview->id == 1 && preview->times > 1);
    CHECK_STR(preview->method, "layered"); /* in its preview quality */
    CHECK(preview->width == (3001 + preview->times - 1) / preview->times);
    shot_free(preview);
    worker_stop(worker); /* in the middle of the best picture */
    input_drop(input);
}

/* A grey wall at 12 and before it, and far behind it, a lamp of one px each. */
static struct input *make_lamps(void)
{
    struct input *input = make_input(200, 100);
    float *colour = input->views[0].colour.data, *depth = input->views[0].depth.data;
    for (size_t i = 0; i < 200 * 100; i++) {
        depth[i] = 12;
        for (size_t c = 0; c < 3; c++)
            colour[3 * i + c] = 0.2f;
    }
    for (size_t lamp = 0; lamp < 2; lamp++) {
        const size_t at = 50 * 200 + (lamp ? 150 : 50);
        depth[at] = lamp ? 1000 : 3;
        for (size_t c = 0; c < 3; c++)
            colour[3 * at + c] = 60;
    }
    return input;
}

/* While the focus is dragged a lamp is the disc that it will be: no bright core, no
 * square, no pop when the best picture comes. */
static void lamps_of_previews_are_discs(void)
{
    struct input *input = make_lamps();
    struct job job = make_job(input, 1);
    job.params.method = RF_METHOD_SCATTER;
    for (int far = 0; far < 2; far++) {
        /* A new one does not know yet that the method is as fast as a preview. */
        struct worker *worker = worker_start(2, wake, NULL);
        job.params.focus_distance = far ? 3 : 12;
        job.params.lens_radius = far ? 0.08 : 0.1; /* some 10 px either way */
        worker_ask(worker, &job);
        struct shot *preview = wait_shot(worker, false);
        struct shot *best = wait_best(worker, job.id);
        REQUIRE(preview && best && preview->quality == SHOT_PREVIEW);
        CHECK(preview->times == 1);
        for (int at = -14; at <= 14; at++) {
            const size_t i = 4 * (size_t)(50 * 200 + (far ? 150 : 50) + at);
            /* Edges are rounded apart; the px of the lamp itself lacks in scatter what
             * the wall gives to all others: what is beside it is meant. */
            const bool is_edge = abs(at) >= 9 && abs(at) <= 12;
            const size_t k = at == 0 ? i + 4 : i;
            CHECK(is_edge || abs(preview->rgba[i] - best->rgba[k]) <= 16);
        }
        shot_free(preview);
        shot_free(best);
        worker_stop(worker);
    }
    input_drop(input);
}

static void maps_need_no_filter(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(120, 80);
    struct job job = make_job(input, 1);
    for (int mode = MODE_DEPTH; mode <= MODE_BAND; mode++) {
        job.id++;
        job.mode = (enum view_mode)mode;
        worker_ask(worker, &job);
        struct shot *shot = wait_shot(worker, false);
        REQUIRE(shot != NULL);
        CHECK(shot->quality == SHOT_BEST && shot->mode == (enum view_mode)mode);
        CHECK(shot->filter_ms == 0);
        const uint8_t *middle = shot->rgba + 4 * (40 * 120 + 60);
        if (mode == MODE_DEPTH)
            CHECK(middle[0] == 0 && shot->rgba[0] == 255);
        if (mode == MODE_COC)
            CHECK(middle[0] == 255 && shot->rgba[0] == 0);
        shot_free(shot);
    }
    worker_stop(worker);
    input_drop(input);
}

static void the_pinhole_comes_by_itself(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(120, 80);
    struct job job = make_job(input, 1);
    uint8_t want[120 * 80 * 4];
    struct tone *tone = tone_create();
    job.wants_filter = false;
    job.wants_pinhole = true;
    worker_ask(worker, &job);
    struct shot *shot = wait_shot(worker, true);
    REQUIRE(shot != NULL);
    display_picture(tone, input->views[0].colour.data, 3, 120 * 80, 0, want);
    CHECK(memcmp(shot->rgba, want, sizeof(want)) == 0);
    shot_free(shot);
    tone_destroy(tone);
    worker_stop(worker);
    input_drop(input);
}

static void bad_pixels_are_reported(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(120, 80);
    const struct job job = make_job(input, 1);
    ((float *)input->views[0].depth.data)[7] = NAN;
    worker_ask(worker, &job);
    struct shot *shot = wait_shot(worker, false);
    REQUIRE(shot != NULL);
    CHECK(strstr(shot->error, "NaN") != NULL);
    shot_free(shot);
    worker_stop(worker);
    input_drop(input);
}

static struct {
    float first;
    volatile int n;
    char error[256];
} saved;

static void keep_saved(void *user, float *pixels, const char *error)
{
    (void)user;
    saved.first = pixels ? pixels[0] : -1;
    snprintf(saved.error, sizeof(saved.error), "%s", error ? error : "");
    saved.n++;
}

static void saving_is_of_its_own_moment(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(120, 80);
    struct save save = {.job = make_job(input, 1), .write = keep_saved};
    struct job job = save.job;
    worker_ask(worker, &job);
    worker_save(worker, &save);
    for (uint64_t i = 2; i < 30; i++) { /* goes on being changed */
        job.id = i;
        job.params.focus_distance = 3 + 0.1 * (double)i;
        worker_ask(worker, &job);
        usleep(2000);
    }
    worker_drain(worker);
    CHECK(saved.n == 1);
    CHECK_STR(saved.error, "");
    float out[120 * 80 * 3];
    const struct rf_image image = rf_image_packed(out, 120, 80, 3);
    rf_apply(&save.job.params, &input->views[0].colour, &input->views[0].depth, &image,
             NULL);
    CHECK(saved.first == out[0]);
    worker_stop(worker);
    input_drop(input);
}

/* The pause before a best picture ends when the mouse is let go. */
static void letting_go_ends_the_pause(void)
{
    struct worker *worker = worker_start(2, wake, NULL);
    struct input *input = make_input(480, 320);
    struct worker_state state;
    struct job job = make_job(input, 1);
    job.mode = MODE_DIFFERENCE; /* has a preview however fast the picture is */
    worker_ask(worker, &job);
    shot_free(wait_best(worker, 1));
    worker_state(worker, &state);
    CHECK(state.n_settled == 0);
    job.id = 2;
    job.params.focus_distance = 4;
    worker_ask(worker, &job);
    worker_settle(worker);
    shot_free(wait_best(worker, 2));
    worker_state(worker, &state);
    CHECK(state.n_settled == 1);
    worker_stop(worker);
    input_drop(input);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(the_best_is_the_filter);
    TEST(exposure_needs_no_filter);
    TEST(newer_work_cancels_the_best);
    TEST(large_pictures_have_small_previews);
    TEST(lamps_of_previews_are_discs);
    TEST(maps_need_no_filter);
    TEST(the_pinhole_comes_by_itself);
    TEST(bad_pixels_are_reported);
    TEST(saving_is_of_its_own_moment);
    TEST(letting_go_ends_the_pause);
    return testing_end();
}
