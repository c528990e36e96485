/* SPDX-License-Identifier: Apache-2.0 */
/* What lies far behind a surface of rough depth does not shine through its inside. */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 256, HEIGHT = 128, WALL = 80, RIM = 44 };

/* A bright sky to the left of a grey wall, whose radius is rough by some px. */
static void draw(struct frame *f, double wall_px, double rough_px)
{
    uint32_t seed = 17;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        bool is_sky = i % WIDTH < WALL;
        double radius = wall_px + rough_px * (2 * random_unit(&seed) - 1);
        f->depth[i] = plain_depth(is_sky ? 60 : radius);
        for (int c = 0; c < 3; c++)
            f->colour[3 * i + c] = is_sky ? 5 : 0.5f;
    }
}

/* The most that a pixel farther than RIM px from the sky is off. */
static double worst(double wall_px, double rough_px)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    double most = 0;
    draw(&f, wall_px, rough_px);
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = WALL + RIM; x < WIDTH; x++)
            most = fmax(most, fabs(frame_at(&f, f.out, x, y)[1] - 0.5));
    frame_free(&f);
    return most;
}

static void no_sky_shines_through_a_rough_wall(void)
{
    static const double walls[][2] = {{0, 0.1},   {0, 0.3},    {2, 0.1},   {4, 0.1},
                                      {8, 0.02},  {16, 0.02},  {-2, 0.1},  {-8, 0.02},
                                      {-16, 0.1}, {5.5, 0.25}, {11.5, 0.2}};
    for (int i = 0; i < 11; i++) {
        double most = worst(walls[i][0], walls[i][1]);
        printf("# a wall of %.1f px, rough by %.2f px: off by %.4f\n", walls[i][0],
               walls[i][1], most);
        CHECK(most < 0.003);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(no_sky_shines_through_a_rough_wall);
    return testing_end();
}
