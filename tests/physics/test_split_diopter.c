/* SPDX-License-Identifier: Apache-2.0 */
/* A split diopter: each half of the picture is that of its own focus. */
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

int main(int argc, char **argv)
{
    testing_is_verbose = getenv("VERBOSE") != NULL;
    testing_begin(argc, argv);
    TEST(halves_of_a_split_diopter);
    return testing_end();
}
