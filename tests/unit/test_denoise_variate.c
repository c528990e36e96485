/* SPDX-License-Identifier: Apache-2.0 */
/* Grain that albedo and normals explain goes out of the colours, other grain stays. */
#include <stdint.h>

#include "denoise_variate.h"
#include "report.h"
#include "testing.h"

enum { WIDTH = 64, HEIGHT = 48, N = WIDTH * HEIGHT, N_CHANNELS = 4 };

/* Grain, -1 to 1. */
static float grain(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return (float)(*state >> 8) * (2.0f / 16777216) - 1;
}

struct scene {
    float colour[N_CHANNELS * N], denoised[N_CHANNELS * N], made[N_CHANNELS * N];
    float albedo[3 * N], clean_albedo[3 * N], normal[3 * N], clean_normal[3 * N];
};

/* Light of 0.8, 0.5 and 0.2 on an albedo of 0.5, and grain of the albedo, of a normal
 * and of the colour alone. */
static void make_scene(struct scene *s, float of_albedo, float of_normal, float of_own)
{
    uint32_t state = 7;
    for (int i = 0; i < N; i++) {
        const float a = of_albedo * grain(&state), n = of_normal * grain(&state);
        const float own = of_own * grain(&state);
        for (int c = 0; c < 3; c++) {
            const float light = 0.8f - 0.3f * (float)c;
            s->denoised[N_CHANNELS * i + c] = 0.5f * light;
            s->colour[N_CHANNELS * i + c] = (0.5f + a) * light + 0.3f * n + own;
            s->albedo[3 * i + c] = 0.5f + a;
            s->clean_albedo[3 * i + c] = 0.5f;
            s->normal[3 * i + c] = c == 1 ? n : 0;
            s->clean_normal[3 * i + c] = 0;
        }
        s->colour[N_CHANNELS * i + 3] = s->denoised[N_CHANNELS * i + 3] = 0.25f;
    }
}

/* Root of the mean square of what is off; false where memory is missing. */
static bool remove_grain(struct scene *s, bool has_normals, double *before,
                         double *after)
{
    const struct denoise_guides sampled = {s->albedo, has_normals ? s->normal : NULL,
                                           false};
    const struct denoise_guides clean = {s->clean_albedo,
                                         has_normals ? s->clean_normal : NULL, true};
    const struct variates variates = {{s->colour, WIDTH, HEIGHT, N_CHANNELS, "x.exr"},
                                      s->denoised,
                                      &sampled,
                                      &clean,
                                      2};
    struct image_error error;
    *before = *after = 0;
    if (!variates_remove(&variates, s->made, &error))
        return false;
    for (int i = 0; i < N; i++)
        for (int c = 0; c < 3; c++) {
            const int k = N_CHANNELS * i + c;
            *before += pow((double)(s->colour[k] - s->denoised[k]), 2) / (3 * N);
            *after += pow((double)(s->made[k] - s->denoised[k]), 2) / (3 * N);
        }
    *before = sqrt(*before);
    *after = sqrt(*after);
    return true;
}

static struct scene scene;

static void what_the_guides_explain_goes_out(void)
{
    double before, after;
    make_scene(&scene, 0.3f, 0.5f, 0);
    REQUIRE(remove_grain(&scene, true, &before, &after));
    CHECK(after < 0.05 * before);
    CHECK(scene.made[3] == 0.25f); /* alpha */
    make_scene(&scene, 0.3f, 0, 0);
    REQUIRE(remove_grain(&scene, false, &before, &after));
    CHECK(after < 0.05 * before);
}

static void what_they_do_not_explain_stays(void)
{
    double before, after;
    make_scene(&scene, 0.3f, 0.5f, 0.2f);
    REQUIRE(remove_grain(&scene, true, &before, &after));
    CHECK_NEAR(after, 0.2 / sqrt(3), 0.02);
    /* Without grain in the guides nothing is known of the colours. */
    make_scene(&scene, 0, 0, 0.2f);
    REQUIRE(remove_grain(&scene, true, &before, &after));
    CHECK(after == before);
}

static void a_lamp_does_not_speak_for_what_is_around_it(void)
{
    double before, after;
    make_scene(&scene, 0.3f, 0, 0);
    for (int c = 0; c < 3; c++)
        scene.colour[N_CHANNELS * (N / 2 + WIDTH / 2) + c] = 1000;
    REQUIRE(remove_grain(&scene, false, &before, &after));
    const int beside = N_CHANNELS * (N / 2 + WIDTH / 2 + 1);
    CHECK_NEAR(scene.made[beside], scene.denoised[beside], 0.1);
}

static void what_is_not_finite_is_copied(void)
{
    double before, after;
    make_scene(&scene, 0.3f, 0, 0);
    scene.colour[5] = NAN;
    REQUIRE(remove_grain(&scene, false, &before, &after));
    CHECK(scene.made[0] == scene.colour[0] && scene.made[4] == scene.colour[4]);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(what_the_guides_explain_goes_out);
    TEST(what_they_do_not_explain_stays);
    TEST(a_lamp_does_not_speak_for_what_is_around_it);
    TEST(what_is_not_finite_is_copied);
    return testing_end();
}
