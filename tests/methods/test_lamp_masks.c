/* SPDX-License-Identifier: Apache-2.0 */
/*
 * No light of a lamp falls on what stands before it in focus: neither where its depth is
 * rough, so that pixels look mixed, nor where a near post hides a strip of it. What a
 * rim leaves open of a pixel shows it.
 */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 200, HEIGHT = 120, WALL = 90, POST = 106, POST_PX = 8, LAMP = 78 };
static const double FAR_PX = 50, POST_R_PX = -20;
static const float LIGHT = 500;

struct scene {
    double rough_px; /* of the wall's radius */
    bool has_post;
};

/* A wall of many colours before a dark background with a lamp of 3 x 3 px. */
static void draw(struct frame *f, const struct scene *scene, float light)
{
    uint32_t seed = 17;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            float *c = frame_at(f, f->colour, x, y);
            const bool is_wall = x >= WALL;
            const bool is_post = scene->has_post && x >= POST && x < POST + POST_PX;
            const bool is_lamp = abs(x - LAMP) < 2 && abs(y - HEIGHT / 2) < 2;
            const double rough = scene->rough_px * (2 * random_unit(&seed) - 1);
            for (int i = 0; i < 3; i++) {
                const float tone = (float)random_unit(&seed);
                c[i] = is_post   ? 0.05f
                       : is_wall ? 0.1f + 0.5f * tone
                       : is_lamp ? light
                                 : 0.1f;
            }
            f->depth[y * WIDTH + x] = plain_depth(is_post   ? POST_R_PX
                                                  : is_wall ? rough
                                                            : FAR_PX);
        }
}

static struct frame filtered(const struct scene *scene, float light)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    draw(&f, scene, light);
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

/* The most that the lamp gives to a pixel of the wall; `disc` gets what it gives to one
 * of its disc. */
static double most_on_wall(const struct scene *scene, double *disc)
{
    struct frame with = filtered(scene, LIGHT), without = filtered(scene, 0.1f);
    double most = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = WALL + 1; x < WIDTH; x++)
            for (int i = 0; i < 3; i++)
                most = fmax(most, (double)(frame_at(&with, with.out, x, y)[i] -
                                           frame_at(&without, without.out, x, y)[i]));
    *disc = (double)frame_at(&with, with.out, LAMP - 20, HEIGHT / 2)[1];
    frame_free(&with);
    frame_free(&without);
    return most;
}

static void no_light_on_what_stands_before_a_lamp(void)
{
    static const struct scene scenes[] = {{0, false},   {0.1, false}, {0.2, false},
                                          {0.4, false}, {0, true},    {0.3, true}};
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        double disc, most = most_on_wall(&scenes[i], &disc);
        printf("# rough by %.1f px%s: %.3f on the wall, %.3f on the disc\n",
               scenes[i].rough_px, scenes[i].has_post ? ", a post before it" : "", most,
               disc);
        CHECK(most < 0.002);
        CHECK(disc > 0.4);
    }
}

/* A wall of one colour in focus before the same, its first column covered so much. */
static struct frame filtered_rim(float share, float light)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const bool is_lamp = abs(x - LAMP) < 2 && abs(y - HEIGHT / 2) < 2;
            const float part = x > WALL ? 1 : x == WALL ? share : 0;
            for (int i = 0; i < 3; i++)
                frame_at(&f, f.colour, x, y)[i] =
                    is_lamp ? light : 0.5f * part + 0.1f * (1 - part);
            f.depth[y * WIDTH + x] = plain_depth(x >= WALL ? 0 : FAR_PX);
        }
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

/* What a rim leaves open shows the lamp behind it, however little that is. */
static void lamps_shine_through_what_a_rim_leaves_open(void)
{
    static const float shares[] = {0.5f, 0.75f, 0.85f, 0.92f};
    for (size_t i = 0; i < sizeof shares / sizeof *shares; i++) {
        struct frame with = filtered_rim(shares[i], LIGHT);
        struct frame without = filtered_rim(shares[i], 0.1f);
        double lit[2];
        for (int k = 0; k < 2; k++) {
            const int x = k ? WALL : WALL - 6, y = HEIGHT / 2;
            lit[k] = (double)(frame_at(&with, with.out, x, y)[1] -
                              frame_at(&without, without.out, x, y)[1]);
        }
        printf("# a rim of %.2f shows %.3f of the lamp\n", (double)shares[i],
               lit[1] / lit[0]);
        CHECK_NEAR(lit[1] / lit[0], 1 - (double)shares[i], 0.03);
        frame_free(&with);
        frame_free(&without);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(no_light_on_what_stands_before_a_lamp);
    TEST(lamps_shine_through_what_a_rim_leaves_open);
    return testing_end();
}
