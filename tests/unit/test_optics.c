/* SPDX-License-Identifier: Apache-2.0 */
#include "rackfocus/rackfocus.h"
#include "testing.h"

static struct rf_lens lens_of(const struct rf_params *params, int width, int height)
{
    struct rf_lens lens;
    struct rf_error error = {0};
    memset(&lens, 0, sizeof lens);
    if (!testing_check(rf_lens_init(&lens, params, width, height, &error) == RF_OK,
                       __FILE__, __LINE__, "rf_lens_init"))
        printf("#     %s: %s\n", error.field, error.message);
    return lens;
}

static void check_error(const struct rf_params *params, const char *field)
{
    struct rf_lens lens;
    struct rf_error error = {0};
    CHECK(rf_lens_init(&lens, params, 640, 480, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, field);
    CHECK(strlen(error.message) > 20);
}

/* Cycles: R = focal_mm 1e-3 / (2 f-stop) scene units, f_px = W f / S. */
static void cg_camera_as_cycles(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.focal_length = 85;
    p.f_stop = 1.4;
    p.focus_distance = 5;
    struct rf_lens lens = lens_of(&p, 1920, 1080);
    double radius = 0.085 / 2.8, f_px = 1920 * 85 / 36.0;
    CHECK_NEAR(lens.lens_radius, radius, 1e-15);
    CHECK_NEAR(lens.focal_length_px, f_px, 1e-9);
    CHECK_NEAR(rf_lens_radius_px(&lens, 8), radius * f_px * (1 / 5.0 - 1 / 8.0), 1e-10);
    CHECK_NEAR(rf_lens_radius_px(&lens, 3), radius * f_px * (1 / 5.0 - 1 / 3.0), 1e-10);
    CHECK_NEAR(rf_lens_radius_px(&lens, INFINITY), radius * f_px / 5, 1e-10);
    CHECK_NEAR(rf_lens_radius_px(&lens, 5), 0, 1e-12);
    CHECK(rf_lens_radius_px(&lens, 4.9) < 0 && rf_lens_radius_px(&lens, 5.1) > 0);
}

/* A picture of POV-Ray: radius aperture / 4 and the focal length in px are given. */
static void lens_in_scene_units_and_px(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.lens_radius = 0.4 / 4;
    p.focal_length_px = 777;
    p.focus_distance = 12;
    struct rf_lens lens = lens_of(&p, 640, 480);
    CHECK_NEAR(rf_lens_radius_px(&lens, 30), 0.1 * 777 * (1 / 12.0 - 1 / 30.0), 1e-12);
    p.f_stop = 22; /* has nothing to say any more */
    p.focal_length = 11;
    lens = lens_of(&p, 640, 480);
    CHECK_NEAR(rf_lens_radius_px(&lens, 30), 0.1 * 777 * (1 / 12.0 - 1 / 30.0), 1e-12);
}

static double focal_px(int fit, int width, int height, double aspect)
{
    struct rf_params p;
    rf_params_init(&p);
    p.sensor_fit = fit;
    p.sensor_width = 40;
    p.sensor_height = 20;
    p.pixel_aspect = aspect;
    return lens_of(&p, width, height).focal_length_px;
}

static void sensor_fits(void)
{
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_AUTO, 800, 600, 1), 800 * 50 / 40.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_AUTO, 600, 800, 1), 800 * 50 / 40.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_AUTO, 600, 600, 1), 600 * 50 / 40.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_HORIZONTAL, 600, 800, 1), 600 * 50 / 40.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_HORIZONTAL, 800, 600, 1), 800 * 50 / 40.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_VERTICAL, 800, 600, 1), 600 * 50 / 20.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_VERTICAL, 600, 800, 1), 800 * 50 / 20.0, 1e-9);
}

/* Pixels twice as wide as high: 800 x 600 of them are as high as 300 of their widths.
 */
static void pixel_aspect_counts_in_pixel_widths(void)
{
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_HORIZONTAL, 800, 600, 2), 1000, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_AUTO, 800, 600, 2), 1000, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_AUTO, 800, 600, 0.5), 1200 * 50 / 40.0, 1e-9);
    CHECK_NEAR(focal_px(RF_SENSOR_FIT_VERTICAL, 800, 600, 2), 300 * 50 / 20.0, 1e-9);
}

static void unit_scale_converts_the_lens(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.unit_scale = 100; /* the scene is in centimetres */
    struct rf_lens lens = lens_of(&p, 640, 480);
    CHECK_NEAR(lens.focal_length, 5, 1e-12);
    CHECK_NEAR(lens.lens_radius, 5 / 5.6, 1e-12);
}

static void shift_moves_the_principal_point(void)
{
    struct rf_params p;
    rf_params_init(&p);
    struct rf_lens lens = lens_of(&p, 640, 480);
    CHECK(lens.principal_px[0] == 320 && lens.principal_px[1] == 240);
    p.shift_x = 0.25; /* the camera looks to the right: its axis moves left */
    p.shift_y = 0.125;
    lens = lens_of(&p, 640, 480);
    CHECK_NEAR(lens.principal_px[0], 320 - 160, 1e-9);
    CHECK_NEAR(lens.principal_px[1], 240 + 80, 1e-9);
}

static void radii_are_clipped(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.lens_radius = 100;
    struct rf_lens lens = lens_of(&p, 640, 480);
    CHECK(lens.max_radius_px == 320);
    CHECK(rf_lens_radius_px(&lens, 1e-3) == -320);
    CHECK(rf_lens_radius_px(&lens, 1e6) == 320);
    lens = lens_of(&p, 480, 640);
    CHECK(lens.max_radius_px == 320);
    p.max_radius = 7.5;
    lens = lens_of(&p, 640, 480);
    CHECK(rf_lens_radius_px(&lens, 1e-3) == -7.5);
    CHECK(rf_lens_radius_px(&lens, INFINITY) == 7.5);
}

static void depth_at_inverts_the_radius(void)
{
    for (int optics = 0; optics < RF_OPTICS_BUFFER; optics++)
        for (int projection = 0; projection < 2; projection++) {
            struct rf_params p;
            rf_params_init(&p);
            p.optics = optics;
            p.projection = projection;
            struct rf_lens lens = lens_of(&p, 1920, 1080);
            for (double z = 0.5; z < 1e4; z *= 1.7) {
                double r = rf_lens_radius_px(&lens, z);
                if (fabs(r) < lens.max_radius_px)
                    CHECK_NEAR(rf_lens_depth_at(&lens, r), z, 1e-6 * z * z);
            }
        }
}

static void check_limits(const struct rf_params *p)
{
    struct rf_lens lens = lens_of(p, 1920, 1080);
    double near_limit, far_limit;
    rf_lens_depth_of_field(&lens, &near_limit, &far_limit);
    CHECK(near_limit > 0 && near_limit < lens.focus_distance);
    CHECK(far_limit > lens.focus_distance);
    CHECK_NEAR(rf_lens_radius_px(&lens, near_limit), -p->coc_limit, 1e-9);
    CHECK(fabs(rf_lens_radius_px(&lens, near_limit * 1.001)) < p->coc_limit);
    CHECK(fabs(rf_lens_radius_px(&lens, near_limit * 0.999)) > p->coc_limit);
    if (isinf(far_limit)) {
        CHECK(rf_lens_radius_px(&lens, 1e30) <= p->coc_limit * (1 + 1e-9));
        return;
    }
    CHECK_NEAR(rf_lens_radius_px(&lens, far_limit), p->coc_limit, 1e-9);
    CHECK(fabs(rf_lens_radius_px(&lens, far_limit * 0.999)) < p->coc_limit);
    CHECK(fabs(rf_lens_radius_px(&lens, far_limit * 1.001)) > p->coc_limit);
}

static void near_and_far_limit(void)
{
    for (int optics = 0; optics < RF_OPTICS_BUFFER; optics++)
        for (int projection = 0; projection < 2; projection++)
            for (double s = 0.2; s < 1e5; s *= 3)
                for (double limit = 0.1; limit < 3; limit *= 3) {
                    struct rf_params p;
                    rf_params_init(&p);
                    p.optics = optics;
                    p.projection = projection;
                    p.focus_distance = s;
                    p.coc_limit = limit;
                    check_limits(&p);
                }
}

/* Focused there, infinity is just sharp; a little closer it is not. */
static void hyperfocal_distance(void)
{
    for (int optics = 0; optics < RF_OPTICS_BUFFER; optics++) {
        struct rf_params p;
        rf_params_init(&p);
        p.optics = optics;
        p.coc_limit = 0.75;
        struct rf_lens lens = lens_of(&p, 1920, 1080);
        double h = rf_lens_hyperfocal(&lens), near_limit, far_limit;
        CHECK(isfinite(h) && h > 0);
        p.focus_distance = h;
        lens = lens_of(&p, 1920, 1080);
        CHECK_NEAR(rf_lens_radius_px(&lens, INFINITY), 0.75, 1e-9);
        CHECK_NEAR(rf_lens_hyperfocal(&lens), h, 1e-9 * h);
        rf_lens_depth_of_field(&lens, &near_limit, &far_limit);
        /* Half of it for the camera, nearly so for a real lens. */
        CHECK_NEAR(near_limit, h / 2, 0.01 * h);
        p.focus_distance = h * 1.0001;
        lens = lens_of(&p, 1920, 1080);
        rf_lens_depth_of_field(&lens, &near_limit, &far_limit);
        CHECK(isinf(far_limit));
        p.focus_distance = h * 0.9999;
        lens = lens_of(&p, 1920, 1080);
        rf_lens_depth_of_field(&lens, &near_limit, &far_limit);
        CHECK(isfinite(far_limit) && far_limit > 1000 * h);
    }
}

/* A textbook: f 50 mm, N 2.8, circle of 0.03 mm: H = f + f^2 / (N c) = 29.812 m. */
static void hyperfocal_as_in_textbooks(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.optics = RF_OPTICS_LENS;
    p.coc_limit = 0.015 * 1920 / 36; /* the radius, in px of the sensor */
    struct rf_lens lens = lens_of(&p, 1920, 1280);
    CHECK_NEAR(rf_lens_hyperfocal(&lens), 0.05 + 0.05 * 0.05 / (2.8 * 0.03e-3), 1e-9);
}

/* Orthographic in Cycles: R = 1 / (2 N), r = R (W / scale) (z - s) / s. */
static void orthographic(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.projection = RF_PROJECTION_ORTHOGRAPHIC;
    p.ortho_scale = 8;
    p.f_stop = 0.5;
    p.focus_distance = 4;
    struct rf_lens lens = lens_of(&p, 1600, 900);
    CHECK_NEAR(lens.lens_radius, 1, 1e-15);
    for (double z = 0; z < 8; z += 0.7)
        CHECK_NEAR(rf_lens_radius_px(&lens, z), 200 * (z - 4) / 4, 1e-10);
    CHECK(rf_lens_radius_px(&lens, INFINITY) == 800);
    CHECK(isinf(rf_lens_hyperfocal(&lens)));
    lens = lens_of(&p, 900, 1600);
    CHECK_NEAR(lens.px_per_unit, 200, 1e-12);
    p.lens_radius = 0.25;
    lens = lens_of(&p, 1600, 900);
    CHECK_NEAR(rf_lens_radius_px(&lens, 6), 0.25 * 200 * 2 / 4, 1e-10);
}

static void screen_position(void)
{
    for (double f = 0.01; f < 1; f *= 2.3)
        for (double d = f * 1.01; d < 100; d *= 1.9) {
            double s = rf_screen_position(f, d);
            CHECK_NEAR(1 / s + 1 / d, 1 / f, 1e-9 / f);
        }
    CHECK(isnan(rf_screen_position(0.05, 0.05)));
    CHECK(isnan(rf_screen_position(0.05, 0.01)));
    struct rf_params p;
    rf_params_init(&p);
    p.optics = RF_OPTICS_LENS;
    struct rf_lens lens = lens_of(&p, 640, 480);
    CHECK_NEAR(lens.screen_position, rf_screen_position(0.05, 10), 1e-15);
}

/* Yu with the screen given: the sharp distance follows from it. */
static void yu_focuses_by_the_screen(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.optics = RF_OPTICS_YU;
    p.screen_position = 0.051;
    p.aperture_coefficient = 900;
    struct rf_lens lens = lens_of(&p, 640, 480);
    CHECK_NEAR(lens.focus_distance, 0.051 * 0.05 / 0.001, 1e-12);
    CHECK_NEAR(rf_lens_radius_px(&lens, lens.focus_distance), 0, 1e-10);
    for (double d = 1; d < 100; d *= 1.4)
        CHECK_NEAR(2 * fabs(rf_lens_radius_px(&lens, d)),
                   fabs(900 * (0.051 * (1 / 0.05 - 1 / d) - 1)), 1e-10);
}

static void conflicts_name_the_field(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.optics = RF_OPTICS_LENS;
    p.focus_distance = 0.04;
    check_error(&p, "focus_distance");
    p.focus_distance = 0.05;
    check_error(&p, "focus_distance");
    p.optics = RF_OPTICS_YU;
    check_error(&p, "focus_distance");
    p.focus_distance = 10;
    p.screen_position = 0.05;
    check_error(&p, "screen_position");
    rf_params_init(&p);
    p.optics = RF_OPTICS_BUFFER;
    check_error(&p, "depth");
    p.depth = RF_DEPTH_BUFFER;
    p.projection = RF_PROJECTION_ORTHOGRAPHIC;
    check_error(&p, "optics");
    rf_params_init(&p);
    p.depth = RF_DEPTH_BUFFER;
    p.depth_far = p.depth_near;
    check_error(&p, "depth_far");
    p.depth = RF_DEPTH_NORMALISED;
    check_error(&p, "depth_far");
    rf_params_init(&p);
    p.depth = RF_DEPTH_BUFFER_INFINITE;
    p.depth_near = 0;
    check_error(&p, "depth_near");
    rf_params_init(&p);
    p.depth_scale = 0;
    check_error(&p, "depth_scale");
    rf_params_init(&p);
    p.f_stop = 0;
    check_error(&p, "f_stop");
    p.f_stop = NAN;
    check_error(&p, "f_stop");
}

static void missing_pointers(void)
{
    struct rf_params p;
    struct rf_lens lens;
    struct rf_error error = {0};
    rf_params_init(&p);
    CHECK(rf_lens_init(NULL, &p, 64, 48, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "lens");
    CHECK(rf_lens_init(&lens, NULL, 64, 48, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "params");
    CHECK(rf_lens_init(&lens, NULL, 64, 48, NULL) == RF_ERROR_ARGUMENT);
}

static void no_picture_has_no_lens(void)
{
    static const int sizes[][2] = {{0, 0}, {0, 30}, {40, 0}, {-1, 30}, {40, 65536}};
    for (int i = 0; i < 5; i++) {
        struct rf_params params;
        struct rf_lens lens = {.scale = 7};
        struct rf_error error = {0};
        rf_params_init(&params);
        CHECK(rf_lens_init(&lens, &params, sizes[i][0], sizes[i][1], &error) ==
              RF_ERROR_ARGUMENT);
        CHECK_STR(error.field, sizes[i][0] < 1 ? "width" : "height");
        CHECK_CONTAINS(error.message, "1 to 65535");
        CHECK(lens.scale == 7);
    }
}

static void nan_stays_nan(void)
{
    for (int projection = 0; projection < 2; projection++) {
        struct rf_params params;
        struct rf_lens lens;
        rf_params_init(&params);
        params.projection = projection;
        REQUIRE(rf_lens_init(&lens, &params, 40, 30, NULL) == RF_OK);
        CHECK(isnan(rf_lens_radius_px(&lens, NAN)));
        CHECK(isnan(rf_lens_depth_at(&lens, NAN)));
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(cg_camera_as_cycles);
    TEST(lens_in_scene_units_and_px);
    TEST(sensor_fits);
    TEST(pixel_aspect_counts_in_pixel_widths);
    TEST(unit_scale_converts_the_lens);
    TEST(shift_moves_the_principal_point);
    TEST(radii_are_clipped);
    TEST(depth_at_inverts_the_radius);
    TEST(near_and_far_limit);
    TEST(hyperfocal_distance);
    TEST(hyperfocal_as_in_textbooks);
    TEST(orthographic);
    TEST(screen_position);
    TEST(yu_focuses_by_the_screen);
    TEST(conflicts_name_the_field);
    TEST(missing_pointers);
    TEST(no_picture_has_no_lens);
    TEST(nan_stays_nan);
    return testing_end();
}
