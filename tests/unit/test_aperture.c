/* SPDX-License-Identifier: Apache-2.0 */
#include "base/context.h"
#include "base/math.h"
#include "base/pool.h"
#include "base/task.h"
#include "compose/footprint.h"
#include "compose/lens_cells.h"
#include "kernels/data.h"
#include "lens/aperture.h"
#include "testing.h"

static struct rf_shape shape_of(int aperture, int blades, double rotation, double ratio)
{
    struct rf_params p;
    struct rf_shape shape;
    rf_params_init(&p);
    p.aperture = aperture;
    p.blades = blades;
    p.blade_rotation = rotation;
    p.aperture_ratio = ratio;
    rf_shape_init(&shape, &p);
    return shape;
}

/* Area by counting, which sees only rf_shape_contains(). */
static double counted_area(const struct rf_shape *shape)
{
    enum { N = 400 };
    double size = 2.2 / fmin(shape->ratio, 1);
    int n = 0;
    for (int i = 0; i < N; i++)
        for (int j = 0; j < N; j++)
            n += rf_shape_contains(shape, ((i + 0.5) / N - 0.5) * size,
                                   ((j + 0.5) / N - 0.5) * size);
    return n * size * size / (N * (double)N);
}

static double corner_area(const struct rf_shape *shape)
{
    double sum = 0;
    for (int i = 0; i < shape->n_corners; i++) {
        const double *a = shape->corner[i];
        const double *b = shape->corner[(i + 1) % shape->n_corners];
        sum += (a[0] * b[1] - b[0] * a[1]) / 2;
    }
    return sum;
}

static void areas(void)
{
    static const double ratios[] = {0.5, 1, 1.5, 2};
    for (int k = 0; k < 4; k++) {
        struct rf_shape disc = shape_of(RF_APERTURE_DISC, 0, 0, ratios[k]);
        CHECK_NEAR(counted_area(&disc) * ratios[k], RF_PI, 0.01);
        CHECK_NEAR(corner_area(&disc) * ratios[k], RF_PI, 0.002);
        for (int n = 3; n <= 16; n++) {
            struct rf_shape s = shape_of(RF_APERTURE_POLYGON, n, 11 * n, ratios[k]);
            double area = n / 2.0 * sin(2 * RF_PI / n);
            CHECK_NEAR(counted_area(&s) * ratios[k], area, 0.01);
            CHECK_NEAR(corner_area(&s) * ratios[k], area, 1e-12);
            CHECK(s.n_corners == n);
        }
    }
}

/* Everything fits the unit circle and touches it: the corner radius is the lens's. */
static void corners_lie_on_the_lens(void)
{
    for (int n = 3; n <= 16; n++) {
        struct rf_shape s = shape_of(RF_APERTURE_POLYGON, n, 7, 1);
        for (int i = 0; i < n; i++)
            CHECK_NEAR(hypot(s.corner[i][0], s.corner[i][1]), 1, 1e-12);
    }
}

/* The distance from the centre to the rim in the direction of an angle. */
static double rim(const struct rf_shape *s, double degrees)
{
    double a = degrees * RF_PI / 180, from = 0, to = 200;
    for (int i = 0; i < 60; i++) {
        double t = (from + to) / 2;
        if (rf_shape_contains(s, t * cos(a), t * sin(a)))
            from = t;
        else
            to = t;
    }
    return from;
}

/* Cycles: the middle of an edge lies at the rotation, counter-clockwise, v up. */
static void edge_at_the_rotation_as_cycles(void)
{
    for (int n = 3; n <= 16; n++)
        for (double turn = -50; turn < 400; turn += 37) {
            struct rf_shape s = shape_of(RF_APERTURE_POLYGON, n, turn, 1);
            CHECK_NEAR(rim(&s, turn), cos(RF_PI / n), 1e-9);
            CHECK_NEAR(rim(&s, turn + 180.0 / n), 1, 1e-9);
            CHECK(rim(&s, turn + 3) > rim(&s, turn));
            CHECK(rim(&s, turn - 3) > rim(&s, turn));
        }
}

/* A triangle tells its directions apart: behind the focus it points left. */
static void a_triangle_points_left(void)
{
    struct rf_shape s = shape_of(RF_APERTURE_POLYGON, 3, 0, 1);
    CHECK(rf_shape_contains(&s, -0.9, 0));
    CHECK(!rf_shape_contains(&s, 0.6, 0));
    s = shape_of(RF_APERTURE_POLYGON, 3, 90, 1); /* edge on top: it points down */
    CHECK(rf_shape_contains(&s, 0, -0.9));
    CHECK(!rf_shape_contains(&s, 0, 0.6));
}

static void povray_orientation_has_a_corner_there(void)
{
    struct rf_params p;
    struct rf_shape s;
    rf_params_init(&p);
    p.blades = 6;
    p.blade_orientation = RF_ORIENTATION_POVRAY;
    rf_shape_init(&s, &p);
    CHECK_NEAR(rim(&s, 0), 1, 1e-9);
    CHECK_NEAR(rim(&s, 30), cos(RF_PI / 6), 1e-9);
}

/* Cycles: the ratio divides x after the rotation. */
static void ratio_divides_the_width(void)
{
    struct rf_shape disc = shape_of(RF_APERTURE_DISC, 0, 0, 1.6);
    CHECK_NEAR(rim(&disc, 0), 1 / 1.6, 1e-9);
    CHECK_NEAR(rim(&disc, 90), 1, 1e-9);
    CHECK_NEAR(rim(&disc, 180), 1 / 1.6, 1e-9);
    struct rf_shape square = shape_of(RF_APERTURE_POLYGON, 4, 45, 0.5);
    CHECK_NEAR(rim(&square, 0), 2, 1e-9); /* the corner on the right, doubled */
    CHECK_NEAR(rim(&square, 90), 1, 1e-9);
}

static void auto_takes_blades_where_given(void)
{
    struct rf_shape disc = shape_of(RF_APERTURE_AUTO, 0, 0, 1);
    struct rf_shape polygon = shape_of(RF_APERTURE_AUTO, 5, 0, 1);
    struct rf_shape forced = shape_of(RF_APERTURE_DISC, 5, 0, 1);
    CHECK(disc.is_disc && forced.is_disc && !polygon.is_disc);
    CHECK(polygon.n_corners == 5);
}

/* Area of a polygon whose edges are arcs: triangles, and circle segments on them. */
static double curved_area(int blades, double curvature)
{
    double a = RF_PI / blades, h = curvature * (1 - cos(a)), w = sin(a);
    double radius = (w * w + h * h) / (2 * h), angle = 2 * asin(w / radius);
    return blades * (w * cos(a) + radius * radius * (angle - sin(angle)) / 2);
}

static void curvature_makes_edges_arcs(void)
{
    struct rf_params p;
    struct rf_shape s;
    rf_params_init(&p);
    for (int blades = 3; blades <= 16; blades++)
        for (double c = 0.25; c <= 1; c += 0.25) {
            p.blades = blades;
            p.blade_rotation = 11;
            p.blade_curvature = c;
            rf_shape_init(&s, &p);
            double area = curved_area(blades, c), edge = cos(RF_PI / blades);
            CHECK_NEAR(corner_area(&s), area, 1e-3 * area);
            CHECK_NEAR(rim(&s, 11), edge + c * (1 - edge),
                       1e-3);                                  /* middle of an edge */
            CHECK_NEAR(rim(&s, 11 + 180.0 / blades), 1, 1e-3); /* corner */
            CHECK(s.n_corners <= RF_DISC_CORNERS);
        }
    p.blade_curvature = 0;
    p.blades = 5;
    rf_shape_init(&s, &p);
    CHECK(s.n_corners == 5);
}

/* Three arcs of -1 meet in the middle; four leave a star. */
static void hollow_blades_leave_an_opening(void)
{
    struct rf_params p;
    struct rf_error error;
    rf_params_init(&p);
    p.blades = 3;
    p.blade_curvature = -0.9;
    CHECK(rf_params_check(&p, &error) == RF_OK);
    p.blade_curvature = -0.91;
    CHECK(rf_params_check(&p, &error) == RF_ERROR_PARAMETER);
    CHECK(strcmp(error.field, "blade_curvature") == 0);
    p.blades = 4;
    p.blade_curvature = -1;
    CHECK(rf_params_check(&p, &error) == RF_OK);
}

/* A new aperture is convex and counter-clockwise like these, whatever its name. */
static void every_aperture_is_convex(void)
{
    for (int a = 0; a < rf_param_find("aperture")->n_choices; a++) {
        struct rf_shape s = shape_of(a, 7, 20, 1.3);
        CHECK(corner_area(&s) > 0.5);
        CHECK(rf_shape_contains(&s, 0, 0));
        for (int i = 0; i < s.n_corners; i++) {
            const double *p = s.corner[i];
            const double *q = s.corner[(i + 1) % s.n_corners];
            const double *r = s.corner[(i + 2) % s.n_corners];
            CHECK((q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]) > 0);
        }
    }
}

/* Area of the parts of `shape` that belong to n sites; each looks right by itself. */
static double parts_area(const struct rf_shape *shape, double (*site)[2], int n)
{
    double sum = 0;
    for (int j = 0; j < n; j++) {
        struct rf_shape part;
        double centroid[2], area = rf_shape_part(shape, site, n, j, &part, centroid);
        sum += area;
        if (area <= 0)
            continue;
        CHECK(rf_shape_contains(&part, 0, 0));
        CHECK(rf_shape_contains(shape, centroid[0], centroid[1]));
        for (int k = 0; k < n; k++)
            CHECK(hypot(site[j][0] - centroid[0], site[j][1] - centroid[1]) <=
                  hypot(site[k][0] - centroid[0], site[k][1] - centroid[1]) + 1e-12);
        for (int i = 0; i < part.n_corners; i++)
            CHECK(fabs(part.corner[i][0]) <= part.size[0] &&
                  fabs(part.corner[i][1]) <= part.size[1]);
    }
    return sum;
}

/* A lens that a look has cut is measured edge by edge, as others are line by line. */
static void measures_of_a_cut_lens(void)
{
    for (int blades = 3; blades < 9; blades++) {
        struct rf_shape shape = shape_of(RF_APERTURE_POLYGON, blades, 0.3, 1.3);
        struct rf_lens_cells cells, same;
        double variance[2], cut_variance[2], middle[3][2], cut_middle[3][2];
        rf_lens_cells_init(&cells, &shape, 3);
        rf_lens_cells_middle(&cells, &shape, middle);
        rf_shape_line_variance(&shape, variance);
        shape.is_cut = true;
        rf_lens_cells_init(&same, &shape, 3);
        rf_lens_cells_middle(&same, &shape, cut_middle);
        rf_shape_line_variance(&shape, cut_variance);
        for (int i = 0; i < 2; i++)
            CHECK_NEAR(cut_variance[i], variance[i], 1e-9);
        for (int c = 0; c < 3; c++) {
            CHECK_NEAR(same.share[c], cells.share[c], 1e-9);
            for (int i = 0; i < 2; i++)
                CHECK_NEAR(cut_middle[c][i], middle[c][i], 1e-9);
        }
        if (blades ==
            4) { /* a square of half diagonal 1: 1 / 6 across, over the ratio */
            CHECK_NEAR(variance[0] * 1.3 * 1.3, 1 / 6., 1e-3);
            CHECK_NEAR(variance[1], 1 / 6., 1e-3);
        }
    }
}

static void parts_share_out_the_aperture(void)
{
    double site[12][2];
    for (int i = 0; i < 12; i++) {
        double rho = sqrt((i + 0.5) / 12), theta = 2.4 * i;
        site[i][0] = rho * cos(theta);
        site[i][1] = rho * sin(theta);
    }
    for (int blades = 0; blades <= 7; blades += 7) {
        struct rf_shape s = shape_of(RF_APERTURE_AUTO, blades, 20, 1.3);
        CHECK_NEAR(parts_area(&s, site, 12), corner_area(&s), 1e-9);
        CHECK_NEAR(parts_area(&s, site, 1), corner_area(&s), 1e-9);
    }
}

/* Two views from one place share its part; a place far outside may have none. */
static void parts_of_places_at_one_point_or_outside(void)
{
    struct rf_shape s = shape_of(RF_APERTURE_DISC, 0, 0, 1), part;
    double site[3][2] = {{0.1, 0}, {0.1, 0}, {9, 0}}, centroid[2];
    CHECK_NEAR(parts_area(&s, site, 3), corner_area(&s), 1e-9);
    CHECK(rf_shape_part(&s, site, 3, 2, &part, centroid) == 0);
}

/* What `of` says of the footprint of radius r. */
static double of_footprint(const struct rf_shape *shape, int n_cells, float r,
                           double (*of)(const struct rf_footprint *))
{
    struct rf_context *context;
    struct rf_footprints f;
    struct rf_footprint_use use = {
        .shape = shape, .n_cells = n_cells, .max_radius = 20, .n_phases = 1};
    struct rf_task task = {.to = 0};
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_footprints_init(&f, context, &use, NULL) == RF_OK);
    if (n_cells == 2) {
        CHECK_NEAR(f.zones.at->cells.share[0], 0.5, 0.05); /* side by side */
        CHECK_NEAR(f.zones.at->cells.site[0][1], f.zones.at->cells.site[1][1], 1e-9);
    }
    unsigned char *needed = rf_calloc(context, rf_footprint_count(&f), 1);
    size_t slot = rf_footprint_slot(&f, 0, rf_radius_index(&f, r), 0, RF_SHARP, 0);
    needed[slot] = 1;
    CHECK(rf_footprints_build(&f, needed, &task, 1, NULL) == RF_OK);
    double found = of(rf_footprint_at(f.table, slot));
    rf_free(context, needed);
    rf_footprints_free(&f);
    rf_context_destroy(context);
    return found;
}

/* The least weight, in parts of the greatest. */
static double faintest(const struct rf_footprint *p)
{
    double least = INFINITY, most = 0;
    for (int i = 0; i < p->n_segments; i++)
        for (int x = 0; x < p->segments[i].n; x++) {
            double w = fabs(p->weights[p->segments[i].weight + x]);
            least = w > 0 ? fmin(w, least) : least;
            most = fmax(w, most);
        }
    return least / most;
}

static double faintest_weight(const struct rf_shape *shape, float r)
{
    return of_footprint(shape, 2, r, faintest);
}

/* The segments that are mirrored, of all but that in the middle; -1: they are not. */
static double mirrored(const struct rf_footprint *p)
{
    for (int i = 0; i < p->n_mirrored; i++) {
        const struct rf_segment *a = &p->segments[i];
        const struct rf_segment *b = &p->segments[p->n_segments - 1 - i];
        size_t n_bytes = (size_t)a->n * sizeof *p->weights;
        if (a->dy != -b->dy || a->dx != b->dx || a->n != b->n || a->cell != b->cell ||
            memcmp(p->weights + a->weight, p->weights + b->weight, n_bytes) != 0)
            return -1;
    }
    return 2.0 * p->n_mirrored / (p->n_segments - 1);
}

/* Is each row the same both ways, if it is said to be? -1: it is not. */
static double even(const struct rf_footprint *p)
{
    for (int i = 0; i < p->n_segments && p->is_even; i++) {
        const struct rf_segment *g = &p->segments[i];
        const float *middle = p->weights + g->weight - g->dx;
        for (int x = 0; x < g->n + g->dx; x++)
            if (x <= -g->dx ? middle[x] != middle[-x] : middle[x] != 0)
                return -1;
    }
    return p->is_even;
}

static void footprints_are_mirrored_where_the_lens_is(void)
{
    struct rf_shape disc = shape_of(RF_APERTURE_DISC, 0, 0, 1.5);
    struct rf_shape hexagon = shape_of(RF_APERTURE_POLYGON, 6, 0, 1);
    struct rf_shape turned = shape_of(RF_APERTURE_POLYGON, 6, 0.1, 1);
    struct rf_shape triangle = shape_of(RF_APERTURE_POLYGON, 3, 0, 1);
    for (float r = -12; r <= 12; r += 0.75f) {
        if (r == 0)
            continue;
        CHECK(of_footprint(&disc, 1, r, mirrored) == 1);
        CHECK(of_footprint(&hexagon, 1, r, mirrored) == 1);
        CHECK(of_footprint(&disc, 1, r, even) == 1);
        CHECK(of_footprint(&hexagon, 1, r, even) == 1);
        CHECK(fabsf(r) < 2 || of_footprint(&turned, 1, r, mirrored) == 0);
        CHECK(fabsf(r) < 2 || of_footprint(&turned, 1, r, even) == 0);
        CHECK(of_footprint(&triangle, 1, r, mirrored) == 1); /* it points left */
        CHECK(fabsf(r) < 2 || of_footprint(&triangle, 1, r, even) == 0);
        CHECK(of_footprint(&disc, 4, r, mirrored) == 0 || fabsf(r) < RF_COMMON_PX);
    }
    CHECK(of_footprint(&disc, 4, 0.125f, mirrored) == 1); /* common to all */
}

/* Where they are wide: a sharp one needs them. */
static void footprints_of_parts_do_without_faint_weights(void)
{
    struct rf_shape disc = shape_of(RF_APERTURE_DISC, 0, 0, 1), part;
    double site[4][2] = {{0.5, 0.5}, {-0.5, 0.5}, {0.5, -0.5}, {-0.5, -0.5}}, middle[2];
    CHECK(rf_shape_part(&disc, site, 4, 0, &part, middle) > 0 && part.is_part);
    CHECK(!disc.is_part && faintest_weight(&disc, 12) < 0.03);
    CHECK(faintest_weight(&part, 12) > 0.045);
    CHECK(faintest_weight(&part, 6) > 0.045); /* at full resolution */
    CHECK(faintest_weight(&part, 1.5f) < 0.03);
}

/* Pixels that the footprints of radii up to r really reach. */
static int true_reach(struct rf_footprints *f, struct rf_context *context, double r)
{
    struct rf_task task = {.to = 0};
    unsigned char *needed = rf_calloc(context, rf_footprint_count(f), 1);
    int most = rf_radius_index(f, (float)r), reach = 0;
    size_t n = rf_footprint_count(f) / (size_t)(2 * f->max_index + 1);
    size_t from = n * (size_t)(f->max_index - most);
    memset(needed + from, 1, n * (size_t)(2 * most + 1));
    CHECK(rf_footprints_build(f, needed, &task, 1, NULL) == RF_OK);
    for (size_t i = from; i < from + n * (size_t)(2 * most + 1); i++) {
        const struct rf_footprint *p = rf_footprint_at(f->table, i);
        reach = rf_max_int(reach, rf_max_int(-p->min_dx, p->max_dx));
        reach = rf_max_int(reach, rf_max_int(-p->min_dy, p->max_dy));
    }
    rf_free(context, needed);
    return reach;
}

static void no_footprint_reaches_farther_than_said(void)
{
    struct rf_context *context;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    for (int i = 0; i < 8; i++) {
        struct rf_shape shape = i % 2 ? shape_of(RF_APERTURE_POLYGON, 5, 0.3, 0.5)
                                      : shape_of(RF_APERTURE_DISC, 0, 0, 1);
        /* Sixteen phases are as many times the work: of smaller radii. */
        const bool has_phases = i / 2 % 2 != 0;
        const double largest = has_phases ? 3 : 4.5;
        struct rf_footprint_use use = {.shape = &shape,
                                       .n_cells = 1,
                                       .max_radius = largest + 0.5,
                                       .n_phases = has_phases ? 4 : 1};
        struct rf_footprints f;
        if (i >= 4) {
            shape.pixel_aspect = 1.7;
            use.drift = (struct rf_drift){{0.6, -0.4}, {0.3, -0.8}};
        }
        REQUIRE(rf_footprints_init(&f, context, &use, NULL) == RF_OK);
        for (double r = 0.25; r < largest; r += 0.75) {
            int reach = true_reach(&f, context, r);
            CHECK(reach <= rf_footprints_reach(&f, 0, r));
            CHECK(reach >= rf_footprints_reach(&f, 0, r) - 3);
        }
        rf_footprints_free(&f);
    }
    rf_context_destroy(context);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(areas);
    TEST(corners_lie_on_the_lens);
    TEST(edge_at_the_rotation_as_cycles);
    TEST(a_triangle_points_left);
    TEST(povray_orientation_has_a_corner_there);
    TEST(ratio_divides_the_width);
    TEST(auto_takes_blades_where_given);
    TEST(curvature_makes_edges_arcs);
    TEST(hollow_blades_leave_an_opening);
    TEST(every_aperture_is_convex);
    TEST(measures_of_a_cut_lens);
    TEST(parts_share_out_the_aperture);
    TEST(parts_of_places_at_one_point_or_outside);
    TEST(footprints_of_parts_do_without_faint_weights);
    TEST(footprints_are_mirrored_where_the_lens_is);
    TEST(no_footprint_reaches_farther_than_said);
    return testing_end();
}
