/* SPDX-License-Identifier: Apache-2.0 */
/* Where the picture lies in the window. */
#include "pixels/zoom.h"
#include "testing.h"

static const struct area area = {10, 20, 400, 300};

static struct zoom fitted(int32_t width, int32_t height)
{
    struct zoom zoom = {.aspect = 1};
    zoom_fit(&zoom, &area, width, height);
    return zoom;
}

static void a_picture_about_as_large_is_shown_as_it_is(void)
{
    const struct zoom zoom = fitted(300, 200);
    CHECK(zoom.scale == 1);
    CHECK(zoom.x == 60 && zoom.y == 70);
    CHECK(zoom.is_fitted);
}

static void a_small_picture_is_magnified(void)
{
    CHECK(fitted(200, 100).scale == 2);
    CHECK(fitted(160, 100).scale == 2.5);
    CHECK(fitted(250, 100).scale == 1.5);
    CHECK(fitted(1, 1).scale == 64);
    const struct zoom zoom = fitted(200, 100);
    CHECK(zoom.x == 10 && zoom.y == 70 && zoom.is_fitted);
}

static void a_large_picture_fits(void)
{
    const struct zoom zoom = fitted(1600, 300);
    CHECK_NEAR(zoom.scale, 0.25, 1e-12);
    CHECK_NEAR(zoom.x, 10, 1e-9);
    CHECK_NEAR(zoom.y, 20 + (300 - 75) / 2.0, 1e-9);
}

static void wide_pixels_are_shown_wide(void)
{
    struct zoom zoom = {.aspect = 2};
    zoom_fit(&zoom, &area, 400, 100);
    CHECK_NEAR(zoom.scale, 0.5, 1e-12);
    int32_t x, y;
    CHECK(zoom_pick(&zoom, 400, 100, 10 + 399, 170, &x, &y));
    CHECK(x == 399);
}

static void the_point_below_the_mouse_stays(void)
{
    struct zoom zoom = fitted(800, 600);
    double before[2], after[2];
    for (int i = 0; i < 20; i++) {
        zoom_to_picture(&zoom, 123, 77, &before[0], &before[1]);
        zoom_by(&zoom, i < 12 ? 1.3 : 0.6, 123, 77);
        zoom_to_picture(&zoom, 123, 77, &after[0], &after[1]);
        CHECK_NEAR(after[0], before[0], 1e-9);
        CHECK_NEAR(after[1], before[1], 1e-9);
    }
    CHECK(!zoom.is_fitted);
}

static void turns_of_the_wheel_come_back_to_one(void)
{
    struct zoom zoom = fitted(300, 200);
    for (int i = 0; i < 7; i++)
        zoom_by(&zoom, pow(2, 0.25), 50, 50);
    for (int i = 0; i < 7; i++)
        zoom_by(&zoom, pow(2, -0.25), 50, 50);
    CHECK(zoom.scale == 1);
}

static void scales_end_somewhere(void)
{
    struct zoom zoom = fitted(200, 100);
    for (int i = 0; i < 100; i++)
        zoom_by(&zoom, 2, 50, 50);
    CHECK(zoom.scale == 64);
    for (int i = 0; i < 100; i++)
        zoom_by(&zoom, 0.5, 50, 50);
    CHECK(zoom.scale == 1 / 64.0);
}

static void every_pixel_of_the_screen_picks_its_own(void)
{
    const struct zoom zoom = fitted(300, 200);
    int32_t x, y;
    for (int i = 0; i < 300; i++) {
        CHECK(zoom_pick(&zoom, 300, 200, 60 + i, 70 + i / 2, &x, &y));
        CHECK(x == i && y == i / 2);
    }
    CHECK(!zoom_pick(&zoom, 300, 200, 59, 130, &x, &y));
    CHECK(!zoom_pick(&zoom, 300, 200, 360, 130, &x, &y));
    CHECK(!zoom_pick(&zoom, 300, 200, 130, 69, &x, &y));
    CHECK(!zoom_pick(&zoom, 300, 200, 130, 270, &x, &y));
}

static void the_picture_cannot_be_lost(void)
{
    struct zoom zoom = fitted(200, 100);
    zoom_pan(&zoom, 1e6, -1e6);
    zoom_settle(&zoom, &area, 200, 100);
    CHECK(zoom.x <= area.x + area.width - 20);
    CHECK(zoom.y + 100 * zoom.scale >= area.y + 20);
}

static void an_area_of_one_pixel_is_survived(void)
{
    const struct area tiny = {0, 0, 1, 1};
    struct zoom zoom = {.aspect = 1};
    int32_t x, y;
    zoom_fit(&zoom, &tiny, 8192, 4320);
    CHECK(zoom.scale > 0 && isfinite(zoom.x) && isfinite(zoom.y));
    zoom_by(&zoom, 2, 0, 0);
    zoom_settle(&zoom, &tiny, 8192, 4320);
    zoom_pick(&zoom, 8192, 4320, 0, 0, &x, &y);
    CHECK(isfinite(zoom.x) && isfinite(zoom.y));
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_picture_about_as_large_is_shown_as_it_is);
    TEST(a_small_picture_is_magnified);
    TEST(a_large_picture_fits);
    TEST(wide_pixels_are_shown_wide);
    TEST(the_point_below_the_mouse_stays);
    TEST(turns_of_the_wheel_come_back_to_one);
    TEST(scales_end_somewhere);
    TEST(every_pixel_of_the_screen_picks_its_own);
    TEST(the_picture_cannot_be_lost);
    TEST(an_area_of_one_pixel_is_survived);
    return testing_end();
}
