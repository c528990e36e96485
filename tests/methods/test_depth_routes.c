/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The depth buffer's two ways to a radius: unprojected to planar depth and through the
 * lens, or a scale and a bias on the value as it is (optics buffer, Reed 2012).
 */
#include "physics/frames.h"
#include "testing.h"

enum { N = 4096 };

static double largest_difference(const struct rf_params *base)
{
    float buffer[N], unprojected[N], linear[N];
    double worst = 0;
    for (int i = 0; i < N; i++)
        buffer[i] = (float)(i + 1) / (N + 1);
    for (int route = 0; route < 2; route++) {
        struct rf_params p = *base;
        struct rf_context *context;
        struct rf_filter *filter;
        struct rf_image in = rf_image_packed(buffer, N, 1, 1);
        struct rf_image out = rf_image_packed(route ? linear : unprojected, N, 1, 1);
        p.optics = route ? RF_OPTICS_BUFFER : RF_OPTICS_CAMERA;
        if (rf_context_create(&context, NULL, NULL) != RF_OK ||
            rf_filter_create(&filter, context, &p, N, 1, NULL) != RF_OK ||
            rf_filter_coc(filter, &in, &out, NULL) != RF_OK)
            return INFINITY;
        rf_filter_destroy(filter);
        rf_context_destroy(context);
    }
    for (int i = 0; i < N; i++)
        worst = fmax(worst, fabs((double)linear[i] - unprojected[i]));
    return worst;
}

static void both_routes_agree(void)
{
    static const int kinds[] = {RF_DEPTH_BUFFER, RF_DEPTH_BUFFER_REVERSED,
                                RF_DEPTH_BUFFER_INFINITE,
                                RF_DEPTH_BUFFER_REVERSED_INFINITE};
    static const double focus[] = {0.6, 3, 25, 400};
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 4; i++) {
            struct rf_params p;
            rf_params_init(&p);
            p.depth = kinds[k];
            p.depth_near = 0.5;
            p.depth_far = 500;
            p.focus_distance = focus[i];
            p.f_stop = 1.4;
            p.max_radius = 200;
            CHECK_NEAR(largest_difference(&p), 0, 1e-4);
        }
}

/* The radii differ from pixel to pixel, so that the test above says something. */
static void the_radii_are_those_of_a_lens(void)
{
    struct rf_params p;
    rf_params_init(&p);
    p.depth = RF_DEPTH_BUFFER;
    p.depth_near = 0.5;
    p.depth_far = 500;
    struct rf_lens lens;
    CHECK(rf_lens_init(&lens, &p, N, 1, NULL) == RF_OK);
    CHECK(rf_lens_radius_px(&lens, 500) > 4);
    CHECK(rf_lens_radius_px(&lens, 0.5) < -50);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(both_routes_agree);
    TEST(the_radii_are_those_of_a_lens);
    return testing_end();
}
