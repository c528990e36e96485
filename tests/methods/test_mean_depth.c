/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rf_view.mean_depth: at edges it says how large the two parts of a pixel are, where
 * colours cannot: before a pattern that has the near thing's own.
 */
#include "physics/frames.h"
#include "testing.h"

enum { SIZE = 64, EDGE = 32, N_CHANNELS = 3, NEAR_PX = -8 };

static const float SHARE = 0.3f; /* of the near half in the pixels of its edge */

/* The left half is near and grey; of the pixels of its edge it covers SHARE. The rest is
 * in focus, a pattern of single pixels around that grey. */
struct scene {
    struct frame f;
    float mean[SIZE * SIZE], behind[SIZE * SIZE];
};

static void fill(struct scene *s)
{
    uint32_t state = 11;
    double near = plain_depth(NEAR_PX), far = plain_depth(0);
    s->f = frame_make(SIZE, SIZE, N_CHANNELS);
    for (int i = 0; i < SIZE * SIZE; i++) {
        int x = i % SIZE;
        float share = x < EDGE ? 1 : x == EDGE ? SHARE : 0;
        s->behind[i] = (float)random_unit(&state);
        s->f.depth[i] = (float)(x < EDGE ? near : far);
        s->mean[i] = (float)((double)share * near + (1 - (double)share) * far);
        for (int c = 0; c < N_CHANNELS; c++)
            s->f.colour[i * N_CHANNELS + c] = share * 0.5f + (1 - share) * s->behind[i];
    }
}

static int mean_width = SIZE; /* px, of the mean distances that are handed on */

static rf_result run(struct scene *s, float *mean, struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    const struct rf_context_params how = {.size = sizeof how, .n_threads = 2};
    struct rf_view view = {.size = sizeof view,
                           .colour =
                               rf_image_packed(s->f.colour, SIZE, SIZE, N_CHANNELS),
                           .depth = rf_image_packed(s->f.depth, SIZE, SIZE, 1)};
    const struct rf_image out = rf_image_packed(s->f.out, SIZE, SIZE, N_CHANNELS);
    if (mean)
        view.mean_depth = rf_image_packed(mean, mean_width, SIZE, 1);
    plain_params(&params, RF_METHOD_LAYERED);
    if (rf_context_create(&context, &how, NULL) != RF_OK ||
        rf_filter_create(&filter, context, &params, SIZE, SIZE, NULL) != RF_OK)
        abort();
    rf_result result = rf_filter_process(filter, &view, 1, &out, NULL, error);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

/* Mean squared error of the pixels before whose rest the near half's blur lies. */
static double error_of(const struct scene *s)
{
    double sum = 0;
    int n = 0;
    for (int y = 16; y < SIZE - 16; y++)
        for (int x = EDGE + 1; x < EDGE - NEAR_PX; x++, n++) {
            double covered = 0, all = 0;
            for (int v = -24; v <= 24; v++)
                for (int u = -24; u <= 24; u++) {
                    if (u * u + v * v > 24 * 24)
                        continue;
                    all++;
                    covered += x + 0.5 + u / 24.0 * NEAR_PX < EDGE + (double)SHARE;
                }
            covered /= all;
            double d = (double)s->f.out[(y * SIZE + x) * N_CHANNELS + 1];
            d -= covered * 0.5 + (1 - covered) * (double)s->behind[y * SIZE + x];
            sum += d * d;
        }
    return sum / n;
}

static void before_a_pattern(void)
{
    struct scene s;
    fill(&s);
    REQUIRE(run(&s, NULL, NULL) == RF_OK);
    double by_colour = error_of(&s);
    REQUIRE(run(&s, s.mean, NULL) == RF_OK);
    double by_mean = error_of(&s);
    printf("# mean squared error %.6f, with mean depth %.6f\n", by_colour, by_mean);
    CHECK(by_mean < by_colour / 1.2);
    frame_free(&s.f);
}

static void unknown_means_change_nothing(void)
{
    struct scene s;
    fill(&s);
    static float without[SIZE * SIZE * N_CHANNELS];
    REQUIRE(run(&s, NULL, NULL) == RF_OK);
    memcpy(without, s.f.out, sizeof without);
    for (int i = 0; i < SIZE * SIZE; i++)
        s.mean[i] = i % 3 == 0 ? NAN : i % 3 == 1 ? -1 : 1e30f;
    REQUIRE(run(&s, s.mean, NULL) == RF_OK);
    CHECK(memcmp(without, s.f.out, sizeof without) == 0);
    frame_free(&s.f);
}

static void another_size_is_an_error(void)
{
    struct scene s;
    struct rf_error error;
    fill(&s);
    mean_width = SIZE / 2;
    CHECK(run(&s, s.mean, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "mean_depth");
    mean_width = SIZE;
    frame_free(&s.f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(before_a_pattern);
    TEST(unknown_means_change_nothing);
    TEST(another_size_is_an_error);
    return testing_end();
}
