/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The distributions of scatter against their formulas in double: w = D(t) / sum of D
 * over the circle hypot(row, col) < r, t = (row^2 + col^2) / max(ceil(r^2), 1).
 */
#include "physics/frames.h"
#include "testing.h"

static double density(int kind, double t)
{
    return kind == RF_DISTRIBUTION_GAUSSIAN ? exp(-2 * t)
           : kind == RF_DISTRIBUTION_RING   ? 1 + 3 * pow(t, 4)
                                            : 1;
}

/* A lone lamp of radius r in the middle, the rest in focus. */
static struct frame lamp(int kind, double r_px, double light)
{
    int size = 2 * (int)ceil(r_px) + 5;
    struct frame f = frame_make(size, size, 1);
    struct rf_params params;
    plain_params(&params, RF_METHOD_SCATTER);
    params.distribution = kind;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = PLAIN_FOCUS;
    f.depth[frame_pixels(&f) / 2] = plain_depth(r_px);
    f.colour[frame_pixels(&f) / 2] = (float)light;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

static double sum_of(const struct frame *f)
{
    double sum = 0;
    for (size_t i = 0; i < frame_pixels(f); i++)
        sum += f->out[i];
    return sum;
}

static void unit_energy_at_any_radius(void)
{
    for (int kind = 0; kind <= RF_DISTRIBUTION_RING; kind++)
        for (double r = 0; r < 200; r = r * 1.21 + 0.13) {
            struct frame f = lamp(kind, r, 1e4);
            CHECK_NEAR(sum_of(&f) / 1e4, 1, 1e-5);
            frame_free(&f);
        }
}

static void every_weight_is_the_formula(void)
{
    static const double radii[] = {0.3, 1.2, 2.9, 7.4, 23.6, 70.3};
    for (int kind = 0; kind <= RF_DISTRIBUTION_RING; kind++)
        for (int k = 0; k < 6; k++) {
            double r = radii[k], m = fmax(ceil(r * r), 1), sum = 0, worst = 0;
            struct frame f = lamp(kind, r, 1);
            int c = f.width / 2;
            for (int y = 0; y < f.height; y++)
                for (int x = 0; x < f.width; x++)
                    if (hypot(x - c, y - c) < r || (x == c && y == c))
                        sum += density(kind, (pow(x - c, 2) + pow(y - c, 2)) / m);
            for (int y = 0; y < f.height; y++)
                for (int x = 0; x < f.width; x++) {
                    bool is_in = hypot(x - c, y - c) < r || (x == c && y == c);
                    double t = (pow(x - c, 2) + pow(y - c, 2)) / m;
                    double want = is_in ? density(kind, t) / sum : 0;
                    double got = *frame_at(&f, f.out, x, y);
                    worst = fmax(worst, fabs(got - want) * sum);
                }
            CHECK_NEAR(worst, 0, 3e-5); /* the table of D has 1024 steps */
            frame_free(&f);
        }
}

/* What each is there for: a soft edge, a bright rim, and the same on both sides. */
static void the_shapes_differ(void)
{
    struct frame flat = lamp(RF_DISTRIBUTION_UNIFORM, 20.5, 1);
    struct frame soft = lamp(RF_DISTRIBUTION_GAUSSIAN, 20.5, 1);
    struct frame ring = lamp(RF_DISTRIBUTION_RING, 20.5, 1);
    int c = flat.width / 2;
    CHECK_NEAR(*frame_at(&flat, flat.out, c, c) / *frame_at(&flat, flat.out, c + 20, c),
               1, 1e-6);
    CHECK_NEAR(*frame_at(&soft, soft.out, c, c) / *frame_at(&soft, soft.out, c + 20, c),
               exp(2 * 400 / 421.0), 0.01);
    CHECK_NEAR(*frame_at(&ring, ring.out, c + 20, c) / *frame_at(&ring, ring.out, c, c),
               1 + 3 * pow(400 / 421.0, 4), 0.01);
    frame_free(&flat);
    frame_free(&soft);
    frame_free(&ring);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(unit_energy_at_any_radius);
    TEST(every_weight_is_the_formula);
    TEST(the_shapes_differ);
    return testing_end();
}
