/* SPDX-License-Identifier: Apache-2.0 */
/* PNG files: there and back, what they cannot hold, damaged ones. */
#include "exr_testing.h"

#include <stdint.h>
#include <unistd.h>

#include "exr_private.h"

static void png_comes_back(void)
{
    struct image_error error = {.message = ""};
    static float samples[5 * 3 * 4];
    for (size_t i = 0; i < 5 * 3; i++) {
        float alpha = (float)(i % 5) / 4.0f;
        for (size_t c = 0; c < 3; c++)
            samples[4 * i + c] = alpha * (float)((i + c) % 15) / 14.0f;
        samples[4 * i + 3] = alpha;
    }
    for (int bits = 8; bits <= 16; bits += 8) {
        float *got = NULL;
        int32_t width, height;
        REQUIRE(
            image_write_png(in_folder("x.png"), samples, 5, 3, 4, bits, false, &error));
        REQUIRE(image_read_png(in_folder("x.png"), &got, &width, &height, &error));
        CHECK(width == 5 && height == 3);
        double tolerance = bits == 8 ? 0.6 / 255 * 2.3 : 0.6 / 65535 * 2.3;
        for (size_t i = 0; i < 5 * 3 * 4; i++)
            CHECK_NEAR(got[i], samples[i], tolerance);
        free(got);
    }
}

static void png_clips_and_encodes(void)
{
    static const float samples[] = {-1, 0, 0.5f, 1, 20, NAN};
    struct image_error error = {.message = ""};
    float *got = NULL;
    int32_t width, height;
    REQUIRE(image_write_png(in_folder("g.png"), samples, 6, 1, 1, 8, false, &error));
    REQUIRE(image_read_png(in_folder("g.png"), &got, &width, &height, &error));
    static const float want[] = {0, 0, 0.5f, 1, 1, 0};
    for (size_t i = 0; i < 6; i++) {
        CHECK_NEAR(got[4 * i], want[i], 0.004);
        CHECK_NEAR(got[4 * i + 3], 1, 0);
    }
    free(got);
    /* As it is: 0.5 is 128 of 255 and reads as the linear light of that. */
    REQUIRE(image_write_png(in_folder("g.png"), samples, 6, 1, 1, 8, true, &error));
    REQUIRE(image_read_png(in_folder("g.png"), &got, &width, &height, &error));
    CHECK_NEAR(got[4 * 2], 0.2158605, 1e-4);
    free(got);
}

static void png_says_why(void)
{
    struct image_error error = {.message = ""};
    float *got, pixel[3] = {0};
    int32_t width, height;
    CHECK(!image_read_png(in_folder("missing.png"), &got, &width, &height, &error));
    CHECK_CONTAINS(error.message, "No such file");
    FILE *file = fopen(in_folder("text.png"), "w");
    REQUIRE(file != NULL);
    fputs("hello", file);
    fclose(file);
    CHECK(!image_read_png(in_folder("text.png"), &got, &width, &height, &error));
    CHECK_CONTAINS(error.message, "is not a PNG file");
    CHECK(!image_write_png(in_folder("y.png"), pixel, 1, 1, 3, 12, false, &error));
    CHECK_CONTAINS(error.message, "12 bits");
    static float noise[64 * 64];
    for (size_t i = 0; i < 64 * 64; i++)
        noise[i] = (float)(i * 7919 % 97) / 97;
    REQUIRE(image_write_png(in_folder("cut.png"), noise, 64, 64, 1, 8, false, &error));
    REQUIRE(truncate(in_folder("cut.png"), 500) == 0);
    CHECK(!image_read_png(in_folder("cut.png"), &got, &width, &height, &error));
    CHECK_CONTAINS(error.message, "cut.png: damaged");
    CHECK(got == NULL);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (!make_folder())
        return 1;
    TEST(png_comes_back);
    TEST(png_clips_and_encodes);
    TEST(png_says_why);
    remove_folder();
    return testing_end();
}
