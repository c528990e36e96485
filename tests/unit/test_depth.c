/* SPDX-License-Identifier: Apache-2.0 */
/* Every convention of depth: there and back, nothing hit, and what is no depth. */
#include <stdlib.h>

#include "rackfocus/rackfocus.h"
#include "testing.h"

enum { WIDTH = 8, HEIGHT = 5, N = WIDTH * HEIGHT };

static rf_result convert(const struct rf_params *params, const float *depth,
                         float *planar, float *radius, struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    rf_result result = rf_context_create(&context, NULL, error);
    if (result != RF_OK)
        return result;
    result = rf_filter_create(&filter, context, params, WIDTH, HEIGHT, error);
    if (result == RF_OK) {
        struct rf_image in = rf_image_packed((float *)depth, WIDTH, HEIGHT, 1);
        struct rf_image to = rf_image_packed(planar, WIDTH, HEIGHT, 1);
        result = rf_filter_planar_depth(filter, &in, &to, error);
        to = rf_image_packed(radius, WIDTH, HEIGHT, 1);
        if (result == RF_OK)
            result = rf_filter_coc(filter, &in, &to, error);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return result;
}

static void params_of_kind(struct rf_params *p, int kind)
{
    rf_params_init(p);
    p->depth = kind;
    p->depth_near = 0.5;
    p->depth_far = 80;
    if (kind == RF_DEPTH_DISPARITY) {
        p->depth_scale = 0.4;
        p->depth_offset = 0.01;
    }
}

/* What a renderer of that kind writes for the planar distance z at pixel (x, y). */
static double encode(const struct rf_params *p, double z, int x, int y)
{
    double n = p->depth_near, f = p->depth_far;
    double f_px = WIDTH * p->focal_length / p->sensor_width;
    double dx = (x + 0.5 - WIDTH / 2.0) / f_px, dy = (y + 0.5 - HEIGHT / 2.0) / f_px;
    switch (p->depth) {
    case RF_DEPTH_PLANAR:
        return z;
    case RF_DEPTH_RADIAL:
        return z * sqrt(1 + dx * dx + dy * dy);
    case RF_DEPTH_BUFFER:
        return f / (f - n) - n * f / (f - n) / z;
    case RF_DEPTH_BUFFER_REVERSED:
        return 1 - (f / (f - n) - n * f / (f - n) / z);
    case RF_DEPTH_BUFFER_INFINITE:
        return 1 - n / z;
    case RF_DEPTH_BUFFER_REVERSED_INFINITE:
        return n / z;
    case RF_DEPTH_INVERSE:
        return 1 / z;
    case RF_DEPTH_DISPARITY:
        return (1 / z - p->depth_offset) / p->depth_scale;
    case RF_DEPTH_NORMALISED:
        return (z - n) / (f - n);
    }
    return NAN; /* a new kind needs its line above */
}

static int n_kinds(void)
{
    return rf_param_find("depth")->n_choices;
}

static void every_kind_comes_back_planar(void)
{
    for (int kind = 0; kind < n_kinds(); kind++) {
        struct rf_params p;
        struct rf_error error = {0};
        float depth[N], planar[N], radius[N];
        double z[N];
        params_of_kind(&p, kind);
        for (int i = 0; i < N; i++) {
            z[i] = 0.6 * pow(1.12, i);
            depth[i] = (float)encode(&p, z[i], i % WIDTH, i / WIDTH);
        }
        rf_result result = convert(&p, depth, planar, radius, &error);
        if (!testing_check(result == RF_OK, __FILE__, __LINE__, "convert"))
            printf("#     kind %d: %s\n", kind, error.message);
        struct rf_lens lens;
        REQUIRE(rf_lens_init(&lens, &p, WIDTH, HEIGHT, NULL) == RF_OK);
        for (int i = 0; i < N; i++) {
            /* A float depth buffer near 1 keeps 2^-25 of the range of 1/z. */
            CHECK_NEAR(planar[i], z[i], 1e-6 * z[i] + 6e-8 * z[i] * z[i] / 0.5);
            CHECK_NEAR(radius[i], rf_lens_radius_px(&lens, z[i]), 1e-5);
        }
    }
}

static void nothing_hit_is_infinity(void)
{
    static const struct {
        int kind;
        double value;
    } cases[] = {
        {RF_DEPTH_PLANAR, INFINITY},   {RF_DEPTH_PLANAR, 1e9},
        {RF_DEPTH_PLANAR, 1e10},       {RF_DEPTH_PLANAR, 3e38},
        {RF_DEPTH_PLANAR, 0},          {RF_DEPTH_RADIAL, INFINITY},
        {RF_DEPTH_RADIAL, 1e10},       {RF_DEPTH_RADIAL, 0},
        {RF_DEPTH_BUFFER, 1},          {RF_DEPTH_BUFFER_REVERSED, 0},
        {RF_DEPTH_BUFFER_INFINITE, 1}, {RF_DEPTH_BUFFER_REVERSED_INFINITE, 0},
        {RF_DEPTH_INVERSE, 0},         {RF_DEPTH_NORMALISED, 1},
    };
    for (size_t k = 0; k < sizeof cases / sizeof cases[0]; k++) {
        struct rf_params p;
        struct rf_error error = {0};
        float depth[N], planar[N], radius[N];
        params_of_kind(&p, cases[k].kind);
        for (int i = 0; i < N; i++)
            depth[i] = (float)encode(&p, 4, i % WIDTH, i / WIDTH);
        depth[11] = (float)cases[k].value;
        REQUIRE(convert(&p, depth, planar, radius, &error) == RF_OK);
        struct rf_lens lens;
        rf_lens_init(&lens, &p, WIDTH, HEIGHT, NULL);
        CHECK(isinf(planar[11]) && planar[11] > 0);
        CHECK_NEAR(radius[11], rf_lens_radius_px(&lens, INFINITY), 1e-6);
        CHECK_NEAR(planar[12], 4, 1e-4);
    }
}

/* A camera that looks along -z, and a sky that is none of its numbers. */
static void infinity_is_so_of_turned_numbers(void)
{
    static const float skies[] = {INFINITY, 1e10F, 1e9F, 0, -INFINITY, -1e10F};
    const int n = sizeof skies / sizeof skies[0];
    for (int kind = RF_DEPTH_PLANAR; kind <= RF_DEPTH_RADIAL; kind++) {
        struct rf_params p;
        struct rf_error error = {0};
        float depth[N], planar[N], radius[N];
        params_of_kind(&p, kind);
        for (int i = 0; i < N; i++)
            depth[i] = (float)-encode(&p, 4, i % WIDTH, i / WIDTH);
        for (int i = 0; i < n; i++)
            depth[i] = skies[i];
        p.depth_scale = -1;
        REQUIRE(convert(&p, depth, planar, radius, &error) == RF_OK);
        struct rf_lens lens;
        rf_lens_init(&lens, &p, WIDTH, HEIGHT, NULL);
        for (int i = 0; i < n; i++) {
            CHECK(isinf(planar[i]) && planar[i] > 0);
            CHECK_NEAR(radius[i], rf_lens_radius_px(&lens, INFINITY), 1e-6);
        }
        CHECK_NEAR(planar[n], 4, 1e-4);
        depth[3] = 4; /* before the turning */
        CHECK(convert(&p, depth, planar, radius, &error) == RF_ERROR_DEPTH);
    }
}

static void depth_infinity_is_a_choice(void)
{
    struct rf_params p;
    float depth[N], planar[N], radius[N];
    rf_params_init(&p);
    p.depth_infinity = 50;
    for (int i = 0; i < N; i++)
        depth[i] = 30 + (float)i;
    REQUIRE(convert(&p, depth, planar, radius, NULL) == RF_OK);
    for (int i = 0; i < N; i++)
        CHECK(depth[i] < 50 ? planar[i] == depth[i] : isinf(planar[i]));
}

static void scale_and_offset(void)
{
    struct rf_params p;
    float depth[N], planar[N], radius[N];
    rf_params_init(&p);
    p.depth_scale = 0.01; /* centimetres */
    p.depth_offset = 0.25;
    for (int i = 0; i < N; i++)
        depth[i] = 100 + (float)i;
    REQUIRE(convert(&p, depth, planar, radius, NULL) == RF_OK);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(planar[i], 1.25 + i * 0.01, 1e-6);
}

static void expect_error(const struct rf_params *p, const float *depth,
                         const char *count, const char *pixel)
{
    float planar[N], radius[N];
    struct rf_error error = {0};
    CHECK(convert(p, depth, planar, radius, &error) == RF_ERROR_DEPTH);
    CHECK(error.code == RF_ERROR_DEPTH);
    CHECK_STR(error.field, "depth");
    CHECK_CONTAINS(error.message, count);
    CHECK_CONTAINS(error.message, pixel);
}

static void bad_values_name_the_first_pixel_and_the_count(void)
{
    static const double bad[] = {NAN, -1e-3, -INFINITY, -5};
    for (int kind = 0; kind < n_kinds(); kind++)
        for (size_t k = 0; k < sizeof bad / sizeof bad[0]; k++) {
            struct rf_params p;
            float depth[N];
            params_of_kind(&p, kind);
            p.depth_offset = 0;
            for (int i = 0; i < N; i++)
                depth[i] = (float)encode(&p, 4, i % WIDTH, i / WIDTH);
            depth[2 * WIDTH + 3] = (float)bad[k];
            expect_error(&p, depth, "1 bad depth value,", "(3, 2)");
            depth[1 * WIDTH + 6] = (float)bad[k];
            depth[4 * WIDTH + 0] = NAN;
            expect_error(&p, depth, "3 bad depth values", "(6, 1)");
        }
}

/* A good number that scale and offset make bad is told from one that is bad itself. */
static void bad_values_say_what_scale_and_offset_made_of_them(void)
{
    struct rf_params p;
    float depth[N];
    params_of_kind(&p, RF_DEPTH_PLANAR);
    p.depth_scale = -1;
    p.depth_offset = 2;
    for (int i = 0; i < N; i++)
        depth[i] = 6;
    expect_error(&p, depth, "the first is 6 at pixel",
                 ", -4 by depth-scale -1 and depth-offset 2: NaN or negative; check");
    p.depth_scale = 1;
    p.depth_offset = 0;
    depth[0] = -3;
    expect_error(&p, depth, "the first is -3", "(0, 0): NaN or negative; check");
    params_of_kind(&p, RF_DEPTH_BUFFER);
    depth[0] = 1;
    expect_error(&p, depth, "the first is 6", ": NaN or outside of 0 to 1; check");
}

static void a_buffer_stays_in_its_range(void)
{
    for (int kind = RF_DEPTH_BUFFER; kind <= RF_DEPTH_BUFFER_REVERSED_INFINITE;
         kind++) {
        struct rf_params p;
        float depth[N];
        params_of_kind(&p, kind);
        for (int i = 0; i < N; i++)
            depth[i] = 0.5f;
        depth[9] = 1.25f;
        expect_error(&p, depth, "1.25", "(1, 1)");
    }
}

/* A frame of nothing but sky; infinity as every kind writes it, unless that is 0. */
static void all_infinite_is_all_blurred(void)
{
    static const float FARTHEST[] = {
        [RF_DEPTH_PLANAR] = 1e10f,      [RF_DEPTH_RADIAL] = INFINITY,
        [RF_DEPTH_BUFFER] = 1,          [RF_DEPTH_BUFFER_REVERSED] = 0,
        [RF_DEPTH_BUFFER_INFINITE] = 1, [RF_DEPTH_BUFFER_REVERSED_INFINITE] = 0,
        [RF_DEPTH_INVERSE] = 0,         [RF_DEPTH_DISPARITY] = 0,
        [RF_DEPTH_NORMALISED] = 1};
    CHECK(sizeof FARTHEST / sizeof *FARTHEST == (size_t)n_kinds());
    for (int kind = 0; kind < n_kinds(); kind++) {
        struct rf_params p;
        float depth[N], planar[N], radius[N];
        params_of_kind(&p, kind);
        p.depth_offset = 0;
        float value = FARTHEST[kind];
        for (int i = 0; i < N; i++)
            depth[i] = value;
        if (value == 0) {
            expect_error(&p, depth, "every depth is 0", "empty channel");
            depth[N - 1] = 0.25f;
        }
        REQUIRE(convert(&p, depth, planar, radius, NULL) == RF_OK);
        CHECK(planar[4] == INFINITY && radius[4] > 0.009);
    }
}

static void nothing_but_0_is_an_error(void)
{
    struct rf_params p;
    float depth[N] = {0};
    rf_params_init(&p);
    expect_error(&p, depth, "every depth is 0", "empty channel");
    depth[N / 2] = -0.0f;
    expect_error(&p, depth, "every depth is 0", "empty channel");
    params_of_kind(&p, RF_DEPTH_RADIAL);
    expect_error(&p, depth, "every depth is 0", "empty channel");
}

/* Blender: shift_x > 0 moves the frame right, so the axis lies left of the middle. */
static void radial_knows_shift_and_pixel_aspect(void)
{
    struct rf_params p;
    float depth[N], planar[N], radius[N];
    params_of_kind(&p, RF_DEPTH_RADIAL);
    p.shift_x = 0.25;
    p.shift_y = -0.125;
    p.pixel_aspect = 2;
    double f_px = WIDTH * 50 / 36.0;
    for (int i = 0; i < N; i++) {
        /* In widths of a pixel, right of and below the axis. */
        double dx = i % WIDTH + 0.5 - (WIDTH / 2.0 - 0.25 * WIDTH);
        double dy = (i / WIDTH + 0.5 - HEIGHT / 2.0) / 2 + 0.125 * WIDTH;
        depth[i] = (float)(7 * sqrt(1 + (dx * dx + dy * dy) / (f_px * f_px)));
    }
    REQUIRE(convert(&p, depth, planar, radius, NULL) == RF_OK);
    for (int i = 0; i < N; i++)
        CHECK_NEAR(planar[i], 7, 1e-5);
}

static void orthographic_rays_are_parallel(void)
{
    struct rf_params p;
    float depth[N], planar[N], radius[N];
    params_of_kind(&p, RF_DEPTH_RADIAL);
    p.projection = RF_PROJECTION_ORTHOGRAPHIC;
    for (int i = 0; i < N; i++)
        depth[i] = 3;
    REQUIRE(convert(&p, depth, planar, radius, NULL) == RF_OK);
    for (int i = 0; i < N; i++)
        CHECK(planar[i] == 3);
}

/* optics buffer computes from the buffer's value, with the same curve. */
static void buffer_optics_agree_with_the_camera(void)
{
    for (int kind = RF_DEPTH_BUFFER; kind <= RF_DEPTH_BUFFER_REVERSED_INFINITE;
         kind++) {
        struct rf_params p;
        float depth[N], planar[N], camera[N], buffer[N];
        params_of_kind(&p, kind);
        p.focus_distance = 3;
        p.lens_radius = 0.3;
        p.max_radius = 1000;
        for (int i = 0; i < N; i++)
            depth[i] = (float)(i / (N - 1.0));
        REQUIRE(convert(&p, depth, planar, camera, NULL) == RF_OK);
        p.optics = RF_OPTICS_BUFFER;
        REQUIRE(convert(&p, depth, planar, buffer, NULL) == RF_OK);
        for (int i = 0; i < N; i++)
            CHECK_NEAR(buffer[i], camera[i], 1e-5 * (1 + fabs(camera[i])));
    }
}

static void in_place_and_into_a_wider_image(void)
{
    struct rf_params p;
    struct rf_context *context;
    struct rf_filter *filter;
    float depth[N], wide[N * 3];
    rf_params_init(&p);
    for (int i = 0; i < N; i++)
        depth[i] = 1 + (float)i;
    for (int i = 0; i < 3 * N; i++)
        wide[i] = -7;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &p, WIDTH, HEIGHT, NULL) == RF_OK);
    struct rf_image in = rf_image_packed(depth, WIDTH, HEIGHT, 1);
    struct rf_image out = rf_image_packed(wide, WIDTH, HEIGHT, 3);
    CHECK(rf_filter_coc(filter, &in, &out, NULL) == RF_ERROR_ARGUMENT);
    out.channels = 1; /* the first of three */
    CHECK(rf_filter_coc(filter, &in, &out, NULL) == RF_OK);
    CHECK(rf_filter_coc(filter, &in, &in, NULL) == RF_OK);
    for (int i = 0; i < N; i++) {
        double r = rf_lens_radius_px(rf_filter_lens(filter), 1 + i);
        CHECK(depth[i] == (float)r);
        CHECK(wide[3 * i] == (float)r && wide[3 * i + 1] == -7);
    }
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_kind_comes_back_planar);
    TEST(nothing_hit_is_infinity);
    TEST(depth_infinity_is_a_choice);
    TEST(infinity_is_so_of_turned_numbers);
    TEST(scale_and_offset);
    TEST(bad_values_name_the_first_pixel_and_the_count);
    TEST(bad_values_say_what_scale_and_offset_made_of_them);
    TEST(a_buffer_stays_in_its_range);
    TEST(all_infinite_is_all_blurred);
    TEST(nothing_but_0_is_an_error);
    TEST(radial_knows_shift_and_pixel_aspect);
    TEST(orthographic_rays_are_parallel);
    TEST(buffer_optics_agree_with_the_camera);
    TEST(in_place_and_into_a_wider_image);
    return testing_end();
}
