/* SPDX-License-Identifier: Apache-2.0 */
/* The method views on a plane, where each view is the middle one moved. */
#include <stdio.h>

#include "physics/frames.h"
#include "testing.h"

/* The most views share cells. */
enum { WIDTH = 96, HEIGHT = 72, N_VIEWS = 5, MOST_VIEWS = 12, R_PX = 4, MARGIN = 20 };

/* Points of the unit lens at which the plane's picture moves by whole pixels. */
static const double points[MOST_VIEWS][2] = {
    {0, 0},      {0.75, 0},     {-0.5, 0.5}, {0, -0.75},    {0.25, 0.5}, {-0.75, -0.25},
    {0.5, -0.5}, {-0.25, 0.75}, {-0.5, 0},   {-0.5, -0.75}, {0.5, 0.25}, {0.25, -0.25}};

typedef float (*light_fn)(int x, int y);

static float waves(int x, int y)
{
    return 0.5f + 0.2f * sinf((float)x * 0.35f) + 0.2f * cosf((float)y * 0.28f);
}

/* A lamp of 2 x 2 pixels in the dark. */
static float lamp(int x, int y)
{
    return x / 2 == WIDTH / 4 && y / 2 == HEIGHT / 4 ? 250 : 0;
}

/* What the n first views make of a plane that the lens blurs by R_PX. */
static struct frame merged_channels(light_fn light, int n, int channels,
                                    const struct rf_params *params, int n_threads)
{
    struct frame views[MOST_VIEWS], result = frame_make(WIDTH, HEIGHT, channels);
    struct rf_view view[MOST_VIEWS];
    for (int j = 0; j < n; j++) {
        views[j] = frame_make(WIDTH, HEIGHT, channels);
        int dx = (int)(points[j][0] * R_PX), dy = -(int)(points[j][1] * R_PX);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++)
                for (int c = 0; c < channels; c++)
                    frame_at(&views[j], views[j].colour, x, y)[c] =
                        c == 3 ? 1 : light(x - dx, y - dy);
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            views[j].depth[i] = plain_depth(R_PX);
        view[j] = (struct rf_view){
            .colour = rf_image_packed(views[j].colour, WIDTH, HEIGHT, channels),
            .depth = rf_image_packed(views[j].depth, WIDTH, HEIGHT, 1),
            .lens_offset = {points[j][0] * 40, points[j][1] * 40},
            .shear_distance = PLAIN_FOCUS};
    }
    struct rf_context_params run = {.size = sizeof run, .n_threads = n_threads};
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image out = rf_image_packed(result.out, WIDTH, HEIGHT, channels);
    CHECK(rf_context_create(&context, &run, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, params, WIDTH, HEIGHT, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, view, n, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 0; j < n; j++)
        frame_free(&views[j]);
    return result;
}

static struct frame merged(light_fn light, int n, const struct rf_params *params,
                           int n_threads)
{
    return merged_channels(light, n, 3, params, n_threads);
}

/* Largest difference away from the border, where no view shows all that is needed. */
static double largest_difference(const struct frame *a, const struct frame *b)
{
    double most = 0;
    for (int y = MARGIN; y < HEIGHT - MARGIN; y++)
        for (int x = MARGIN; x < WIDTH - MARGIN; x++)
            most = fmax(
                most, fabs(a->out[(y * WIDTH + x) * 3] - b->out[(y * WIDTH + x) * 3]));
    return most;
}

/*
 * The cells of the lens put together are the lens, for any number of views; and where
 * another focus moves the views by parts of a pixel.
 */
static void a_plane_is_blurred_as_by_one_view(void)
{
    for (int k = 0; k < 4; k++) {
        struct rf_params params;
        plain_params(&params, RF_METHOD_VIEWS);
        params.blades = k & 1 ? 5 : 0;
        if (k & 2)
            params.focus_distance = plain_depth(1.3);
        struct frame one = merged(waves, 1, &params, 1);
        for (int n = 2; n <= MOST_VIEWS; n++) {
            struct frame several = merged(waves, n, &params, 1);
            CHECK(largest_difference(&one, &several) < 5e-3);
            frame_free(&several);
        }
        frame_free(&one);
    }
}

/* A near and a far plane of noise, of which a view shows `near` columns. */
static void fill_planes(struct frame *f, int near)
{
    uint32_t state = 3;
    for (size_t i = 0; i < frame_pixels(f) * 3; i++)
        f->colour[i] = (float)random_unit(&state);
    for (int i = 0; i < f->width * f->height; i++)
        f->depth[i] = i % f->width < near ? 3 : 12;
}

/* The tilt of a lens as large as can be makes radii that are beyond whole numbers. */
static void any_lens_can_be_tilted(void)
{
    struct rf_params params;
    struct rf_view views[3];
    struct frame frames[3];
    plain_params(&params, RF_METHOD_VIEWS);
    params.focus_distance = 17;
    params.max_radius = 50;
    params.tilt_x = 36;
    params.lens_radius = 9e8;
    for (int j = 0; j < 3; j++) {
        frames[j] = frame_make(98, 11, 3);
        fill_planes(&frames[j], 40 + j);
        views[j] =
            (struct rf_view){.colour = rf_image_packed(frames[j].colour, 98, 11, 3),
                             .depth = rf_image_packed(frames[j].depth, 98, 11, 1),
                             .lens_offset = {points[j][0] * 9e7, points[j][1] * 9e7},
                             .shear_distance = params.focus_distance};
    }
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image out = rf_image_packed(frames[0].out, 98, 11, 3);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &params, 98, 11, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, views, 3, &out, NULL, NULL) == RF_OK);
    for (size_t i = 0; i < frame_pixels(&frames[0]) * 3; i++)
        CHECK(isfinite(frames[0].out[i]));
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 0; j < 3; j++)
        frame_free(&frames[j]);
}

enum { N_TILTED = 5 };

/* A plane whose radius grows by -SLOPE px per px to the right, where `views` of it were
 * sheared to a plane that faces the camera. */
static const double SLOPE = 0.1;

static void make_tilted(struct frame *frames, struct rf_view *views)
{
    double middle = WIDTH / 2.0;
    for (int j = 0; j < N_TILTED; j++) {
        struct frame *f = &frames[j];
        double u = points[j][0], v = points[j][1];
        *f = frame_make(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            double seen = i % WIDTH + 0.5;
            double x = (seen - u * SLOPE * middle) / (1 - u * SLOPE);
            double r = -SLOPE * (x - middle), y = i / WIDTH + 0.5 + v * r;
            for (int c = 0; c < 3; c++)
                f->colour[3 * i + c] =
                    (float)(0.5 + 0.2 * sin(x * 0.35) + 0.2 * cos(y * 0.28));
            f->depth[i] = plain_depth(r);
        }
        views[j] =
            (struct rf_view){.colour = rf_image_packed(f->colour, WIDTH, HEIGHT, 3),
                             .depth = rf_image_packed(f->depth, WIDTH, HEIGHT, 1),
                             .lens_offset = {u * 40, v * 40},
                             .shear_distance = PLAIN_FOCUS};
    }
}

/*
 * A plane in a tilted lens' focus is as sharp of several views as it is, but for 2.6e-3
 * of a contrast of 0.8 where samples lie 10 % closer or wider than pixels.
 */
static void a_tilted_plane_is_in_focus(void)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct frame frames[N_TILTED];
    struct rf_view views[N_TILTED];
    static float made[WIDTH * HEIGHT * 3];
    struct rf_image out = rf_image_packed(made, WIDTH, HEIGHT, 3);
    make_tilted(frames, views);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    for (int tilted = 0; tilted < 2; tilted++) {
        double most = 0;
        plain_params(&params, RF_METHOD_VIEWS);
        /* 40000 px of radius per 1 / z, a lens of 0.05 and 1000 px */
        params.tilt_x = tilted * asin(SLOPE * 0.05 * 1000 / 40000) * 180 / acos(-1);
        REQUIRE(rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) ==
                RF_OK);
        REQUIRE(rf_filter_process(filter, views, N_TILTED, &out, NULL, NULL) == RF_OK);
        for (int y = MARGIN; y < HEIGHT - MARGIN; y++)
            for (int x = MARGIN; x < WIDTH - MARGIN; x++)
                most = fmax(most, fabs(made[3 * (y * WIDTH + x)] -
                                       frames[0].colour[3 * (y * WIDTH + x)]));
        CHECK(tilted ? most < 3e-3 : most > 0.02);
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    for (int j = 0; j < N_TILTED; j++)
        frame_free(&frames[j]);
}

/* What the views of the tilted plane make where one pixel has `depth`. */
static void merge_tilted(struct frame *frames, struct rf_view *views, float depth,
                         const struct rf_params *params, float *made)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image out = rf_image_packed(made, WIDTH, HEIGHT, 3);
    frames[0].depth[HEIGHT / 2 * WIDTH + WIDTH / 2] = depth;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, params, WIDTH, HEIGHT, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, views, N_TILTED, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* A radius beyond all numbers is the largest, wherever the focus is bent. */
static void next_to_the_camera_before_a_bent_focus(void)
{
    static float near[WIDTH * HEIGHT * 3], nearest[WIDTH * HEIGHT * 3];
    struct frame frames[N_TILTED];
    struct rf_view views[N_TILTED];
    struct rf_params params;
    make_tilted(frames, views);
    for (int bent = 0; bent < 3; bent++) {
        plain_params(&params, RF_METHOD_VIEWS);
        params.max_radius = 20;
        params.tilt_x = bent == 0 ? 5 : 0;
        params.field_curvature = bent == 1 ? 1e-4 : 0;
        params.split_diopter = bent == 2 ? 80 : 0;
        merge_tilted(frames, views, 1, &params, near);
        merge_tilted(frames, views, 1e-40f, &params, nearest);
        CHECK(memcmp(near, nearest, sizeof near) == 0);
    }
    for (int j = 0; j < N_TILTED; j++)
        frame_free(&frames[j]);
}

static void a_lamp_keeps_its_light(void)
{
    struct rf_params params;
    plain_params(&params, RF_METHOD_VIEWS);
    for (int n = 1; n <= MOST_VIEWS; n++) {
        struct frame f = merged(lamp, n, &params, 1);
        double sum = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++)
            sum += f.out[3 * i];
        CHECK_NEAR(sum / (4 * 250), 1, 2e-3);
        frame_free(&f);
    }
}

/* Grey and opaque pictures are their colour; so is a lens stopped down. */
static void grey_and_alpha(void)
{
    static const double radii[] = {40, 6};
    for (int k = 0; k < 4; k++) {
        struct rf_params params;
        plain_params(&params, RF_METHOD_VIEWS);
        params.lens_radius = radii[k % 2];
        light_fn light = k < 2 ? waves : lamp;
        struct frame rgb = merged_channels(light, N_VIEWS, 3, &params, 2);
        struct frame grey = merged_channels(light, N_VIEWS, 1, &params, 2);
        struct frame rgba = merged_channels(light, N_VIEWS, 4, &params, 2);
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                double v = frame_at(&rgb, rgb.out, x, y)[1];
                const float *with_alpha = frame_at(&rgba, rgba.out, x, y);
                CHECK_NEAR(frame_at(&grey, grey.out, x, y)[0], v, 1e-4 * (1 + v));
                CHECK_NEAR(with_alpha[1], v, 1e-4 * (1 + v));
                CHECK_NEAR(with_alpha[3], 1, 1e-4);
            }
        frame_free(&rgb);
        frame_free(&grey);
        frame_free(&rgba);
    }
}

/* Of all views, and stopped down to the place of one; in focus elsewhere. */
static void same_bits_for_any_threads(void)
{
    static const double radii[] = {40, 6}, focus[] = {PLAIN_FOCUS, 0.9 * PLAIN_FOCUS};
    for (int k = 0; k < 8; k++) {
        struct rf_params params;
        plain_params(&params, RF_METHOD_VIEWS);
        params.lens_radius = radii[k % 2];
        params.focus_distance = focus[k / 2 % 2];
        int n = k < 4 ? N_VIEWS : MOST_VIEWS;
        struct frame one = merged(waves, n, &params, 1);
        for (int threads = 2; threads <= 7; threads += 5) {
            struct frame many = merged(waves, n, &params, threads);
            CHECK(memcmp(one.out, many.out, frame_bytes(&one)) == 0);
            frame_free(&many);
        }
        frame_free(&one);
    }
}

/* Numbers that look random, of variance 1. */
static float noise(uint32_t seed)
{
    seed = (seed ^ (seed >> 16)) * 0x7feb352du;
    seed = (seed ^ (seed >> 15)) * 0x846ca68bu;
    seed ^= seed >> 16;
    return ((float)(seed >> 8) * 0x1p-24f - 0.5f) * sqrtf(12);
}

/*
 * The deviation of what n views make of a grey plane of radius r_px, each with noise of
 * variance n: the samples of one picture shared out.
 */
static double grain(int n, double r_px)
{
    enum { MOST = 32 };
    static struct rf_lens_point lens[MOST];
    struct frame views[MOST], result = frame_make(WIDTH, HEIGHT, 3);
    struct rf_view view[MOST];
    struct rf_params params;
    struct rf_image out = rf_image_packed(result.out, WIDTH, HEIGHT, 3);
    plain_params(&params, RF_METHOD_VIEWS);
    CHECK(rf_lens_points(&params, n, 0, lens, NULL) == RF_OK);
    for (int j = 0; j < n; j++) {
        views[j] = frame_make(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            float v = 0.5f + 0.02f * sqrtf((float)n) * noise((uint32_t)(i * MOST + j));
            for (int c = 0; c < 3; c++)
                views[j].colour[3 * i + c] = v;
            views[j].depth[i] = plain_depth(r_px);
        }
        view[j] = (struct rf_view){
            .colour = rf_image_packed(views[j].colour, WIDTH, HEIGHT, 3),
            .depth = rf_image_packed(views[j].depth, WIDTH, HEIGHT, 1),
            .lens_offset = {lens[j].u * 40, lens[j].v * 40},
            .shear_distance = PLAIN_FOCUS};
    }
    struct rf_context_params run = {.size = sizeof run, .n_threads = 2};
    struct rf_context *context;
    struct rf_filter *filter;
    CHECK(rf_context_create(&context, &run, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, view, n, &out, NULL, NULL) == RF_OK);
    double squares = 0;
    for (int y = MARGIN; y < HEIGHT - MARGIN; y++)
        for (int x = MARGIN; x < WIDTH - MARGIN; x++)
            squares += pow(result.out[(y * WIDTH + x) * 3] - 0.5, 2);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 0; j < n; j++)
        frame_free(&views[j]);
    frame_free(&result);
    return sqrt(squares / ((WIDTH - 2 * MARGIN) * (HEIGHT - 2 * MARGIN)));
}

/* Cells of one view each had 1.8 times the grain with 32. */
static void many_views_are_no_grainier(void)
{
    static const double radii[] = {0.3, 1, 2, 3.5, 7};
    for (int k = 0; k < 5; k++) {
        double eight = grain(8, radii[k]);
        for (int n = 12; n <= 32; n = n == 12 ? 16 : 2 * n) {
            double many = grain(n, radii[k]);
            printf("# radius %g: 8 views %.5f, %d views %.5f\n", radii[k], eight, n,
                   many);
            CHECK(many < 1.07 * eight);
        }
    }
}

/* Refocused to the plane, it is what the views show there, and nothing is dark. */
static void refocused_it_is_sharp(void)
{
    struct rf_params params;
    plain_params(&params, RF_METHOD_VIEWS);
    params.focus_distance = plain_depth(R_PX);
    struct frame f = merged(waves, N_VIEWS, &params, 2);
    double most = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            most = fmax(most, fabs(f.out[(y * WIDTH + x) * 3] - waves(x, y)));
    CHECK(most < 0.02);
    frame_free(&f);
}

/*
 * A dark post before a slanted floor, on which a bright stripe lies that one of two
 * views does not see: the other one shows it.
 */
static void a_view_shows_what_the_other_does_not(void)
{
    static const double lens[2] = {-0.5, 0.5};
    struct frame views[2], result = frame_make(WIDTH, HEIGHT, 3);
    struct rf_view view[2];
    for (int j = 0; j < 2; j++) {
        views[j] = frame_make(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            int y = i / WIDTH;
            double r = R_PX + 0.1 * (y - HEIGHT / 2), x = i % WIDTH;
            double on_floor = x - lens[j] * r, on_post = x + lens[j] * R_PX;
            bool is_post = fabs(on_post - WIDTH / 2) < 4;
            bool is_lit = !is_post && fabs(on_floor - (WIDTH / 2 - 4)) < 3;
            for (int c = 0; c < 3; c++)
                views[j].colour[3 * i + c] = is_lit ? 2 : 0.05f;
            views[j].depth[i] = plain_depth(is_post ? -R_PX : r);
        }
        view[j] = (struct rf_view){
            .colour = rf_image_packed(views[j].colour, WIDTH, HEIGHT, 3),
            .depth = rf_image_packed(views[j].depth, WIDTH, HEIGHT, 1),
            .lens_offset = {lens[j] * 40, 0},
            .shear_distance = PLAIN_FOCUS};
    }
    struct rf_params params;
    struct rf_filter *filter;
    struct rf_context *context;
    struct rf_image out = rf_image_packed(result.out, WIDTH, HEIGHT, 3);
    plain_params(&params, RF_METHOD_VIEWS);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, view, 2, &out, NULL, NULL) == RF_OK);
    double sum = 0;
    for (int x = 0; x < WIDTH; x++)
        sum += result.out[3 * (HEIGHT / 2 * WIDTH + x)] - 0.05;
    CHECK(sum > 6); /* 6.3; 5.5 where only one view shows the stripe */
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 0; j < 2; j++)
        frame_free(&views[j]);
    frame_free(&result);
}

/*
 * What a lamp of one pixel, blurred by 20 px, leaves beside a bar that hides it from
 * the left half of the lens: light to the left and to the right of it. Its place is the
 * edge of two pixels, and views show it in both.
 */
static void half_a_lamp(double light[2])
{
    enum { N = 8 };
    static const double R = 20, X = WIDTH / 2, Y = HEIGHT / 2 + 0.3;
    struct frame views[N], result = frame_make(WIDTH, HEIGHT, 3);
    struct rf_view view[N];
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image out = rf_image_packed(result.out, WIDTH, HEIGHT, 3);
    for (int j = 0; j < N; j++) {
        double rho = sqrt((j + 0.5) / N), angle = j * 2.399963;
        double u = rho * cos(angle), v = rho * sin(angle);
        int lamp_x = (int)floor(X + u * R), lamp_y = (int)floor(Y - v * R);
        views[j] = frame_make(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            int x = i % WIDTH, y = i / WIDTH;
            bool is_bar = x + 0.5 < X - u * R;
            for (int c = 0; c < 3; c++)
                views[j].colour[3 * i + c] =
                    !is_bar && x == lamp_x && y == lamp_y ? 1000 : 0;
            views[j].depth[i] = plain_depth(is_bar ? -R : R);
        }
        view[j] = (struct rf_view){
            .colour = rf_image_packed(views[j].colour, WIDTH, HEIGHT, 3),
            .depth = rf_image_packed(views[j].depth, WIDTH, HEIGHT, 1),
            .lens_offset = {u * 40, v * 40},
            .shear_distance = PLAIN_FOCUS};
    }
    plain_params(&params, RF_METHOD_VIEWS);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, view, N, &out, NULL, NULL) == RF_OK);
    light[0] = light[1] = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        light[i % WIDTH + 0.5 > X] += result.out[3 * i] / 1000;
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 0; j < N; j++)
        frame_free(&views[j]);
    frame_free(&result);
}

static void a_small_lamp_is_hidden_from_half_the_lens(void)
{
    double light[2];
    half_a_lamp(light);
    CHECK(light[0] < 5e-3);
    CHECK_NEAR(light[1], 0.5, 5e-3);
}

/*
 * A lamp behind the edge of a card in focus, and a wire across all of it before the
 * card: what each view shows at pixel (x, y) from lens point (u, v), as radius; `light`
 * receives its colour.
 */
static double card_and_wire(double u, double v, double x, double y, float *light)
{
    static const double R = 20, CARD_X = WIDTH / 2, LAMP_X = WIDTH / 2 - 4;
    *light = 0.2f;
    if (fabs(y - v * R - HEIGHT / 2) < 2)
        return -R;
    if (x < CARD_X)
        return 0;
    bool is_lamp = fabs(x - u * R - LAMP_X) < 2 && fabs(y + v * R - HEIGHT / 2) < 2;
    *light = is_lamp ? 200 : 0;
    return R;
}

static void a_wire_before_a_card_lets_no_lamp_through_it(void)
{
    enum { N = 8 };
    struct frame views[N], result = frame_make(WIDTH, HEIGHT, 3);
    struct rf_view view[N];
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image out = rf_image_packed(result.out, WIDTH, HEIGHT, 3);
    for (int j = 0; j < N; j++) {
        double rho = sqrt((j + 0.5) / N), angle = j * 2.399963;
        double u = rho * cos(angle), v = rho * sin(angle);
        views[j] = frame_make(WIDTH, HEIGHT, 3);
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            float light;
            double r = card_and_wire(u, v, i % WIDTH + 0.5, i / WIDTH + 0.5, &light);
            views[j].depth[i] = plain_depth(r);
            for (int c = 0; c < 3; c++)
                views[j].colour[3 * i + c] = light;
        }
        view[j] = (struct rf_view){
            .colour = rf_image_packed(views[j].colour, WIDTH, HEIGHT, 3),
            .depth = rf_image_packed(views[j].depth, WIDTH, HEIGHT, 1),
            .lens_offset = {u * 40, v * 40},
            .shear_distance = PLAIN_FOCUS};
    }
    plain_params(&params, RF_METHOD_VIEWS);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, view, N, &out, NULL, NULL) == RF_OK);
    float most = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        if (i % WIDTH < WIDTH / 2 - 3)
            most = fmaxf(result.out[3 * i], most);
    CHECK_NEAR(most, 0.2, 0.02); /* 2.7 where what the wire hides blocks nothing */
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 0; j < N; j++)
        frame_free(&views[j]);
    frame_free(&result);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(any_lens_can_be_tilted);
    TEST(a_plane_is_blurred_as_by_one_view);
    TEST(a_tilted_plane_is_in_focus);
    TEST(next_to_the_camera_before_a_bent_focus);
    TEST(a_lamp_keeps_its_light);
    TEST(grey_and_alpha);
    TEST(same_bits_for_any_threads);
    TEST(many_views_are_no_grainier);
    TEST(refocused_it_is_sharp);
    TEST(a_view_shows_what_the_other_does_not);
    TEST(a_small_lamp_is_hidden_from_half_the_lens);
    TEST(a_wire_before_a_card_lets_no_lamp_through_it);
    return testing_end();
}
