/* SPDX-License-Identifier: Apache-2.0 */
/* What lies beyond the border: as if the camera had seen it, where that can be known. */
#include "frames.h"
#include "testing.h"

enum { SIDE = 240, CUT = 60, KEPT = SIDE - 2 * CUT };

/*
 * How a stalk lies in the picture: at x = at + lean y, or across, where x and y change
 * places. Half of its width grows by `growth` px per px; waves: px to both sides; bow: px
 * per px^2.
 */
struct stalk {
    double at, lean, half_width, growth, r_px;
    bool is_across;
    double waves, bow;
};

static bool is_on(const struct stalk *s, int x, int y)
{
    double along = (s->is_across ? x : y) - SIDE / 2, across = s->is_across ? y : x;
    across -= s->bow * along * along;
    return fabs(across + 0.5 - s->at - s->lean * along - s->waves * sin(along / 2)) <
           s->half_width + s->growth * along;
}

/* A dark ground behind the focus and stalks of the colour 0.8 before it. */
static struct frame make(const struct stalk *stalks, int n, int x0, int y0, int side)
{
    struct frame f = frame_make(side, side, 1);
    for (int y = 0; y < side; y++)
        for (int x = 0; x < side; x++) {
            double r_px = 9;
            for (int k = 0; k < n; k++)
                if (is_on(&stalks[k], x0 + x, y0 + y))
                    r_px = fmin(stalks[k].r_px, r_px);
            f.depth[y * side + x] = plain_depth(r_px);
            f.colour[y * side + x] = r_px < 9 ? 0.8f : 0.05f;
        }
    return f;
}

/* The largest error of a picture whose rest was not seen. */
static double error_of(const struct stalk *stalks, int n)
{
    struct rf_params p;
    struct frame whole = make(stalks, n, 0, 0, SIDE);
    struct frame cut = make(stalks, n, CUT, CUT, KEPT);
    double worst = 0;
    plain_params(&p, RF_METHOD_LAYERED);
    CHECK(frame_filter(&whole, &p, 2, NULL) == RF_OK);
    CHECK(frame_filter(&cut, &p, 2, NULL) == RF_OK);
    for (int y = 0; y < KEPT; y++)
        for (int x = 0; x < KEPT; x++)
            worst = fmax(worst,
                         fabs((double)*frame_at(&whole, whole.out, CUT + x, CUT + y) -
                              (double)*frame_at(&cut, cut.out, x, y)));
    frame_free(&whole);
    frame_free(&cut);
    return worst;
}

/* Upright ones are the measure. */
static void what_leaves_aslant_goes_on_aslant(void)
{
    const struct stalk upright[] = {{100, 0, 4, 0, -12, false, 0, 0},
                                    {100, 0, 4, 0, -12, true, 0, 0}};
    for (int k = 0; k < 2; k++) {
        double straight = error_of(&upright[k], 1);
        printf("# upright: %.4f\n", straight);
        CHECK(straight < 0.004);
        for (int lean = -9; lean <= 9; lean += 3) {
            struct stalk s = upright[k];
            s.lean = 0.1 * lean;
            double worst = error_of(&s, 1);
            printf("# leaning by %.1f: %.4f\n", s.lean, worst);
            CHECK(worst < 0.02);
        }
    }
}

/* Bark and leaves lean as a whole. */
static void what_is_rough_leans_as_a_whole(void)
{
    const struct stalk s = {105, 0.4, 6, 0, -12, false, 1.2, 0};
    double worst = error_of(&s, 1);
    printf("# rough: %.4f\n", worst);
    CHECK(worst < 0.05);
}

/* The outline of what is round goes on along its tangent. */
static void what_is_bowed_goes_on_along_its_tangent(void)
{
    const struct stalk s = {80, 0, 6, 0, -12, false, 0, 0.012};
    double worst = error_of(&s, 1);
    printf("# bowed: %.4f\n", worst);
    CHECK(worst < 0.03);
}

/* It becomes narrower or wider as it does inside. */
static void what_tapers_goes_on_to_taper(void)
{
    for (int sign = -1; sign <= 1; sign += 2) {
        struct stalk s = {SIDE / 2, 0, 14, sign * 0.15, -12, sign < 0, 0, 0};
        double worst = error_of(&s, 1);
        printf("# growing by %.2f px: %.4f\n", s.growth, worst);
        CHECK(worst < 0.02);
    }
}

/* Stalks that cross beyond the border: the nearer one hides the other. */
static void the_nearer_of_two_is_seen(void)
{
    const struct stalk two[] = {{SIDE / 2 - 36, -0.5, 4, 0, -14, false, 0, 0},
                                {SIDE / 2 + 36, 0.5, 4, 0, 4, false, 0, 0}};
    double worst = error_of(two, 2);
    printf("# crossing: %.4f\n", worst);
    CHECK(worst < 0.1);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(what_leaves_aslant_goes_on_aslant);
    TEST(what_is_rough_leans_as_a_whole);
    TEST(what_is_bowed_goes_on_along_its_tangent);
    TEST(what_tapers_goes_on_to_taper);
    TEST(the_nearer_of_two_is_seen);
    return testing_end();
}
