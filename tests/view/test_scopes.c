/* SPDX-License-Identifier: Apache-2.0 */
/* Histogram and waveform. */
#include <stdlib.h>

#include "pixels/scopes.h"
#include "testing.h"

enum { WIDTH = 64, HEIGHT = 32 };

static struct scopes scopes;

static void fill(uint8_t (*rgba)[4], uint8_t left, uint8_t right)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        memset(rgba[i], i % WIDTH < WIDTH / 2 ? left : right, 4);
}

static void codes_are_counted(void)
{
    static uint8_t rgba[WIDTH * HEIGHT][4];
    fill(rgba, 0, 200);
    scopes_count(&scopes, rgba[0], WIDTH, HEIGHT);
    CHECK(scopes.n == WIDTH * HEIGHT);
    for (int c = 0; c < 3; c++)
        CHECK(scopes.histogram[c][0] == scopes.n / 2 &&
              scopes.histogram[c][200] == scopes.n / 2);
    CHECK(scopes.black == 0.5 && scopes.white == 0);
    CHECK(scopes.most == scopes.n / 2); /* of 200: the ends are left out */
}

static void the_waveform_keeps_the_place(void)
{
    static uint8_t rgba[WIDTH * HEIGHT][4];
    fill(rgba, 255, 4);
    scopes_count(&scopes, rgba[0], WIDTH, HEIGHT);
    CHECK(scopes.white == 0.5);
    CHECK(scopes.waveform[0][SCOPES_LEVELS - 1] == HEIGHT);
    CHECK(scopes.waveform[0][1] == 0);
    const int right = SCOPES_COLUMNS - SCOPES_COLUMNS / WIDTH;
    CHECK(scopes.waveform[right][1] == HEIGHT);
    CHECK(scopes.most_waveform == HEIGHT);
}

static void large_pictures_are_sampled(void)
{
    enum { SIDE = 2000 };
    uint8_t *rgba = calloc((size_t)SIDE * SIDE, 4);
    scopes_count(&scopes, rgba, SIDE, SIDE);
    CHECK(scopes.n > 100000 && scopes.n <= 250000);
    CHECK(scopes.black == 1 && scopes.most == 0);
    free(rgba);
    scopes_count(&scopes, NULL, 0, 0);
    CHECK(scopes.n == 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(codes_are_counted);
    TEST(the_waveform_keeps_the_place);
    TEST(large_pictures_are_sampled);
    return testing_end();
}
