/* SPDX-License-Identifier: Apache-2.0 */
/* Grain that a pixel filter smeared is told from grain of single pixels. */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "denoise/denoise_grain.h"
#include "testing.h"

enum { WIDTH = 100, HEIGHT = 60, N = WIDTH * HEIGHT };

static float noise[N], samples[4 * N], albedo[3 * N], normal[3 * N];

/* Values of -1 to 1 that look random. */
static float random_of(int i)
{
    uint32_t v = (uint32_t)i * 2654435761u + 12345;
    v = (v ^ v >> 15) * 2246822519u;
    v = (v ^ v >> 13) * 3266489917u;
    return (float)(v ^ v >> 16) / (float)UINT32_MAX * 2 - 1;
}

/* Noise of this size; smeared: each value goes to its neighbours, too. */
static void make_noise(float size, bool is_smeared)
{
    for (int i = 0; i < N; i++) {
        noise[i] = size * random_of(i);
        if (is_smeared)
            noise[i] =
                size * (4 * random_of(i) + random_of(i - 1) + random_of(i + 1)) / 6;
    }
}

/* What samples are multiplied by. */
static float white = 1;

static bool is_smeared(int n_channels, const float *light, bool has_albedo)
{
    const struct denoise_picture picture = {samples,    WIDTH, HEIGHT,
                                            n_channels, "it",  white};
    const struct denoise_guides guides = {has_albedo ? albedo : NULL, normal, false};
    for (int i = 0; i < N; i++)
        for (int c = 0; c < n_channels; c++)
            samples[i * n_channels + c] = white * (light[i] + noise[i]);
    return denoise_is_smeared(&picture, &guides);
}

static float light[N];

static void make_light(float from, float to)
{
    for (int i = 0; i < N; i++)
        light[i] = from + (to - from) * (float)(i % WIDTH) / WIDTH;
    memset(albedo, 0, sizeof albedo);
    memset(normal, 0, sizeof normal);
}

static void smeared_grain_is_told(void)
{
    for (int n_channels = 1; n_channels <= 4; n_channels += n_channels > 1 ? 1 : 2) {
        make_light(0.3f, 0.6f);
        make_noise(0.2f, false);
        CHECK(!is_smeared(n_channels, light, true));
        make_noise(0.2f, true);
        CHECK(is_smeared(n_channels, light, true));
    }
}

static void what_cannot_be_told_is_not(void)
{
    make_light(0.3f, 0.6f);
    make_noise(0.2f, true);
    CHECK(!is_smeared(3, light, false)); /* no albedo */
    make_noise(0.003f, true);
    CHECK(!is_smeared(3, light, true)); /* hardly any grain */
    make_noise(0.2f, true);
    make_light(1.5f, 2);
    CHECK(!is_smeared(3, light, true)); /* white */
    make_light(0.3f, 0.6f);
    for (int i = 0; i < 3 * N; i++)
        albedo[i] = i / 3 % 2 ? 0.4f : 0.6f;
    CHECK(!is_smeared(3, light, true)); /* textures */
    make_light(0.3f, 0.6f);
    for (int i = 0; i < 3 * N; i++)
        normal[i] = i / 3 % 2 ? 0.4f : 0.6f;
    CHECK(!is_smeared(3, light, true)); /* bumps */
    make_noise(0.1f, false);
    for (float period = 2.5f; period < 20; period += 0.25f) {
        make_light(0.3f, 0.6f);
        for (int i = 0; i < N; i++)
            light[i] += 0.15f * sinf((float)(i % WIDTH) * 6.2832f / period);
        CHECK(!is_smeared(3, light, true)); /* light with a pattern */
    }
}

/* One plain block less than FEWEST_BLOCKS tell nothing. */
static void few_blocks_are_chance(void)
{
    for (int n_plain = 19; n_plain <= 20; n_plain++) {
        make_light(0.3f, 0.6f);
        make_noise(0.2f, true);
        for (int i = 0; i < N; i++) {
            const int block = i / WIDTH / 8 * (WIDTH / 8) + i % WIDTH / 8;
            for (int c = 0; c < 3 && block >= n_plain; c++)
                albedo[3 * i + c] = random_of(i);
        }
        CHECK(is_smeared(3, light, true) == (n_plain == 20));
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    static const float whites[] = {1, 1 / 128.0f, 64};
    for (int i = 0; i < 3; i++) {
        white = whites[i];
        TEST(smeared_grain_is_told);
        TEST(what_cannot_be_told_is_not);
        TEST(few_blocks_are_chance);
    }
    return testing_end();
}
