/* SPDX-License-Identifier: Apache-2.0 */
/* What lies far behind a surface of rough depth does not shine through its inside. */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 256, HEIGHT = 128, WALL = 80, RIM = 44 };

/* A bright sky to the left of a grey wall, whose radius is rough by some px. */
static void draw(struct frame *f, double wall_px, double rough_px)
{
    uint32_t seed = 17;
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        bool is_sky = i % WIDTH < WALL;
        double radius = wall_px + rough_px * (2 * random_unit(&seed) - 1);
        f->depth[i] = plain_depth(is_sky ? 60 : radius);
        for (int c = 0; c < 3; c++)
            f->colour[3 * i + c] = is_sky ? 5 : 0.5f;
    }
}

/* The most that a pixel farther than RIM px from the sky is off. */
static double worst(double wall_px, double rough_px)
{
    struct frame f = frame_make(WIDTH, HEIGHT, 3);
    struct rf_params params;
    double most = 0;
    draw(&f, wall_px, rough_px);
    plain_params(&params, RF_METHOD_LAYERED);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = 0; y < HEIGHT; y++)
        for (int x = WALL + RIM; x < WIDTH; x++)
            most = fmax(most, fabs(frame_at(&f, f.out, x, y)[1] - 0.5));
    frame_free(&f);
    return most;
}

static void no_sky_shines_through_a_rough_wall(void)
{
    static const double walls[][2] = {{0, 0.1},   {0, 0.3},    {2, 0.1},   {4, 0.1},
                                      {8, 0.02},  {16, 0.02},  {-2, 0.1},  {-8, 0.02},
                                      {-16, 0.1}, {5.5, 0.25}, {11.5, 0.2}};
    for (int i = 0; i < 11; i++) {
        double most = worst(walls[i][0], walls[i][1]);
        printf("# a wall of %.1f px, rough by %.2f px: off by %.4f\n", walls[i][0],
               walls[i][1], most);
        CHECK(most < 0.003);
    }
}

/* ---- a sphere and a wall --------------------------------------------------------- */

enum { SIDE = 200, MOST_VIEWS = 12 };
static const double FOCAL_PX = 400, FOCUS = 6, LENS = 0.195, SKY = 255;

/* A sphere, or a wall that slants to the right. */
struct thing {
    double radius, distance; /* scene units */
    double slope;   /* of the wall: 1 / unit by which 1 / depth grows in 1 px */
    double half_px; /* half of its width */
};

/* The planar depth where the ray of a picture's place from a point of the lens meets the
 * thing; 0: it does not. */
static double meet_sphere(const struct thing *s, double x, double y,
                          const double eye[2])
{
    const double dx = (x - SIDE / 2.0) / FOCAL_PX - eye[0] / FOCUS;
    const double dy = (SIDE / 2.0 - y) / FOCAL_PX - eye[1] / FOCUS;
    const double a = dx * dx + dy * dy + 1;
    const double b = eye[0] * dx + eye[1] * dy - s->distance;
    const double c = eye[0] * eye[0] + eye[1] * eye[1] + s->distance * s->distance -
                     s->radius * s->radius;
    return b * b > a * c ? (-b - sqrt(b * b - a * c)) / a : 0;
}

static double meet_wall(const struct thing *s, double x, double y, const double eye[2])
{
    const double dx = (x - SIDE / 2.0) / FOCAL_PX - eye[0] / FOCUS;
    const double dy = (SIDE / 2.0 - y) / FOCAL_PX - eye[1] / FOCUS;
    const double slope = s->slope * FOCAL_PX; /* 1 / z = 1 / distance + slope x / z */
    const double z = (1 - slope * eye[0]) / (1 / s->distance + slope * dx);
    const double half = s->half_px / FOCAL_PX;
    return fabs(eye[0] / z + dx) < half && fabs(eye[1] / z + dy) < half ? z : 0;
}

static double meet(const struct thing *s, double x, double y, const double eye[2])
{
    return s->radius > 0 ? meet_sphere(s, x, y, eye) : meet_wall(s, x, y, eye);
}

/* A black thing before a bright sky. */
static void draw_thing(struct frame *f, const struct thing *s, const double eye[2])
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE, y = i / SIDE;
        const double depth = meet(s, x + 0.5, y + 0.5, eye);
        int n_sky = 0;
        for (int k = 0; k < 16; k++)
            n_sky += meet(s, x + (k % 4 + 0.5) / 4, y + (k / 4 + 0.5) / 4, eye) == 0;
        f->depth[i] = depth > 0 ? (float)depth : 1e10f;
        for (int c = 0; c < 3; c++)
            f->colour[3 * i + c] = (float)(SKY * n_sky / 16);
    }
}

/* Does the lens see no sky there? */
static bool is_inside(const struct thing *s, double x, double y)
{
    if (!(s->radius > 0))
        return fmax(fabs(x), fabs(y)) < 0.75 * s->half_px;
    const double slope =
        s->radius / sqrt(s->distance * s->distance - s->radius * s->radius);
    const double rim_z = s->distance / (1 + slope * slope);
    const double blur_px = LENS * FOCAL_PX * (1 / rim_z - 1 / FOCUS);
    return hypot(x, y) <= FOCAL_PX * slope - blur_px - 2;
}

/* The most and the mean share of the sky that is seen where the lens sees none. */
static void measure_leak(const struct thing *s, const struct frame *f, double *most,
                         double *mean)
{
    int n = 0;
    *most = *mean = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
        if (!is_inside(s, i % SIDE + 0.5 - SIDE / 2.0, i / SIDE + 0.5 - SIDE / 2.0))
            continue;
        *most = fmax(*most, fabs(f->out[3 * i]) / SKY);
        *mean += fabs(f->out[3 * i]) / SKY;
        n++;
    }
    *mean /= n;
}

/* The place of one of n views on the lens; a spiral of the golden angle. */
static void find_eye(int j, int n, double eye[2])
{
    static const double four[][2] = {
        {0.35, 0}, {-0.45, 0.41}, {0.07, -0.79}, {0.57, 0.74}};
    const double radius = n > 1 ? sqrt((j + 0.5) / n) : 0, turn = 2.399963 * j;
    eye[0] = LENS * (n == 4 ? four[j][0] : radius * cos(turn));
    eye[1] = LENS * (n == 4 ? four[j][1] : radius * sin(turn));
}

/* Of n views that are sheared to FOCUS, into a frame to be freed. */
static struct frame filter_views(const struct thing *s, int n_views, double focus)
{
    struct frame frames[MOST_VIEWS];
    struct rf_view views[MOST_VIEWS];
    struct rf_params params;
    rf_params_init(&params);
    params.method = n_views > 1 ? RF_METHOD_VIEWS : RF_METHOD_LAYERED;
    params.focus_distance = focus;
    params.lens_radius = LENS;
    params.focal_length_px = FOCAL_PX;
    for (int j = 0; j < n_views; j++) {
        double eye[2];
        find_eye(j, n_views, eye);
        frames[j] = frame_make(SIDE, SIDE, 3);
        draw_thing(&frames[j], s, eye);
        views[j] =
            (struct rf_view){.colour = rf_image_packed(frames[j].colour, SIDE, SIDE, 3),
                             .depth = rf_image_packed(frames[j].depth, SIDE, SIDE, 1),
                             .lens_offset = {eye[0], eye[1]},
                             .shear_distance = FOCUS};
    }
    struct rf_image out = rf_image_packed(frames[0].out, SIDE, SIDE, 3);
    struct rf_context *context;
    struct rf_filter *filter;
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &params, SIDE, SIDE, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, views, n_views, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int j = 1; j < n_views; j++)
        frame_free(&frames[j]);
    return frames[0];
}

static void filter_thing(const struct thing *s, int n_views, double focus, double *most,
                         double *mean)
{
    struct frame f = filter_views(s, n_views, focus);
    measure_leak(s, &f, most, mean);
    frame_free(&f);
}

/* Its rim's footprints are narrower than those of what lies behind it, where it ends. */
static void no_sky_shines_through_a_sphere(void)
{
    static const struct thing spheres[] = {{.radius = 0.4, .distance = 3},
                                           {.radius = 0.4, .distance = 2.9},
                                           {.radius = 0.8, .distance = 4}};
    for (int i = 0; i < 3; i++)
        for (int n_views = 1; n_views <= 4; n_views += 3) {
            double most, mean;
            filter_thing(&spheres[i], n_views, FOCUS, &most, &mean);
            printf("# %d views, sphere %d: at most %.5f, mean %.7f\n", n_views, i, most,
                   mean);
            CHECK(most < (n_views > 1 ? 0.01 : 1e-4));
            CHECK(mean < (n_views > 1 ? 5e-6 : 1e-6));
        }
}

/* Near the focus it covers pixels to 95 % only where its radii change. */
static void no_sky_shines_through_a_slanted_wall(void)
{
    static const struct {
        int n_views;
        double focus;
    } cases[] = {{1, 6}, {2, 6}, {8, 6}, {8, 6.3}, {2, 5.7}, {12, 6}, {12, 5.8}};
    for (int k = 0; k < 7; k++)
        for (int i = 1; i <= 4; i *= 2) {
            const struct thing wall = {
                .distance = FOCUS, .slope = 7e-5 * i, .half_px = 60};
            double most, mean;
            filter_thing(&wall, cases[k].n_views, cases[k].focus, &most, &mean);
            printf("# %d views, focus %.1f, wall %d: at most %.5f, mean %.7f\n",
                   cases[k].n_views, cases[k].focus, i, most, mean);
            CHECK(most < 1e-3);
        }
}

/* The share of the sky in a column beside a wall in focus, which eight views show that were
 * sheared to another distance. */
static double light_beside_a_wall(double half_px, int x)
{
    const struct thing wall = {.distance = 5, .half_px = half_px};
    struct frame f = filter_views(&wall, 8, wall.distance);
    double light = 0;
    for (int y = SIDE / 2 - 40; y < SIDE / 2 + 40; y++)
        light += frame_at(&f, f.out, x, y)[1] / SKY / 80;
    printf("# %.3f of the sky\n", light);
    frame_free(&f);
    return light;
}

/* Each view shows it up to 3 px beside the place where it is. */
static void a_wall_ends_where_it_is(void)
{
    const int half = 60, last = SIDE / 2 + half - 1;
    CHECK(light_beside_a_wall(half, last + 1) > 0.85); /* a pinhole has 1 */
    CHECK(light_beside_a_wall(half, last + 2) > 0.99);
    CHECK(light_beside_a_wall(half, last - 1) < 0.01);
}

/* Two px before the border: half of the views see it go on to theirs, and must not close
 * it beyond. All of the sky would be right. */
static void a_wall_ends_at_the_border(void)
{
    CHECK(light_beside_a_wall(SIDE / 2 - 2, SIDE - 1) > 0.65);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(no_sky_shines_through_a_rough_wall);
    TEST(no_sky_shines_through_a_sphere);
    TEST(no_sky_shines_through_a_slanted_wall);
    TEST(a_wall_ends_where_it_is);
    TEST(a_wall_ends_at_the_border);
    return testing_end();
}
