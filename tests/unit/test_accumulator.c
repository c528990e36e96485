/* SPDX-License-Identifier: Apache-2.0 */
/* The mean of pictures, streamed: against sums in long double, and its errors. */
#include <stdlib.h>

#include "base/context.h"
#include "testing.h"

enum { WIDTH = 7, HEIGHT = 5, N = WIDTH * HEIGHT * 4, N_VIEWS = 300 };

static struct rf_context *context;

static void fill(float *picture, int view)
{
    for (int i = 0; i < N; i++)
        picture[i] = (float)((i * 37 + view * 101) % 97) / 31 * (i % 9 ? 1 : 1e4f);
}

static void check_mean(double gamma, double tolerance)
{
    struct rf_params p;
    struct rf_accumulator *accumulator;
    long double want[N] = {0};
    float picture[N], mean[N];
    rf_params_init(&p);
    p.blend_gamma = gamma;
    REQUIRE(rf_accumulator_create(&accumulator, context, &p, WIDTH, HEIGHT, 4, NULL) ==
            RF_OK);
    const struct rf_image image = rf_image_packed(picture, WIDTH, HEIGHT, 4);
    const struct rf_image out = rf_image_packed(mean, WIDTH, HEIGHT, 4);
    for (int v = 0; v < N_VIEWS; v++) {
        fill(picture, v);
        CHECK(rf_accumulator_add(accumulator, &image, NULL) == RF_OK);
        for (int i = 0; i < N; i++)
            want[i] += i % 4 == 3 ? picture[i] : powl(picture[i], 1 / gamma);
    }
    CHECK(rf_accumulator_count(accumulator) == N_VIEWS);
    REQUIRE(rf_accumulator_mean(accumulator, &out, NULL) == RF_OK);
    for (int i = 0; i < N; i++) {
        double v = (double)powl(want[i] / N_VIEWS, i % 4 == 3 ? 1 : gamma);
        CHECK_NEAR(mean[i], v, tolerance * v);
    }
    rf_accumulator_destroy(accumulator);
}

static void mean_of_linear_light(void)
{
    check_mean(1, 1e-7);
}

/* Alpha is coverage and stays linear. */
static void mean_in_the_blend_space(void)
{
    check_mean(2.2, 5e-7);
}

/* 1/N in 8 bits would lose all of it: 1000 pictures of one part in 1e6 beside 1. */
static void faint_light_survives(void)
{
    struct rf_params p;
    struct rf_accumulator *accumulator;
    float picture[3], mean[3];
    rf_params_init(&p);
    REQUIRE(rf_accumulator_create(&accumulator, context, &p, 1, 1, 3, NULL) == RF_OK);
    const struct rf_image image = rf_image_packed(picture, 1, 1, 3);
    const struct rf_image out = rf_image_packed(mean, 1, 1, 3);
    for (int v = 0; v < 1000; v++) {
        picture[0] = v == 0 ? 1e6f : 1e-3f;
        picture[1] = picture[2] = 1e-6f;
        CHECK(rf_accumulator_add(accumulator, &image, NULL) == RF_OK);
    }
    REQUIRE(rf_accumulator_mean(accumulator, &out, NULL) == RF_OK);
    CHECK_NEAR(mean[0], 1000.000999, 1e-4);
    CHECK_NEAR(mean[1], 1e-6, 1e-12);
    rf_accumulator_destroy(accumulator);
}

static void one_picture_is_itself(void)
{
    struct rf_params p;
    struct rf_accumulator *accumulator;
    float picture[N], mean[N];
    rf_params_init(&p);
    REQUIRE(rf_accumulator_create(&accumulator, context, &p, WIDTH, HEIGHT, 4, NULL) ==
            RF_OK);
    const struct rf_image image = rf_image_packed(picture, WIDTH, HEIGHT, 4);
    const struct rf_image out = rf_image_packed(mean, WIDTH, HEIGHT, 4);
    fill(picture, 3);
    CHECK(rf_accumulator_add(accumulator, &image, NULL) == RF_OK);
    CHECK(rf_accumulator_mean(accumulator, &out, NULL) == RF_OK);
    CHECK(!memcmp(picture, mean, sizeof mean));
    rf_accumulator_destroy(accumulator);
}

/* A bad picture is refused and leaves the sum as it was. */
static void bad_pictures_are_refused(void)
{
    struct rf_params p;
    struct rf_error error;
    struct rf_accumulator *accumulator;
    float picture[N], mean[N];
    rf_params_init(&p);
    REQUIRE(rf_accumulator_create(&accumulator, context, &p, WIDTH, HEIGHT, 4, NULL) ==
            RF_OK);
    struct rf_image image = rf_image_packed(picture, WIDTH, HEIGHT, 4);
    const struct rf_image out = rf_image_packed(mean, WIDTH, HEIGHT, 4);
    CHECK(rf_accumulator_mean(accumulator, &out, &error) == RF_ERROR_ARGUMENT);
    fill(picture, 3);
    CHECK(rf_accumulator_add(accumulator, &image, NULL) == RF_OK);
    picture[50] = NAN;
    CHECK(rf_accumulator_add(accumulator, &image, &error) == RF_ERROR_PIXEL);
    CHECK_CONTAINS(error.message, "(5, 1)");
    image.channels = 3;
    CHECK(rf_accumulator_add(accumulator, &image, &error) == RF_ERROR_ARGUMENT);
    CHECK_CONTAINS(error.message, "3 channels");
    image = rf_image_packed(picture, HEIGHT, WIDTH, 4);
    CHECK(rf_accumulator_add(accumulator, &image, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_accumulator_count(accumulator) == 1);
    CHECK(rf_accumulator_mean(accumulator, &out, &error) == RF_OK);
    fill(picture, 3);
    CHECK(!memcmp(picture, mean, sizeof mean));
    rf_accumulator_destroy(accumulator);
    CHECK(rf_accumulator_create(&accumulator, context, &p, 0, 5, 3, &error) ==
          RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "width");
    CHECK(rf_accumulator_create(&accumulator, context, &p, 5, 5, 2, &error) ==
          RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "channels");
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (rf_context_create(&context, NULL, NULL) != RF_OK)
        return 1;
    TEST(mean_of_linear_light);
    TEST(mean_in_the_blend_space);
    TEST(faint_light_survives);
    TEST(one_picture_is_itself);
    TEST(bad_pictures_are_refused);
    rf_context_destroy(context);
    return testing_end();
}
