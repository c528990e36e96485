/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A straight edge near the focus, before an even ground of another radius: what lies behind
 * the focus, too, is not seen through it. The lens sees the ground beyond the edge's own blur
 * only, whatever the ground's, so that a pixel has the share of the disc's area, of radius
 * abs(r) about it, that lies beyond the edge.
 */
#include "frames.h"
#include "testing.h"

enum { WIDTH = 96, HEIGHT = 32, EDGE = 48, AROUND = 4 };

/* Of a row's pixels, how the one at the edge is shown: whole, or half of it is the ground's,
 * with the depth of one or the other. */
enum mixed { WHOLE, HALF_NEAR, HALF_FAR, N_MIXED };

/* The part of a disc of radius r about 0 that lies below x. */
static double part_below(double x, double r)
{
    double t = fmin(fmax(x / r, -1), 1);
    return 0.5 + (t * sqrt(1 - t * t) + asin(t)) / acos(-1);
}

/* How much of pixel x shows the ground: the mean over its width. */
static double ground_at(int x, double r, enum mixed mixed)
{
    enum { N = 200 };
    double edge = EDGE + (mixed == WHOLE ? 0 : 0.5), sum = 0;
    for (int i = 0; i < N; i++)
        sum += part_below(x + (i + 0.5) / N - edge, fabs(r));
    return sum / N;
}

/* Root of the mean square, of the contrast, in the pixels around the edge; the colours are
 * those of a display times `light`. */
static double error_of(double near_px, double far_px, enum mixed mixed, float light)
{
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const bool is_mixed = x == EDGE && mixed != WHOLE;
            const bool is_near = is_mixed ? mixed == HALF_NEAR : x < EDGE;
            const float ground = is_mixed ? 0.5f : x < EDGE ? 0 : 1;
            float *rgb = frame_at(&f, f.colour, x, y);
            rgb[0] = light * (0.9f - 0.8f * ground);
            rgb[1] = light * (0.1f + 0.8f * ground);
            rgb[2] = light * 0.5f;
            f.depth[y * WIDTH + x] = plain_depth(is_near ? near_px : far_px);
        }
    CHECK(frame_filter(&f, &params, 1, NULL) == RF_OK);
    double sum = 0;
    for (int x = EDGE - AROUND; x <= EDGE + AROUND; x++) {
        double found = (*(frame_at(&f, f.out, x, HEIGHT / 2) + 1) / light - 0.1) / 0.8;
        double off = found - ground_at(x, near_px, mixed);
        sum += off * off;
    }
    frame_free(&f);
    return sqrt(sum / (2 * AROUND + 1));
}

/* With bins of 2 px alone 0.065, with pixels closed across steps of up to 1.5 px 0.063, with
 * both 0.072; now 0.024. */
static void edges_near_the_focus_hide_what_is_behind(void)
{
    static const double near[] = {-1.2, -0.8, -0.4, -0.2, 0.1, 0.2, 0.3, 0.45};
    static const double behind[] = {1.1, 1.5, 1.9, 3, 5};
    double worst = 0;
    for (size_t i = 0; i < sizeof near / sizeof *near; i++)
        for (size_t k = 0; k < sizeof behind / sizeof *behind; k++)
            for (int mixed = 0; mixed < N_MIXED; mixed++)
                worst = fmax(worst, error_of(near[i], near[i] + behind[k], mixed, 1));
    printf("# worst: %.4f\n", worst);
    CHECK(worst < 0.03);
}

/* Of a pixel's two parts the far one is not seen through the pixels beside it: the worst was
 * 0.051 where both were added up. */
static void parts_behind_the_focus_hide_each_other(void)
{
    static const double near[] = {0.3, 0.55, 0.6, 0.8, 1};
    static const double behind[] = {0.7, 0.8, 1, 1.2};
    double worst = 0;
    for (size_t i = 0; i < sizeof near / sizeof *near; i++)
        for (size_t k = 0; k < sizeof behind / sizeof *behind; k++)
            for (int mixed = HALF_NEAR; mixed <= HALF_FAR; mixed++)
                worst = fmax(worst, error_of(near[i], near[i] + behind[k], mixed, 1));
    printf("# worst: %.4f\n", worst);
    CHECK(worst < 0.03);
}

/* Steps that are smaller are edges beside bright things, of which more is seen: the worst was
 * 0.048 of their contrast. */
static void bright_things_have_edges_at_small_steps(void)
{
    static const double near[] = {0.1, 0.3, 0.55, 0.8, 1};
    double worst = 0;
    for (size_t i = 0; i < sizeof near / sizeof *near; i++)
        for (int mixed = HALF_NEAR; mixed <= HALF_FAR; mixed++)
            worst = fmax(worst, error_of(near[i], near[i] + 0.5, mixed, 2));
    printf("# worst: %.4f\n", worst);
    CHECK(worst < 0.03);
}

/* A dark thing in focus with a light rim of one pixel, before an even ground far behind; of
 * the rim pixel (x, y) only a part shows, and its depth is the ground's. */
enum { SIZE = 48, LEFT = 16, RIGHT = 31 };

static struct frame rimmed(int x, int y, float share)
{
    struct frame f = frame_make(SIZE, SIZE, 3);
    for (int i = 0; i < SIZE * SIZE; i++) {
        int px = i % SIZE, py = i / SIZE;
        bool is_near = px >= LEFT && px <= RIGHT && py >= LEFT;
        bool is_rim = is_near && (px == LEFT || px == RIGHT || py == LEFT);
        float light = !is_near ? 0.05f : is_rim ? 0.3f : 0.09f;
        if (px == x && py == y)
            light = 0.05f + share * (0.3f - 0.05f);
        for (int k = 0; k < 3; k++)
            f.colour[3 * i + k] = light;
        f.depth[i] = plain_depth(is_near && (px != x || py != y) ? 0.2 : 3);
    }
    return f;
}

/* Blurred as the ground it left a dark dot: 0.08 of 0.25. */
static void a_rim_keeps_what_the_depth_missed(void)
{
    static const float shares[] = {0.6f, 0.8f, 1};
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    for (int i = 0; i < 3; i++) {
        struct frame f = rimmed(RIGHT, 30, shares[i]);
        CHECK(frame_filter(&f, &params, 1, NULL) == RF_OK);
        CHECK_NEAR((double)*frame_at(&f, f.out, RIGHT, 30),
                   (double)*frame_at(&f, f.colour, RIGHT, 30), 0.02);
        frame_free(&f);
    }
}

/* A pixel that is 96 % of a black thing in focus shows 4 % of the ground; it was black. */
static void a_dark_edge_keeps_the_light_behind_it(void)
{
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    struct frame f = frame_make(SIZE, SIZE, 3);
    for (int i = 0; i < SIZE * SIZE; i++) {
        int x = i % SIZE;
        for (int k = 0; k < 3; k++)
            f.colour[3 * i + k] = x < LEFT ? 0 : x == LEFT ? 0.04f : 1;
        f.depth[i] = plain_depth(x <= LEFT ? 0.1 : 3);
    }
    CHECK(frame_filter(&f, &params, 1, NULL) == RF_OK);
    CHECK_NEAR((double)*frame_at(&f, f.out, LEFT, SIZE / 2), 0.04, 0.01);
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(edges_near_the_focus_hide_what_is_behind);
    TEST(parts_behind_the_focus_hide_each_other);
    TEST(bright_things_have_edges_at_small_steps);
    TEST(a_rim_keeps_what_the_depth_missed);
    TEST(a_dark_edge_keeps_the_light_behind_it);
    return testing_end();
}
