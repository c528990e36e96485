/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A bright sky seen through gaps of a wall in focus is as bright in them as everywhere:
 * it goes on behind the wall. A lamp beside the gaps stays a lamp.
 */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 160, HEIGHT = 120 };
static const float SKY = 20;

enum gaps { SLITS, HOLES, LEAVES, N_GAPS };

static bool is_open(enum gaps gaps, int x, int y)
{
    switch (gaps) {
    case SLITS:
        return x % 50 >= 20 && x % 50 < 28;
    case HOLES:
        return x % 40 >= 8 && x % 40 < 30 && y % 40 >= 10 && y % 40 < 26;
    default:
        return sin(0.31 * x) + sin(0.27 * y + 0.1 * x) > 0.4;
    }
}

/* The most that an open pixel is off, as a part of the sky's light. */
static double worst(enum gaps gaps, double sky_px)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    double most = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const bool is_sky = is_open(gaps, x, y);
            f.depth[y * WIDTH + x] = plain_depth(is_sky ? sky_px : 0);
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] = is_sky ? SKY : 0.2f;
        }
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            if (is_open(gaps, x, y)) {
                const double got = (double)frame_at(&f, f.out, x, y)[1];
                most = fmax(most, fabs(got / (double)SKY - 1));
            }
    frame_free(&f);
    return most;
}

static void a_sky_between_things_is_a_sky(void)
{
    static const double radii[] = {5, 15, 25};
    for (int gaps = 0; gaps < N_GAPS; gaps++)
        for (int i = 0; i < 3; i++) {
            const double most = worst((enum gaps)gaps, radii[i]);
            printf("# gaps %d, sky of %g px: off by %.4f\n", gaps, radii[i], most);
            CHECK(most < 0.03);
        }
}

/* Light of one pixel in a slit, all of which has its depth: cut by the wall's edges. */
static void a_lamp_in_a_gap_is_a_lamp(void)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    double sum = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const bool is_gap = x >= 70 && x < 90, is_lamp = x == 80 && y == 60;
            f.depth[y * WIDTH + x] = plain_depth(is_gap ? 20 : 0);
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] = is_lamp ? 1000 : 0;
        }
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const double got = (double)frame_at(&f, f.out, x, y)[1];
            sum += got;
            CHECK((x >= 70 && x < 90) || got < 0.001);
        }
    /* Of a disc of radius 20, the part within 10 px left and right of its middle. */
    const double inside = (2 * asin(0.5) + 2 * 0.5 * sqrt(0.75)) / 3.14159265;
    printf("# %.4f of the lamp, %.4f expected\n", sum / 1000, inside);
    CHECK_NEAR(sum / 1000, inside, 0.02);
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_sky_between_things_is_a_sky);
    TEST(a_lamp_in_a_gap_is_a_lamp);
    return testing_end();
}
