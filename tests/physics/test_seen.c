/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rf_view.seen: what a flat mirror shows is a room behind a hole in the wall. It has the
 * blur of its own way, the edge of the hole that of the mirror, and what stands before
 * the mirror hides it.
 */
#include "physics/frames.h"
#include "testing.h"

enum {
    WIDTH = 128,
    HEIGHT = 96,
    N = WIDTH * HEIGHT,
    LEFT = 32, /* the mirror */
    RIGHT = 96,
    TOP = 16,
    BOTTOM = 80,
    ROOM_PX = 12,
    N_VIEWS = 2,
};

/* A mirror in a wall. The light is what it shows; colour is all of it. */
struct scene {
    struct frame f;
    float light[3 * N], seen[N];
    double mirror_px, wall_px;
    int post; /* columns of a dark post before the mirror */
};

static bool is_mirror(int x, int y)
{
    return x >= LEFT && x < RIGHT && y >= TOP && y < BOTTOM;
}

static bool is_post(const struct scene *s, int x)
{
    return x >= 60 && x < 60 + s->post;
}

static struct scene make(double mirror_px, double wall_px)
{
    struct scene s = {
        .f = frame_make(WIDTH, HEIGHT, 3), .mirror_px = mirror_px, .wall_px = wall_px};
    return s;
}

/* `wall` is the wall's grey, `dirt` that on the mirror. */
static void draw(struct scene *s, float wall, float dirt)
{
    uint32_t state = 3;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            int i = y * WIDTH + x;
            bool is_seen = is_mirror(x, y) && !is_post(s, x);
            float grey = (float)(0.2 + 0.5 * random_unit(&state));
            s->seen[i] = is_seen ? plain_depth(ROOM_PX) : NAN;
            s->f.depth[i] = plain_depth(is_post(s, x)     ? -10
                                        : is_mirror(x, y) ? s->mirror_px
                                                          : s->wall_px);
            for (int c = 0; c < 3; c++) {
                s->light[3 * i + c] = is_seen ? grey : 0;
                s->f.colour[3 * i + c] = is_post(s, x) ? 0
                                         : is_seen     ? grey + dirt
                                                       : wall;
            }
        }
}

/* Filters views, into the first one's `out`; or tells a window of the first one. */
static rf_result process(const struct rf_view *views, int n_views, float *out,
                         bool is_window, struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    const struct rf_image image = rf_image_packed(out, WIDTH, HEIGHT, 3);
    const struct rf_window whole = {0, 0, WIDTH, HEIGHT};
    struct rf_survey survey = {.size = sizeof survey};
    plain_params(&params, n_views > 1 ? RF_METHOD_VIEWS : RF_METHOD_LAYERED);
    if (rf_context_create(&context, NULL, NULL) != RF_OK ||
        rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) != RF_OK)
        abort();
    rf_result result =
        is_window ? rf_filter_survey(filter, views, &whole, &whole, &survey, error)
                  : rf_filter_process(filter, views, n_views, &image, NULL, error);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

/* A view of the scene, and the light of its mirror. */
static struct rf_view view_of(struct scene *s, struct rf_seen_light *light)
{
    *light = (struct rf_seen_light){rf_image_packed(s->light, WIDTH, HEIGHT, 3),
                                    rf_image_packed(s->seen, WIDTH, HEIGHT, 1)};
    return (struct rf_view){.size = sizeof(struct rf_view),
                            .colour = rf_image_packed(s->f.colour, WIDTH, HEIGHT, 3),
                            .depth = rf_image_packed(s->f.depth, WIDTH, HEIGHT, 1),
                            .seen = light,
                            .n_seen = 1};
}

static rf_result run_as(struct scene *s, bool is_window, struct rf_error *error)
{
    struct rf_seen_light light;
    const struct rf_view view = view_of(s, &light);
    return process(&view, 1, s->f.out, is_window, error);
}

static rf_result run(struct scene *s)
{
    return run_as(s, false, NULL);
}

/* The same colours and depths without a word of mirrors, into `out`. */
static void filter_plain(const float *colour, const float *depth, float *out)
{
    struct frame f = {WIDTH, HEIGHT, 3, (float *)colour, (float *)depth, out};
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    if (frame_filter(&f, &params, 1, NULL) != RF_OK)
        abort();
}

static double largest_difference(const float *a, const float *b, int margin,
                                 bool inside)
{
    double most = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            bool is_in = x >= LEFT + margin && x < RIGHT - margin &&
                         y >= TOP + margin && y < BOTTOM - margin;
            bool is_out = x < LEFT - margin || x >= RIGHT + margin ||
                          y < TOP - margin || y >= BOTTOM + margin;
            for (int c = 0; (inside ? is_in : is_out) && c < 3; c++) {
                int i = 3 * (y * WIDTH + x) + c;
                most = fmax(most, fabs((double)a[i] - b[i]));
            }
        }
    return most;
}

static float other[3 * N], depth[N], colour[3 * N];

static void a_lamp_has_the_disc_of_its_own_way(void)
{
    struct scene s = make(0, 0);
    double mass = 0, moment = 0;
    draw(&s, 0, 0);
    for (int i = 0; i < 3 * N; i++)
        s.light[i] = s.f.colour[i] = 0;
    for (int c = 0; c < 3; c++)
        s.light[3 * (48 * WIDTH + 64) + c] = s.f.colour[3 * (48 * WIDTH + 64) + c] =
            100;
    REQUIRE(run(&s) == RF_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++) {
            double v = s.f.out[3 * (y * WIDTH + x)];
            mass += v;
            moment += v * ((x - 64.0) * (x - 64.0) + (y - 48.0) * (y - 48.0));
        }
    CHECK_NEAR(mass, 100, 0.5);
    /* Of a disc of radius r: r^2 / 2. */
    CHECK_NEAR(sqrt(2 * moment / mass), ROOM_PX, 0.3);
    frame_free(&s.f);
}

/* Dark wall, dark mirror: nothing is there but the room behind the hole. */
static void a_mirror_is_a_hole_in_the_wall(void)
{
    for (int post = 0; post <= 8; post += 8) {
        struct scene s = make(1, 1);
        s.post = post;
        draw(&s, 0, 0);
        for (int i = 0; i < N; i++)
            depth[i] = isnan(s.seen[i]) ? s.f.depth[i] : s.seen[i];
        filter_plain(s.light, depth, other);
        REQUIRE(run(&s) == RF_OK);
        CHECK(largest_difference(s.f.out, other, 0, true) < 1e-6);
        CHECK(largest_difference(s.f.out, other, 0, false) < 1e-6);
        frame_free(&s.f);
    }
}

/* The same of several views: one of them has a post, behind which another sees. */
static void several_views_see_a_hole_in_the_wall(void)
{
    struct scene scenes[N_VIEWS];
    struct rf_seen_light lights[N_VIEWS];
    struct rf_view views[N_VIEWS], holes[N_VIEWS];
    static float hole_depth[N_VIEWS][N];
    for (int j = 0; j < N_VIEWS; j++) {
        struct scene *s = &scenes[j];
        *s = make(1, 1);
        s->post = 8 * j;
        draw(s, 0, 0);
        views[j] = view_of(s, &lights[j]);
        views[j].lens_offset[0] = j ? 20 : -20;
        views[j].shear_distance = PLAIN_FOCUS;
        for (int i = 0; i < N; i++)
            hole_depth[j][i] = isnan(s->seen[i]) ? s->f.depth[i] : s->seen[i];
        holes[j] = views[j];
        holes[j].n_seen = 0;
        holes[j].colour = lights[j].colour;
        holes[j].depth = rf_image_packed(hole_depth[j], WIDTH, HEIGHT, 1);
    }
    REQUIRE(process(holes, N_VIEWS, other, false, NULL) == RF_OK);
    REQUIRE(process(views, N_VIEWS, scenes[0].f.out, false, NULL) == RF_OK);
    CHECK(largest_difference(scenes[0].f.out, other, 0, true) < 1e-6);
    CHECK(largest_difference(scenes[0].f.out, other, 0, false) < 1e-6);
    filter_plain(scenes[0].light, hole_depth[0], colour); /* and not as one view */
    CHECK(largest_difference(scenes[0].f.out, colour, 0, true) > 0.01);
    for (int j = 0; j < N_VIEWS; j++)
        frame_free(&scenes[j].f);
}

/* A mirror in focus before a wall far behind: its edge is sharp, no light passes it. */
static void a_wall_behind_the_mirror_takes_nothing_of_it(void)
{
    struct scene s = make(0, 20);
    draw(&s, 0.5f, 0);
    for (int i = 0; i < N; i++) {
        depth[i] = plain_depth(ROOM_PX);
        for (int c = 0; c < 3; c++)
            colour[3 * i + c] = s.light[3 * i + c];
    }
    REQUIRE(run(&s) == RF_OK);
    filter_plain(colour, depth, other); /* the room alone, as far as it is shown */
    CHECK(largest_difference(s.f.out, other, ROOM_PX + 2, true) < 0.02);
    for (int i = 0; i < 3 * N; i++)
        other[i] = 0.5f;
    CHECK(largest_difference(s.f.out, other, 2, false) < 0.01);
    frame_free(&s.f);
}

static void dirt_on_the_mirror_stays_in_focus(void)
{
    struct scene s = make(0, 0);
    draw(&s, 0.1f, 0);
    for (int c = 0; c < 3; c++)
        s.f.colour[3 * (48 * WIDTH + 64) + c] += 0.3f;
    REQUIRE(run(&s) == RF_OK);
    float at = s.f.out[3 * (48 * WIDTH + 64)], beside = s.f.out[3 * (48 * WIDTH + 66)];
    CHECK_NEAR(at - beside, 0.3, 0.05);
    frame_free(&s.f);
}

static void light_of_no_depth_changes_nothing(void)
{
    struct scene s = make(4, 9);
    draw(&s, 0.3f, 0.1f);
    filter_plain(s.f.colour, s.f.depth, other);
    for (int i = 0; i < N; i++)
        s.seen[i] = i % 2 ? NAN : 0;
    REQUIRE(run(&s) == RF_OK);
    CHECK(memcmp(s.f.out, other, sizeof other) == 0);
    for (int i = 0; i < N; i++) /* nor an image before its surface */
        s.seen[i] = is_mirror(i % WIDTH, i / WIDTH) ? plain_depth(-5) : NAN;
    REQUIRE(run(&s) == RF_OK);
    CHECK(memcmp(s.f.out, other, sizeof other) == 0);
    frame_free(&s.f);
}

static void what_cannot_be_done_is_refused(void)
{
    struct scene s = make(0, 0);
    struct rf_error error;
    draw(&s, 0.1f, 0);
    struct rf_seen_light light;
    struct rf_view views[] = {view_of(&s, &light), view_of(&s, &light)};
    views[1].n_seen = 0; /* what is mirrored in one view only */
    CHECK(process(views, N_VIEWS, s.f.out, false, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "seen");
    CHECK(run_as(&s, true, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "seen");
    s.light[5] = INFINITY;
    CHECK(run_as(&s, false, &error) == RF_ERROR_PIXEL);
    CHECK_STR(error.field, "seen");
    frame_free(&s.f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_lamp_has_the_disc_of_its_own_way);
    TEST(a_mirror_is_a_hole_in_the_wall);
    TEST(several_views_see_a_hole_in_the_wall);
    TEST(a_wall_behind_the_mirror_takes_nothing_of_it);
    TEST(dirt_on_the_mirror_stays_in_focus);
    TEST(light_of_no_depth_changes_nothing);
    TEST(what_cannot_be_done_is_refused);
    return testing_end();
}
