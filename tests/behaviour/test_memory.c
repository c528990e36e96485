/* SPDX-License-Identifier: Apache-2.0 */
/* Memory ends at the k-th allocation, for every k: a clean error, no leak, no crash. */
#include <math.h>
#include <stdio.h>

#include "physics/failing_memory.h"
#include "physics/frames.h"
#include "testing.h"

static size_t n_methods;

/* With the distribution of scatter, where the parameters ask for a picture. */
static rf_result create(struct rf_filter **filter, const struct rf_context *context,
                        const struct rf_params *params, const struct frame *f,
                        struct rf_error *error)
{
    float picture[4 * 5 * 3];
    for (int i = 0; i < 4 * 5 * 3; i++)
        picture[i] = (float)(i % 7);
    const struct rf_image image = rf_image_packed(picture, 4, 5, 3);
    bool has_image = params->distribution == RF_DISTRIBUTION_IMAGE;
    return rf_filter_create_with(filter, context, params, f->width, f->height,
                                 has_image ? &image : NULL, error);
}

static rf_result run(struct frame *f, const struct rf_params *params,
                     struct memory *memory, struct rf_error *error)
{
    struct rf_context_params how = memory_context(memory);
    struct rf_context *context;
    struct rf_filter *filter;
    rf_result result = rf_context_create(&context, &how, error);
    if (result != RF_OK)
        return result;
    result = create(&filter, context, params, f, error);
    if (result == RF_OK) {
        struct rf_view view = {
            .colour = rf_image_packed(f->colour, f->width, f->height, f->channels),
            .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
        struct rf_image out = rf_image_packed(f->out, f->width, f->height, f->channels);
        struct rf_image coc = rf_image_packed(f->out, f->width, f->height, 1);
        result = rf_filter_coc(filter, &view.depth, &coc, error);
        if (result == RF_OK)
            result = rf_filter_process(filter, &view, 1, &out, NULL, error);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return result;
}

static void check_every_k(const struct rf_params *params)
{
    struct frame f = frame_make(13, 9, 4);
    struct memory memory = {.lock = PTHREAD_MUTEX_INITIALIZER};
    frame_fill_scene(&f, 3);
    REQUIRE(run(&f, params, &memory, NULL) == RF_OK);
    CHECK(memory.n_live == 0);
    int n = memory.n_requests;
    uint64_t want = hash_bytes(0, f.out, frame_bytes(&f));
    CHECK(n >= 5);
    /* Which thread takes which tile decides how many requests a run makes, so that the
     * last ones need not come up again. */
    int n_failed = 0;
    for (int k = 1; k <= n; k++) {
        struct rf_error error = {0};
        memory.n_requests = 0;
        memory.fails_from = k;
        rf_result result = run(&f, params, &memory, &error);
        bool has_failed = memory.n_requests >= k, is_clean = memory.n_live == 0;
        n_failed += has_failed;
        if (has_failed)
            is_clean = is_clean && result == RF_ERROR_MEMORY &&
                       error.code == RF_ERROR_MEMORY && strstr(error.message, "memory");
        else
            is_clean = is_clean && result == RF_OK &&
                       hash_bytes(0, f.out, frame_bytes(&f)) == want;
        if (!testing_check(is_clean, __FILE__, __LINE__, "clean"))
            printf("#     method %d, allocation %d of %d: %s, \"%s\", %d blocks left\n",
                   params->method, k, n, rf_result_name(result), error.message,
                   memory.n_live);
        memory.n_live = 0;
    }
    CHECK(n_failed > n / 2);
    memory.n_requests = memory.fails_from = 0;
    CHECK(run(&f, params, &memory, NULL) == RF_OK);
    CHECK(hash_bytes(0, f.out, frame_bytes(&f)) == want);
    frame_free(&f);
}

static void every_allocation_may_fail(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_params params;
        scene_params(&params, (int)m);
        check_every_k(&params);
        params.blades = 6;
        params.sub_apertures = 1;
        params.split_edges = params.fill_hidden = params.exact_highlights = 0;
        params.distribution = RF_DISTRIBUTION_IMAGE;
        check_every_k(&params);
    }
}

/* Of a picture that is made colour by colour. */
static void every_allocation_of_colours_may_fail(void)
{
    struct rf_params params;
    scene_params(&params, RF_METHOD_LAYERED);
    params.axial_chroma = 2;
    check_every_k(&params);
    params.axial_chroma = 0; /* an aperture in colour: the colours share their lists */
    params.aperture = RF_APERTURE_IMAGE;
    params.distribution = RF_DISTRIBUTION_IMAGE; /* gives create() the picture */
    check_every_k(&params);
}

/* Of one that is made focus by focus. */
static void every_allocation_of_focuses_may_fail(void)
{
    struct rf_params params;
    scene_params(&params, RF_METHOD_LAYERED);
    params.split_diopter = 10 * params.focus_distance;
    params.sub_apertures = 1; /* the fewest of each focus' own, which are tried above */
    params.split_edges = params.fill_hidden = params.exact_highlights = 0;
    check_every_k(&params);
}

static rf_result add_up(struct frame *f, struct memory *memory, struct rf_error *error)
{
    struct rf_context_params how = memory_context(memory);
    struct rf_context *context;
    struct rf_accumulator *accumulator;
    struct rf_params params;
    rf_params_init(&params);
    rf_result result = rf_context_create(&context, &how, error);
    if (result != RF_OK)
        return result;
    result = rf_accumulator_create(&accumulator, context, &params, f->width, f->height,
                                   f->channels, error);
    if (result == RF_OK) {
        const struct rf_image image =
            rf_image_packed(f->colour, f->width, f->height, f->channels);
        const struct rf_image out =
            rf_image_packed(f->out, f->width, f->height, f->channels);
        result = rf_accumulator_add(accumulator, &image, error);
        if (result == RF_OK)
            result = rf_accumulator_mean(accumulator, &out, error);
        rf_accumulator_destroy(accumulator);
    }
    rf_context_destroy(context);
    return result;
}

static void sums_may_fail(void)
{
    struct frame f = frame_make(26, 18, 4);
    struct memory memory = {.lock = PTHREAD_MUTEX_INITIALIZER};
    frame_fill_scene(&f, 3);
    REQUIRE(add_up(&f, &memory, NULL) == RF_OK);
    CHECK(memory.n_live == 0);
    CHECK(!memcmp(f.out, f.colour, frame_bytes(&f)));
    int n = memory.n_requests;
    for (int k = 1; k <= n; k++) {
        struct rf_error error = {0};
        memory.n_requests = 0;
        memory.fails_from = k;
        CHECK(add_up(&f, &memory, &error) == RF_ERROR_MEMORY);
        CHECK(error.code == RF_ERROR_MEMORY && memory.n_live == 0);
    }
    frame_free(&f);
}

/* Memory full of rubbish or of zeros: the same picture. */
static void check_rubbish(const struct rf_params *params)
{
    struct frame f = frame_make(70, 66, 3);
    struct memory memory = {.lock = PTHREAD_MUTEX_INITIALIZER};
    frame_fill_scene(&f, 7);
    CHECK(run(&f, params, &memory, NULL) == RF_OK);
    uint64_t rubbish = hash_bytes(0, f.out, frame_bytes(&f));
    CHECK(frame_filter(&f, params, 2, NULL) == RF_OK);
    CHECK(hash_bytes(0, f.out, frame_bytes(&f)) == rubbish);
    float most = 0; /* the tests' core fills its own memory with huge values, too */
    for (size_t i = 0; i < frame_pixels(&f) * (size_t)f.channels; i++)
        most = fmaxf(fabsf(f.out[i]), most);
    CHECK(most < 1e6f);
    frame_free(&f);
}

static void nothing_is_read_before_it_is_written(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_params params;
        scene_params(&params, (int)m);
        check_rubbish(&params);
    }
}

/* A border that begins, or ends, beyond the picture: no pixel is of one focus alone. */
static void nor_within_the_border_of_a_split_diopter(void)
{
    for (int offset = -1; offset <= 1; offset++) {
        struct rf_params params;
        scene_params(&params, RF_METHOD_LAYERED);
        params.split_diopter = 10 * params.focus_distance;
        params.split_softness = 4;
        params.split_offset = 1.6f * (float)offset;
        params.lens_radius *= 4;
        check_rubbish(&params);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rf_method_list(&n_methods);
    TEST(every_allocation_may_fail);
    TEST(every_allocation_of_colours_may_fail);
    TEST(every_allocation_of_focuses_may_fail);
    TEST(sums_may_fail);
    TEST(nothing_is_read_before_it_is_written);
    TEST(nor_within_the_border_of_a_split_diopter);
    return testing_end();
}
