/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The light that cat's eyes and barn doors take: lone lamps with `fall` against those
 * with `keep`, times the light of the cut lens over that of the whole one, which is
 * counted here on a grid of points of the lens. Within 1e-4 of a lamp's energy.
 */
#include "frames.h"
#include "testing.h"

enum { WIDTH = 880, HEIGHT = 640, N_GRID = 1400, SIDE = 64, N_COLOURS = 3 };

static const double LENS = 40, LAMP = 1e4, PI = 3.14159265358979324;

struct lens {
    const char *name;
    double cat_eye, left, top; /* the doors */
    double ratio, obstruction, curvature;
    int blades;
    bool has_picture;
    bool has_wall; /* in the place of the lamp: a bright half, no highlight */
};

/* The picture of the aperture: smooth, other in each colour, dark below at the left. */
static float picture_at(int x, int y, int c)
{
    return (float)((x + 2) * (y < 40 ? 3 : 1) * (c == 0) + (2 * SIDE - x) * (c == 1) +
                   (200 + x * y) * (c == 2));
}

static bool is_in_blades(const struct lens *l, double u, double v)
{
    double half = PI / l->blades, sagitta = -l->curvature * (1 - cos(half));
    for (int i = 0; i < l->blades; i++) {
        double a = half * (2 * i + 1) + half;
        double x = u * cos(a) + v * sin(a), y = v * cos(a) - u * sin(a);
        double reach = cos(half) - x, w = sin(half);
        if (reach < 0)
            return false;
        /* Thales: beyond the arc the chord is seen at a wider angle. */
        if (sagitta > 0 &&
            reach * reach + y * y - w * w < reach * (sagitta - w * w / sagitta))
            return false;
    }
    return true;
}

/* The light of the whole lens at the point (u, v). */
static double light_at(const struct lens *l, double u, double v, int c)
{
    double r2 = u * u + v * v;
    if (l->has_picture)
        return (double)picture_at((int)((u + 1) / 2 * SIDE), (int)((1 - v) / 2 * SIDE),
                                  c);
    if (r2 < l->obstruction * l->obstruction)
        return 0;
    return l->blades ? is_in_blades(l, u, v) : r2 <= 1;
}

/* The share of the light that comes through to q, in each colour. */
static void share_at(const struct lens *l, const double q[2], double share[N_COLOURS])
{
    double open[N_COLOURS] = {0}, whole[N_COLOURS] = {0};
    for (int i = 0; i < N_GRID * N_GRID; i++) {
        double u = (i % N_GRID + 0.5) / N_GRID * 2 - 1;
        double v = (i / N_GRID + 0.5) / N_GRID * 2 - 1;
        double du = u - l->cat_eye * q[0], dv = v - l->cat_eye * q[1];
        bool is_open = (l->cat_eye == 0 || du * du + dv * dv <= 1) &&
                       -u >= -l->left * q[0] - 1 && v >= l->top * q[1] - 1;
        for (int c = 0; c < (l->has_picture ? N_COLOURS : 1); c++) {
            double light = light_at(l, u, v, c);
            whole[c] += light;
            open[c] += is_open ? light : 0;
        }
    }
    for (int c = 0; c < N_COLOURS; c++)
        share[c] = l->has_picture ? open[c] / whole[c] : open[0] / whole[0];
}

enum { MOST_VIEWS = 2, VIEW_PX = 4 };

/* A lamp, or a wall of which the right half is brighter. */
static void fill(const struct lens *l, struct frame *f, int x, int y)
{
    for (int i = 0; i < WIDTH * HEIGHT * N_COLOURS; i++)
        f->colour[i] = !l->has_wall ? 0 : i / N_COLOURS % WIDTH < x ? 0.4f : 0.6f;
    for (int c = 0; c < N_COLOURS && !l->has_wall; c++)
        frame_at(f, f->colour, x, y)[c] = (float)LAMP;
}

/* A picture of a lamp at (x, y) of radius r, by one view or by two, to the left and to
 * the right of the middle of the lens, which see the lamp VIEW_PX beside it. */
static struct frame lamp_through(const struct lens *l, int exposure, int x, int y,
                                 double r, int n_views)
{
    static float picture[SIDE * SIDE * N_COLOURS];
    struct frame f = frame_make(WIDTH, HEIGHT, N_COLOURS);
    struct rf_params p;
    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    for (int i = 0; i < SIDE * SIDE * N_COLOURS; i++)
        picture[i] =
            picture_at(i / N_COLOURS % SIDE, i / N_COLOURS / SIDE, i % N_COLOURS);
    const struct rf_image aperture = rf_image_packed(picture, SIDE, SIDE, N_COLOURS);
    plain_params(&p, n_views > 1 ? RF_METHOD_VIEWS : RF_METHOD_LAYERED);
    p.cat_eye = l->cat_eye;
    p.barn_left = l->left;
    p.barn_top = l->top;
    p.aperture_ratio = l->ratio;
    p.obstruction = l->obstruction;
    p.blades = l->blades;
    p.blade_curvature = l->curvature;
    p.cat_eye_exposure = exposure;
    p.fill_hidden = 0; /* black beside black: for speed */
    if (l->has_picture)
        p.aperture = RF_APERTURE_IMAGE;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = plain_depth(r);
    struct rf_view views[MOST_VIEWS];
    struct frame seen[MOST_VIEWS];
    for (int i = 0; i < n_views; i++) {
        int side = n_views == 1 ? 0 : i ? 1 : -1;
        seen[i] = frame_make(WIDTH, HEIGHT, N_COLOURS);
        fill(l, &seen[i], x + side * VIEW_PX, y);
        views[i] = (struct rf_view){
            .colour = rf_image_packed(seen[i].colour, WIDTH, HEIGHT, N_COLOURS),
            .depth = rf_image_packed(f.depth, WIDTH, HEIGHT, 1),
            .lens_offset = {LENS * side * VIEW_PX / r, 0},
            .shear_distance = PLAIN_FOCUS};
    }
    struct rf_image out = rf_image_packed(f.out, WIDTH, HEIGHT, N_COLOURS);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create_with(&filter, context, &p, WIDTH, HEIGHT,
                                l->has_picture ? &aperture : NULL, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, views, n_views, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    for (int i = 0; i < n_views; i++)
        frame_free(&seen[i]);
    return f;
}

/* A lamp of radius r whose shares, linear between its corners, are those counted. */
static void check_lamp(const struct lens *l, int x, int y, double r)
{
    struct frame keep = lamp_through(l, RF_EXPOSURE_KEEP, x, y, r, 1);
    struct frame fall = lamp_through(l, RF_EXPOSURE_FALL, x, y, r, 1);
    double share[4][N_COLOURS], half_px = hypot(WIDTH, HEIGHT) / 2;
    int reach = (int)fabs(r) + 2;
    for (int i = 0; i < 4; i++) {
        double at_x = x + 0.5 + (i % 2 ? reach : -reach);
        double at_y = y + 0.5 + (i / 2 ? reach : -reach);
        const double q[2] = {(at_x - WIDTH / 2.0) / half_px,
                             (HEIGHT / 2.0 - at_y) / half_px};
        share_at(l, q, share[i]);
    }
    for (int c = 0; c < N_COLOURS; c++) {
        double sum = 0, want = 0;
        for (int i = 0; i < WIDTH * HEIGHT; i++) {
            double s = (i % WIDTH - x) / (2.0 * reach) + 0.5;
            double t = (i / WIDTH - y) / (2.0 * reach) + 0.5;
            double left = (1 - t) * share[0][c] + t * share[2][c];
            double right = (1 - t) * share[1][c] + t * share[3][c];
            size_t at = (size_t)i * N_COLOURS + (size_t)c;
            sum += (double)fall.out[at];
            want += (double)keep.out[at] * ((1 - s) * left + s * right);
        }
        printf("# %s, colour %d: %.5f of a lamp's light, %+.1e\n", l->name, c,
               sum / LAMP, (sum - want) / LAMP);
        CHECK_NEAR(sum / LAMP, want / LAMP, 1e-4);
        CHECK(sum / LAMP < 0.95);
    }
    frame_free(&keep);
    frame_free(&fall);
}

static void the_light_of_every_aperture_falls(void)
{
    static const struct lens lenses[] = {
        {"ring", .cat_eye = 0.8, .obstruction = 0.6, .ratio = 1},
        {"hollow blades", .cat_eye = 0.9, .blades = 5, .curvature = -0.7, .ratio = 1},
        {"hollow ring, doors", .left = 1, .top = 0.7, .blades = 6, .curvature = -0.5,
         .obstruction = 0.3, .ratio = 1},
        {"picture", .cat_eye = 0.9, .ratio = 1, .has_picture = true},
        {"disc", .cat_eye = 0.9, .ratio = 1},
    };
    for (size_t i = 0; i < sizeof lenses / sizeof *lenses; i++)
        check_lamp(&lenses[i], 120, 90, i % 2 ? 7 : -7);
}

/*
 * With `fall` a lamp keeps what its lens leaves of its footprint: two discs, the second
 * of radius 1 / (1 - c r / h) and so much farther beside the first. Their common area is
 * summed along lines. By the share of the pixels alone it is 5.2 % less at 40 px and
 * 5.6 % more at -40; by the rounded radius of the footprint it was 1.6e-4 off.
 */
static void lamps_keep_what_their_footprint_does(void)
{
    enum { N = 200000 };
    static const struct lens lens = {.cat_eye = 0.9, .ratio = 1};
    static const double radii[] = {5, -5, 40.06, -40.06, 90, -90};
    static const int places[][2] = {{WIDTH / 2, HEIGHT / 2}, {680, 440}, {150, 150}};
    double half_px = hypot(WIDTH, HEIGHT) / 2;
    for (int i = 0; i < 6 * 3; i++) {
        int x = places[i % 3][0], y = places[i % 3][1];
        double r = radii[i / 3], scale = 1 - lens.cat_eye * r / half_px, want = 0;
        double away = hypot(x + 0.5 - WIDTH / 2.0, HEIGHT / 2.0 - y - 0.5) / half_px *
                      lens.cat_eye / scale;
        for (int k = 0; k < N; k++) {
            double v = (k + 0.5) / N * 2 - 1, half = sqrt(1 - v * v);
            double rest = 1 / scale / scale - v * v, wide = rest > 0 ? sqrt(rest) : 0;
            want += rest > 0
                        ? fmax(fmin(half, away + wide) - fmax(-half, away - wide), 0)
                        : 0;
        }
        want *= 2.0 / N / PI;
        struct frame f = lamp_through(&lens, RF_EXPOSURE_FALL, x, y, r, 1);
        double sum = 0;
        for (int k = 0; k < WIDTH * HEIGHT; k++)
            sum += (double)f.out[k * N_COLOURS];
        printf("# r %g at (%d, %d): %.5f, %+.1e\n", r, x, y, sum / LAMP,
               sum / LAMP - want);
        CHECK_NEAR(sum / LAMP, want, 2e-5);
        frame_free(&f);
    }
}

/* Parts of the lens weigh by the light that comes through each, not by their areas: both
 * views make the edge of a wall as one does. */
static void views_have_the_light_of_one(void)
{
    enum { X = 90, Y = 320, REACH = 20 };
    static const struct lens lens = {
        .cat_eye = 0.9, .ratio = 1, .has_picture = true, .has_wall = true};
    for (double r = -10; r <= 10; r += 20) {
        struct frame one = lamp_through(&lens, RF_EXPOSURE_FALL, X, Y, r, 1);
        struct frame two = lamp_through(&lens, RF_EXPOSURE_FALL, X, Y, r, 2);
        double worst = 0;
        for (int i = -REACH; i <= REACH; i++)
            for (int c = 0; c < N_COLOURS; c++) {
                double a = (double)frame_at(&one, one.out, X + i, Y)[c];
                double b = (double)frame_at(&two, two.out, X + i, Y)[c];
                worst = fmax(fabs(a - b), worst);
            }
        printf("# r %g: views are off by %.1e\n", r, worst);
        CHECK(worst < 4.5e-3); /* by areas 6.4e-3 */
        frame_free(&one);
        frame_free(&two);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(the_light_of_every_aperture_falls);
    TEST(lamps_keep_what_their_footprint_does);
    TEST(views_have_the_light_of_one);
    return testing_end();
}
