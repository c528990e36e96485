/* SPDX-License-Identifier: Apache-2.0 */
/* Lamps in clean pictures: their light is that of the samples, their shape is not. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "denoise/denoise_lamps.h"
#include "common/report.h"
#include "testing.h"

enum { WIDTH = 64, HEIGHT = 40, N = WIDTH * HEIGHT };

static const float DARK = 0.1f;

static float grainy[N], grainy_rgb[3 * N], clean[3 * N], was[3 * N];

static void fill(float luminance)
{
    for (int i = 0; i < 3 * N; i++)
        clean[i] = grainy_rgb[i] = luminance;
    for (int i = 0; i < N; i++)
        grainy[i] = luminance;
}

/* A rectangle of this colour in the samples, and of another brightness when clean. */
static void draw(int x0, int y0, int width, int height, float samples, float made)
{
    static const float COLOUR[] = {1.2f, 1, 0.4f};
    for (int y = y0; y < y0 + height; y++)
        for (int x = x0; x < x0 + width; x++)
            for (int c = 0; c < 3; c++) {
                grainy_rgb[3 * (y * WIDTH + x) + c] = COLOUR[c] * samples;
                clean[3 * (y * WIDTH + x) + c] = COLOUR[c] * made;
                grainy[y * WIDTH + x] =
                    samples * (0.2126f * COLOUR[0] + 0.7152f + 0.0722f * COLOUR[2]);
            }
}

static void scale(float by)
{
    for (int i = 0; i < N; i++)
        grainy[i] *= by;
    for (int i = 0; i < 3 * N; i++)
        grainy_rgb[i] *= by;
}

/* What the samples are multiplied by; the clean picture has a white of 1. */
static float white = 1;

static void keep(int n_channels, int n_threads)
{
    const struct denoise_picture picture = {.samples =
                                                n_channels < 3 ? grainy : grainy_rgb,
                                            .width = WIDTH,
                                            .height = HEIGHT,
                                            .n_channels = n_channels,
                                            .white = white};
    struct image_error error;
    memcpy(was, clean, sizeof was);
    scale(white);
    CHECK(denoise_keep_lamps(&picture, clean, n_threads, &error));
    scale(1 / white);
}

/* By what factor the light around a pixel has changed. */
static double light(int x0, int y0)
{
    double now = 0, before = 0;
    for (int y = y0 - 2; y <= y0 + 2; y++)
        for (int x = x0 - 2; x <= x0 + 2; x++) {
            now += (double)clean[3 * (y * WIDTH + x) + 1];
            before += (double)was[3 * (y * WIDTH + x) + 1];
        }
    return now / before;
}

static bool is_as_before(void)
{
    return !memcmp(clean, was, sizeof clean);
}

static void a_lamp_has_the_light_of_its_samples(void)
{
    static const struct {
        float samples, made;
        double least, most;
    } lamps[] = {{50, 65, 0.76, 0.78},
                 {50, 42, 1.17, 1.2},
                 {50, 120, 0.5, 0.51},
                 {80, 25, 1.9, 2}};
    for (int i = 0; i < 4; i++)
        for (int n_channels = 1; n_channels <= 3; n_channels += 2) {
            fill(DARK);
            draw(20, 20, 2, 1, lamps[i].samples, lamps[i].made);
            keep(n_channels, 1);
            CHECK(light(20, 20) >= lamps[i].least && light(20, 20) <= lamps[i].most);
        }
}

static void its_colour_and_what_lies_beside_it_stay(void)
{
    fill(DARK);
    draw(20, 20, 2, 1, 50, 60);
    keep(3, 1);
    const int i = 3 * (20 * WIDTH + 20);
    CHECK(fabsf(clean[i] / clean[i + 1] - 1.2f) < 5e-3f); /* what is around is grey */
    CHECK(fabsf(clean[i + 2] / clean[i + 1] - 0.4f) < 5e-3f);
    int n_changed = 0;
    for (int k = 0; k < 3 * N; k++)
        n_changed += clean[k] != was[k];
    CHECK(n_changed == 6);
}

static void what_was_taken_for_a_spark_stays_away(void)
{
    fill(DARK);
    draw(20, 20, 1, 1, 500, 1.5f);
    keep(3, 1);
    CHECK(is_as_before());
}

static void wide_lights_keep_what_the_denoiser_made(void)
{
    fill(DARK);
    draw(10, 5, 30, 30, 50, 60);
    keep(3, 1);
    CHECK(is_as_before());
    fill(8); /* a bright wall in grain */
    for (int i = 0; i < 3 * N; i += 21)
        grainy_rgb[i] = 100;
    keep(3, 1);
    CHECK(is_as_before());
}

/* As lamps of two pixels are in pictures of two and four times the size. */
static void larger_lamps_have_their_light_too(void)
{
    for (int size = 4; size <= 12; size += 4) {
        fill(DARK);
        draw(20, 12, size, size, 50, 60);
        keep(3, 1);
        CHECK(fabs(light(20 + size / 2, 12 + size / 2) - 50.0 / 60) < 0.01);
        CHECK(clean[3 * (10 * WIDTH + 20)] == was[3 * (10 * WIDTH + 20)]);
    }
    fill(0); /* all light in the left half of the samples: the whole counts */
    draw(20, 20, 4, 8, 100, 50);
    draw(24, 20, 4, 8, 0, 50);
    keep(3, 1);
    CHECK(fabsf(clean[3 * (24 * WIDTH + 23) + 1] / 50 - 1) < 0.02f);
}

static void each_channel_has_the_light_of_its_samples(void)
{
    fill(DARK);
    draw(20, 20, 2, 2, 50, 60);
    for (int y = 20; y < 22; y++)
        for (int x = 20; x < 22; x++) {
            clean[3 * (y * WIDTH + x)] *= 1.25f;
            clean[3 * (y * WIDTH + x) + 2] = 0;
        }
    keep(3, 1);
    const float *lamp = clean + 3 * (20 * WIDTH + 20);
    CHECK(fabsf(lamp[0] / 60 - 1) < 0.02f && fabsf(lamp[1] / 50 - 1) < 0.02f);
    CHECK(lamp[2] == 0);
    fill(0); /* a red lamp stays red */
    draw(20, 20, 2, 2, 50, 60);
    for (int i = 0; i < N; i++)
        clean[3 * i + 1] = clean[3 * i + 2] = grainy_rgb[3 * i + 1] =
            grainy_rgb[3 * i + 2] = 0;
    keep(3, 1);
    CHECK(fabsf(lamp[0] / 60 - 1) < 0.02f && lamp[1] == 0 && lamp[2] == 0);
}

static void dim_lamps_change_little_by_little(void)
{
    double last = 1;
    for (int i = 0; i <= 20; i++) {
        fill(0);
        draw(20, 20, 1, 1, 1.5f * (1.8f + 0.13f * (float)i), 1.8f + 0.13f * (float)i);
        keep(3, 1);
        const double gain = light(20, 20);
        CHECK(gain > last - 1e-5 && gain < last + 0.05);
        last = gain;
    }
    CHECK(last > 1.45 && last < 1.51);
}

static void corners_and_threads(void)
{
    static float first[3 * N];
    for (int n_threads = 1; n_threads <= 3; n_threads++) {
        fill(DARK);
        draw(0, 0, 1, 1, 40, 50);
        draw(WIDTH - 1, HEIGHT - 1, 1, 1, 40, 50);
        draw(30, 17, 1, 2, 40, 50);
        keep(3, n_threads);
        CHECK(clean[1] < 41 && clean[1] > 39.5f);
        CHECK(clean[3 * N - 2] < 41 && clean[3 * N - 2] > 39.5f);
        if (n_threads == 1)
            memcpy(first, clean, sizeof first);
        CHECK(!memcmp(first, clean, sizeof first));
    }
}

/* Four pixels wide, with a dim rim, and with samples that lie two pixels off. */
static void a_whole_lamp_is_meant(void)
{
    fill(0);
    draw(20, 20, 4, 4, 50, 60);
    keep(3, 1);
    CHECK(fabs(light(22, 22) - 50.0 / 60) < 0.01);
    fill(0);
    draw(20, 20, 1, 1, 80, 100);
    draw(21, 20, 1, 1, 3.6f, 4.5f);
    keep(3, 1);
    const int rim = 3 * (20 * WIDTH + 21);
    CHECK(fabsf(clean[rim] / was[rim] - 0.8f) < 0.01f);
    fill(0);
    draw(20, 20, 1, 1, 0, 50);
    draw(22, 22, 1, 1, 50, 0);
    keep(3, 1);
    CHECK(fabs(light(20, 20) - 1) < 0.01);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    static const float whites[] = {1, 1 / 128.0f, 64};
    for (int i = 0; i < 3; i++) {
        white = whites[i];
        TEST(a_lamp_has_the_light_of_its_samples);
        TEST(its_colour_and_what_lies_beside_it_stay);
        TEST(what_was_taken_for_a_spark_stays_away);
        TEST(wide_lights_keep_what_the_denoiser_made);
        TEST(larger_lamps_have_their_light_too);
        TEST(each_channel_has_the_light_of_its_samples);
        TEST(dim_lamps_change_little_by_little);
        TEST(a_whole_lamp_is_meant);
        TEST(corners_and_threads);
    }
    return testing_end();
}
