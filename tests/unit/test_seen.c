/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rf_filter_seen_depth(): the distance of what is seen in a mirror from how far it moves
 * between views. The room in the mirror is a picture of noise, drawn at the place where
 * each view has it.
 */
#include "physics/frames.h"
#include "testing.h"

enum {
    WIDTH = 160,
    HEIGHT = 120,
    N = WIDTH * HEIGHT,
    LEFT = 40, /* the mirror */
    RIGHT = 130,
    TOP = 20,
    BOTTOM = 100,
    MIRROR_PX = 2, /* radius of its surface; of the wall around it WALL_PX */
    WALL_PX = 6,
    MOST_VIEWS = 3,
};

struct scene {
    int n_views;
    double at[MOST_VIEWS][2]; /* on the lens, scene units */
    double room_px, near_px;  /* radii of the room and, left of `split`, of a thing */
    int split;
    double grain, contrast;
    int post;     /* columns of a post before the mirror, 0: none */
    double curve; /* of the surface: px of radius per squared px */
    float *colour, *depth, *light[MOST_VIEWS], *out;
};

static float value_at(int x, int y)
{
    uint32_t v = (uint32_t)x * 0x9e3779b1u ^ (uint32_t)y * 0x85ebca77u;
    v = (v ^ v >> 15) * 0x2c1b3c6du;
    v = (v ^ v >> 12) * 0x297a2d39u;
    return (float)((v ^ v >> 15) >> 8) / 16777216;
}

/* A pattern of cells of 3 px, smooth between them. */
static double pattern(double x, double y)
{
    double fx = x / 3, fy = y / 3, ix = floor(fx), iy = floor(fy);
    int a = (int)ix + 1000, b = (int)iy + 1000;
    fx -= ix;
    fy -= iy;
    double up = value_at(a, b) * (1 - fx) + value_at(a + 1, b) * fx;
    double down = value_at(a, b + 1) * (1 - fx) + value_at(a + 1, b + 1) * fx;
    return up * (1 - fy) + down * fy;
}

/* A lens of a radius of LENS_RADIUS: r = 16 - 1600 / z px, 0 at z = 100. */
static const double LENS_RADIUS = 1.6, INFINITE_PX = 16;

static float depth_of(double r_px)
{
    return (float)(PLAIN_FOCUS * INFINITE_PX / (INFINITE_PX - r_px));
}

/* How far a radius moves between the first view, in the middle, and a point (u, v):
 * sheared to the plane in focus, by as much. */
static double moved(double at, double radius)
{
    return at / LENS_RADIUS * radius;
}

static struct scene make(void)
{
    struct scene s = {.n_views = 2,
                      .at = {{0, 0}, {1.5, 0}, {0, 1.5}},
                      .room_px = 11,
                      .near_px = 11,
                      .contrast = 0.8};
    s.colour = calloc(3 * N, sizeof(float));
    s.depth = calloc(N, sizeof(float));
    s.out = calloc(N, sizeof(float));
    for (int j = 0; j < MOST_VIEWS; j++)
        s.light[j] = calloc(3 * N, sizeof(float));
    if (!s.colour || !s.depth || !s.out || !s.light[MOST_VIEWS - 1])
        abort();
    return s;
}

static void release(struct scene *s)
{
    free(s->colour);
    free(s->depth);
    free(s->out);
    for (int j = 0; j < MOST_VIEWS; j++)
        free(s->light[j]);
}

/* Is the mirror seen at (x, y) of view j? */
static bool is_mirror(const struct scene *s, int j, int x, int y)
{
    double dx = moved(s->at[j][0], MIRROR_PX), dy = -moved(s->at[j][1], MIRROR_PX);
    if (x - dx < LEFT || x - dx >= RIGHT || y - dy < TOP || y - dy >= BOTTOM)
        return false;
    double post = 80 + moved(s->at[j][0], -8);
    return !(s->post && x >= post && x < post + s->post);
}

/* The room at (x, y) of view j: what stands before the rest of it first. */
static double room_at(const struct scene *s, int j, int x, int y)
{
    double near_x = x - moved(s->at[j][0], s->near_px);
    double near_y = y + moved(s->at[j][1], s->near_px);
    if (near_x < s->split)
        return pattern(near_x, near_y);
    return pattern(x - moved(s->at[j][0], s->room_px) + 300,
                   y + moved(s->at[j][1], s->room_px));
}

static void draw(struct scene *s)
{
    uint32_t state = 5;
    for (int j = 0; j < s->n_views; j++)
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                size_t i = (size_t)y * WIDTH + (size_t)x;
                double v = 0.5 + s->contrast * (room_at(s, j, x, y) - 0.5);
                for (int c = 0; c < 3; c++) {
                    double grain = s->grain * (random_unit(&state) - 0.5);
                    s->light[j][3 * i + (size_t)c] =
                        is_mirror(s, j, x, y) ? (float)fmax(v + grain, 0.01) : 0;
                }
                if (j > 0)
                    continue;
                bool is_post = s->post && x >= 80 && x < 80 + s->post;
                double bend = s->curve * (x - 85) * (x - 85);
                s->depth[i] = depth_of(is_post                 ? -8
                                       : is_mirror(s, 0, x, y) ? MIRROR_PX + bend
                                                               : WALL_PX);
                for (int c = 0; c < 3; c++)
                    s->colour[3 * i + (size_t)c] =
                        0.2f + s->light[0][3 * i + (size_t)c];
            }
}

static rf_result find(struct scene *s, int n_threads, struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    const struct rf_context_params how = {.size = sizeof how, .n_threads = n_threads};
    struct rf_view views[MOST_VIEWS] = {{.size = sizeof *views}};
    struct rf_image lights[MOST_VIEWS];
    const struct rf_image out = rf_image_packed(s->out, WIDTH, HEIGHT, 1);
    plain_params(&params, RF_METHOD_LAYERED);
    params.lens_radius = LENS_RADIUS;
    views[0].colour = rf_image_packed(s->colour, WIDTH, HEIGHT, 3);
    views[0].depth = rf_image_packed(s->depth, WIDTH, HEIGHT, 1);
    for (int j = 0; j < s->n_views; j++) {
        views[j].size = sizeof *views;
        memcpy(views[j].lens_offset, s->at[j], sizeof views[j].lens_offset);
        views[j].shear_distance = PLAIN_FOCUS;
        lights[j] = rf_image_packed(s->light[j], WIDTH, HEIGHT, 3);
    }
    if (rf_context_create(&context, &how, NULL) != RF_OK ||
        rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) != RF_OK)
        abort();
    rf_result result =
        rf_filter_seen_depth(filter, views, s->n_views, lights, &out, error);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

/* Share of a part of the mirror whose radius is within `tolerance` of r. */
static double share_near(const struct scene *s, int x0, int x1, double r,
                         double tolerance)
{
    int n = 0, n_good = 0;
    for (int y = TOP; y < BOTTOM; y++)
        for (int x = x0; x < x1; x++) {
            n++;
            n_good += fabs(INFINITE_PX * (1 - PLAIN_FOCUS / s->out[y * WIDTH + x]) -
                           r) < tolerance;
        }
    printf("# %.3f of %d..%d are at %g\n", (double)n_good / n, x0, x1, r);
    return (double)n_good / n;
}

static int count_found(const struct scene *s, bool in_mirror)
{
    int n = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            n += is_mirror(s, 0, x, y) == in_mirror && !isnan(s->out[y * WIDTH + x]);
    return n;
}

static void a_room_is_found_and_nothing_beside_it(void)
{
    struct scene s = make();
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(share_near(&s, LEFT, RIGHT, 11, 0.3) > 0.95);
    CHECK(count_found(&s, false) == 0);
    release(&s);
}

static void whatever_side_the_view_is_from(void)
{
    static const double places[][2] = {{-1.5, 0}, {0, 1.3}, {0, -1.3}, {0.8, 1}};
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
        struct scene s = make();
        memcpy(s.at[1], places[k], sizeof s.at[1]);
        draw(&s);
        REQUIRE(find(&s, 1, NULL) == RF_OK);
        CHECK(share_near(&s, LEFT, RIGHT, 11, 0.3) > 0.95);
        release(&s);
    }
}

static void two_distances_in_one_mirror(void)
{
    struct scene s = make();
    s.near_px = 5;
    s.split = 75;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(share_near(&s, LEFT + 2, 72, 5, 0.3) > 0.95);
    CHECK(share_near(&s, 90, RIGHT - 2, 11, 0.3) > 0.95);
    release(&s);
}

static void grain_does_not_mislead(void)
{
    struct scene s = make();
    s.grain = 0.5;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(share_near(&s, LEFT, RIGHT, 11, 0.5) > 0.9);
    release(&s);
}

static void more_views_agree(void)
{
    struct scene s = make();
    s.n_views = 3;
    s.grain = 0.6;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(share_near(&s, LEFT, RIGHT, 11, 0.5) > 0.9);
    release(&s);
}

static void without_a_pattern_the_surface_keeps_it(void)
{
    struct scene s = make();
    s.contrast = 0;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(count_found(&s, true) == 0);
    s.grain = 0.3; /* nor does grain alone make one */
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(count_found(&s, true) == 0);
    release(&s);
}

static void dirt_on_the_mirror_is_no_room(void)
{
    struct scene s = make();
    s.room_px = s.near_px = MIRROR_PX;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(count_found(&s, true) == 0);
    release(&s);
}

static void what_is_nearer_than_the_surface_keeps_its_depth(void)
{
    struct scene s = make();
    s.room_px = s.near_px = MIRROR_PX - 6;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(count_found(&s, true) == 0);
    release(&s);
}

static void a_curved_surface_keeps_its_depth(void)
{
    struct scene s = make();
    s.curve = 0.002;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(count_found(&s, true) == 0);
    release(&s);
}

static void a_post_before_the_mirror_is_none_of_it(void)
{
    struct scene s = make();
    s.post = 10;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    CHECK(share_near(&s, LEFT, 79, 11, 0.5) > 0.95);
    CHECK(share_near(&s, 91, RIGHT, 11, 0.5) > 0.95);
    CHECK(count_found(&s, false) == 0);
    release(&s);
}

static void threads_do_not_matter(void)
{
    struct scene s = make();
    float *once = calloc(N, sizeof *once);
    s.grain = 0.3;
    draw(&s);
    REQUIRE(find(&s, 1, NULL) == RF_OK);
    memcpy(once, s.out, N * sizeof *once);
    REQUIRE(find(&s, 3, NULL) == RF_OK);
    CHECK(memcmp(once, s.out, N * sizeof *once) == 0);
    free(once);
    release(&s);
}

/* The ways of rays that the view knows, into s->out. */
static rf_result keep_way(struct scene *s, struct rf_error *error)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    const struct rf_view view = {.size = sizeof view,
                                 .colour = rf_image_packed(s->colour, WIDTH, HEIGHT, 3),
                                 .depth = rf_image_packed(s->depth, WIDTH, HEIGHT, 1)};
    const struct rf_image light = rf_image_packed(s->light[0], WIDTH, HEIGHT, 3);
    const struct rf_image out = rf_image_packed(s->out, WIDTH, HEIGHT, 1);
    plain_params(&params, RF_METHOD_LAYERED);
    params.lens_radius = LENS_RADIUS;
    if (rf_context_create(&context, NULL, NULL) != RF_OK ||
        rf_filter_create(&filter, context, &params, WIDTH, HEIGHT, NULL) != RF_OK)
        abort();
    rf_result result = rf_filter_seen_way(filter, &view, &light, &out, &out, error);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

static void ways_are_kept_behind_flat_surfaces(void)
{
    for (int curved = 0; curved <= 1; curved++) {
        struct scene s = make();
        s.curve = curved * 0.002;
        draw(&s);
        for (int i = 0; i < N; i++)
            s.out[i] = s.light[0][3 * i] > 0 ? depth_of(11) : s.depth[i] * 1.001f;
        REQUIRE(keep_way(&s, NULL) == RF_OK);
        CHECK(count_found(&s, false) == 0);
        if (curved)
            CHECK(count_found(&s, true) == 0);
        else
            CHECK(share_near(&s, LEFT, RIGHT, 11, 0.01) > 0.99);
        s.light[0][1] = NAN;
        CHECK(keep_way(&s, NULL) == RF_ERROR_PIXEL);
        release(&s);
    }
}

static void what_cannot_be_found_is_refused(void)
{
    struct scene s = make();
    struct rf_error error;
    draw(&s);
    s.at[1][0] = 0;
    CHECK(find(&s, 1, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "lens_offset");
    s.n_views = 1;
    CHECK(find(&s, 1, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "n_views");
    s.n_views = 2;
    s.at[1][0] = 1.5;
    s.light[1][7] = NAN;
    CHECK(find(&s, 1, &error) == RF_ERROR_PIXEL);
    CHECK_STR(error.field, "seen");
    release(&s);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_room_is_found_and_nothing_beside_it);
    TEST(whatever_side_the_view_is_from);
    TEST(two_distances_in_one_mirror);
    TEST(grain_does_not_mislead);
    TEST(more_views_agree);
    TEST(without_a_pattern_the_surface_keeps_it);
    TEST(dirt_on_the_mirror_is_no_room);
    TEST(what_is_nearer_than_the_surface_keeps_its_depth);
    TEST(a_curved_surface_keeps_its_depth);
    TEST(a_post_before_the_mirror_is_none_of_it);
    TEST(threads_do_not_matter);
    TEST(ways_are_kept_behind_flat_surfaces);
    TEST(what_cannot_be_found_is_refused);
    return testing_end();
}
