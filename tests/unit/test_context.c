/* SPDX-License-Identifier: Apache-2.0 */
/* Contexts, filters, errors: what a caller can get wrong, and the allocator's hooks. */
#include <pthread.h>
#include <stdlib.h>
#include <unistd.h>

#include "physics/frames.h"
#include "portable.h"
#include "testing.h"

struct tally {
    pthread_mutex_t lock;
    int n_allocated, n_released, n_misused;
};

static void *count_allocate(void *user, size_t n_bytes)
{
    struct tally *tally = user;
    pthread_mutex_lock(&tally->lock);
    tally->n_allocated++;
    tally->n_misused += n_bytes == 0;
    pthread_mutex_unlock(&tally->lock);
    return aligned_alloc(64, (n_bytes + 63) / 64 * 64);
}

static void count_release(void *user, void *memory)
{
    struct tally *tally = user;
    pthread_mutex_lock(&tally->lock);
    tally->n_released++;
    tally->n_misused += memory == NULL;
    pthread_mutex_unlock(&tally->lock);
    aligned_release(memory);
}

static void every_byte_comes_from_the_hooks(void)
{
    struct tally tally = {.lock = PTHREAD_MUTEX_INITIALIZER};
    struct rf_context_params run = {.size = sizeof run,
                                    .n_threads = 2,
                                    .allocate = count_allocate,
                                    .release = count_release,
                                    .user = &tally};
    size_t n_methods;
    rf_method_list(&n_methods);
    for (size_t method = 0; method < n_methods; method++) {
        struct rf_context *context;
        struct rf_filter *filter;
        struct rf_params params;
        scene_params(&params, (int)method);
        struct frame f = frame_make(40, 30, 4);
        frame_fill_scene(&f, 6);
        int before = tally.n_allocated;
        REQUIRE(rf_context_create(&context, &run, NULL) == RF_OK);
        CHECK(tally.n_allocated == before + 1);
        REQUIRE(rf_filter_create(&filter, context, &params, 40, 30, NULL) == RF_OK);
        CHECK(tally.n_allocated > before + 1);
        before = tally.n_allocated;
        struct rf_view view = {.colour = rf_image_packed(f.colour, 40, 30, 4),
                               .depth = rf_image_packed(f.depth, 40, 30, 1)};
        struct rf_image out = rf_image_packed(f.out, 40, 30, 4);
        CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_OK);
        CHECK(tally.n_allocated > before);
        rf_filter_destroy(filter);
        rf_context_destroy(context);
        CHECK(tally.n_allocated == tally.n_released);
        CHECK(tally.n_misused == 0);
        frame_free(&f);
    }
}

static void thread_counts(void)
{
    struct rf_context_params run = {.size = sizeof run};
    struct rf_context *context;
    struct rf_error error;
    static const int good[] = {1, 2, 7, 1024};
    for (int i = 0; i < 4; i++) {
        run.n_threads = good[i];
        REQUIRE(rf_context_create(&context, &run, NULL) == RF_OK);
        CHECK(rf_context_threads(context) == good[i]);
        rf_context_destroy(context);
    }
    run.n_threads = 0;
    REQUIRE(rf_context_create(&context, &run, NULL) == RF_OK);
    CHECK(rf_context_threads(context) >= 1);
#ifdef _SC_NPROCESSORS_CONF
    CHECK(rf_context_threads(context) <= sysconf(_SC_NPROCESSORS_CONF));
#endif
    rf_context_destroy(context);
    static const int bad[] = {-1, 1025, INT32_MAX, INT32_MIN};
    for (int i = 0; i < 4; i++) {
        run.n_threads = bad[i];
        CHECK(rf_context_create(&context, &run, &error) == RF_ERROR_PARAMETER);
        CHECK_STR(error.field, "n_threads");
    }
}

/* Filters the scene with an instruction set; false where the machine lacks it. */
static bool filter_with(const char *cpu, struct frame *f)
{
    struct rf_context_params run = {.size = sizeof run, .n_threads = 2, .cpu = cpu};
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    if (rf_context_create(&context, &run, &error) != RF_OK) {
        CHECK_STR(error.field, "cpu");
        return false;
    }
    CHECK_STR(rf_context_cpu(context), cpu);
    scene_params(&params, RF_METHOD_LAYERED);
    CHECK(rf_filter_create(&filter, context, &params, f->width, f->height, NULL) ==
          RF_OK);
    struct rf_view view = {.colour = rf_image_packed(f->colour, f->width, f->height, 4),
                           .depth = rf_image_packed(f->depth, f->width, f->height, 1)};
    struct rf_image out = rf_image_packed(f->out, f->width, f->height, 4);
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return true;
}

static void instruction_sets_give_the_same_bits(void)
{
    static const char *const names[] = {"sse4", "avx2", "avx512"};
    struct frame plain = frame_make(173, 97, 4), other = frame_make(173, 97, 4);
    frame_fill_scene(&plain, 20);
    frame_fill_scene(&other, 20);
    REQUIRE(filter_with("generic", &plain));
    size_t n_bytes = (size_t)173 * 97 * 4 * sizeof(float);
    for (int i = 0; i < 3; i++)
        if (filter_with(names[i], &other))
            CHECK(!memcmp(plain.out, other.out, n_bytes));
    CHECK(!filter_with("z80", &other));
    frame_free(&plain);
    frame_free(&other);
}

static void context_arguments(void)
{
    struct rf_context *context;
    struct rf_error error;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    rf_context_destroy(context);
    rf_context_destroy(NULL);
    CHECK(rf_context_create(NULL, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "context");
    struct rf_context_params run = {.size = 0};
    CHECK(rf_context_create(&context, &run, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "size");
    run.size = sizeof run + 8;
    CHECK(rf_context_create(&context, &run, &error) == RF_ERROR_ARGUMENT);
    run.size = sizeof run;
    run.allocate = count_allocate;
    CHECK(rf_context_create(&context, &run, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "allocate");
    run.allocate = NULL;
    run.release = count_release;
    CHECK(rf_context_create(&context, &run, &error) == RF_ERROR_ARGUMENT);
}

static void filter_arguments(void)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    rf_params_init(&params);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(NULL, context, &params, 4, 4, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "filter");
    CHECK(rf_filter_create(&filter, NULL, &params, 4, 4, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "context");
    CHECK(rf_filter_create(&filter, context, NULL, 4, 4, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "params");
    params.size = 0;
    CHECK(rf_filter_create(&filter, context, &params, 4, 4, &error) ==
          RF_ERROR_ARGUMENT);
    rf_params_init(&params);
    params.f_stop = -1;
    CHECK(rf_filter_create(&filter, context, &params, 4, 4, &error) ==
          RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "f_stop");
    rf_filter_destroy(NULL);
    rf_context_destroy(context);
}

static rf_result process(const struct rf_filter *filter, const struct rf_view *view,
                         int n_views, const struct rf_image *out,
                         struct rf_error *error)
{
    memset(error, 0, sizeof *error);
    return rf_filter_process(filter, view, n_views, out, NULL, error);
}

static void process_arguments(void)
{
    struct frame f = frame_make(6, 4, 3);
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    frame_fill_scene(&f, 2);
    rf_params_init(&params);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, 6, 4, NULL) == RF_OK);
    const struct rf_view good = {.colour = rf_image_packed(f.colour, 6, 4, 3),
                                 .depth = rf_image_packed(f.depth, 6, 4, 1)};
    struct rf_view view = good;
    struct rf_image out = rf_image_packed(f.out, 6, 4, 3);
    CHECK(process(filter, &view, 1, &out, &error) == RF_OK);
    CHECK(error.code == RF_OK && error.message[0] == '\0');
    CHECK(process(NULL, &view, 1, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "filter");
    CHECK(process(filter, NULL, 1, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "views");
    CHECK(process(filter, &view, 1, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "out");
    CHECK(process(filter, &view, 0, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "n_views");
    CHECK(process(filter, &view, 2, &out, &error) == RF_ERROR_ARGUMENT);
    view.depth.width = 5;
    CHECK(process(filter, &view, 1, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "depth");
    CHECK_CONTAINS(error.message, "5 x 4");
    CHECK_CONTAINS(error.message, "6 x 4");
    view = good;
    view.colour.data = NULL;
    CHECK(process(filter, &view, 1, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "colour");
    view = good;
    view.colour.channels = 2;
    CHECK(process(filter, &view, 1, &out, &error) == RF_ERROR_ARGUMENT);
    view = good;
    view.colour.row_bytes += 2;
    CHECK(process(filter, &view, 1, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "colour");
    out.channels = 1;
    CHECK(process(filter, &good, 1, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "out");
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    frame_free(&f);
}

static void apply_does_it_in_one_call(void)
{
    struct frame f = frame_make(32, 24, 4);
    struct rf_params params;
    struct rf_error error = {0};
    scene_params(&params, RF_METHOD_SCATTER);
    frame_fill_scene(&f, 4);
    REQUIRE(frame_filter(&f, &params, 1, &error) == RF_OK);
    float *other = calloc(1, frame_bytes(&f));
    struct rf_image colour = rf_image_packed(f.colour, 32, 24, 4);
    struct rf_image depth = rf_image_packed(f.depth, 32, 24, 1);
    struct rf_image out = rf_image_packed(other, 32, 24, 4);
    CHECK(rf_apply(&params, &colour, &depth, &out, &error) == RF_OK);
    CHECK(memcmp(other, f.out, frame_bytes(&f)) == 0);
    CHECK(memcmp(other, f.colour, frame_bytes(&f)) != 0);
    CHECK(rf_apply(NULL, &colour, &depth, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_apply(&params, NULL, &depth, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_apply(&params, &colour, NULL, &out, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_apply(&params, &colour, &depth, NULL, NULL) == RF_ERROR_ARGUMENT);
    free(other);
    frame_free(&f);
}

static void names_and_version(void)
{
    for (int i = RF_OK; i <= RF_ERROR_CANCELLED; i++)
        for (int k = RF_OK; k < i; k++)
            CHECK(strcmp(rf_result_name(i), rf_result_name(k)) != 0);
    CHECK_STR(rf_result_name(RF_ERROR_MEMORY), "out of memory");
    CHECK(rf_result_name((rf_result)999) != NULL);
    char text[32];
    snprintf(text, sizeof text, "%d.%d.%d", RF_VERSION_MAJOR, RF_VERSION_MINOR,
             RF_VERSION_PATCH);
    CHECK_STR(rf_version(), text);
}

static void methods_match_the_parameter(void)
{
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    const struct rf_param_info *row = rf_param_find("method");
    CHECK((int)n == row->n_choices);
    CHECK(rf_method_list(NULL) == methods);
    for (size_t i = 0; i < n && (int)i < row->n_choices; i++) {
        CHECK_STR(methods[i].name, row->choices[i].name);
        CHECK(strlen(methods[i].help) > 10 && strlen(methods[i].cost) > 5 &&
              strlen(methods[i].source) > 3);
    }
}

static void packed_images(void)
{
    float data[24];
    struct rf_image image = rf_image_packed(data, 4, 2, 3);
    CHECK(image.data == data && image.width == 4 && image.height == 2);
    CHECK(image.channels == 3 && image.channel_bytes == 4);
    CHECK(image.pixel_bytes == 12 && image.row_bytes == 48);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_byte_comes_from_the_hooks);
    TEST(thread_counts);
    TEST(instruction_sets_give_the_same_bits);
    TEST(context_arguments);
    TEST(filter_arguments);
    TEST(process_arguments);
    TEST(apply_does_it_in_one_call);
    TEST(names_and_version);
    TEST(methods_match_the_parameter);
    TEST(packed_images);
    return testing_end();
}
