/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Highlights under the artist's control: how much light a picture has after clamp, gain
 * and saturation, by their formulas (core/input/highlights.c), under every method that
 * keeps light, blurred and in focus.
 */
#include "frames.h"
#include "testing.h"

enum { SIDE = 61, MIDDLE = SIDE / 2 };

static const double LUMINANCE[3] = {0.2126, 0.7152, 0.0722};
static const double LAMP[3] = {8, 4, 2}, REST = 0.5;

/* What a change makes of a pixel's luminance. */
struct change {
    double clamp, threshold, gain, saturation;
};

static const struct change changes[] = {
    {0, 1, 3, 1}, {0, 2, 0, 1}, {4, 1, 1, 1},   {4, 1, 2, 1},
    {0, 1, 1, 0}, {0, 1, 2, 2}, {0, 3, 0.5, 4},
};
enum { N_CHANGES = sizeof changes / sizeof *changes };

static void set_change(struct rf_params *p, const struct change *change)
{
    p->highlight_clamp = change->clamp;
    p->highlight_threshold = change->threshold;
    p->highlight_gain = change->gain;
    p->highlight_saturation = change->saturation;
}

static double wanted_luminance(const struct change *change, const double c[3])
{
    double y = 0, most = fmax(fmax(c[0], c[1]), c[2]), part = 1;
    for (int i = 0; i < 3; i++)
        y += LUMINANCE[i] * c[i];
    if (change->clamp > 0 && most > change->clamp)
        part = change->clamp / most;
    double above = fmax(0, 1 - change->threshold / (most * part));
    return y * part * (1 + (change->gain - 1) * above);
}

/* A coloured lamp in a dark frame, all of it at one radius. */
static struct frame lone_lamp(double r_px)
{
    struct frame f = frame_make(SIDE, SIDE, 4);
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        f.depth[i] = plain_depth(r_px);
        f.colour[4 * i + 3] = 1;
    }
    for (int k = 0; k < 3; k++)
        frame_at(&f, f.colour, MIDDLE, MIDDLE)[k] = (float)LAMP[k];
    return f;
}

static double sum_of(const struct frame *f, int channel)
{
    double sum = 0;
    for (size_t i = 0; i < frame_pixels(f); i++)
        sum += f->out[4 * i + (size_t)channel];
    return sum;
}

static void energy_is_by_the_formula(void)
{
    static const double radii[] = {0, 0.5, 3, -3, 12, -12};
    for (size_t i = 0; i < N_CHANGES * n_physical_methods(); i++)
        for (size_t k = 0; k < sizeof radii / sizeof *radii; k++) {
            const struct change *change = &changes[i % N_CHANGES];
            struct rf_params p;
            plain_params(&p, (int)(i / N_CHANGES));
            set_change(&p, change);
            struct frame f = lone_lamp(radii[k]);
            CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
            double y = 0;
            for (int c = 0; c < 3; c++)
                y += LUMINANCE[c] * sum_of(&f, c);
            CHECK_NEAR(y, wanted_luminance(change, LAMP), 1e-4 * y + 1e-5);
            CHECK_NEAR(frame_at(&f, f.out, MIDDLE, MIDDLE)[3], 1, 1e-5);
            frame_free(&f);
        }
}

/* In focus each pixel can be read: hue, what is below the threshold, grey. */
static void pixels_are_by_the_formula(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_LAYERED);
    set_change(&p, &(struct change){4, 1, 2, 1});
    struct frame f = lone_lamp(0);
    frame_at(&f, f.colour, 3, 3)[1] = (float)REST;
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    /* 8 4 2 becomes 4 2 1, of which 3/4 counts twice. */
    CHECK_NEAR(frame_at(&f, f.out, MIDDLE, MIDDLE)[0], 7, 1e-5);
    CHECK_NEAR(frame_at(&f, f.out, MIDDLE, MIDDLE)[1], 3.5, 1e-5);
    CHECK_NEAR(frame_at(&f, f.out, MIDDLE, MIDDLE)[2], 1.75, 1e-5);
    CHECK(frame_at(&f, f.out, 3, 3)[1] == (float)REST);
    set_change(&p, &(struct change){0, 0, 1, 0});
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    const float *grey = frame_at(&f, f.out, MIDDLE, MIDDLE);
    CHECK_NEAR(grey[0], grey[1], 1e-5);
    CHECK_NEAR(grey[1], grey[2], 1e-5);
    frame_free(&f);
}

/* A colour cannot be more saturated than pure; no channel falls below 0. */
static void saturation_stops_at_pure_colours(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_LAYERED);
    set_change(&p, &(struct change){0, 0, 1, 4});
    struct frame f = lone_lamp(0);
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    const float *pure = frame_at(&f, f.out, MIDDLE, MIDDLE);
    CHECK_NEAR(pure[2], 0, 1e-5);
    CHECK(pure[0] > 8 && pure[1] > 0);
    frame_free(&f);
}

/* A picture of grey has but a gain. */
static void grey_pictures(void)
{
    struct rf_params p;
    plain_params(&p, RF_METHOD_LAYERED);
    set_change(&p, &(struct change){0, 1, 3, 0});
    struct frame f = frame_make(SIDE, SIDE, 1);
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = plain_depth(5);
    *frame_at(&f, f.colour, MIDDLE, MIDDLE) = 11;
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    double sum = 0;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        sum += f.out[i];
    CHECK_NEAR(sum, 31, 1e-3);
    frame_free(&f);
}

/* Views are changed before they are averaged: a lamp seen by half of them has half. */
static void means_of_views(void)
{
    struct rf_params p;
    struct rf_context *context;
    struct rf_accumulator *mean;
    float lit[3] = {8, 4, 2}, dark[3] = {0}, out[3];
    plain_params(&p, RF_METHOD_ACCUMULATE);
    set_change(&p, &(struct change){0, 2, 3, 1});
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_accumulator_create(&mean, context, &p, 1, 1, 3, NULL) == RF_OK);
    const struct rf_image pictures[] = {rf_image_packed(lit, 1, 1, 3),
                                        rf_image_packed(dark, 1, 1, 3)};
    for (int i = 0; i < 2; i++)
        CHECK(rf_accumulator_add(mean, &pictures[i], NULL) == RF_OK);
    const struct rf_image image = rf_image_packed(out, 1, 1, 3);
    CHECK(rf_accumulator_mean(mean, &image, NULL) == RF_OK);
    CHECK_NEAR(out[0], (2 + 3 * 6) / 2.0, 1e-5); /* the mean itself would give 8 */
    rf_accumulator_destroy(mean);
    rf_context_destroy(context);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(energy_is_by_the_formula);
    TEST(pixels_are_by_the_formula);
    TEST(saturation_stops_at_pure_colours);
    TEST(grey_pictures);
    TEST(means_of_views);
    return testing_end();
}
