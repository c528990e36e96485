/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lens looks: the picture of a lone lamp against its lens traced pixel by pixel, at nine
 * places, for radii from 2 to 200 px on both sides of the focus: its energy within 1e-4
 * (2e-3 where the footprint is traced and loses light), its shape within 2 % of its area.
 */
#include "frames.h"
#include "testing.h"

enum { WIDTH = 1040, HEIGHT = 840, EDGE = 220 };
enum { N_POINTS = 55, STEP = 34 }; /* Fibonacci's lattice */

static const double LAMP = 1e4, FINE_PX = 8, WIDE_PX = 60, RIM_POINTS = 100;
static const double FINE_CORNER = 0.12; /* px: no corner of a lamp is missed */
static bool testing_is_verbose;
static const double RADII[] = {2, -2, 5, -5, 12, -12, 40, -40, 200, -200};
enum { N_RADII = sizeof RADII / sizeof *RADII };

struct look {
    const char *name;
    double cat_eye, astigmatism, swirl, door[4]; /* left, right, top, bottom */
    double ratio, obstruction;
    int blades;
    double turn, curvature; /* of the blades: radians; 0 and below: hollow */
    double bend_px;         /* what curvature of field adds to radii in a corner */
    bool is_wide;           /* its lamps are far wider than their radius */
};

/* A lamp at (x, y) of a black picture. */
struct lamp {
    const struct look *look;
    int x, y;
    double r;
    bool is_scatter; /* which keeps the lamp's energy, whatever is taken of its lens */
};

static double half_px(void)
{
    return hypot(WIDTH, HEIGHT) / 2;
}

/* Does the lens let the ray through (u, v) to the place q of the picture pass? */
static bool is_open(const struct look *look, double u, double v, const double q[2])
{
    const double side[4][2] = {{-1, 0}, {1, 0}, {0, 1}, {0, -1}};
    double p[2] = {u * look->ratio, v};
    double dx = p[0] - look->cat_eye * q[0], dy = p[1] - look->cat_eye * q[1];
    if (p[0] * p[0] + p[1] * p[1] < look->obstruction * look->obstruction)
        return false;
    if (look->cat_eye > 0 && dx * dx + dy * dy > 1)
        return false;
    for (int i = 0; i < 4; i++)
        if (side[i][0] * p[0] + side[i][1] * p[1] <
            look->door[i] * (side[i][0] * q[0] + side[i][1] * q[1]) - 1)
            return false;
    if (look->blades == 0)
        return p[0] * p[0] + p[1] * p[1] <= 1;
    const double half = 3.14159265358979324 / look->blades;
    double depth = -look->curvature * (1 - cos(half)); /* of the arcs */
    for (int i = 0; i < look->blades; i++) {
        double a = 2 * half * i + look->turn;
        double x = p[0] * cos(a) + p[1] * sin(a);
        if (x > cos(half))
            return false;
        /* Thales: beyond the arc the chord is seen at a wider angle. */
        double y = p[1] * cos(a) - p[0] * sin(a);
        double reach = cos(half) - x, w = sin(half);
        if (depth > 0 &&
            reach * reach + y * y - w * w < reach * (depth - w * w / depth))
            return false;
    }
    return true;
}

/* Is the point (x, y) of the picture lit by the lamp? */
static bool is_lit(const struct lamp *lamp, double x, double y)
{
    const struct look *look = lamp->look;
    const double q[2] = {(x - WIDTH / 2.0) / half_px(), (HEIGHT / 2.0 - y) / half_px()};
    double q2 = q[0] * q[0] + q[1] * q[1];
    double at[2] = {(lamp->x + 0.5 - WIDTH / 2.0) / half_px(),
                    (HEIGHT / 2.0 - lamp->y - 0.5) / half_px()};
    double r =
        lamp->r + look->bend_px * (q2 - at[0] * at[0] - at[1] * at[1]); /* of here */
    double d[2] = {(x - lamp->x - 0.5) / r, (lamp->y + 0.5 - y) / r};
    if (q2 == 0)
        return is_open(look, d[0], d[1], q);
    double along = (d[0] * q[0] + d[1] * q[1]) / q2 / (1 + look->astigmatism * q2);
    double across = (d[1] * q[0] - d[0] * q[1]) / q2 / (1 + look->swirl * q2);
    return is_open(look, along * q[0] - across * q[1], along * q[1] + across * q[0], q);
}

/* How often pixels on a lamp's rim are cut in four: the wider a lamp, the fewer of its
 * pixels lie there. */
static int depth_of(const struct lamp *lamp)
{
    double r = fabs(lamp->r);
    if (lamp->look->is_wide && r > FINE_PX)
        return r > WIDE_PX ? 0 : 1;
    return (int)fmax(ceil(log2(RIM_POINTS / r)), 0);
}

/* Is a square lit alike on a grid of n x n points, its corners among them? No rim of a
 * lamp that is much wider than the grid is crosses it then. */
static bool is_even(const struct lamp *lamp, double x, double y, double side, int n)
{
    bool is_first = is_lit(lamp, x, y);
    double step = side / (n - 1);
    for (int i = 1; i < n * n; i++)
        if (is_lit(lamp, x + i % n * step, y + i / n * step) != is_first)
            return false;
    return true;
}

/* How much of a square is lit; the points of the last ones lie on no line. */
static double lit_share(const struct lamp *lamp, double x, double y, double side,
                        int depth)
{
    double sum = 0, half = side / 2;
    int n = 3 + (fabs(lamp->r) > FINE_PX ? 0 : (int)(side / FINE_CORNER));
    if (is_even(lamp, x, y, side, n))
        return is_lit(lamp, x, y);
    for (int i = 0; i < 4 && depth > 0; i++)
        sum += lit_share(lamp, x + i % 2 * half, y + i / 2 * half, half, depth - 1) / 4;
    for (int i = 0; i < N_POINTS && depth == 0; i++)
        sum += is_lit(lamp, x + (i + 0.5) / N_POINTS * side,
                      y + (i * STEP % N_POINTS + 0.5) / N_POINTS * side) /
               (double)N_POINTS;
    return sum;
}

static void look_params(struct rf_params *p, const struct look *look, int method)
{
    plain_params(p, method);
    p->cat_eye = look->cat_eye;
    p->astigmatism = look->astigmatism;
    p->swirl = look->swirl;
    p->barn_left = look->door[0];
    p->barn_right = look->door[1];
    p->barn_top = look->door[2];
    p->barn_bottom = look->door[3];
    p->aperture_ratio = look->ratio;
    p->obstruction = look->obstruction;
    p->blades = look->blades;
    p->blade_curvature = look->curvature;
    p->blade_rotation = look->turn * 180 / 3.14159265358979324;
    p->aperture = look->blades ? RF_APERTURE_POLYGON : RF_APERTURE_DISC;
    p->cat_eye_exposure =
        method == RF_METHOD_SCATTER ? RF_EXPOSURE_KEEP : RF_EXPOSURE_FALL;
    p->field_curvature = look->bend_px / 40000 /* px per 1 / distance */;
    p->fill_hidden = 0; /* black beside black: for speed */
}

/* How far around a lamp is looked, px: beyond what it can light. What lands farther out
 * is missing from its energy. */
static int reach_of(const struct lamp *lamp)
{
    const struct look *look = lamp->look;
    double growth = 1 + fmax(fmax(look->swirl, look->astigmatism), 0.2);
    return (int)ceil((fabs(lamp->r) + 2 * fabs(look->bend_px)) * growth) + 4;
}

/* The share of its energy that a lamp keeps which lights `lit` px. */
static double energy_of(const struct lamp *lamp, double lit)
{
    struct look bright = *lamp->look;
    struct lamp whole = *lamp;
    int reach = reach_of(lamp), side = 2 * reach + 1;
    double sum = 0;
    bright.cat_eye = 0;
    memset(bright.door, 0, sizeof bright.door);
    whole.look = &bright;
    for (int i = 0; i < side * side; i++)
        sum += lit_share(&whole, lamp->x - reach + i % side, lamp->y - reach + i / side,
                         1, depth_of(lamp));
    return lit / sum;
}

static bool is_dark(const struct look *look)
{
    const double *door = look->door;
    return look->cat_eye > 0 || door[0] > 0 || door[1] > 0 || door[2] > 0 ||
           door[3] > 0;
}

/* What differs between the picture around a lamp and what is lit, in parts of it; the
 * energy of lamps that light the picture's rim is not known. */
static void check_lamp(const struct frame *f, const struct lamp *lamp)
{
    double wrong = 0, sum = 0, lit = 0;
    bool is_cut = false;
    int reach = reach_of(lamp), side = 2 * reach + 1;
    double *share = calloc((size_t)side * (size_t)side, sizeof *share);
    REQUIRE(share);
    for (int i = 0; i < side * side; i++) {
        int x = lamp->x - reach + i % side, y = lamp->y - reach + i / side;
        bool is_inside = x >= 0 && y >= 0 && x < f->width && y < f->height;
        share[i] = is_inside ? lit_share(lamp, x, y, 1, depth_of(lamp)) : 0;
        double v = is_inside ? (double)*frame_at(f, f->out, x, y) : 0;
        lit += share[i];
        sum += v;
        is_cut |= share[i] > 0 &&
                  (x == 0 || y == 0 || x == f->width - 1 || y == f->height - 1);
    }
    for (int i = 0; i < side * side; i++) {
        int x = lamp->x - reach + i % side, y = lamp->y - reach + i / side;
        bool is_inside = x >= 0 && y >= 0 && x < f->width && y < f->height;
        double v = is_inside ? (double)*frame_at(f, f->out, x, y) / sum : 0;
        wrong += fabs(v - share[i] / lit) / 2;
    }
    free(share);
    bool is_counted = is_dark(lamp->look) && !lamp->is_scatter; /* on grids of points */
    double want = is_counted && !is_cut ? energy_of(lamp, lit) : 1;
    double off = sum / LAMP / want - 1;
    CHECK(is_cut ? off < 1e-4
                 : fabs(off) < (is_counted && lamp->look->is_wide ? 2e-3 : 1e-4));
    CHECK(wrong < 0.02);
    if (testing_is_verbose)
        printf("# %s, r %g at (%d, %d): light %+.1e, shape %.4f\n", lamp->look->name,
               lamp->r, lamp->x, lamp->y, off, wrong);
}

/* Three times three, row by row; of each kind one: in a corner, in the middle, beside a
 * side. */
enum { N_PLACES = 9, CORNER = 0, CENTRE = 4, SIDE_PLACE = 7 };

/* Lamps at the places from `first` on, of a picture of radius r. */
static void check_lamps(const struct look *look, int method, double r, int first, int n)
{
    bool is_scatter = method == RF_METHOD_SCATTER; /* nothing hides anything there */
    struct rf_params p;
    struct frame f = frame_make(WIDTH, HEIGHT, 1);
    struct lamp lamps[N_PLACES];
    look_params(&p, look, method);
    for (int i = 0; i < WIDTH * HEIGHT; i++) {
        double x = i % WIDTH + 0.5 - WIDTH / 2.0, y = i / WIDTH + 0.5 - HEIGHT / 2.0;
        double bent = look->bend_px * (x * x + y * y) / half_px() / half_px();
        f.depth[i] = plain_depth(is_scatter ? 0 : r - bent);
    }
    for (int i = first; i < first + n; i++) {
        struct lamp lamp = {look, EDGE + i % 3 * (WIDTH - 2 * EDGE) / 2,
                            EDGE + i / 3 * (HEIGHT - 2 * EDGE) / 2, r, is_scatter};
        *frame_at(&f, f.colour, lamp.x, lamp.y) = (float)LAMP;
        if (is_scatter)
            f.depth[(size_t)lamp.y * WIDTH + (size_t)lamp.x] = plain_depth(r);
        lamps[i] = lamp;
    }
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    for (int i = first; i < first + n; i++)
        check_lamp(&f, &lamps[i]);
    frame_free(&f);
}

static void check_look(const struct look *look, int method, double most)
{
    int first = method == RF_METHOD_SCATTER ? 6 : 0; /* its circles are whole pixels */
    for (int i = first; i < N_RADII && fabs(RADII[i]) <= most; i++) {
        if (fabs(RADII[i]) <= WIDE_PX) {
            check_lamps(look, method, RADII[i], 0, N_PLACES);
            continue;
        }
        static const int places[] = {CORNER, CENTRE,
                                     SIDE_PLACE}; /* they would overlap */
        for (int k = 0; k < 3; k++)
            check_lamps(look, method, RADII[i], places[k], 1);
    }
}

static void cat_eyes(void)
{
    const struct look look = {"cat's eyes", .cat_eye = 0.8, .ratio = 1};
    check_look(&look, RF_METHOD_LAYERED, 200);
    check_look(&look, RF_METHOD_SCATTER, 200);
}

static void swirl(void)
{
    const struct look look = {"swirl", .cat_eye = 0.5, .astigmatism = -0.3,
                              .swirl = 0.4, .ratio = 1};
    check_look(&look, RF_METHOD_LAYERED, 40);
}

/*
 * Looks at the ends of their ranges, and pairs of them, whose lamps light several parts
 * of the picture, or none that a polygon is the shape of.
 */
static void extremes(void)
{
    static const struct look looks[] = {
        {"swirl 2", .swirl = 2, .ratio = 1, .is_wide = true},
        {"swirl 4", .swirl = 4, .ratio = 1, .is_wide = true},
        {"swirl -0.9", .swirl = -0.9, .ratio = 1, .is_wide = true},
        {"astigmatism 4", .astigmatism = 4, .ratio = 1, .is_wide = true},
        {"both 4", .astigmatism = 4, .swirl = 4, .ratio = 1, .is_wide = true},
        {"4 and -0.9", .astigmatism = 4, .swirl = -0.9, .ratio = 1, .is_wide = true},
        {"-0.9 and 4", .astigmatism = -0.9, .swirl = 4, .ratio = 1, .is_wide = true},
        {"swirl 4, cat's eyes", .cat_eye = 0.8, .swirl = 4, .ratio = 1,
         .is_wide = true},
        {"swirl 3, doors", .swirl = 3, .door = {0.5, 1, 0.8, 1.5}, .ratio = 1,
         .is_wide = true},
        {"swirl 3, blades, oval", .swirl = 3, .ratio = 1.5, .is_wide = true,
         .blades = 6},
        {"bent", .bend_px = 120, .ratio = 1, .is_wide = true},
        {"bent back, swirl 2", .swirl = 2, .bend_px = -90, .ratio = 1, .is_wide = true},
    };
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        check_lamps(&looks[i], RF_METHOD_LAYERED, 40, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, 40, CENTRE, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, -150, CORNER, 1);
    }
}

/* A bound of what they may light is far wider than they are. */
static void small_lamps_of_a_bent_surface(void)
{
    const struct look look = {"bent, small", .bend_px = 120, .ratio = 1,
                              .is_wide = true};
    check_lamps(&look, RF_METHOD_LAYERED, 2, CORNER, 1);
    check_lamps(&look, RF_METHOD_LAYERED, -3, CORNER, 1);
}

/* What is hidden of the lens is stretched as its rim is. */
static void stretched_rings(void)
{
    static const struct look looks[] = {
        {"ring, swirl", .swirl = 0.8, .obstruction = 0.6, .ratio = 1},
        {"oval ring, astigmatism", .astigmatism = -0.5, .cat_eye = 0.4,
         .obstruction = 0.6, .ratio = 1.5},
        {"ring, bent", .bend_px = 40, .obstruction = 0.5, .ratio = 1},
    };
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        check_lamps(&looks[i], RF_METHOD_LAYERED, 8, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, -20, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, 20, SIDE_PLACE, 1);
    }
}

static void doors(void)
{
    const struct look look = {"doors", .door = {0.5, 1, 0.8, 1.5}, .ratio = 1};
    check_look(&look, RF_METHOD_LAYERED, 40);
    check_look(&look, RF_METHOD_SCATTER, 200);
}

static void blades_and_ratio(void)
{
    const struct look look = {"blades", .cat_eye = 0.8, .ratio = 1.5, .blades = 6};
    check_look(&look, RF_METHOD_LAYERED, 40);
}

/* Each takes its light in another way: by areas, by lines, by shapes that are moved. */
static void pairs_that_take_light(void)
{
    static const struct look looks[] = {
        {"oval, cat's eyes", .cat_eye = 0.5, .ratio = 1.5},
        {"cat's eyes, doors", .cat_eye = 0.6, .door = {0.5, 1, 0.8, 1.5}, .ratio = 1},
        {"ring, cat's eyes", .cat_eye = 0.6, .obstruction = 0.4, .ratio = 1},
        {"bent, cat's eyes", .cat_eye = 0.5, .bend_px = 60, .ratio = 1},
        {"blades, swirl, cat's eyes", .cat_eye = 0.5, .swirl = 0.4, .ratio = 1,
         .blades = 5},
        {"3 blades, astigmatism", .astigmatism = 0.8, .swirl = -0.8, .ratio = 1,
         .blades = 3},
    };
    for (size_t i = 0; i < sizeof looks / sizeof *looks; i++) {
        check_lamps(&looks[i], RF_METHOD_LAYERED, 12, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, -40, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, 40, SIDE_PLACE, 1);
    }
}

/* Edges are arcs that bulge inwards, at every radius; with other looks at some. */
static void hollow_blades(void)
{
    static const struct look looks[] = {
        {"5 hollow blades", .blades = 5, .turn = 0.2, .curvature = -0.5, .ratio = 1},
        {"9 hollow blades", .blades = 9, .curvature = -0.5, .ratio = 1},
        {"3 hollow blades", .blades = 3, .curvature = -0.5, .ratio = 1},
        {"4 as hollow as can be", .blades = 4, .curvature = -1, .ratio = 1},
        {"hollow, oval, cat's eyes", .cat_eye = 0.8, .blades = 5, .curvature = -0.7,
         .ratio = 1.5},
        {"hollow, ring, swirl", .swirl = 0.4, .obstruction = 0.4, .blades = 6,
         .turn = 0.2, .curvature = -0.5, .ratio = 1},
    };
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < N_RADII; k += 1 + 2 * i)
            check_lamps(&looks[i], RF_METHOD_LAYERED, RADII[k], CENTRE, 1);
    for (size_t i = 2; i < sizeof looks / sizeof *looks; i++) {
        check_lamps(&looks[i], RF_METHOD_LAYERED, 5, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, -40, CORNER, 1);
        check_lamps(&looks[i], RF_METHOD_LAYERED, 40, CENTRE, 1);
    }
}

enum { SIDE = 221, MIDDLE = SIDE / 2 };

/* The share of a lamp's light that lands within `distance` px, in one channel. */
static double within_px(const struct frame *f, int channel, double distance)
{
    double sum = 0, inside = 0;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++) {
            double v = (double)frame_at(f, f->out, x, y)[channel];
            double d = hypot(x - MIDDLE, y - MIDDLE) - distance;
            sum += v;
            inside += v * fmin(fmax(0.5 - d, 0), 1);
        }
    CHECK_NEAR(sum / LAMP, 1, 1e-4);
    return inside / sum;
}

/* A lamp in the middle of a picture of radius r, through a lens with a picture or not.
 */
static struct frame lone_lamp_in(const struct rf_context *context,
                                 const struct rf_params *p, double r,
                                 const struct rf_image *aperture)
{
    struct rf_filter *filter = NULL;
    struct frame f = frame_make(SIDE, SIDE, 3);
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = plain_depth(r);
    for (int c = 0; c < 3; c++)
        frame_at(&f, f.colour, MIDDLE, MIDDLE)[c] = (float)LAMP;
    struct rf_view view = {.colour = rf_image_packed(f.colour, SIDE, SIDE, 3),
                           .depth = rf_image_packed(f.depth, SIDE, SIDE, 1)};
    struct rf_image out = rf_image_packed(f.out, SIDE, SIDE, 3);
    CHECK(rf_filter_create_with(&filter, context, p, SIDE, SIDE, aperture, NULL) ==
          RF_OK);
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    return f;
}

static struct frame lone_lamp(const struct rf_params *p, double r,
                              const struct rf_image *aperture)
{
    struct rf_context *context = NULL;
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    struct frame f = lone_lamp_in(context, p, r, aperture);
    rf_context_destroy(context);
    return f;
}

/* The light within the distance d lies where |r rho - a rho^3| <= d on the lens. */
static double aberrant(double r, double a, double d)
{
    enum { N = 20000 };
    int n = 0;
    for (int i = 0; i < N; i++) {
        double rho = sqrt((i + 0.5) / N);
        n += fabs(r * rho - a * rho * rho * rho) <= d;
    }
    return n / (double)N;
}

static void spherical_aberration(void)
{
    static const double cases[][2] = {{40, -12}, {40, 12}, {-40, -12},
                                      {-25, 9},  {12, -4}, {0.5, -8}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        double r = cases[i][0], a = cases[i][1];
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.spherical = a;
        struct frame f = lone_lamp(&p, r, NULL);
        double rim = fmax(fabs(r - a), fabs(r));
        for (double d = 3; d < rim + 2; d += rim / 7)
            if (fabs(r) > 1) /* smaller ones are no highlights */
                CHECK_NEAR(within_px(&f, 1, d), aberrant(r, a, d), 0.02);
        CHECK(within_px(&f, 1, fabs(r - a) * 0.6) < 0.999);
        frame_free(&f);
    }
}

/* Above 0 discs behind the focus have bright rims, and those before it soft ones: the
 * outer half of an even disc's radius has three quarters of the light. */
static void the_sign_of_the_rims(void)
{
    for (double r = -30; r <= 30; r += 60) {
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.spherical = 6;
        struct frame f = lone_lamp(&p, r, NULL);
        double rim = r > 0 ? 24 : 36;
        double outer = 1 - within_px(&f, 1, rim / 2);
        CHECK(r > 0 ? outer > 0.8 : outer < 0.7);
        frame_free(&f);
    }
}

/* Every radius and level of a picture that is all texture, with the widest footprints:
 * they stay within what a tile holds. */
static void aberration_keeps_within_its_tiles(void)
{
    static const char *const settings[][2] = {{"swirl", "1"},
                                              {"pixel-aspect", "2"},
                                              {"aperture-ratio", "0.5"},
                                              {"cat-eye", "1"}};
    struct frame f = frame_make(140, 100, 3);
    frame_fill_scene(&f, 30);
    for (int i = 0; i < 16; i++) {
        struct rf_params p;
        scene_params(&p, RF_METHOD_LAYERED);
        p.spherical = i % 2 ? 60 : -7;
        p.sub_apertures = i % 4 < 2 ? 1 : 4;
        CHECK(rf_params_set(&p, settings[i / 4][0], settings[i / 4][1], NULL) == RF_OK);
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        for (size_t k = 0; k < 3 * frame_pixels(&f); k++)
            REQUIRE(isfinite(f.out[k]));
    }
    frame_free(&f);
}

/* A ring of red light around a disc of blue, and green everywhere. */
static void picture_of_the_aperture(void)
{
    enum { N = 200 };
    static float picture[N * N * 3];
    for (int i = 0; i < N * N; i++) {
        double rho = hypot(i % N + 0.5 - N / 2, i / N + 0.5 - N / 2) / (N / 2);
        picture[3 * i] = rho < 1 && rho > 0.5;
        picture[3 * i + 1] = rho < 1;
        picture[3 * i + 2] = rho < 0.5;
    }
    const struct rf_image aperture = rf_image_packed(picture, N, N, 3);
    for (double r = -40; r <= 40; r += 80) {
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.aperture = RF_APERTURE_IMAGE;
        struct frame f = lone_lamp(&p, r, &aperture);
        CHECK_NEAR(within_px(&f, 0, 20), 0, 0.02);
        CHECK_NEAR(within_px(&f, 0, 30), (0.5625 - 0.25) / 0.75, 0.02);
        CHECK_NEAR(within_px(&f, 0, 41), 1, 0.005);
        CHECK_NEAR(within_px(&f, 1, 20), 0.25, 0.02);
        CHECK_NEAR(within_px(&f, 2, 10), 0.25, 0.02);
        CHECK_NEAR(within_px(&f, 2, 21), 1, 0.01);
        frame_free(&f);
    }
}

/* A context keeps footprints: those of another picture, or of none, are not taken. */
static void pictures_of_the_aperture_in_turn(void)
{
    enum { N = 40, N_PICTURES = 3, N_VALUES = N * N * 3 };
    static float pictures[N_PICTURES * N_VALUES];
    struct rf_context *context = NULL;
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    for (int i = 0; i < N_PICTURES * N_VALUES; i++)
        pictures[i] = (float)(i * 7 % (11 + i / N_VALUES));
    for (int turn = 0; turn < 4 * (N_PICTURES + 1); turn++) {
        int at = turn % (N_PICTURES + 1);
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.aperture = at < N_PICTURES ? RF_APERTURE_IMAGE : RF_APERTURE_DISC;
        struct rf_image picture = rf_image_packed(pictures + at % N_PICTURES * N_VALUES,
                                                  N, N, at == 1 ? 1 : 3);
        const struct rf_image *aperture = at < N_PICTURES ? &picture : NULL;
        double r = turn % 3 == 0 ? -7 : 6 + turn % 3; /* those that are kept */
        struct frame kept = lone_lamp_in(context, &p, r, aperture);
        struct frame fresh = lone_lamp(&p, r, aperture);
        CHECK(!memcmp(kept.out, fresh.out, frame_bytes(&fresh)));
        frame_free(&kept);
        frame_free(&fresh);
    }
    rf_context_destroy(context);
}

/* A mirror lens: light between 0.5 and 1 of the radius, of a disc and of blades. */
static void rings_of_a_mirror_lens(void)
{
    for (double r = -40; r <= 40; r += 80) {
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.obstruction = 0.5;
        struct frame f = lone_lamp(&p, r, NULL);
        CHECK_NEAR(within_px(&f, 0, 19), 0, 0.02);
        CHECK_NEAR(within_px(&f, 0, 30), (0.5625 - 0.25) / 0.75, 0.02);
        CHECK_NEAR(within_px(&f, 0, 41), 1, 0.005);
        frame_free(&f);
        p.blades = 6;
        f = lone_lamp(&p, r, NULL);
        CHECK_NEAR(within_px(&f, 0, 19), 0, 0.02);
        double area = 1.5 * sqrt(3), hole = 0.25 * 3.14159265358979324;
        double within = 0.5625 * 3.14159265358979324; /* 30 px: no corner cut yet */
        CHECK_NEAR(within_px(&f, 0, 30), (within - hole) / (area - hole), 0.02);
        frame_free(&f);
    }
}

/*
 * Where a cat's eye leaves of a mirror lens only what its obstruction hides, a lamp has
 * no light: rounding was spread in its place, of 200 and of -135 for a lamp of 100.
 */
static void an_obstruction_hides_all_of_the_lens(void)
{
    struct rf_params params;
    struct frame f = frame_make(11, 32, 1);
    rf_params_init(&params);
    params.focus_distance = 10;
    params.lens_radius = 0.273;
    params.focal_length_px = 461;
    params.max_radius = 20;
    params.obstruction = 0.949;
    params.cat_eye = 0.687;
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        f.colour[i] = 0.1f;
        f.depth[i] = 1;
    }
    *frame_at(&f, f.colour, 0, 1) = 100;
    CHECK(frame_filter(&f, &params, 1, NULL) == RF_OK);
    for (size_t i = 0; i < frame_pixels(&f); i++)
        CHECK(f.out[i] >= 0 && f.out[i] < 1);
    frame_free(&f);
}

static void a_missing_picture_is_said(void)
{
    struct rf_params p;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_error error;
    plain_params(&p, RF_METHOD_LAYERED);
    p.aperture = RF_APERTURE_IMAGE;
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, &p, 8, 8, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "aperture");
    rf_context_destroy(context);
}

static void longitudinal_colour(void)
{
    static const double size[3] = {36, 30, 24};
    for (double r = -30; r <= 30; r += 60) {
        struct rf_params p;
        plain_params(&p, RF_METHOD_LAYERED);
        p.axial_chroma = r > 0 ? 6 : -6;
        struct frame f = lone_lamp(&p, r, NULL);
        for (int c = 0; c < 3; c++) {
            double half = size[c] / 2;
            CHECK_NEAR(within_px(&f, c, half), 0.25, 0.01);
            CHECK_NEAR(within_px(&f, c, size[c] + 1), 1, 0.005);
        }
        frame_free(&f);
    }
}

/* Has the picture of f with radii larger by `shift` the same colour c as f.out? Their
 * tiles differ with the largest radius, so that sums are rounded apart. */
static void check_colour(struct frame *f, const struct rf_params *p, int c,
                         double shift, double most)
{
    struct frame other = frame_make(f->width, f->height, 3);
    double sum = 0;
    memcpy(other.colour, f->colour, 3 * frame_pixels(f) * sizeof *f->colour);
    for (size_t i = 0; i < frame_pixels(f); i++)
        other.depth[i] = plain_depth(400 - 40000 / (double)f->depth[i] + shift);
    CHECK(frame_filter(&other, p, 2, NULL) == RF_OK);
    for (size_t i = 0; i < frame_pixels(f); i++)
        sum += fabs((double)(other.out[3 * i + (size_t)c] - f->out[3 * i + (size_t)c]));
    CHECK_NEAR(sum / (double)frame_pixels(f), 0, most);
    frame_free(&other);
}

/* Each colour of a scene of posts, lamps and a floor through the focus is that of the
 * picture whose radii are all larger by as much, in every level. */
static void colours_are_those_of_their_radii(void)
{
    enum { W = 160, H = 120 };
    struct frame f = frame_make(W, H, 3);
    for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
            bool is_post = x % 50 < 8;
            double r = is_post ? -20 : 24 - 0.3 * y;
            bool is_lamp = !is_post && x % 40 == 30 && y % 45 == 20;
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] =
                    is_lamp ? 300 : (float)((x / 7 + y / 5 + c) % 3) * 0.4f;
            f.depth[(size_t)y * W + (size_t)x] = plain_depth(r);
        }
    for (int cells = 1; cells <= 4; cells += 3) {
        struct rf_params p, plain;
        plain_params(&p, RF_METHOD_LAYERED);
        p.sub_apertures = cells;
        plain = p;
        p.axial_chroma = 3;
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        for (int c = 0; c < 3; c++)
            check_colour(&f, &plain, c, 3 * (1 - c), 0.01);
    }
    frame_free(&f);
}

/* An edge 60 px from the middle lies 3 px farther in red and as much nearer in blue. */
static void lateral_colour(void)
{
    struct rf_params p;
    struct frame f = frame_make(SIDE, SIDE, 3);
    plain_params(&p, RF_METHOD_LAYERED);
    p.lateral_chroma = 0.05;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = PLAIN_FOCUS;
    for (int y = 0; y < SIDE; y++)
        for (int x = 0; x < SIDE; x++)
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] = x < MIDDLE + 60;
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    for (int c = 0; c < 3; c++) {
        double lit = 0;
        for (int x = MIDDLE; x < SIDE; x++)
            lit += (double)frame_at(&f, f.out, x, MIDDLE)[c];
        CHECK_NEAR(lit, 60 + 3 * (1 - c), 0.1);
    }
    frame_free(&f);
}

/*
 * What is no lamp is spread by three cells of the lens, which zones reshape: in a corner
 * and at the sides they are as bright as each other. With weights that had not settled
 * they differed by 1.39 here.
 */
static void cells_of_a_stretched_lens_are_even(void)
{
    static const double pairs[][2] = {
        {0.5, -0.5}, {-0.5, 0.5}, {0.4, 0.5}, {-0.7, -0.6}};
    static const int places[][2] = {{980, 420}, {520, 60}, {60, 60}, {970, 130}};
    for (int i = 0; i < 4 * 4; i++) {
        const int x = places[i % 4][0], y = places[i % 4][1];
        struct frame f = frame_make(WIDTH, HEIGHT, 1);
        struct rf_params p;
        double low = 1, high = 0;
        plain_params(&p, RF_METHOD_LAYERED);
        p.astigmatism = pairs[i / 4][0];
        p.swirl = pairs[i / 4][1];
        p.fill_hidden = 0;
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            f.depth[k] = plain_depth(5);
        *frame_at(&f, f.colour, x, y) = 0.5f;
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        for (int k = 0; k < 9; k++) {
            double v = (double)*frame_at(&f, f.out, x + k % 3 - 1, y + k / 3 - 1);
            low = fmin(low, v);
            high = fmax(high, v);
        }
        if (testing_is_verbose)
            printf("# astigmatism %g, swirl %g at (%d, %d): %.3f\n", p.astigmatism,
                   p.swirl, x, y, high / low);
        CHECK(high < 1.15 * low);
        frame_free(&f);
    }
}

int main(int argc, char **argv)
{
    testing_is_verbose = getenv("VERBOSE") != NULL;
    testing_begin(argc, argv);
    TEST(cat_eyes);
    TEST(swirl);
    TEST(extremes);
    TEST(small_lamps_of_a_bent_surface);
    TEST(stretched_rings);
    TEST(cells_of_a_stretched_lens_are_even);
    TEST(doors);
    TEST(blades_and_ratio);
    TEST(pairs_that_take_light);
    TEST(hollow_blades);
    TEST(spherical_aberration);
    TEST(the_sign_of_the_rims);
    TEST(aberration_keeps_within_its_tiles);
    TEST(picture_of_the_aperture);
    TEST(pictures_of_the_aperture_in_turn);
    TEST(rings_of_a_mirror_lens);
    TEST(an_obstruction_hides_all_of_the_lens);
    TEST(a_missing_picture_is_said);
    TEST(longitudinal_colour);
    TEST(colours_are_those_of_their_radii);
    TEST(lateral_colour);
    return testing_end();
}
