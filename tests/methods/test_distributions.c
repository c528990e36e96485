/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The distributions of scatter against their formulas in double: w = D(t) / sum of D
 * over the circle hypot(row, col) < r, t = (row^2 + col^2) / max(ceil(r^2), 1).
 */
#include "physics/frames.h"
#include "testing.h"

static double density(int kind, double t)
{
    return kind == RF_DISTRIBUTION_GAUSSIAN ? exp(-2 * t)
           : kind == RF_DISTRIBUTION_RING   ? 1 + 3 * pow(t, 4)
                                            : 1;
}

/* A lone lamp of radius r in the middle, the rest in focus; of pixels of an aspect. */
static struct frame lamp_of_pixels(double aspect, int kind, double r_px, double light)
{
    int size = 2 * (int)ceil(r_px * fmax(aspect, 1)) + 5;
    struct frame f = frame_make(size, size, 1);
    struct rf_params params;
    plain_params(&params, RF_METHOD_SCATTER);
    params.distribution = kind;
    params.pixel_aspect = aspect;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = PLAIN_FOCUS;
    f.depth[frame_pixels(&f) / 2] = plain_depth(r_px);
    f.colour[frame_pixels(&f) / 2] = (float)light;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

static struct frame lamp(int kind, double r_px, double light)
{
    return lamp_of_pixels(1, kind, r_px, light);
}

static double sum_of(const struct frame *f)
{
    double sum = 0;
    for (size_t i = 0; i < frame_pixels(f); i++)
        sum += f->out[i];
    return sum;
}

static void unit_energy_at_any_radius(void)
{
    for (int kind = 0; kind <= RF_DISTRIBUTION_RING; kind++)
        for (double r = 0; r < 200; r = r * 1.21 + 0.13) {
            struct frame f = lamp(kind, r, 1e4);
            CHECK_NEAR(sum_of(&f) / 1e4, 1, 1e-5);
            frame_free(&f);
        }
}

static void every_weight_is_the_formula(void)
{
    static const double radii[] = {0.3, 1.2, 2.9, 7.4, 23.6, 70.3};
    for (int kind = 0; kind <= RF_DISTRIBUTION_RING; kind++)
        for (int k = 0; k < 6; k++) {
            double r = radii[k], m = fmax(ceil(r * r), 1), sum = 0, worst = 0;
            struct frame f = lamp(kind, r, 1);
            int c = f.width / 2;
            for (int y = 0; y < f.height; y++)
                for (int x = 0; x < f.width; x++)
                    if (hypot(x - c, y - c) < r || (x == c && y == c))
                        sum += density(kind, (pow(x - c, 2) + pow(y - c, 2)) / m);
            for (int y = 0; y < f.height; y++)
                for (int x = 0; x < f.width; x++) {
                    bool is_in = hypot(x - c, y - c) < r || (x == c && y == c);
                    double t = (pow(x - c, 2) + pow(y - c, 2)) / m;
                    double want = is_in ? density(kind, t) / sum : 0;
                    double got = *frame_at(&f, f.out, x, y);
                    worst = fmax(worst, fabs(got - want) * sum);
                }
            CHECK_NEAR(worst, 0, 3e-5); /* the table of D has 1024 steps */
            frame_free(&f);
        }
}

/* Twice the deviation along columns and rows, px; of a disc it is the radius. */
static void spread_of(const struct frame *f, double spread[2])
{
    double square[2] = {0, 0}, sum = sum_of(f);
    int c = f->width / 2;
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            square[0] += *frame_at(f, f->out, x, y) * pow(x - c, 2);
            square[1] += *frame_at(f, f->out, x, y) * pow(y - c, 2);
        }
    for (int k = 0; k < 2; k++)
        spread[k] = 2 * sqrt(square[k] / sum);
}

/* Circles of pixels that are not square are as many rows high as are round. */
static void circles_are_round_on_the_screen(void)
{
    static const double aspects[] = {0.25, 0.5, 1.3, 2, 40};
    for (int kind = 0; kind <= RF_DISTRIBUTION_RING; kind++)
        for (int k = 0; k < 5; k++) {
            struct frame square = lamp(kind, 20.5, 1e4);
            struct frame f = lamp_of_pixels(aspects[k], kind, 20.5, 1e4);
            double want[2], spread[2];
            spread_of(&square, want);
            spread_of(&f, spread);
            CHECK_NEAR(sum_of(&f) / 1e4, 1, 1e-5);
            CHECK_NEAR(spread[0] / want[0], 1, 0.03);
            CHECK_NEAR(spread[1] / want[1] / aspects[k], 1, 0.04);
            frame_free(&f);
            frame_free(&square);
        }
}

/* And what is in focus stays as it is, whatever else is in the picture. */
static void focus_is_the_identity_at_any_aspect(void)
{
    static const double aspects[] = {1e-3, 0.5, 2, 1e3};
    for (int k = 0; k < 4; k++) {
        struct frame f = lamp(RF_DISTRIBUTION_UNIFORM, 30, 1);
        struct rf_params params;
        plain_params(&params, RF_METHOD_SCATTER);
        params.pixel_aspect = aspects[k];
        f.depth[0] = plain_depth(30); /* black */
        f.depth[frame_pixels(&f) / 2] = PLAIN_FOCUS;
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        CHECK(memcmp(f.out, f.colour, frame_pixels(&f) * sizeof *f.out) == 0);
        frame_free(&f);
    }
}

/* What each is there for: a soft edge, a bright rim, and the same on both sides. */
static void the_shapes_differ(void)
{
    struct frame flat = lamp(RF_DISTRIBUTION_UNIFORM, 20.5, 1);
    struct frame soft = lamp(RF_DISTRIBUTION_GAUSSIAN, 20.5, 1);
    struct frame ring = lamp(RF_DISTRIBUTION_RING, 20.5, 1);
    int c = flat.width / 2;
    CHECK_NEAR(*frame_at(&flat, flat.out, c, c) / *frame_at(&flat, flat.out, c + 20, c),
               1, 1e-6);
    CHECK_NEAR(*frame_at(&soft, soft.out, c, c) / *frame_at(&soft, soft.out, c + 20, c),
               exp(2 * 400 / 421.0), 0.01);
    CHECK_NEAR(*frame_at(&ring, ring.out, c + 20, c) / *frame_at(&ring, ring.out, c, c),
               1 + 3 * pow(400 / 421.0, 4), 0.01);
    frame_free(&flat);
    frame_free(&soft);
    frame_free(&ring);
}

/* ---- a picture as the distribution --------------------------------------------- */

/* Light of a picture of w x h squares within [x0, x1] x [y0, y1], by clipping each. */
static double light_within(const float *picture, int w, int h, int step, double x0,
                           double x1, double y0, double y1)
{
    double sum = 0;
    for (int j = 0; j < h; j++)
        for (int i = 0; i < w; i++)
            sum += picture[(j * w + i) * step] *
                   fmax(0, fmin(x1, i + 1) - fmax(x0, i)) *
                   fmax(0, fmin(y1, j + 1) - fmax(y0, j));
    return sum;
}

/* What the pixel (dx, dy) from a lamp of radius r should get of its light. */
static double share(const float *picture, int w, int h, int step, double r, int dx,
                    int dy)
{
    double scale = fmax(w, h) / (2 * fmax(fabs(r), 0.5)); /* squares per px */
    if (r < 0) {                                          /* before the focus */
        dx = -dx;
        dy = -dy;
    }
    return light_within(picture, w, h, step, w / 2.0 + (dx - 0.5) * scale,
                        w / 2.0 + (dx + 0.5) * scale, h / 2.0 + (dy - 0.5) * scale,
                        h / 2.0 + (dy + 0.5) * scale) /
           light_within(picture, w, h, step, 0, w, 0, h);
}

/* The pixels of stamped(), width through height. */
static double stamp_aspect = 1;

/* A frame of `channels` whose middle is a lamp of signed radius r, blurred by picture.
 */
static struct frame stamped(double r, int channels, const float *picture, int w, int h,
                            int picture_channels)
{
    int size = 2 * (int)ceil(fabs(r) * fmax(stamp_aspect, 1)) + 5;
    struct frame f = frame_make(size, size, channels);
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    plain_params(&params, RF_METHOD_SCATTER);
    params.distribution = RF_DISTRIBUTION_IMAGE;
    params.pixel_aspect = stamp_aspect;
    size_t middle = frame_pixels(&f) / 2;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = PLAIN_FOCUS;
    f.depth[middle] = plain_depth(r);
    for (int c = 0; c < channels; c++)
        f.colour[middle * (size_t)channels + (size_t)c] = 10;
    struct rf_image image = rf_image_packed((float *)picture, w, h, picture_channels);
    struct rf_view view = {.colour = rf_image_packed(f.colour, size, size, channels),
                           .depth = rf_image_packed(f.depth, size, size, 1)};
    struct rf_image out = rf_image_packed(f.out, size, size, channels);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create_with(&filter, context, &params, size, size, &image, NULL) ==
          RF_OK);
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return f;
}

/* An arrow-like picture without any symmetry. */
static void draw_picture(float *picture, int w, int h, int channels)
{
    for (int j = 0; j < h; j++)
        for (int i = 0; i < w; i++)
            for (int c = 0; c < channels; c++)
                picture[(j * w + i) * channels + c] =
                    (float)((i * 5 + j * 3 + i * j + 7 * c) % 11) * (i < 2 * j + 3);
}

static void picture_is_integrated_over_each_pixel(void)
{
    static const int sizes[][2] = {{1, 1}, {7, 5}, {24, 40}};
    static const double radii[] = {0.2, 0.9, -3.3, 8.6, -21.25};
    for (int s = 0; s < 3; s++)
        for (int k = 0; k < 5; k++) {
            float picture[40 * 24];
            int w = sizes[s][0], h = sizes[s][1];
            double worst = 0, sum = 0;
            draw_picture(picture, w, h, 1);
            picture[0] = 3;
            struct frame f = stamped(radii[k], 1, picture, w, h, 1);
            int c = f.width / 2;
            /* plain_depth() is rounded to float: about 1e-6 of the radius. */
            for (int y = 0; y < f.height; y++)
                for (int x = 0; x < f.width; x++) {
                    double got = *frame_at(&f, f.out, x, y) / 10;
                    sum += got;
                    worst = fmax(worst, fabs(got - share(picture, w, h, 1, radii[k],
                                                         x - c, y - c)));
                }
            CHECK_NEAR(worst, 0, 2e-5);
            CHECK_NEAR(sum, 1, 1e-6);
            frame_free(&f);
        }
}

/* Pixels twice as wide as high: two rows hold what one held. */
static void pictures_are_upright_in_any_pixels(void)
{
    float picture[7 * 5];
    draw_picture(picture, 7, 5, 1);
    for (int sign = -1; sign <= 1; sign += 2) {
        double r = sign * 12.5, worst = 0, sum = 0;
        stamp_aspect = 2;
        struct frame f = stamped(r, 1, picture, 7, 5, 1);
        stamp_aspect = 1;
        int c = f.width / 2;
        for (int y = 0; y < f.height; y++)
            for (int x = 0; x < f.width; x++) {
                double got = *frame_at(&f, f.out, x, y) / 10;
                double scale = 7 / (2 * r), x0 = 3.5 + (x - c - 0.5) * scale;
                double y0 = 2.5 + (y - c - 0.5) * scale / 2;
                double x1 = x0 + scale, y1 = y0 + scale / 2;
                double want = light_within(picture, 7, 5, 1, fmin(x0, x1), fmax(x0, x1),
                                           fmin(y0, y1), fmax(y0, y1)) /
                              light_within(picture, 7, 5, 1, 0, 7, 0, 5);
                sum += got;
                worst = fmax(worst, fabs(got - want));
            }
        CHECK_NEAR(worst, 0, 2e-5);
        CHECK_NEAR(sum, 1, 1e-6);
        frame_free(&f);
    }
}

/* Each channel of a coloured picture has unit energy of its own; alpha gets the mean
 * of their shapes, and a fourth channel is not looked at. */
static void coloured_pictures(void)
{
    float rgba[9 * 9 * 4];
    draw_picture(rgba, 9, 9, 4);
    struct frame f = stamped(12.3, 4, rgba, 9, 9, 4);
    int middle = f.width / 2;
    double sum[4] = {0}, worst = 0, mean_worst = 0;
    float mean[81];
    for (int i = 0; i < 81; i++)
        mean[i] = (rgba[4 * i] + rgba[4 * i + 1] + rgba[4 * i + 2]) / 3;
    for (int y = 0; y < f.height; y++)
        for (int x = 0; x < f.width; x++)
            for (int c = 0; c < 4; c++) {
                const float *from = c < 3 ? rgba + c : mean;
                double want =
                    share(from, 9, 9, c < 3 ? 4 : 1, 12.3, x - middle, y - middle);
                double got = frame_at(&f, f.out, x, y)[c] / 10;
                sum[c] += got;
                worst = fmax(worst, c < 3 ? fabs(got - want) : 0);
                mean_worst = fmax(mean_worst, c == 3 ? fabs(got - want) : 0);
            }
    CHECK_NEAR(worst, 0, 2e-5);
    CHECK_NEAR(mean_worst, 0, 2e-5);
    for (int c = 0; c < 4; c++)
        CHECK_NEAR(sum[c], 1, 1e-6);
    frame_free(&f);
}

static void bad_pictures_are_named(void)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    float picture[12] = {0}, out[4];
    plain_params(&params, RF_METHOD_SCATTER);
    params.distribution = RF_DISTRIBUTION_IMAGE;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, 2, 2, NULL) == RF_OK);
    struct rf_image image = rf_image_packed(picture, 4, 3, 1);
    float colour[4] = {1, 1, 1, 1}, depth[4] = {1, 1, 1, 1};
    struct rf_view view = {.colour = rf_image_packed(colour, 2, 2, 1),
                           .depth = rf_image_packed(depth, 2, 2, 1)};
    struct rf_image to = rf_image_packed(out, 2, 2, 1);
    CHECK(rf_filter_process(filter, &view, 1, &to, NULL, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "distribution");
    rf_filter_destroy(filter);
    filter = NULL;
    CHECK(rf_filter_create_with(&filter, context, &params, 2, 2, &image, &error) ==
          RF_ERROR_PIXEL);
    CHECK_CONTAINS(error.message, "black");
    picture[5] = -1;
    CHECK(rf_filter_create_with(&filter, context, &params, 2, 2, &image, &error) ==
          RF_ERROR_PIXEL);
    CHECK_CONTAINS(error.message, "(1, 1)");
    picture[5] = NAN;
    CHECK(rf_filter_create_with(&filter, context, &params, 2, 2, &image, &error) ==
          RF_ERROR_PIXEL);
    CHECK(!filter);
    image.channels = 2;
    CHECK(rf_filter_create_with(&filter, context, &params, 2, 2, &image, &error) ==
          RF_ERROR_ARGUMENT);
    image.channels = 1;
    picture[5] = 1;
    REQUIRE(rf_filter_create_with(&filter, context, &params, 2, 2, &image, &error) ==
            RF_OK);
    picture[5] = NAN; /* it was copied */
    CHECK(rf_filter_process(filter, &view, 1, &to, NULL, &error) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(unit_energy_at_any_radius);
    TEST(every_weight_is_the_formula);
    TEST(the_shapes_differ);
    TEST(circles_are_round_on_the_screen);
    TEST(focus_is_the_identity_at_any_aspect);
    TEST(picture_is_integrated_over_each_pixel);
    TEST(pictures_are_upright_in_any_pixels);
    TEST(coloured_pictures);
    TEST(bad_pictures_are_named);
    return testing_end();
}
