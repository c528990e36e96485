/* SPDX-License-Identifier: Apache-2.0 */
/* The eye on the lens: how far things move, what comes to light, real views. */
#include <stdlib.h>

#include "pixels/input.h"
#include "pixels/relief.h"
#include "testing.h"

enum { WIDTH = 96, HEIGHT = 40, N = WIDTH * HEIGHT };

/* A near post before a far wall whose px say their column. */
static void paint(float *colour, float *planar, double post_x, double wall_shift)
{
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            const int i = y * WIDTH + x;
            const bool is_post = x >= post_x && x < post_x + 10;
            planar[i] = is_post ? 2 : 8;
            colour[3 * i] = is_post ? 1 : 0;
            colour[3 * i + 1] = is_post ? 0 : (float)(x - wall_shift) / WIDTH;
            colour[3 * i + 2] = (float)y / HEIGHT;
        }
}

static struct input *make_input(int n_views)
{
    struct input *input = input_create(WIDTH, HEIGHT, 3, n_views);
    for (int i = 0; i < n_views; i++) {
        float *colour = malloc(3 * N * sizeof(float));
        float *planar = malloc(N * sizeof(float));
        input->views[i] =
            (struct rf_view){.colour = rf_image_packed(colour, WIDTH, HEIGHT, 3),
                             .depth = rf_image_packed(planar, WIDTH, HEIGHT, 1)};
        paint(colour, planar, 40, 0);
    }
    return input;
}

/* K = lens radius times focal length in px = 0.5 * 64; focus at 4. */
static struct rf_params make_params(void)
{
    struct rf_params params;
    rf_params_init(&params);
    params.lens_radius = 0.5;
    params.focal_length_px = 64;
    params.focus_distance = 4;
    return params;
}

static bool prepare(struct input *input, struct rf_lens *lens)
{
    const struct rf_params params = make_params();
    struct rf_context *context;
    rf_context_create(&context, NULL, NULL);
    const bool is_good = input_prepare(input, context, &params, NULL) &&
                         rf_lens_init(lens, &params, WIDTH, HEIGHT, NULL) == RF_OK;
    rf_context_destroy(context);
    return is_good;
}

/* First column of the post in row y; -1 for none. */
static int find_post(const float *colour, int y)
{
    for (int x = 0; x < WIDTH; x++)
        if (colour[3 * (y * WIDTH + x)] == 1)
            return x;
    return -1;
}

static void no_shift_is_the_picture(void)
{
    struct input *input = make_input(1);
    struct rf_lens lens;
    float out[3 * N];
    int view;
    REQUIRE(prepare(input, &lens));
    input_see(input, &lens, (const double[2]){0, 0}, out, &view);
    CHECK(memcmp(out, input->views[0].colour.data, sizeof(out)) == 0);
    input_drop(input);
}

static void things_move_by_their_radius(void)
{
    struct input *input = make_input(1);
    struct rf_lens lens;
    float out[3 * N];
    int view;
    REQUIRE(prepare(input, &lens));
    /* The post's radius is 32 (1/4 - 1/2) = -8, the wall's 32 (1/4 - 1/8) = 4. */
    CHECK_NEAR(rf_lens_radius_px(&lens, 2), -8, 1e-9);
    input_see(input, &lens, (const double[2]){1, 0}, out, &view);
    CHECK(find_post(out, 20) == 32);
    CHECK_NEAR(out[3 * (20 * WIDTH + 80) + 1] * WIDTH, 80 - 4, 1e-3);
    input_see(input, &lens, (const double[2]){-0.5, 0}, out, &view);
    CHECK(find_post(out, 20) == 44);
    /* The eye upwards: what is near goes down, rows grow downwards. */
    input_see(input, &lens, (const double[2]){0, 1}, out, &view);
    CHECK_NEAR(out[3 * (20 * WIDTH + 45) + 2] * HEIGHT, 20 - 8, 1e-3);
    CHECK_NEAR(out[3 * (20 * WIDTH + 80) + 2] * HEIGHT, 20 + 4, 1e-3);
    input_drop(input);
}

static void what_comes_to_light_is_background(void)
{
    struct input *input = make_input(1);
    struct rf_lens lens;
    float out[3 * N];
    int view;
    REQUIRE(prepare(input, &lens));
    input_see(input, &lens, (const double[2]){1, 0}, out, &view);
    int n_post = 0;
    for (int x = 0; x < WIDTH; x++)
        n_post += out[3 * (20 * WIDTH + x)] == 1;
    CHECK(n_post == 10); /* it is as wide as it was: nothing of it fills the hole */
    input_drop(input);
}

static void infinity_is_far(void)
{
    struct input *input = make_input(1);
    struct rf_lens lens;
    float out[3 * N];
    float *planar = input->views[0].depth.data;
    int view;
    for (int i = 0; i < N; i++)
        planar[i] = planar[i] == 8 ? INFINITY : planar[i];
    REQUIRE(prepare(input, &lens));
    input_see(input, &lens, (const double[2]){0.5, 0}, out, &view);
    CHECK_NEAR(out[3 * (20 * WIDTH + 80) + 1] * WIDTH, 80 - 4, 1e-3);
    input_drop(input);
}

/* Views taken at u = -1 and 1 with parallel cameras, as a renderer would make them: a
 * place o sees depth z moved by -o f_px / z. */
static struct input *make_views(void)
{
    struct input *input = make_input(2);
    for (int i = 0; i < 2; i++) {
        const double o = i ? 0.5 : -0.5;
        input->views[i].lens_offset[0] = o;
        paint(input->views[i].colour.data, input->views[i].depth.data, 40 - o * 64 / 2,
              -o * 64 / 8);
    }
    return input;
}

static void the_middle_is_between_the_views(void)
{
    struct input *input = make_views();
    struct rf_lens lens;
    REQUIRE(prepare(input, &lens));
    CHECK(find_post(input->colour, 20) == 40);
    CHECK_NEAR(input->colour[3 * (20 * WIDTH + 70) + 1] * WIDTH, 70, 1e-3);
    CHECK(input->planar[20 * WIDTH + 44] == 2 && input->planar[20 * WIDTH + 70] == 8);
    CHECK(input->nearest == 2 && input->farthest == 8);
    input_drop(input);
}

static void the_nearest_view_is_taken(void)
{
    struct input *input = make_views();
    struct rf_lens lens;
    float out[3 * N];
    int view = -1;
    REQUIRE(prepare(input, &lens));
    input_see(input, &lens, (const double[2]){1, 0}, out, &view);
    CHECK(view == 1);
    /* As one picture from the middle would say: by the radius. */
    CHECK(find_post(out, 20) == 32);
    CHECK_NEAR(out[3 * (20 * WIDTH + 80) + 1] * WIDTH, 80 - 4, 1e-3);
    input_see(input, &lens, (const double[2]){-0.25, 0}, out, &view);
    CHECK(view == 0);
    CHECK(find_post(out, 20) == 42);
    input_drop(input);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(no_shift_is_the_picture);
    TEST(things_move_by_their_radius);
    TEST(what_comes_to_light_is_background);
    TEST(infinity_is_far);
    TEST(the_middle_is_between_the_views);
    TEST(the_nearest_view_is_taken);
    return testing_end();
}
