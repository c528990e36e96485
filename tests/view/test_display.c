/* SPDX-License-Identifier: Apache-2.0 */
/* What the screen shows of pictures, depths and radii. */
#include <stdlib.h>

#include "image.h"
#include "pixels/display.h"
#include "testing.h"

/* As png_write encodes, from its formula. */
static int slow_code(float v)
{
    v = v < 0 ? 0 : v > 1 ? 1 : v;
    const float curve =
        v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1.0f / 2.4f) - 0.055f;
    return (int)lrintf(fminf(fmaxf(curve, 0), 1) * 255);
}

static void the_table_is_the_curve(void)
{
    struct tone *tone = tone_create();
    REQUIRE(tone != NULL);
    int n_wrong = 0;
    for (uint32_t bits = 0; bits < 0x40000000; bits += 997) {
        float v;
        memcpy(&v, &bits, sizeof(v));
        n_wrong += tone_encode(tone, v) != slow_code(v);
    }
    CHECK(n_wrong == 0);
    CHECK(tone_encode(tone, -1) == 0);
    CHECK(tone_encode(tone, INFINITY) == 255);
    CHECK(tone_encode(tone, NAN) == 0);
    tone_destroy(tone);
}

static void a_stop_is_a_factor_of_two(void)
{
    struct tone *tone = tone_create();
    const float pixels[6] = {0.1f, 0.2f, 0.4f, 0.05f, 0.1f, 0.2f};
    uint8_t plain[8], brighter[8];
    display_picture(tone, pixels, 3, 2, 0, plain);
    display_picture(tone, pixels, 3, 2, 1, brighter);
    CHECK(memcmp(plain, brighter + 4, 4) == 0);
    CHECK(plain[3] == 255);
    tone_destroy(tone);
}

static void grey_and_alpha_are_shown(void)
{
    struct tone *tone = tone_create();
    const float grey[1] = {0.5f}, rgba[4] = {0.5f, 0.25f, 0, 0.5f};
    uint8_t out[4];
    display_picture(tone, grey, 1, 1, 0, out);
    CHECK(out[0] == 188 && out[1] == 188 && out[2] == 188 && out[3] == 255);
    display_picture(tone, rgba, 4, 1, 0, out);
    CHECK(out[0] == 188 && out[1] == 137 && out[2] == 0 && out[3] == 255);
    tone_destroy(tone);
}

static void farther_is_lighter(void)
{
    const float planar[5] = {2, 3, 6, 60, INFINITY};
    uint8_t out[20];
    display_depth(planar, 5, 2, 60, out);
    CHECK(out[0] == 0);
    CHECK(out[12] == 255 && out[16] == 255);
    for (int i = 1; i < 4; i++)
        CHECK(out[4 * i] > out[4 * (i - 1)]);
    /* Equal steps of 1/z are equal steps of grey. */
    CHECK_NEAR(out[4], 255 * (1 / 2.0 - 1 / 3.0) / (1 / 2.0 - 1 / 60.0), 0.51);
    display_depth(planar, 1, 2, 2, out);
    CHECK(out[0] == 0);
}

static void the_sign_of_the_blur_has_a_colour(void)
{
    const float radius[4] = {-8, 0, 8, 2};
    uint8_t out[16];
    display_coc(radius, 4, 8, out);
    CHECK(out[0] > out[2] && out[0] == 255);          /* before: orange */
    CHECK(out[4] == 0 && out[5] == 0 && out[6] == 0); /* in focus: black */
    CHECK(out[10] > out[8] && out[10] == 255);        /* behind: blue */
    CHECK(out[14] < out[10] && out[14] > 0);
}

static void what_is_in_focus_keeps_its_colour(void)
{
    struct tone *tone = tone_create();
    const float pixels[6] = {0.5f, 0.1f, 0.1f, 0.5f, 0.1f, 0.1f};
    const float radius[2] = {0.5f, -0.6f};
    uint8_t plain[8], band[8];
    display_picture(tone, pixels, 3, 2, 0, plain);
    display_band(tone, pixels, 3, radius, 2, 0, 0.5, band);
    CHECK(memcmp(plain, band, 4) == 0);
    CHECK(band[4] == band[5] && band[4] < plain[4]);
    tone_destroy(tone);
}

static void exposure_is_counted_in_stops(void)
{
    static const uint8_t green[3] = {40, 170, 60}, red[3] = {225, 30, 30};
    const float px[4][3] = {
        {0.18f, 0.18f, 0.18f}, {2, 0, 0}, {0, 0, 0}, {0.045f, 0.045f, 0.045f}};
    uint8_t rgba[4][4], want[3];
    display_exposure(px[0], 3, 4, 0, rgba[0]);
    CHECK(memcmp(rgba[0], green, 3) == 0 && rgba[0][3] == 255);
    CHECK(memcmp(rgba[1], red, 3) == 0); /* one clipped channel is enough */
    display_exposure_colour(-INFINITY, want);
    CHECK(memcmp(rgba[2], want, 3) == 0 && want[2] > want[1]);
    display_exposure_colour(-2, want);
    CHECK(memcmp(rgba[3], want, 3) == 0 && want[0] == want[1]);
    display_exposure(px[3], 3, 1, 2, rgba[3]); /* two stops brighter */
    CHECK(memcmp(rgba[3], green, 3) == 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(the_table_is_the_curve);
    TEST(a_stop_is_a_factor_of_two);
    TEST(grey_and_alpha_are_shown);
    TEST(farther_is_lighter);
    TEST(the_sign_of_the_blur_has_a_colour);
    TEST(what_is_in_focus_keeps_its_colour);
    TEST(exposure_is_counted_in_stops);
    return testing_end();
}
