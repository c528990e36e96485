/* SPDX-License-Identifier: Apache-2.0 */
/* What lies behind all things keeps its colour when the grain is taken out. */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "denoise/denoise_background.h"
#include "testing.h"

enum { WIDTH = 40, HEIGHT = 30, N = WIDTH * HEIGHT, EDGE = 20, N_CHANNELS = 4 };

static float grainy[N_CHANNELS * N], clean[N_CHANNELS * N], normal[3 * N];

/* Grain of a mean of 1, the same in each run. */
static float grain(int i)
{
    return 0.5f + (float)((unsigned)i * 2654435761u >> 8 & 0xffff) / 65536;
}

/* A thing on the left, all with grain, before a background of this colour; the clean
 * picture has 1 everywhere on the left, and 0.01 too much of it on the right. */
static void draw(const float *colour, float alpha, float of_grain)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const int i = y * WIDTH + x;
            const bool is_thing = x < EDGE;
            for (int c = 0; c < 3; c++) {
                const float at = 1 + of_grain * (grain(3 * i + c) - 1);
                grainy[N_CHANNELS * i + c] = is_thing ? grain(i) : colour[c] * at;
                clean[N_CHANNELS * i + c] = is_thing ? 1 : colour[c] + 0.01f;
                normal[3 * i + c] = is_thing && c == 2;
            }
            grainy[N_CHANNELS * i + 3] = clean[N_CHANNELS * i + 3] =
                is_thing ? 1 : alpha;
        }
}

static void keep(const float *normals, int n_threads)
{
    const struct denoise_picture picture = {.samples = grainy,
                                            .width = WIDTH,
                                            .height = HEIGHT,
                                            .n_channels = N_CHANNELS,
                                            .white = 1};
    const struct denoise_guides guides = {.normal = (float *)normals};
    denoise_keep_background(&picture, &guides, clean, n_threads);
}

/* Pixels that have their samples, of things or of the background. */
static int n_kept(bool of_things)
{
    int n = 0;
    for (int i = 0; i < N; i++)
        n += (i % WIDTH < EDGE) == of_things &&
             !memcmp(clean + N_CHANNELS * i, grainy + N_CHANNELS * i,
                     N_CHANNELS * sizeof(float));
    return n;
}

static const float BLACK[3], SKY[] = {0.2f, 0.4f, 0.9f};

static void a_film_without_alpha_is_black(void)
{
    draw(BLACK, 0, 0);
    keep(NULL, 1);
    CHECK(n_kept(false) == (WIDTH - EDGE) * HEIGHT && n_kept(true) == 0);
    CHECK(clean[N_CHANNELS * EDGE] == 0);
}

static void light_without_alpha_stays_clean(void)
{
    draw(SKY, 0, 1);
    keep(NULL, 1);
    CHECK(n_kept(false) == 0);
}

static void a_world_keeps_its_colour(void)
{
    const float *const colours[] = {BLACK, SKY};
    for (int i = 0; i < 2; i++) {
        draw(colours[i], 1, 0);
        keep(NULL, 1);
        CHECK(n_kept(false) == 0); /* it might be anything */
        keep(normal, 1);
        CHECK(n_kept(false) == (WIDTH - EDGE) * HEIGHT && n_kept(true) == 0);
    }
    draw(SKY, 1, 0); /* a gradient */
    for (int i = 0; i < N; i++)
        grainy[N_CHANNELS * i] *= 1 + 0.004f * (float)(i / WIDTH);
    keep(normal, 1);
    CHECK(n_kept(false) == (WIDTH - EDGE) * HEIGHT);
}

static void fog_is_denoised(void)
{
    draw(SKY, 1, 0.2f);
    keep(normal, 1);
    CHECK(n_kept(false) == 0);
    draw(BLACK, 1, 0); /* light of a lamp in few of its pixels */
    for (int y = 0; y < HEIGHT; y += 3)
        for (int x = EDGE; x < WIDTH; x += 3)
            grainy[N_CHANNELS * (y * WIDTH + x)] = 0.1f;
    keep(normal, 1);
    CHECK(n_kept(false) == 0);
}

/* Five pixels of a world among things: too few to tell. */
static void a_hole_is_denoised(void)
{
    draw(SKY, 1, 0);
    for (int i = 0; i < N; i++)
        normal[3 * i + 2] = 1;
    for (int x = EDGE; x < EDGE + 5; x++)
        normal[3 * (10 * WIDTH + x) + 2] = 0;
    keep(normal, 1);
    CHECK(n_kept(false) == 0);
}

static void threads_do_not_matter(void)
{
    static float first[N_CHANNELS * N];
    for (int n_threads = 1; n_threads <= 3; n_threads++) {
        draw(SKY, 1, 0);
        keep(normal, n_threads);
        if (n_threads == 1)
            memcpy(first, clean, sizeof first);
        CHECK(!memcmp(first, clean, sizeof first));
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_film_without_alpha_is_black);
    TEST(light_without_alpha_stays_clean);
    TEST(a_world_keeps_its_colour);
    TEST(fog_is_denoised);
    TEST(a_hole_is_denoised);
    TEST(threads_do_not_matter);
    return testing_end();
}
