/* SPDX-License-Identifier: Apache-2.0 */
/* rf_look_lit_in(): what bounds say of discs of places against many of their places. */
#include <math.h>
#include <stdlib.h>

#include "lens/aperture.h"
#include "lens/look.h"
#include "testing.h"

enum { WIDTH = 640, HEIGHT = 400, N_DISCS = 4000, N_PLACES = 60 };

static unsigned long state = 1;

/* Between from and to, the same on each machine. */
static double random_in(double from, double to)
{
    state = (state * 1103515245 + 12345) & 0x7fffffff;
    return from + (to - from) * (double)(state >> 8) / (double)(0x7fffffff >> 8);
}

/* How many discs bounds decide. */
struct decided {
    int dark, lit, wrong;
};

/* Discs of all sizes around places that lenses of the look light and do not light. */
static struct decided check_discs(const struct rf_params *p, const double slope[2],
                                  double bend)
{
    struct decided decided = {0, 0, 0};
    struct rf_shape lens;
    struct rf_look look = rf_look_make(p, WIDTH, HEIGHT);
    rf_shape_init(&lens, p);
    look.slope[0] = slope[0];
    look.slope[1] = slope[1];
    look.bend = bend;
    look.most_px = 300;
    struct rf_look_limits limits = rf_look_limits_make(&look, &lens);
    for (int i = 0; i < N_DISCS; i++) {
        const double q[2] = {random_in(-0.8, 0.8), random_in(-0.5, 0.5)};
        const double r = random_in(-150, 150), away = exp(random_in(-7, -2));
        const double to[2] = {q[0] + random_in(-0.5, 0.5), q[1] + random_in(-0.5, 0.5)};
        enum rf_look_lit lit = rf_look_lit_in(&look, &limits, q, r, to, away);
        decided.dark += lit == RF_LIT_NOWHERE;
        decided.lit += lit == RF_LIT_EVERYWHERE;
        for (int k = 0; k < N_PLACES; k++) {
            double angle = random_in(0, 6.3), far = away * sqrt(random_in(0, 1)), u[2];
            const double at[2] = {to[0] + far * cos(angle), to[1] + far * sin(angle)};
            bool is_lit = rf_look_lens_point(&look, &lens, q, r, at, u);
            decided.wrong +=
                lit != RF_LIT_SOMEWHERE && is_lit != (lit == RF_LIT_EVERYWHERE);
        }
    }
    CHECK(decided.wrong == 0);
    if (getenv("VERBOSE"))
        printf("# of %d discs %d dark, %d lit\n", N_DISCS, decided.dark, decided.lit);
    return decided;
}

static const double none[2] = {0, 0};

static void a_plain_disc(void)
{
    struct rf_params p;
    rf_params_init(&p);
    struct decided decided = check_discs(&p, none, 0);
    CHECK(decided.dark > 0.3 * N_DISCS);
    CHECK(decided.lit > 0.07 * N_DISCS);
}

static void surfaces_in_focus(void)
{
    static const double slopes[][2] = {{200, 0}, {-300, 500}, {40, -2000}};
    struct rf_params p;
    rf_params_init(&p);
    for (int i = 0; i < 3; i++)
        for (int k = -1; k <= 1; k++) {
            struct decided decided = check_discs(&p, slopes[i], 150 * k);
            CHECK(decided.dark > 0.02 * N_DISCS);
            CHECK(decided.lit > 0.1 * N_DISCS);
        }
}

static void stretched_ones(void)
{
    static const double looks[][2] = {{4, 0}, {0, -0.9}, {-0.9, 4}, {2, 2}};
    struct rf_params p;
    rf_params_init(&p);
    p.blades = 5;
    p.aperture = RF_APERTURE_POLYGON;
    p.aperture_ratio = 1.6;
    for (int i = 0; i < 4; i++) {
        p.astigmatism = looks[i][0];
        p.swirl = looks[i][1];
        struct decided decided = check_discs(&p, (const double[2]){50, 90}, -40);
        CHECK(decided.dark > 0.2 * N_DISCS);
        CHECK(decided.lit > 0.005 * N_DISCS);
    }
}

/* What is cut out of the lens may be anywhere. */
static void a_cut_lens_is_lit_nowhere_for_sure(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.cat_eye = 0.7;
    p.barn_left = 0.5;
    struct decided decided = check_discs(&p, (const double[2]){50, 90}, 0);
    CHECK(decided.dark > 0.2 * N_DISCS);
    CHECK(decided.lit == 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_plain_disc);
    TEST(surfaces_in_focus);
    TEST(stretched_ones);
    TEST(a_cut_lens_is_lit_nowhere_for_sure);
    return testing_end();
}
