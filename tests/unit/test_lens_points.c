/* SPDX-License-Identifier: Apache-2.0 */
/* rf_lens_points() by what it promises: even shares, places, moments, repeatability. */
#include <stdlib.h>

#include "base/math.h"
#include "lens/aperture.h"
#include "testing.h"

static struct rf_params params_of(int pattern, int blades, double rotation,
                                  double ratio)
{
    struct rf_params p;
    rf_params_init(&p);
    p.lens_pattern = pattern;
    p.blades = blades;
    p.blade_rotation = rotation;
    p.aperture_ratio = ratio;
    return p;
}

static struct rf_lens_point points[RF_MAX_LENS_POINTS];

static bool make(const struct rf_params *p, int n, int frame)
{
    struct rf_error error;
    rf_result result = rf_lens_points(p, n, frame, points, &error);
    if (result != RF_OK)
        printf("# %s: %s\n", error.field, error.message);
    return result == RF_OK;
}

/* Share of the aperture's area on the side of a line at `distance` from the middle. */
static double share_of_area(const struct rf_shape *shape, double angle, double distance)
{
    enum { N = 250 };
    double size = 2.2 / fmin(shape->ratio, 1);
    int n = 0, n_beyond = 0;
    for (int i = 0; i < N * N; i++) {
        double u = ((i % N + 0.5) / N - 0.5) * size;
        double v = ((i / N + 0.5) / N - 0.5) * size;
        bool is_in = rf_shape_contains(shape, u, v);
        n += is_in;
        n_beyond += is_in && u * cos(angle) + v * sin(angle) > distance;
    }
    return n_beyond / (double)n;
}

static double share_of_points(int n, double angle, double distance)
{
    int n_beyond = 0;
    for (int i = 0; i < n; i++)
        n_beyond += points[i].u * cos(angle) + points[i].v * sin(angle) > distance;
    return n_beyond / (double)n;
}

/* Every line through the lens has as large a share of points as of area beyond it. */
static void check_even(const struct rf_params *p, int frame)
{
    struct rf_shape shape;
    rf_shape_init(&shape, p);
    REQUIRE(make(p, 1024, frame));
    for (int i = 0; i < 1024; i++)
        CHECK(rf_shape_contains(&shape, 0.999 * points[i].u, 0.999 * points[i].v));
    for (double angle = 0.1; angle < 6; angle += 1.3)
        for (double distance = 0; distance < 0.7; distance += 0.3)
            CHECK_NEAR(share_of_points(1024, angle, distance),
                       share_of_area(&shape, angle, distance), 0.015);
}

static void equal_areas_hold_equally_many(void)
{
    static const int patterns[] = {RF_LENS_PATTERN_AUTO, RF_LENS_PATTERN_GRID};
    for (int k = 0; k < 2; k++)
        for (int is_random = 0; is_random < 2; is_random++)
            for (int blades = 0; blades < 9; blades = blades < 3 ? 3 : blades + 2) {
                struct rf_params p = params_of(patterns[k], blades, 17, 1);
                p.lens_random = is_random;
                check_even(&p, 5);
                p.aperture_ratio = 1.5;
                check_even(&p, 5);
            }
}

/* Of hollow blades all points lie in the opening, and every side of it has its share. */
static void hollow_blades_hold_equally_many(void)
{
    for (int blades = 3; blades < 10; blades += 2)
        for (int pattern = 0; pattern < 2; pattern++) {
            struct rf_params p = params_of(
                pattern ? RF_LENS_PATTERN_GRID : RF_LENS_PATTERN_AUTO, blades, 17, 1.5);
            struct rf_hollow h;
            double beside, area = 0, outer = 0, points_outer = 0;
            p.blade_curvature = -0.8;
            rf_hollow_init(&h, &p);
            for (int i = 0; i < 300 * 300; i++) {
                double u = (i % 300 + 0.5) / 150 - 1, v = (i / 300 + 0.5) / 150 - 1;
                bool is_open = rf_hollow_within(&h, u, v, &beside) > 0 && beside > 0;
                area += is_open;
                outer += is_open && u * u + v * v > 0.16;
            }
            REQUIRE(make(&p, 1024, 0));
            for (int i = 0; i < 1024; i++) {
                double u = points[i].u * 1.5, v = points[i].v;
                CHECK(rf_hollow_within(&h, 0.99 * u, 0.99 * v, &beside) > 0);
                CHECK(beside > 0);
                points_outer += u * u + v * v > 0.16;
            }
            CHECK_NEAR(points_outer / 1024, outer / area, 0.015);
            REQUIRE(make(&p, 2, 0));
            for (int i = 0; i < 2; i++)
                CHECK(rf_hollow_within(&h, points[i].u * 1.5, points[i].v, &beside) >
                          0 &&
                      beside > 0);
        }
}

static void disc_is_vogels_spiral(void)
{
    struct rf_params p = params_of(RF_LENS_PATTERN_DISC, 7, 0, 1); /* blades: unused */
    const double golden = 360 * (1 - 2 / (1 + sqrt(5)));           /* degrees */
    REQUIRE(make(&p, 37, 0));
    for (int i = 0; i < 37; i++) {
        double u = points[i].u, v = points[i].v;
        CHECK_NEAR(u * u + v * v, (2 * i + 1) / 74.0, 1e-12);
        double turn = atan2(v, u) * 180 / RF_PI - fmod(golden * i, 360);
        CHECK_NEAR(remainder(turn, 360), 0, 1e-9);
    }
}

/* Two see both sides of the lens; random ones still reach all of it. */
static void two_face_each_other(void)
{
    for (int blades = 0; blades < 6; blades += 3) {
        struct rf_params p = params_of(RF_LENS_PATTERN_AUTO, blades, 17, 1);
        p.aperture_ratio = 1.5;
        REQUIRE(make(&p, 2, 0));
        CHECK_NEAR(points[0].u, sqrt(0.125) / 1.5, 1e-12);
        CHECK_NEAR(points[0].v, sqrt(0.125), 1e-12);
        CHECK_NEAR(points[1].u, -points[0].u, 1e-12);
        CHECK_NEAR(points[1].v, -points[0].v, 1e-12);
        p.lens_random = true;
        double most = 0;
        for (int frame = 0; frame < 40; frame++) {
            REQUIRE(make(&p, 2, frame));
            most = fmax(most, hypot(points[0].u * 1.5, points[0].v));
            most = fmax(most, hypot(points[1].u * 1.5, points[1].v));
        }
        CHECK(most > (blades ? 0.6 : 0.9));
    }
}

/* Mean square distance of the lens' places from the nearest of n points. */
static double mean_distance2(int n)
{
    enum { GRID = 100 };
    double sum = 0;
    int count = 0;
    for (int i = 0; i < GRID * GRID; i++) {
        double u = (i % GRID + 0.5) / GRID * 2 - 1, v = (i / GRID + 0.5) / GRID * 2 - 1;
        double least = 4;
        if (hypot(u, v) > 1)
            continue;
        for (int j = 0; j < n; j++)
            least = fmin(least, hypot(points[j].u - u, points[j].v - v));
        sum += least * least;
        count++;
    }
    return sum / count;
}

/*
 * Two to four stand where the rest of the lens is near to one of them, at places of
 * their own along both axes; a plain mean of them must have the blur of the lens
 * instead.
 */
static void few_are_near_to_all_of_the_lens(void)
{
    static const double nearest[] = {0.36, 0.20, 0.141}, step[] = {0.7, 0.24, 0.37};
    for (int n = 2; n <= 4; n++) {
        struct rf_params p = params_of(RF_LENS_PATTERN_AUTO, 0, 17, 1);
        REQUIRE(make(&p, n, 0));
        CHECK(mean_distance2(n) < nearest[n - 2]);
        for (int i = 0; i < n; i++)
            for (int j = 0; j < i; j++) {
                CHECK(fabs(points[i].u - points[j].u) > step[n - 2]);
                CHECK(fabs(points[i].v - points[j].v) > step[n - 2]);
            }
        p.method = RF_METHOD_ACCUMULATE;
        REQUIRE(make(&p, n, 0));
        double square = 0;
        for (int i = 0; i < n; i++)
            square += points[i].u * points[i].u + points[i].v * points[i].v;
        CHECK_NEAR(square / n, 0.5, 1e-12);
    }
}

static void circle_is_evenly_on_the_rim(void)
{
    for (int n = 2; n < 40; n += 9) {
        struct rf_params p = params_of(RF_LENS_PATTERN_CIRCLE, 0, 0, 1);
        REQUIRE(make(&p, n, 0));
        double side = 2 * sin(RF_PI / n);
        CHECK_NEAR(points[0].u, 1, 1e-12);
        for (int i = 0; i < n; i++) {
            const struct rf_lens_point *a = &points[i], *b = &points[(i + 1) % n];
            CHECK_NEAR(hypot(a->u, a->v), 1, 1e-12);
            CHECK_NEAR(hypot(a->u - b->u, a->v - b->v), side, 1e-12);
            CHECK(a->u * b->v - a->v * b->u > -1e-12); /* counter-clockwise */
        }
    }
}

/* Turning the blades turns the points, and nothing else. */
static void polygon_turns(void)
{
    static struct rf_lens_point straight[200];
    struct rf_params p = params_of(RF_LENS_PATTERN_POLYGON, 5, 0, 1);
    REQUIRE(make(&p, 200, 0));
    memcpy(straight, points, sizeof straight);
    p.blade_rotation = 40;
    REQUIRE(make(&p, 200, 0));
    double c = cos(40 * RF_PI / 180), s = sin(40 * RF_PI / 180);
    for (int i = 0; i < 200; i++) {
        CHECK_NEAR(points[i].u, c * straight[i].u - s * straight[i].v, 1e-12);
        CHECK_NEAR(points[i].v, s * straight[i].u + c * straight[i].v, 1e-12);
    }
}

/* The inverse of Shirley and Chiu's map. */
static void disc_to_square(double u, double v, double *x, double *y)
{
    double r = hypot(u, v), a, b;
    if (fabs(u) > fabs(v)) {
        a = copysign(r, u);
        b = 4 / RF_PI * a * atan(v / u);
    } else {
        b = copysign(r, v);
        a = 4 / RF_PI * b * atan(u / v);
    }
    *x = (a + 1) / 2;
    *y = (b + 1) / 2;
}

static void each_cell_of_the_grid_has_one(void)
{
    for (int frame = 0; frame < 3; frame++) {
        struct rf_params p = params_of(RF_LENS_PATTERN_GRID, 0, 0, 1);
        int count[12][12] = {{0}};
        p.lens_random = 1;
        REQUIRE(make(&p, 144, frame));
        for (int i = 0; i < 144; i++) {
            double x, y;
            disc_to_square(points[i].u, points[i].v, &x, &y);
            count[(int)(12 * y)][(int)(12 * x)]++;
        }
        for (int i = 0; i < 144; i++)
            CHECK(count[i / 12][i % 12] == 1);
    }
}

static bool is_same(const struct rf_lens_point *a, const struct rf_lens_point *b, int n)
{
    return !memcmp(a, b, sizeof *a * (size_t)n);
}

static void fixed_unless_random(void)
{
    static struct rf_lens_point first[64];
    for (int pattern = RF_LENS_PATTERN_DISC; pattern <= RF_LENS_PATTERN_GRID;
         pattern++) {
        struct rf_params p = params_of(pattern, 6, 0, 1);
        REQUIRE(make(&p, 64, 1));
        memcpy(first, points, sizeof first);
        REQUIRE(make(&p, 64, 2));
        CHECK(is_same(first, points, 64));
        p.lens_seed = 1;
        REQUIRE(make(&p, 64, 1));
        CHECK(is_same(first, points, 64) == (pattern != RF_LENS_PATTERN_GRID));
        p.lens_random = 1;
        REQUIRE(make(&p, 64, 1));
        memcpy(first, points, sizeof first);
        REQUIRE(make(&p, 64, 1));
        CHECK(is_same(first, points, 64));
        REQUIRE(make(&p, 64, 2));
        CHECK(!is_same(first, points, 64));
        p.lens_seed = 2;
        REQUIRE(make(&p, 64, 1));
        CHECK(!is_same(first, points, 64));
    }
}

/* Over many frames few random points are the whole lens: a disc's mean square is 1/2.
 */
static void random_frames_make_the_lens(void)
{
    static const int patterns[] = {RF_LENS_PATTERN_DISC, RF_LENS_PATTERN_GRID};
    for (int k = 0; k < 2; k++) {
        struct rf_params p = params_of(patterns[k], 0, 0, 1);
        double u = 0, v = 0, square = 0;
        p.lens_random = 1;
        for (int frame = -1000; frame < 1000; frame++) {
            REQUIRE(make(&p, 3, frame));
            for (int i = 0; i < 3; i++) {
                u += points[i].u / 6000;
                v += points[i].v / 6000;
                square +=
                    (points[i].u * points[i].u + points[i].v * points[i].v) / 6000;
            }
        }
        CHECK_NEAR(u, 0, 0.02);
        CHECK_NEAR(v, 0, 0.02);
        CHECK_NEAR(square, 0.5, 0.01);
    }
}

static int compare_times(const void *a, const void *b)
{
    double s = *(const double *)a, t = *(const double *)b;
    return (s > t) - (s < t);
}

static void each_part_of_the_shutter_has_one(void)
{
    for (int is_random = 0; is_random < 2; is_random++)
        for (int n = 2; n <= RF_MAX_LENS_POINTS; n = n * 3 - 1) {
            static double times[RF_MAX_LENS_POINTS];
            struct rf_params p = params_of(RF_LENS_PATTERN_DISC, 0, 0, 1);
            p.lens_random = is_random;
            REQUIRE(make(&p, n, 9));
            for (int i = 0; i < n; i++)
                times[i] = points[i].time;
            qsort(times, (size_t)n, sizeof *times, compare_times);
            for (int i = 0; i < n; i++)
                CHECK_NEAR(times[i], (i + 0.5) / n, is_random ? 0.5 / n : 1e-12);
        }
}

static double correlation(int n, double (*value)(const struct rf_lens_point *))
{
    double mean = 0, square = 0, mixed = 0;
    for (int i = 0; i < n; i++)
        mean += value(&points[i]) / n;
    for (int i = 0; i < n; i++) {
        double v = value(&points[i]) - mean;
        square += v * v / n;
        mixed += v * (points[i].time - 0.5) / n;
    }
    return mixed / sqrt(square / 12);
}

static double right(const struct rf_lens_point *p)
{
    return p->u;
}

static double upwards(const struct rf_lens_point *p)
{
    return p->v;
}

static double from_middle(const struct rf_lens_point *p)
{
    return p->u * p->u + p->v * p->v;
}

/* No side of the lens, and neither rim nor middle, belongs to a part of the time. */
static void moments_do_not_follow_the_place(void)
{
    for (int pattern = RF_LENS_PATTERN_DISC; pattern <= RF_LENS_PATTERN_GRID; pattern++)
        for (int n = 16; n <= 1024; n *= 4) {
            struct rf_params p = params_of(pattern, 6, 0, 1);
            REQUIRE(make(&p, n, 0));
            CHECK_NEAR(correlation(n, right), 0, 0.15);
            CHECK_NEAR(correlation(n, upwards), 0, 0.15);
            if (pattern != RF_LENS_PATTERN_CIRCLE)
                CHECK_NEAR(correlation(n, from_middle), 0, 0.15);
        }
}

static void bad_arguments_are_named(void)
{
    struct rf_params p;
    struct rf_error error;
    rf_params_init(&p);
    CHECK(rf_lens_points(&p, 1, 0, points, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "n");
    CHECK(rf_lens_points(&p, 1025, 0, points, &error) == RF_ERROR_PARAMETER);
    CHECK_CONTAINS(error.message, "2 to 1024");
    CHECK(rf_lens_points(&p, 1024, 0, points, &error) == RF_OK);
    CHECK(rf_lens_points(&p, 2, 0, points, NULL) == RF_OK);
    CHECK(rf_lens_points(&p, 2, 0, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_lens_points(NULL, 2, 0, points, &error) == RF_ERROR_ARGUMENT);
    p.lens_pattern = RF_LENS_PATTERN_POLYGON;
    CHECK(rf_lens_points(&p, 8, 0, points, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "blades");
    p.lens_pattern = 5;
    CHECK(rf_lens_points(&p, 8, 0, points, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "lens_pattern");
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(equal_areas_hold_equally_many);
    TEST(hollow_blades_hold_equally_many);
    TEST(disc_is_vogels_spiral);
    TEST(two_face_each_other);
    TEST(few_are_near_to_all_of_the_lens);
    TEST(circle_is_evenly_on_the_rim);
    TEST(polygon_turns);
    TEST(each_cell_of_the_grid_has_one);
    TEST(fixed_unless_random);
    TEST(random_frames_make_the_lens);
    TEST(each_part_of_the_shutter_has_one);
    TEST(moments_do_not_follow_the_place);
    TEST(bad_arguments_are_named);
    return testing_end();
}
