/* SPDX-License-Identifier: Apache-2.0 */
/* Merges with and without grain, mixed: each band by what is wrong with it. */
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "denoise/denoise_mix.h"
#include "image.h"
#include "testing.h"

enum { WIDTH = 128, HEIGHT = 96, N = WIDTH * HEIGHT * 3 };

static const double PI = 3.14159265358979323846;
static const float GREY = 0.5f, LIFT = 0.25f;

static float clean[N], grainy[N], flipped[N], was[N];
static uint32_t state;

/* Uniform, of mean 0 and this standard deviation. */
static float grain(float sigma)
{
    state = state * 1664525u + 1013904223u;
    return sigma * 3.4641f * ((float)(state >> 8) / 16777216.0f - 0.5f);
}

/* A wave of this length along both axes, of mean square 1/4. */
static float wave(int x, int y, double length)
{
    return (float)(sin(2 * PI * x / length) * sin(2 * PI * y / length));
}

/* The truth is grey; the clean merge lacks a wave, the other has grain. */
static void fill(float amplitude, double length, float sigma)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 3; c++) {
            float w = amplitude * wave(i % WIDTH, i / WIDTH, length);
            clean[3 * i + c] = GREY - w;
            grainy[3 * i + c] = GREY + grain(sigma);
            flipped[3 * i + c] = grainy[3 * i + c] + grain(sigma) + LIFT;
        }
    memcpy(was, clean, sizeof was);
}

static double error_of(const float *picture)
{
    double sum = 0;
    for (int i = 0; i < N; i++)
        sum += pow(picture[i] - GREY, 2);
    return sqrt(sum / N);
}

/* What all that is mixed is multiplied by. */
static float white = 1;

static void scale(float by)
{
    float *const pictures[] = {clean, grainy, flipped};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < N; i++)
            pictures[k][i] *= by;
}

static void mix(int n_threads)
{
    const struct denoise_merges merges = {clean,  grainy, flipped, WIDTH,
                                          HEIGHT, 3,      white,   n_threads};
    struct image_error error;
    scale(white);
    CHECK(denoise_mix(&merges, &error));
    scale(1 / white);
}

/* Grain is fine, what is missing coarse: it comes back, less than the grain does. */
static void what_is_coarse_comes_back_without_fine_grain(void)
{
    state = 1;
    fill(0.12f, 64, 0.1f);
    const double before = error_of(clean), noise = error_of(grainy);
    mix(2);
    printf("# error: clean %.4f, grainy %.4f, mixed %.4f\n", before, noise,
           error_of(clean));
    CHECK(error_of(clean) < 0.35 * before && error_of(clean) < 0.35 * noise);
}

/* Fine structure is missing and the grain is fine: nobody can tell, but by how much. */
static void what_is_fine_comes_back_where_there_is_more_of_it(void)
{
    state = 2;
    fill(0.4f, 4, 0.05f);
    const double before = error_of(clean);
    mix(2);
    CHECK(error_of(clean) < 0.4 * before);
}

static void grain_alone_stays_out(void)
{
    state = 3;
    fill(0, 16, 0.1f);
    mix(2);
    printf("# error of grain alone: %.4f of 0.1\n", error_of(clean));
    CHECK(error_of(clean) < 0.005);
}

/* A square of fine structure is missing; the grain beside it stays out. */
static void grain_stays_out_beside_what_is_missing(void)
{
    double sum = 0;
    int n = 0;
    state = 6;
    fill(0, 16, 0.05f);
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        for (int c = 0; c < 3; c++)
            if (abs(i % WIDTH - 64) < 6 && abs(i / WIDTH - 48) < 6) {
                float missing = (i + i / WIDTH) % 2 ? 0.4f : -0.4f;
                clean[3 * i + c] += missing;
            }
    mix(2);
    for (int y = 36; y < 60; y++)
        for (int x = 80; x < 86; x++, n++)
            sum += pow(clean[3 * (y * WIDTH + x)] - GREY, 2);
    printf("# error beside it: %.4f of 0.05\n", sqrt(sum / n));
    CHECK(sqrt(sum / n) < 0.01);
}

static void a_lamp_is_taken_as_it_is(void)
{
    state = 4;
    fill(0, 16, 0);
    for (int c = 0; c < 3; c++) {
        grainy[3 * (40 * WIDTH + 50) + c] = 300;
        flipped[3 * (40 * WIDTH + 50) + c] = 300 + LIFT;
    }
    mix(1);
    const float *lamp = clean + 3 * (40 * WIDTH + 50);
    CHECK(fabsf(lamp[1] - 300) < 1e-3f);
    CHECK(fabsf(lamp[1 + 3 * 4] - GREY) < 1e-3f);
}

static float from_disc(int i)
{
    return hypotf((float)(i % WIDTH) - 40, (float)(i / WIDTH) - 48);
}

/* A disc in the dark is brighter with its grain, and the grain is coarse: the finer bands
 * of the disc alone would leave a dark ring around it. */
static void a_disc_has_no_ring(void)
{
    const float dark = 0.05f, coarse = 0.3f;
    float least = 1;
    for (int i = 0; i < N; i++) {
        const float disc = fminf(fmaxf(10.5f - from_disc(i / 3), 0), 1);
        clean[i] = dark + 0.2f * disc;
        grainy[i] = dark + 0.35f * disc;
        flipped[i] = grainy[i] + coarse + LIFT;
    }
    mix(2);
    for (int i = 0; i < N; i++)
        if (from_disc(i / 3) > 12)
            least = fminf(least, clean[i]);
    printf("# least beside a disc: %.4f of %.2f\n", (double)least, (double)dark);
    CHECK(least > 0.99f * dark);
}

/* One pixel of 16 is a glint before black: with random signs alone half of them would be
 * cut at 0, and what is left would pass for more than grain. */
static void glints_are_grain(void)
{
    const float dark = 0.02f, glint = 0.8f;
    state = 7;
    for (int i = 0; i < N; i += 3) {
        const bool is_glint = grain(1) > 1.5155f;
        for (int c = 0; c < 3; c++) {
            clean[i + c] = dark + glint / 16;
            grainy[i + c] = dark + (is_glint ? glint : 0);
        }
    }
    memcpy(flipped, grainy, sizeof flipped);
    const struct denoise_picture picture = {flipped, WIDTH, HEIGHT, 3, "it", white};
    scale(white);
    denoise_flip(&picture, clean, 1);
    scale(1 / white);
    memcpy(was, clean, sizeof was);
    mix(2);
    double sum = 0;
    for (int i = 0; i < N; i++)
        sum += pow(clean[i] - was[i], 2);
    printf("# grain of glints: %.4f\n", sqrt(sum / N));
    CHECK(sqrt(sum / N) < 0.01);
}

/* A lit half has less light without its grain; that comes back, and no light of it beside
 * the half. */
static void black_stays_black_beside_light(void)
{
    double sum = 0;
    float most = 0;
    state = 8;
    for (int i = 0; i < N; i++) {
        const bool is_lit = i / 3 % WIDTH >= WIDTH / 2;
        clean[i] = is_lit ? 0.2f : 0;
        grainy[i] = is_lit ? 0.3f + grain(0.1f) : 0;
        flipped[i] = grainy[i] + LIFT + (is_lit ? grain(0.1f) : 0);
    }
    mix(2);
    for (int i = 0; i < N; i += 3) {
        const int x = i / 3 % WIDTH;
        if (x < WIDTH / 2 - 2)
            most = fmaxf(most, clean[i]);
        sum += x >= WIDTH * 3 / 4 ? clean[i] : 0;
    }
    printf("# most in black: %.6f, light: %.3f\n", (double)most,
           sum / (HEIGHT * WIDTH / 4));
    CHECK(most < 2e-4f);
    CHECK(sum / (HEIGHT * WIDTH / 4) > 0.28);
}

static void threads_do_not_matter(void)
{
    static float once[N];
    state = 5;
    fill(0.1f, 24, 0.1f);
    mix(1);
    memcpy(once, clean, sizeof once);
    memcpy(clean, was, sizeof clean);
    mix(3);
    CHECK(memcmp(once, clean, sizeof once) == 0);
}

/* Was the grain of pixel i turned round? */
static bool is_turned(int i)
{
    return (flipped[3 * i] > grainy[3 * i] + LIFT) != (grainy[3 * i] > GREY);
}

/* Grain of each pixel gets a sign of its own; what neighbours share keeps its scale. */
static void signs_are_as_wide_as_grain(void)
{
    static const float own[2] = {1, 0.6f};
    for (int k = 0; k < 2; k++) {
        float last = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            const float next = grain(0.05f), v = own[k] * next + (1 - own[k]) * last;
            last = next;
            for (int c = 0; c < 3; c++) {
                clean[3 * i + c] = GREY;
                grainy[3 * i + c] = GREY + v;
            }
        }
        memcpy(flipped, grainy, sizeof flipped);
        const struct denoise_picture picture = {flipped, WIDTH, HEIGHT, 3, "it", white};
        scale(white);
        denoise_flip(&picture, clean, 1);
        scale(1 / white);
        for (int i = 0; i < N; i++) {
            const float before = grainy[i] - GREY, now = flipped[i] - grainy[i] - LIFT;
            CHECK_NEAR(fabsf(now), fabsf(before), 1e-6);
        }
        double n = 0; /* pixels beside one of the other sign */
        for (int i = 1; i < WIDTH * HEIGHT; i++)
            n += i % WIDTH && is_turned(i) != is_turned(i - 1);
        CHECK_NEAR(n / (WIDTH * HEIGHT), k == 0 ? 0.5 : 0.5 / 4, 0.03);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    static const float whites[] = {1, 1 / 128.0f, 64};
    for (int i = 0; i < 3; i++) {
        white = whites[i];
        TEST(what_is_coarse_comes_back_without_fine_grain);
        TEST(what_is_fine_comes_back_where_there_is_more_of_it);
        TEST(grain_alone_stays_out);
        TEST(grain_stays_out_beside_what_is_missing);
        TEST(a_lamp_is_taken_as_it_is);
        TEST(a_disc_has_no_ring);
        TEST(glints_are_grain);
        TEST(black_stays_black_beside_light);
        TEST(threads_do_not_matter);
        TEST(signs_are_as_wide_as_grain);
    }
    return testing_end();
}
