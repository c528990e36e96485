/* SPDX-License-Identifier: Apache-2.0 */
/* Halves: every value, every rounding, runs of them. */
#include "../testing.h"

#include <stdint.h>

#include "exr_private.h"

static void half_of_every_value(void)
{
    for (uint32_t i = 0; i < 65536; i++) {
        float value = image_half_to_float((uint16_t)i);
        if (isnan(value)) {
            CHECK(isnan(image_half_to_float(image_float_to_half(value))));
            continue;
        }
        if (image_float_to_half(value) != i) {
            CHECK(image_float_to_half(value) == i);
            return;
        }
    }
    CHECK_NEAR(image_half_to_float(0x3c00), 1.0, 0);
    CHECK_NEAR(image_half_to_float(0x0001), 0x1p-24, 0);
    CHECK_NEAR(image_half_to_float(0x7bff), 65504.0, 0);
    CHECK(signbit(image_half_to_float(0x8000)));
}

/* Midway between two neighbours the even one wins; beside it the nearer. */
static void half_rounds_to_nearest_even(void)
{
    for (uint32_t i = 0; i < 0x7bff; i++) {
        float low = image_half_to_float((uint16_t)i);
        float high = image_half_to_float((uint16_t)(i + 1));
        float middle = low + (high - low) / 2;
        uint32_t even = i % 2 ? i + 1 : i;
        bool is_good = image_float_to_half(middle) == even &&
                       image_float_to_half(nextafterf(middle, 0)) == i &&
                       image_float_to_half(nextafterf(middle, 1e9f)) == i + 1 &&
                       image_float_to_half(-middle) == (even | 0x8000);
        if (!is_good) {
            CHECK(is_good);
            printf("#     at %u\n", (unsigned)i);
            return;
        }
    }
    CHECK(true);
}

static void half_does_not_overflow(void)
{
    CHECK(image_float_to_half(65519.996f) == 0x7bff);
    CHECK(image_float_to_half(65520.0f) == 0x7bff);
    CHECK(image_float_to_half(1e10f) == 0x7bff);
    CHECK(image_float_to_half(-3e38f) == 0xfbff);
    CHECK(image_float_to_half(INFINITY) == 0x7c00);
    CHECK(image_float_to_half(-INFINITY) == 0xfc00);
    CHECK(image_float_to_half(1e-10f) == 0);
}

/* Runs give the bits of single values, whatever instructions they take. */
static void runs_of_halves_have_the_same_bits(void)
{
    enum { N = 65536, MOST_STRIDE = 5 };
    static uint16_t halves[N + 3], back[N + 3];
    static float floats[MOST_STRIDE * (N + 3)];
    for (uint32_t i = 0; i < N + 3; i++)
        halves[i] = (uint16_t)(i * 40503u);
    for (size_t stride = 1; stride <= MOST_STRIDE; stride++) {
        size_t n_bad = 0, n = N + 3 - stride % 2;
        memset(floats, 0x55, sizeof floats);
        image_halves_to_floats(floats, stride, (const uint8_t *)halves, n);
        for (size_t i = 0; i < n; i++) {
            float want = image_half_to_float(halves[i]);
            n_bad += memcmp(&floats[i * stride], &want, 4) != 0;
        }
        image_floats_to_halves((uint8_t *)back, floats, stride, n);
        for (size_t i = 0; i < n; i++)
            n_bad += back[i] != image_float_to_half(floats[i * stride]);
        CHECK(n_bad == 0);
        if (stride > 1) /* what lies between is left alone */
            CHECK(memcmp(floats + 1, "UUUU", 4) == 0);
    }
    printf("# F16C: %s\n", image_has_f16c() ? "yes" : "no");
}

/* All exponents, both signs, mantissas around every rounding border. */
static void rounding_of_runs_is_that_of_single_values(void)
{
    static const uint32_t mantissas[] = {
        0,      1,      0xfff,    0x1000,   0x1001,   0x1fff,   0x2000,
        0x3000, 0x2fff, 0x7fefff, 0x7ff000, 0x7ff001, 0x7fffff, 0x400000};
    enum { N_MANTISSAS = sizeof mantissas / sizeof *mantissas };
    static uint32_t bits[512 * N_MANTISSAS];
    static float floats[512 * N_MANTISSAS];
    static uint16_t got[512 * N_MANTISSAS];
    size_t n = 0, n_bad = 0;
    for (uint32_t top = 0; top < 512; top++)
        for (size_t m = 0; m < N_MANTISSAS; m++)
            bits[n++] = top << 23 | mantissas[m];
    memcpy(floats, bits, sizeof bits);
    image_floats_to_halves((uint8_t *)got, floats, 1, n);
    for (size_t i = 0; i < n; i++)
        n_bad += got[i] != image_float_to_half(floats[i]);
    CHECK(n_bad == 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(half_of_every_value);
    TEST(half_rounds_to_nearest_even);
    TEST(half_does_not_overflow);
    TEST(runs_of_halves_have_the_same_bits);
    TEST(rounding_of_runs_is_that_of_single_values);
    return testing_end();
}
