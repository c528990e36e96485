/* SPDX-License-Identifier: Apache-2.0 */
/* Alpha is coverage: premultiplied in, premultiplied and soft out. Layered method. */
#include "frames.h"
#include "testing.h"

enum { WIDTH = 96, HEIGHT = 80 };

/* How much of a pixel an object of radius 22 px covers, in steps of 1/16. */
static double coverage(int x, int y)
{
    int n = 0;
    for (int i = 0; i < 16; i++)
        n += hypot(x + (i % 4 + 0.5) / 4 - WIDTH / 2.0,
                   y + (i / 4 + 0.5) / 4 - HEIGHT / 2.0) < 22;
    return n / 16.0;
}

static const float object[3] = {0.75f, 0.5f, 0.125f};
static const float ground[3] = {0.125f, 0.25f, 0.5f};

/* The object at radius r_object over nothing, or over a ground at r_ground. */
static struct frame cut_out(double r_object, bool has_ground, double r_ground)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 4);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            float *c = frame_at(&f, f.colour, x, y), a = (float)coverage(x, y);
            for (int k = 0; k < 3; k++)
                c[k] = object[k] * a + (has_ground ? ground[k] * (1 - a) : 0);
            c[3] = has_ground ? 1 : a;
            float nothing = has_ground ? plain_depth(r_ground) : INFINITY;
            f.depth[y * WIDTH + x] = a > 0.5f ? plain_depth(r_object) : nothing;
        }
    return f;
}

static rf_result filter(struct frame *f)
{
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.max_radius = 30;
    return frame_filter(f, &params, 2, NULL);
}

static void check_matte(double r_px)
{
    struct frame f = cut_out(r_px, false, 0);
    REQUIRE(filter(&f) == RF_OK);
    double before = 0, after = 0, n_soft = 0;
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        const float *c = f.out + 4 * i;
        before += f.colour[4 * i + 3];
        after += c[3];
        n_soft += c[3] > 0.1 && c[3] < 0.9;
        REQUIRE(c[3] >= 0 && c[3] <= 1 + 1e-6);
        for (int k = 0; k < 3; k++) {
            /* Premultiplied: colour <= alpha, and un-premultiplied it is uniform. */
            REQUIRE(c[k] <= c[3] + 1e-6);
            if (c[3] > 0.02)
                CHECK_NEAR(c[k] / c[3], object[k], 0.01);
        }
    }
    double soft_ring = 2 * 3.14159265358979 * 22 * fabs(r_px);
    if (r_px <= 0)
        CHECK_NEAR(after / before, 1, 0.02);
    CHECK(n_soft > 0.5 * soft_ring && n_soft < 3 * soft_ring);
    frame_free(&f);
}

static void a_foreground_becomes_a_soft_matte(void)
{
    check_matte(-3);
    check_matte(-8);
    check_matte(-14);
}

static void a_background_object_does_too(void)
{
    check_matte(5);
    check_matte(12);
}

/*
 * In focus on nothing: the edge stays as sharp as it was rendered, but for the ramp of
 * the saturating sum, which takes a coverage of 0.9375 for 0.975.
 */
static void a_sharp_object_keeps_its_edge(void)
{
    struct frame f = cut_out(0, false, 0);
    REQUIRE(filter(&f) == RF_OK);
    double worst = 0;
    for (size_t i = 0; i < frame_pixels(&f) * 4; i++)
        worst = fmax(worst, fabs(f.out[i] - f.colour[i]));
    CHECK_NEAR(worst, 0, 0.04);
    frame_free(&f);
}

/* Filtered on its own and put over a sharp ground, or filtered together: the same. */
static void the_matte_composites_like_the_whole_picture(void)
{
    static const double radii[] = {-3, -8, -14};
    for (int k = 0; k < 3; k++) {
        struct frame matte = cut_out(radii[k], false, 0);
        struct frame whole = cut_out(radii[k], true, 0);
        REQUIRE(filter(&matte) == RF_OK && filter(&whole) == RF_OK);
        double worst = 0, sum = 0;
        for (size_t i = 0; i < frame_pixels(&matte); i++)
            for (int c = 0; c < 3; c++) {
                const float *m = matte.out + 4 * i;
                double over = m[c] + (1 - m[3]) * ground[c];
                double d = fabs(over - whole.out[4 * i + (size_t)c]);
                worst = fmax(worst, d);
                sum += d * d;
            }
        CHECK_NEAR(sqrt(sum / (double)frame_pixels(&matte) / 3), 0, 0.005);
        CHECK_NEAR(worst, 0, 0.04);
        frame_free(&matte);
        frame_free(&whole);
    }
}

/* One scene with alpha and without it, both filtered. */
static bool filter_both(struct frame *four, struct frame *three, int method)
{
    struct rf_params params;
    scene_params(&params, method);
    frame_fill_scene(four, 8);
    memcpy(three->depth, four->depth, frame_pixels(four) * sizeof(float));
    for (size_t i = 0; i < frame_pixels(four); i++)
        memcpy(three->colour + 3 * i, four->colour + 4 * i, 3 * sizeof(float));
    return frame_filter(four, &params, 2, NULL) == RF_OK &&
           frame_filter(three, &params, 2, NULL) == RF_OK;
}

/* Where everything is opaque, alpha stays 1 and the colour is that of three channels.
 */
static void opaque_stays_opaque(void)
{
    struct frame four = frame_make(80, 60, 4), three = frame_make(80, 60, 3);
    REQUIRE(filter_both(&four, &three, RF_METHOD_LAYERED));
    double alpha = 0, colour = 0;
    for (size_t i = 0; i < frame_pixels(&four); i++) {
        alpha = fmax(alpha, fabs(four.out[4 * i + 3] - 1));
        for (size_t c = 0; c < 3; c++)
            colour = fmax(colour, fabs(four.out[4 * i + c] - three.out[3 * i + c]) /
                                      (1 + three.out[3 * i + c]));
    }
    CHECK_NEAR(alpha, 0, 1e-5);
    CHECK_NEAR(colour, 0, 1e-5);
    frame_free(&four);
    frame_free(&three);
}

/*
 * V-Ray, Arnold and others write the light of a sky with an alpha of 0. The colours are
 * those of a sky that is opaque: no dark seam around what stands before it, whatever is
 * in focus.
 */
static void check_lit_sky(double r_object, double r_sky)
{
    struct frame f = cut_out(r_object, false, 0), opaque = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.max_radius = fmax(fabs(r_sky), 1);
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        float *c = f.colour + 4 * i;
        for (int k = 0; k < 3; k++) {
            c[k] += (1 - c[3]) * (float)(0.5 + 0.2 * k);
            opaque.colour[3 * i + (size_t)k] = c[k];
        }
        opaque.depth[i] = f.depth[i];
    }
    REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
    REQUIRE(frame_filter(&opaque, &params, 2, NULL) == RF_OK);
    double worst = 0, sum = 0;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        for (size_t k = 0; k < 3; k++) {
            double d = fabs(f.out[4 * i + k] - opaque.out[3 * i + k]);
            worst = fmax(worst, d);
            sum += d * d;
        }
    CHECK_NEAR(sqrt(sum / (double)frame_pixels(&f) / 3), 0, 0.004);
    if (!testing_check(worst < 0.06, __FILE__, __LINE__, "lit sky"))
        printf("#     object %g px, sky %g px: off by %g\n", r_object, r_sky, worst);
    frame_free(&f);
    frame_free(&opaque);
}

static void a_lit_sky_without_alpha_has_no_seam(void)
{
    check_lit_sky(0, 4);
    check_lit_sky(-4, 4);
    check_lit_sky(-9, 0.5);
    check_lit_sky(3, 12);
}

/* A thing in focus before a blurred ground: circles overlap, and alpha is no sum of them. */
static void scatter_has_no_alpha_above_one(void)
{
    struct frame four = frame_make(80, 60, 4), three = frame_make(80, 60, 3);
    struct rf_params params;
    REQUIRE(filter_both(&four, &three, RF_METHOD_SCATTER));
    double most = 0, colour = 0;
    size_t n_full = 0;
    for (size_t i = 0; i < frame_pixels(&four); i++) {
        most = fmax(most, four.out[4 * i + 3]);
        n_full += four.out[4 * i + 3] == 1;
        for (size_t c = 0; c < 3; c++)
            colour = fmax(colour, fabs(four.out[4 * i + c] - three.out[3 * i + c]));
    }
    CHECK(most == 1 && n_full > 100);
    CHECK(colour == 0);
    /* What the caller has above 1 in focus is the caller's. */
    for (size_t i = 0; i < frame_pixels(&four); i++) {
        four.depth[i] = PLAIN_FOCUS;
        four.colour[4 * i + 3] = 3;
    }
    plain_params(&params, RF_METHOD_SCATTER);
    REQUIRE(frame_filter(&four, &params, 2, NULL) == RF_OK);
    CHECK(memcmp(four.out, four.colour, frame_bytes(&four)) == 0);
    frame_free(&four);
    frame_free(&three);
}

/* Three equal channels give what one channel gives. */
static void grey_is_one_channel_of_rgb(void)
{
    struct frame grey = frame_make(80, 60, 1), rgb = frame_make(80, 60, 3);
    for (size_t m = 0; m < n_physical_methods(); m++) {
        struct rf_params params;
        scene_params(&params, (int)m);
        frame_fill_scene(&grey, 8);
        memcpy(rgb.depth, grey.depth, frame_pixels(&grey) * sizeof(float));
        for (size_t i = 0; i < frame_pixels(&grey) * 3; i++)
            rgb.colour[i] = grey.colour[i / 3];
        REQUIRE(frame_filter(&grey, &params, 2, NULL) == RF_OK);
        REQUIRE(frame_filter(&rgb, &params, 2, NULL) == RF_OK);
        double worst = 0;
        for (size_t i = 0; i < frame_pixels(&grey) * 3; i++)
            worst = fmax(worst, fabs(rgb.out[i] - grey.out[i / 3]) /
                                    (1 + fabs(grey.out[i / 3])));
        CHECK_NEAR(worst, 0, 1e-5);
    }
    frame_free(&grey);
    frame_free(&rgb);
}

/* A bar in focus whose left half has alpha `alpha` and no depth. */
static struct frame veiled_bar(float alpha, int film_depth)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 4);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 40; x < 44; x++) {
            float *c = frame_at(&f, f.colour, x, y);
            c[0] = c[1] = c[2] = c[3] = x < 42 ? alpha : 1;
        }
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = f.colour[4 * i + 3] == 1 ? PLAIN_FOCUS : INFINITY;
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.max_radius = 30;
    params.film_depth = film_depth;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

static double left_half_of(float alpha, int film_depth)
{
    struct frame f = veiled_bar(alpha, film_depth);
    double found = *frame_at(&f, f.out, 41, HEIGHT / 2);
    frame_free(&f);
    return found / alpha;
}

/* What is chosen stays sharp with its neighbour, the rest blurs like the sky. */
static void film_depth_chooses_by_alpha(void)
{
    CHECK_NEAR(left_half_of(0.7f, RF_FILM_DEPTH_SOLID), 1, 1e-3);
    CHECK_NEAR(left_half_of(0.7f, RF_FILM_DEPTH_ALL), 1, 1e-3);
    CHECK_NEAR(left_half_of(0.3f, RF_FILM_DEPTH_ALL), 1, 1e-3);
}

/*
 * Thing in focus, opaque up to x = 40, whose alpha falls to `end` `width` px on and stays
 * so, striped, before film or a sky of that light. No depth up to 0.5. A denoiser may
 * have left light, `rest`, in the three empty pixels beside it. Filtered.
 */
static struct frame rim(float end, int width, float sky, float rest, int film_depth)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 4);
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        int x = (int)(i % WIDTH);
        float to = 1 - (1 - end) * (float)(x - 40) / (float)width;
        float *c = f.colour + 4 * i;
        c[3] = fminf(fmaxf(to, end), 1);
        c[0] = c[1] = c[2] = c[3] * (x / 2 % 2 ? 1 : 0.2f) + (1 - c[3]) * sky;
        for (int k = 0; k < 3 && c[3] <= 0 && x < 43 + width; k++)
            c[k] += rest;
        f.depth[i] = c[3] > 0.5f ? PLAIN_FOCUS : INFINITY;
    }
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.max_radius = 30;
    params.film_depth = film_depth;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

static double alpha_at(int film_depth, int x, float rest)
{
    struct frame f = rim(0, 6, 0, rest, film_depth);
    double found = frame_at(&f, f.out, x, HEIGHT / 2)[3];
    frame_free(&f);
    return found;
}

/* A rim 6 px wide stays sharp with its thing. */
static void rims_take_their_depth(void)
{
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(params.film_depth == RF_FILM_DEPTH_EDGES);
    CHECK_NEAR(alpha_at(RF_FILM_DEPTH_EDGES, 45, 0), 1 / 6.0, 0.01);
    CHECK_NEAR(alpha_at(RF_FILM_DEPTH_EDGES, 50, 0), 0, 0.01);
    CHECK(alpha_at(RF_FILM_DEPTH_SOLID, 45, 0) < 0.12);
    CHECK(alpha_at(RF_FILM_DEPTH_SOLID, 50, 0) > 0.02);
}

/* What a denoiser left beside it is no sky: beyond that there is nothing. */
static void rims_beside_a_denoisers_rest_do_too(void)
{
    CHECK_NEAR(alpha_at(RF_FILM_DEPTH_EDGES, 45, 0.05f), 1 / 6.0, 0.01);
    CHECK_NEAR(alpha_at(RF_FILM_DEPTH_EDGES, 50, 0.05f), 0, 0.01);
}

static bool is_kept(float end, int width, float sky, int film_depth)
{
    struct frame kept = rim(end, width, sky, 0, RF_FILM_DEPTH_KEEP);
    struct frame f = rim(end, width, sky, 0, film_depth);
    bool is_same = !memcmp(f.out, kept.out, frame_bytes(&f));
    frame_free(&f);
    frame_free(&kept);
    return is_same;
}

/* A veil goes on from the thing; a sky that is seen where alpha is 0 is seen through the
 * rim, too. */
static void veils_and_skies_take_none(void)
{
    CHECK(is_kept(0.3f, 6, 0, RF_FILM_DEPTH_EDGES));
    CHECK(!is_kept(0.3f, 6, 0, RF_FILM_DEPTH_ALL));
    CHECK(is_kept(0, 6, 0.5f, RF_FILM_DEPTH_EDGES));
    CHECK(is_kept(0, 2, 0.5f, RF_FILM_DEPTH_ALL));
    CHECK(!is_kept(0, 2, 0, RF_FILM_DEPTH_ALL));
}

/* The sky of an opaque film has no depth either, and keeps none. */
static void the_sky_is_no_veil(void)
{
    struct frame a = cut_out(0, true, 0);
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.max_radius = 30;
    for (size_t i = 0; i < frame_pixels(&a); i++)
        if (a.depth[i] != a.depth[0])
            a.depth[i] = INFINITY;
    struct frame b = a;
    b.out = calloc(frame_pixels(&a) * 4, sizeof(float));
    REQUIRE(b.out);
    params.film_depth = RF_FILM_DEPTH_ALL;
    CHECK(frame_filter(&a, &params, 2, NULL) == RF_OK);
    params.film_depth = RF_FILM_DEPTH_KEEP;
    CHECK(frame_filter(&b, &params, 2, NULL) == RF_OK);
    CHECK(!memcmp(a.out, b.out, frame_bytes(&a)));
    free(b.out);
    frame_free(&a);
}

/*
 * A box of a luminous front whose dark top is seen as a sliver, in focus before nothing: the
 * sliver's pixels are parts by their alpha, no fringes of the front's light. As fringes they
 * left the sliver's radius behind them, and light in the row above it: 0.05 of 1.2.
 */
static void a_sliver_beside_light_is_no_fringe(void)
{
    static const float light[] = {0.015f, 0.24f, 1.2f}, alpha[] = {0.2f, 0.94f, 1};
    struct frame f = frame_make(WIDTH, HEIGHT, 4);
    enum { TOP = HEIGHT / 2 };
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            int row = y - TOP > 2 ? 2 : y - TOP;
            float *c = frame_at(&f, f.colour, x, y);
            for (int k = 0; k < 3 && row >= 0; k++)
                c[k] = light[row];
            c[3] = row < 0 ? 0 : alpha[row];
            f.depth[y * WIDTH + x] =
                row < 1 ? INFINITY : plain_depth(row == 1 ? 0.19 : 0.1);
        }
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.max_radius = 3;
    REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = TOP - 3; y < TOP; y++)
        CHECK((double)*frame_at(&f, f.out, WIDTH / 2, y) < 0.005);
    CHECK_NEAR((double)*frame_at(&f, f.out, WIDTH / 2, TOP), 0.015, 0.01);
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_foreground_becomes_a_soft_matte);
    TEST(a_background_object_does_too);
    TEST(a_sharp_object_keeps_its_edge);
    TEST(the_matte_composites_like_the_whole_picture);
    TEST(opaque_stays_opaque);
    TEST(a_lit_sky_without_alpha_has_no_seam);
    TEST(scatter_has_no_alpha_above_one);
    TEST(grey_is_one_channel_of_rgb);
    TEST(film_depth_chooses_by_alpha);
    TEST(rims_take_their_depth);
    TEST(rims_beside_a_denoisers_rest_do_too);
    TEST(veils_and_skies_take_none);
    TEST(the_sky_is_no_veil);
    TEST(a_sliver_beside_light_is_no_fringe);
    return testing_end();
}
