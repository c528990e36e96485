/* SPDX-License-Identifier: Apache-2.0 */
/* The surface in focus, and a split diopter: each half of the picture is that of its own
 * focus. */
#include "frames.h"
#include "testing.h"

enum { SIDE = 221, MIDDLE = SIDE / 2 };

static bool testing_is_verbose;

/* Stripes, and a post before them on both sides of the middle. */
static struct frame striped(void)
{
    struct frame f = frame_make(SIDE, SIDE, 3);
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            bool is_post = abs(y - MIDDLE) < 9;
            f.depth[y * SIDE + x] = plain_depth(is_post ? -6 : 9);
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] =
                    is_post ? 0.1f : 0.5f + 0.4f * (float)(x / 5 % 2);
        }
    return f;
}

/*
 * Pixels have the focus of their own side, and what they see of the other side has it,
 * too: both halves are those of pictures of one focus. In a soft border they lie
 * between, on the line half way.
 */
static void halves_of_a_split_diopter(void)
{
    static const int methods[] = {RF_METHOD_LAYERED, RF_METHOD_VIEWS,
                                  RF_METHOD_SCATTER};
    static const double SECOND = 103, SOFT = 0.01; /* 8 px less; 3 px: two pictures */
    for (int i = 0; i < 3; i++) {
        struct frame f = striped(), one = striped(), two = striped(), soft = striped();
        struct rf_params p;
        plain_params(&p, methods[i]);
        CHECK(frame_filter(&one, &p, 2, NULL) == RF_OK);
        p.focus_distance = SECOND;
        CHECK(frame_filter(&two, &p, 2, NULL) == RF_OK);
        p.focus_distance = PLAIN_FOCUS;
        p.split_diopter = SECOND;
        p.split_softness = 0;
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        p.split_softness = SOFT;
        CHECK(frame_filter(&soft, &p, 2, NULL) == RF_OK);
        double worst = 0, beside = 0, apart = 0;
        for (int y = 0; y < SIDE; y++)
            for (int x = 0; x < SIDE; x++) {
                double a = (double)frame_at(&f, one.out, x, y)[1];
                double b = (double)frame_at(&f, two.out, x, y)[1];
                double half = (double)frame_at(&f, soft.out, x, y)[1];
                double own = x + 0.5 > SIDE / 2.0 ? b : a;
                worst = fmax(fabs((double)frame_at(&f, f.out, x, y)[1] - own), worst);
                beside = fmax(fmax(half - fmax(a, b), fmin(a, b) - half), beside);
                apart = fmax(fabs(a - b), apart);
            }
        if (testing_is_verbose)
            printf("# split diopter, method %d: halves %.1e, border %.1e of %.2f\n",
                   methods[i], worst, beside, apart);
        CHECK(apart > 0.1);
        CHECK(worst < 1e-3);
        CHECK(beside < 1e-3);
        frame_free(&f);
        frame_free(&one);
        frame_free(&two);
        frame_free(&soft);
    }
}

/* The radius that a flat depth has at a place, of the focus that `key` bends. */
static void check_focus(const char *key, double value, double shift(double x, double y))
{
    enum { W = 90, H = 60 };
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params p;
    static float depth[W * H], radius[W * H];
    plain_params(&p, RF_METHOD_LAYERED);
    CHECK(rf_params_set_number(&p, key, value, NULL) == RF_OK);
    p.split_softness = 0;
    for (int i = 0; i < W * H; i++)
        depth[i] = plain_depth(17);
    const struct rf_image in = rf_image_packed(depth, W, H, 1);
    struct rf_image out = rf_image_packed(radius, W, H, 1);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &p, W, H, NULL) == RF_OK);
    CHECK(rf_filter_coc(filter, &in, &out, NULL) == RF_OK);
    for (int y = 0; y < H; y += 7)
        for (int x = 0; x < W; x += 7)
            CHECK_NEAR(radius[y * W + x],
                       17 + 40000 * shift(x + 0.5 - W / 2.0, H / 2.0 - y - 0.5), 1e-3);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* 1/s(q) - 1/s for 10 degrees of a lens of 50 mm and 1000 px, in metres. */
static double tilted_right(double x, double y)
{
    return x * sin(3.14159265358979324 / 18) / (0.05 * 1000) + 0 * y;
}

static double tilted_up(double x, double y)
{
    return tilted_right(y, x);
}

static double curved(double x, double y)
{
    return 0.002 * (x * x + y * y) / (45 * 45 + 30 * 30);
}

static double split(double x, double y)
{
    return (x > 0 ? 1.0 / 80 - 1.0 / 100 : 0) + 0 * y;
}

static void the_surface_in_focus(void)
{
    check_focus("tilt-x", 10, tilted_right);
    check_focus("tilt-y", 10, tilted_up);
    check_focus("field-curvature", 0.002, curved);
    check_focus("split-diopter", 80, split);
}

int main(int argc, char **argv)
{
    testing_is_verbose = getenv("VERBOSE") != NULL;
    testing_begin(argc, argv);
    TEST(halves_of_a_split_diopter);
    TEST(the_surface_in_focus);
    return testing_end();
}
