/* SPDX-License-Identifier: Apache-2.0 */
/* The generators against models.h, and what all of them promise. */
#include "models.h"

static void compare(const struct rf_params *params, int width, int height, int channels,
                    double r_px)
{
    struct frame f = frame_make(width, height, channels);
    uint32_t seed = (uint32_t)(width + 31 * params->method);
    for (size_t i = 0; i < frame_pixels(&f) * (size_t)channels; i++)
        f.colour[i] = (float)(random_unit(&seed) * (i % 53 ? 1 : 40));
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = plain_depth((random_unit(&seed) * 2 - 1) * r_px);
    double *radius = radii_of(&f, params), worst = 0;
    CHECK(frame_filter(&f, params, 2, NULL) == RF_OK);
    for (int c = 0; c < channels; c++) {
        struct plane in = plane_of(&f, c), want = plane_make(width, height);
        model_generate(&in, radius, params, &want);
        for (int i = 0; i < width * height; i++)
            worst = fmax(worst, fabs(f.out[i * channels + c] - want.at[i]) /
                                    (1 + fabs(want.at[i])));
        plane_free(&in);
        plane_free(&want);
    }
    if (!testing_check(worst <= 1e-4, __FILE__, __LINE__, "formula"))
        printf("#     method %d, %d x %d x %d, radius %g: off by %g\n", params->method,
               width, height, channels, r_px, worst);
    free(radius);
    frame_free(&f);
}

static void compare_sizes(const struct rf_params *params)
{
    compare(params, 33, 26, 3, 0.8);
    compare(params, 26, 33, 4, 5);
    compare(params, 31, 22, 1, 17);
    compare(params, 1, 19, 3, 6);
    compare(params, 19, 1, 3, 6);
}

static void box_is_its_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_BOX);
    for (p.box_repeats = 1; p.box_repeats <= 3; p.box_repeats++)
        compare_sizes(&p);
}

static void lowres_is_its_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_LOWRES);
    for (p.lowres_factor = 2; p.lowres_factor <= 16; p.lowres_factor += 3)
        compare_sizes(&p);
}

static void mipmap_is_its_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_MIPMAP);
    for (p.mipmap_bias = -1; p.mipmap_bias <= 1; p.mipmap_bias += 1)
        compare_sizes(&p);
}

/* The model takes four samples; the code one of a level that was built for it. */
static void mipmap_offset_is_its_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_MIPMAP_OFFSET);
    for (p.mipmap_bias = -1; p.mipmap_bias <= 1; p.mipmap_bias += 1)
        compare_sizes(&p);
}

static void offset_is_its_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_OFFSET);
    for (p.copies = 4; p.copies <= 16; p.copies *= 2)
        compare_sizes(&p);
}

static void recursive_offset_is_its_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_RECURSIVE_OFFSET);
    for (p.recursions = 1; p.recursions <= 5; p.recursions++)
        compare_sizes(&p);
}

/* Any radius, any pattern: a constant stays what it is, up to the border. */
static void a_constant_stays_constant(void)
{
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++) {
        struct rf_params p;
        struct frame f = frame_make(61, 43, 4);
        uint32_t seed = 9;
        double worst = 0;
        plain_params(&p, m);
        for (size_t i = 0; i < frame_pixels(&f); i++) {
            f.depth[i] = plain_depth((random_unit(&seed) * 2 - 1) * 40);
            for (size_t c = 0; c < 4; c++)
                f.colour[4 * i + c] = 0.3f + 0.2f * (float)c;
        }
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        for (size_t i = 0; i < frame_pixels(&f) * 4; i++)
            worst = fmax(worst, fabs(f.out[i] - f.colour[i]));
        CHECK_NEAR(worst, 0, 2e-6);
        frame_free(&f);
    }
}

/* The mean square distance of the blur is that of the disc, r^2 / 4 per axis; where a
 * level of detail or a small picture stands in for the radius, within the step. */
static void the_spread_is_that_of_the_disc(void)
{
    static const double radii[] = {2, 4, 9, 16};
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++)
        for (int k = 0; k < 4; k++) {
            double r = radii[k], sum = 0, xx = 0;
            struct rf_params p;
            int size = 129, c = size / 2;
            struct frame f = frame_make(size, size, 1);
            plain_params(&p, m);
            p.lowres_factor = (int)r;
            for (size_t i = 0; i < frame_pixels(&f); i++)
                f.depth[i] = plain_depth(r);
            *frame_at(&f, f.colour, c, c) = 1;
            CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
            for (int y = 0; y < size; y++)
                for (int x = 0; x < size; x++) {
                    double v = *frame_at(&f, f.out, x, y);
                    sum += v;
                    xx += v * (x - c) * (x - c);
                }
            bool is_exact = m == RF_METHOD_BOX || m == RF_METHOD_RECURSIVE_OFFSET;
            CHECK_NEAR(sqrt(xx / sum) / (r / 2), 1, is_exact ? 0.001 : 0.45);
            frame_free(&f);
        }
}

/* A lamp of a million leaves nothing beside its blur. */
static void highlights_leave_no_trace(void)
{
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++) {
        struct rf_params p;
        struct frame f = frame_make(256, 40, 1);
        double worst = 0;
        plain_params(&p, m);
        for (size_t i = 0; i < frame_pixels(&f); i++) {
            f.depth[i] = plain_depth(3);
            f.colour[i] = 0.1f;
        }
        *frame_at(&f, f.colour, 20, 20) = 1e6f;
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        for (int y = 0; y < 40; y++)
            for (int x = 64; x < 256; x++)
                worst = fmax(worst, fabs(*frame_at(&f, f.out, x, y) - 0.1));
        CHECK_NEAR(worst, 0, 1e-6);
        frame_free(&f);
    }
}

/* What a spread along rows is along columns, times the aspect of the pixels. */
static void the_spread_is_round_on_the_screen(void)
{
    static const int methods[] = {RF_METHOD_BOX, RF_METHOD_LOWRES};
    static const double aspects[] = {0.5, 2, 2.5};
    for (int i = 0; i < 6; i++) {
        double square[2] = {0, 0}, aspect = aspects[i / 2];
        int rows = (int)(8 * aspect), top = 64 / rows * rows;
        struct rf_params p;
        struct frame f = frame_make(129, 129, 1);
        plain_params(&p, methods[i % 2]);
        p.pixel_aspect = aspect;
        p.lowres_factor = 8;
        for (size_t k = 0; k < frame_pixels(&f); k++) {
            f.depth[k] = plain_depth(8);
            /* All of a block, so that its middle is the lamp's. */
            f.colour[k] = k % 129 / 8 == 8 && (int)k / 129 / rows == 64 / rows;
        }
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        double middle[2] = {67.5, top + (rows - 1) / 2.0};
        for (int y = 0; y < 129; y++)
            for (int x = 0; x < 129; x++) {
                double v = *frame_at(&f, f.out, x, y);
                square[0] += v * pow(x - middle[0], 2);
                square[1] += v * pow(y - middle[1], 2);
            }
        CHECK_NEAR(sqrt(square[1] / square[0]) / aspect, 1, 0.02);
        frame_free(&f);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(box_is_its_formula);
    TEST(lowres_is_its_formula);
    TEST(mipmap_is_its_formula);
    TEST(mipmap_offset_is_its_formula);
    TEST(offset_is_its_formula);
    TEST(recursive_offset_is_its_formula);
    TEST(a_constant_stays_constant);
    TEST(the_spread_is_that_of_the_disc);
    TEST(highlights_leave_no_trace);
    TEST(the_spread_is_round_on_the_screen);
    return testing_end();
}
