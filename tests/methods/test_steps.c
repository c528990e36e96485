/* SPDX-License-Identifier: Apache-2.0 */
/* A bright sky far behind draws no lines along the steps of what stands before it. */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 160, HEIGHT = 96, SKY_END = 40, STEP = 100 };

/* From the left: sky of radius sky_px, a dark wall of wall_px, a roof of roof_px. */
static void draw(struct frame *f, double sky_px, double wall_px, double roof_px)
{
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        int x = i % WIDTH;
        f->depth[i] = plain_depth(x < SKY_END ? sky_px : x < STEP ? wall_px : roof_px);
        for (int c = 0; c < 3; c++)
            f->colour[3 * i + c] = x < SKY_END ? 1.5f : 0.01f;
    }
}

/* The most light before the step, where the wall hides the sky from all of the lens. */
static float brightest(double wall_px, double roof_px, int sub_apertures)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    float most = 0;
    draw(&f, 100, wall_px, roof_px);
    plain_params(&params, RF_METHOD_LAYERED);
    params.sub_apertures = sub_apertures;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = HEIGHT / 4; y < HEIGHT * 3 / 4; y++)
        for (int x = STEP - 20; x < STEP + 20; x++)
            most = fmaxf(most, frame_at(&f, f.out, x, y)[1]);
    frame_free(&f);
    return most;
}

static void check_steps(const double steps[][2], int n)
{
    for (int i = 0; i < n; i++)
        for (int cells = 1; cells <= 4; cells += 3) {
            float most = brightest(steps[i][0], steps[i][1], cells);
            printf(
                "# wall %.1f px, roof %.1f px, %d x %d cells: %.3f of a sky of 1.5\n",
                steps[i][0], steps[i][1], cells, cells, (double)most);
            CHECK(most < 0.06f);
        }
}

static void a_far_sky_shows_through_no_step(void)
{
    static const double steps[][2] = {{0.7, 0}, {1.5, 0}, {2.2, 0}, {4, 0}};
    check_steps(steps, 4);
}

/* Too little for the lens to look a pixel far behind them. */
static void nor_through_little_ones_out_of_focus(void)
{
    static const double steps[][2] = {{3, 2.2}, {6, 5}, {-3, -3.8}, {-6, -8}};
    check_steps(steps, 4);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_far_sky_shows_through_no_step);
    TEST(nor_through_little_ones_out_of_focus);
    return testing_end();
}
