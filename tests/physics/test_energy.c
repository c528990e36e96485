/* SPDX-License-Identifier: Apache-2.0 */
/* A lone emitter keeps its light, whatever the radius, the aperture, the brightness. */
#include "frames.h"
#include "testing.h"

static size_t n_methods;

/*
 * The sum of a lone emitter of the given light in a black frame, all of it at radius
 * r_px, or with everything else in focus.
 */
static double energy(struct rf_params *params, double r_px, double light,
                     bool rest_in_focus)
{
    double wide = fabs(r_px) * fmax(1, 1 / params->aperture_ratio);
    /* The rim of a dim circle is soft: layered draws it at a reduced resolution. */
    int width = 2 * (int)ceil(wide * 1.5) + 15;
    int height = 2 * (int)ceil(fabs(r_px) * 1.5) + 15;
    struct frame f = frame_make(width, height, 1);
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = rest_in_focus ? PLAIN_FOCUS : plain_depth(r_px);
    size_t centre = (size_t)(height / 2) * (size_t)width + (size_t)(width / 2);
    f.depth[centre] = plain_depth(r_px);
    f.colour[centre] = (float)light;
    struct rf_error error = {0};
    if (frame_filter(&f, params, 2, &error) != RF_OK)
        printf("# %s: %s\n", error.field, error.message);
    double sum = 0;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        sum += f.out[i];
    frame_free(&f);
    return sum / light;
}

static void check_energy(struct rf_params *params, double r_px, double light,
                         bool rest_in_focus)
{
    double sum = energy(params, r_px, light, rest_in_focus), most = 1 + 1e-5;
    /*
     * Not more than 1 px before what lies behind, no neighbour can show the background
     * that a single pixel hides: layered fills a small hole with the pixel itself, a
     * larger one from around it, where some of its light is.
     */
    if (rest_in_focus && fabs(r_px) <= 1 && params->method == RF_METHOD_LAYERED)
        most = 1.25;
    if (!testing_check(sum >= 1 - 1e-5 && sum <= most, __FILE__, __LINE__, "energy"))
        printf("#     method %d, aperture of %d blades, ratio %g, radius %g px, light "
               "%g%s: %.9f of the light is left\n",
               params->method, params->blades, params->aperture_ratio, r_px, light,
               rest_in_focus ? ", rest in focus" : "", sum);
}

static void both_sides(struct rf_params *params, double r_px, double light,
                       bool rest_in_focus)
{
    check_energy(params, r_px, light, false);
    check_energy(params, -r_px, light, false);
    /* Before the focus nothing hides an emitter from the lens. */
    if (rest_in_focus)
        check_energy(params, -r_px, light, true);
}

static void small_radii_in_fine_steps(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_params params;
        plain_params(&params, (int)m);
        for (double r = 0; r < 4; r += 0.07)
            both_sides(&params, r, 1, true);
    }
}

static void every_radius_up_to_200(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_params params;
        plain_params(&params, (int)m);
        for (int r = 0; r <= 200; r += r < 64 ? 1 : 34) { /* wide ones are slow */
            check_energy(&params, r, 1, false);
            check_energy(&params, -r, 1, true);
        }
    }
}

static void every_polygon_and_ratio(void)
{
    static const double ratios[] = {1, 0.6, 1.5, 3};
    static const double radii[] = {0.3, 1, 2.4, 7.7, 23, 61};
    for (size_t m = 0; m < n_methods; m++)
        for (int blades = 2; blades <= 16; blades++)
            for (int k = 0; k < 4; k++) {
                struct rf_params params;
                plain_params(&params, (int)m);
                params.blades = blades == 2 ? 0 : blades;
                params.blade_rotation = 13 * blades;
                params.aperture_ratio = ratios[k];
                int most = blades % 5 == 0 ? 6 : 5; /* the largest is slow */
                for (int i = 0; i < most; i++) {
                    check_energy(&params, radii[i], 1, false);
                    check_energy(&params, -radii[i], 1, true);
                }
            }
}

static void polygons_at_200(void)
{
    for (size_t m = 0; m < n_methods; m++)
        for (int blades = 3; blades <= 16; blades += 13) {
            struct rf_params params;
            plain_params(&params, (int)m);
            params.blades = blades;
            if (blades == 3)
                check_energy(&params, 200, 1, false);
            else
                check_energy(&params, -200, 1, true);
        }
}

static void highlights_at_any_brightness(void)
{
    static const double lights[] = {1e-6, 3, 50, 1e4, 1e5, 1e6};
    static const double radii[] = {0, 0.5, 1, 1.3, 2, 5, 17, 50};
    for (size_t m = 0; m < n_methods; m++)
        for (int i = 0; i < 6; i++)
            for (int k = 0; k < 8; k++) {
                struct rf_params params;
                plain_params(&params, (int)m);
                both_sides(&params, radii[k], lights[i], true);
                params.blades = 5;
                both_sides(&params, radii[k], lights[i], true);
            }
}

/* Without the layered method's extras the books must balance as well. */
static void every_setting_of_the_method(void)
{
    for (int bits = 0; bits < 16; bits++) {
        struct rf_params params;
        plain_params(&params, RF_METHOD_LAYERED);
        params.split_edges = bits & 1;
        params.fill_hidden = bits >> 1 & 1;
        params.exact_highlights = bits >> 2 & 1;
        params.sub_apertures = bits >> 3 ? 16 : 1;
        both_sides(&params, 3.3, 1, params.fill_hidden);
        both_sides(&params, 9, 1e4, params.fill_hidden);
    }
}

/* Many at once, with neighbours that overlap: the sum of a whole inner region. */
static void a_field_of_lamps(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct rf_params params;
        plain_params(&params, (int)m);
        struct frame f = frame_make(120, 90, 3);
        double before = 0, after = 0;
        for (size_t i = 0; i < frame_pixels(&f); i++)
            f.depth[i] = plain_depth(9);
        for (int y = 30; y < 60; y += 7)
            for (int x = 30; x < 90; x += 5) {
                float *c = frame_at(&f, f.colour, x, y);
                c[0] = (float)(x * y), c[1] = 1, c[2] = 2e4f;
            }
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        for (size_t i = 0; i < frame_pixels(&f) * 3; i++) {
            before += f.colour[i];
            after += f.out[i];
        }
        CHECK_NEAR(after / before, 1, 1e-5);
        frame_free(&f);
    }
}

/*
 * A slanted thing covers the left of a lamp's disc. Its pixels cast shadows of
 * different sizes, and no light may pass between them.
 */
static void a_slanted_thing_has_no_cracks(void)
{
    enum { LAMP_X = 90, LAMP_Y = 60, EDGE_X = 80, RADIUS = 20 };
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    struct frame f = frame_make(150, 120, 3);
    double light[2] = {0, 0};
    for (int y = 0; y < f.height; y++)
        for (int x = 0; x < f.width; x++)
            f.depth[y * f.width + x] =
                plain_depth(x < EDGE_X ? fmin(-12 + 0.5 * (EDGE_X - x), 15) : RADIUS);
    for (int n = 0; n < 3; n++)
        frame_at(&f, f.colour, LAMP_X, LAMP_Y)[n] = 1e4f;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = LAMP_Y - 6; y <= LAMP_Y + 6; y++)
        for (int dx = 10; dx < RADIUS - 2; dx++) {
            light[0] += frame_at(&f, f.out, LAMP_X - dx, y)[0];
            light[1] += frame_at(&f, f.out, LAMP_X + dx, y)[0];
        }
    printf("# light of a half that is covered: %g, of the other: %g\n", light[0],
           light[1]);
    CHECK(light[1] > 500);
    CHECK(light[0] < 0.001 * light[1]);
    frame_free(&f);
}

/*
 * A thing in focus stands before a window far behind it: where the lens looks past its
 * edge the window goes on, as bright as it is beside it, and not into a dark seam.
 */
static void a_bright_window_goes_on_behind_an_edge(void)
{
    enum { EDGE_X = 120, MIDDLE_Y = 90 };
    static const int radii[] = {4, 8};
    for (int i = 0; i < 2; i++) {
        struct rf_params params;
        plain_params(&params, RF_METHOD_LAYERED);
        struct frame f = frame_make(240, 180, 3);
        for (int y = 0; y < f.height; y++)
            for (int x = 0; x < f.width; x++) {
                bool is_lit = x >= EDGE_X - 50 && abs(y - MIDDLE_Y) < 25;
                f.depth[y * f.width + x] =
                    x < EDGE_X ? plain_depth(radii[i]) : PLAIN_FOCUS;
                for (int n = 0; n < 3; n++)
                    frame_at(&f, f.colour, x, y)[n] = x >= EDGE_X ? 0.03f
                                                      : is_lit    ? 40
                                                                  : 0.05f;
            }
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        for (int x = EDGE_X - 8; x < EDGE_X; x++)
            CHECK_NEAR(frame_at(&f, f.out, x, MIDDLE_Y)[1], 40, 0.8);
        CHECK_NEAR(frame_at(&f, f.out, EDGE_X, MIDDLE_Y)[1], 0.03, 1e-3);
        frame_free(&f);
    }
}

/* A sky of 40 before dark hills: as bright in the corners as in the middle. */
static void a_bright_sky_reaches_the_border(void)
{
    static const int radii[] = {3, 20};
    for (int i = 0; i < 2; i++) {
        struct rf_params params;
        plain_params(&params, RF_METHOD_LAYERED);
        struct frame f = frame_make(160, 120, 3);
        for (int y = 0; y < f.height; y++)
            for (int x = 0; x < f.width; x++) {
                f.depth[y * f.width + x] = y < 70 ? plain_depth(radii[i]) : PLAIN_FOCUS;
                for (int n = 0; n < 3; n++)
                    frame_at(&f, f.colour, x, y)[n] = y < 70 ? 40 : 0.05f;
            }
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        for (int x = 0; x < f.width; x++)
            for (int y = 0; y < 70 - radii[i] - 4; y++)
                CHECK_NEAR(frame_at(&f, f.out, x, y)[1], 40, 0.2);
        frame_free(&f);
    }
}

/* The same of a sky to the left that is narrower than it is blurred, and than the wall. */
static void a_narrow_sky_reaches_the_border(void)
{
    enum { WIDE = 60, SKY_PX = 90 };
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    struct frame f = frame_make(200, 120, 3);
    for (int y = 0; y < f.height; y++)
        for (int x = 0; x < f.width; x++) {
            f.depth[y * f.width + x] = x < WIDE ? plain_depth(SKY_PX) : PLAIN_FOCUS;
            for (int n = 0; n < 3; n++)
                frame_at(&f, f.colour, x, y)[n] = x < WIDE ? 9 : 0.05f;
        }
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int x = 0; x < WIDE - 8; x++)
        for (int y = 0; y < f.height; y++)
            CHECK_NEAR(frame_at(&f, f.out, x, y)[1], 9, 0.2);
    frame_free(&f);
}

/* What is seen of a lamp that the border cuts shines, and what continues it does not. */
static void a_lamp_at_the_border_is_no_bar(void)
{
    enum { LAMP = 5, RADIUS = 20 };
    double light[3] = {0, 0, 0};
    for (int place = 0; place < 3; place++) { /* within, beside a side, in a corner */
        struct rf_params params;
        plain_params(&params, RF_METHOD_LAYERED);
        struct frame f = frame_make(160, 120, 3);
        int x0 = place == 2 ? 0 : 80, y0 = place == 0 ? 60 : 0;
        for (int y = 0; y < f.height; y++)
            for (int x = 0; x < f.width; x++) {
                bool is_lamp = x >= x0 && x < x0 + LAMP && y >= y0 && y < y0 + LAMP;
                f.depth[y * f.width + x] = plain_depth(RADIUS);
                for (int n = 0; n < 3; n++)
                    frame_at(&f, f.colour, x, y)[n] = is_lamp ? 1000 : 0.05f;
            }
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        for (size_t i = 0; i < frame_pixels(&f); i++)
            light[place] += f.out[i * 3] - 0.05;
        frame_free(&f);
    }
    printf("# light of a lamp: %g, beside a side %g, in a corner %g\n", light[0],
           light[1], light[2]);
    CHECK_NEAR(light[0], LAMP * LAMP * 1000, 50);
    CHECK(light[1] > 0.5 * light[0] && light[1] < 0.7 * light[0]);
    CHECK(light[2] > 0.25 * light[0] && light[2] < 0.5 * light[0]);
}

/*
 * Light below 0, as colours out of gamut have it, is light: a picture of one colour stays
 * so at any radius, and a lamp keeps all of its own.
 */
static void colours_below_0_are_kept(void)
{
    enum { SIDE = 100, MIDDLE = SIDE / 2 };
    static const float colour[3] = {-0.05f, 0.5f, 0.1f}, lamp[3] = {-20, 900, 100};
    static const int methods[] = {RF_METHOD_LAYERED, RF_METHOD_VIEWS,
                                  RF_METHOD_LAYERED};
    for (int i = 0; i < 3; i++)
        for (int is_lit = 0; is_lit < 2; is_lit++) {
            struct rf_params p;
            struct frame f = frame_make(SIDE, SIDE, 3);
            plain_params(&p, methods[i]);
            p.quality = i == 2 ? RF_QUALITY_PREVIEW : RF_QUALITY_BEST;
            for (int k = 0; k < SIDE * SIDE; k++) {
                f.depth[k] = plain_depth(k % SIDE < 20 ? 0 : 12);
                for (int c = 0; c < 3; c++)
                    f.colour[3 * k + c] = colour[c];
            }
            for (int c = 0; c < 3 && is_lit; c++)
                frame_at(&f, f.colour, MIDDLE, MIDDLE)[c] += lamp[c];
            CHECK(frame_filter(&f, &p, 1, NULL) == RF_OK);
            double sum[3] = {0};
            for (int k = 0; k < SIDE * SIDE; k++)
                for (int c = 0; c < 3; c++) {
                    double more = (double)(f.out[3 * k + c] - colour[c]);
                    sum[c] += more;
                    CHECK(is_lit || fabs(more) < 1e-5);
                }
            for (int c = 0; c < 3 && is_lit && i < 2; c++)
                CHECK_NEAR(sum[c] / (double)lamp[c], 1, 0.01);
            frame_free(&f);
        }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    n_methods = n_physical_methods();
    TEST(small_radii_in_fine_steps);
    TEST(every_radius_up_to_200);
    TEST(every_polygon_and_ratio);
    TEST(polygons_at_200);
    TEST(highlights_at_any_brightness);
    TEST(every_setting_of_the_method);
    TEST(a_field_of_lamps);
    TEST(a_slanted_thing_has_no_cracks);
    TEST(a_bright_window_goes_on_behind_an_edge);
    TEST(a_bright_sky_reaches_the_border);
    TEST(a_narrow_sky_reaches_the_border);
    TEST(a_lamp_at_the_border_is_no_bar);
    TEST(colours_below_0_are_kept);
    return testing_end();
}
