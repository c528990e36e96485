/* SPDX-License-Identifier: Apache-2.0 */
/* Pictures that are made colour by colour: what the colours share is right for each. */
#include <math.h>
#include <stdlib.h>

#include "physics/frames.h"
#include "testing.h"

enum { W = 150, H = 110, N = 20 };

static struct rf_image out_of(struct frame *f)
{
    return rf_image_packed(f->out, f->width, f->height, f->channels);
}

/* The scene through an aperture with a picture of so many channels. */
static void filter_with(struct frame *f, const struct rf_params *p, float *picture,
                        int channels)
{
    const struct rf_image aperture = rf_image_packed(picture, N, N, channels);
    struct rf_view view = {.colour = rf_image_packed(f->colour, W, H, 3),
                           .depth = rf_image_packed(f->depth, W, H, 1)};
    struct rf_image out = out_of(f);
    struct rf_context *context;
    struct rf_filter *filter;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create_with(&filter, context, p, W, H, &aperture, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* Posts, a floor through the focus and lamps behind it. */
static struct frame make_scene(void)
{
    struct frame f = frame_make(W, H, 3);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            bool is_post = x % 50 < 6;
            bool is_lamp = !is_post && x % 25 == 15 && y % 30 == 10;
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] =
                    is_lamp ? 300 : (float)((x / 7 + y / 5 + c) % 3) * 0.4f;
            f.depth[y * W + x] = plain_depth(is_post ? -20 : 24 - 0.3 * y);
        }
    return f;
}

/* An aperture in colour gives each colour what an aperture in grey gives, whose light is
 * that of the colour. */
static void a_coloured_aperture_is_three_grey_ones(void)
{
    static float coloured[N * N * 3], grey[N * N];
    for (int i = 0; i < N * N * 3; i++)
        coloured[i] = (float)(i * 7 % 11);
    for (int cells = 1; cells <= 4; cells += 3) {
        struct frame f = make_scene(), other = make_scene();
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.aperture = RF_APERTURE_IMAGE;
        p.sub_apertures = cells;
        p.swirl = cells == 4 ? 0.3 : 0;
        filter_with(&f, &p, coloured, 3);
        for (int c = 0; c < 3; c++) {
            double most = 0;
            for (int i = 0; i < N * N; i++)
                grey[i] = coloured[3 * i + c];
            filter_with(&other, &p, grey, 1);
            for (size_t i = (size_t)c; i < 3 * frame_pixels(&f); i += 3)
                most = fmax(most, fabs((double)(f.out[i] - other.out[i])));
            CHECK_NEAR(most, 0, 1e-4);
        }
        frame_free(&f);
        frame_free(&other);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_coloured_aperture_is_three_grey_ones);
    return testing_end();
}
