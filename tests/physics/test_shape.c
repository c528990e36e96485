/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The picture of a lone lamp is the aperture, times the radius: its size, its shape,
 * turned over before the focus, the same at any brightness. For every method; methods
 * that know only circles say so in knows_apertures().
 */
#include "frames.h"
#include "testing.h"

static size_t n_methods;

/*
 * A light that counts as a highlight; the layered method draws those at full
 * resolution. Others with a radius above 8 px go through a reduced one, where a rim is
 * softer and a single pixel sits in a block of 1/8 of its radius or less.
 */
static const double BRIGHT = 100;

static bool knows_apertures(size_t method)
{
    return method != RF_METHOD_SCATTER;
}

struct moments {
    double sum, x, y, xx, yy, xxx, yyy, peak;
};

/* A lamp in the middle of a black frame whose every pixel has radius r. */
static struct frame lamp(struct rf_params *params, double r_px, double light)
{
    int size = 2 * (int)ceil(fabs(r_px) * fmax(1, 1 / params->aperture_ratio)) + 13;
    struct frame f = frame_make(size, size, 1);
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = plain_depth(r_px);
    *frame_at(&f, f.colour, size / 2, size / 2) = (float)light;
    CHECK(frame_filter(&f, params, 2, NULL) == RF_OK);
    return f;
}

/* Moments about the lamp, x to the right and y up. */
static struct moments moments_of(const struct frame *f)
{
    struct moments m = {0};
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            double v = *frame_at(f, f->out, x, y);
            double dx = x - f->width / 2, dy = f->height / 2 - y;
            m.sum += v;
            m.x += v * dx;
            m.y += v * dy;
            m.xx += v * dx * dx;
            m.yy += v * dy * dy;
            m.xxx += v * dx * dx * dx;
            m.yyy += v * dy * dy * dy;
            m.peak = fmax(m.peak, v);
        }
    return m;
}

static void check_disc(int method, double r, double light)
{
    struct rf_params params;
    plain_params(&params, method);
    struct frame f = lamp(&params, r, light);
    struct moments m = moments_of(&f);
    bool is_reduced = light != BRIGHT && fabs(r) >= 8;
    /* Scatter moves in whole pixels; the grain of a pixel adds to a small circle. */
    double close = 0.01 + 0.15 / (r * r / 4);
    if (method == RF_METHOD_SCATTER)
        close = 0.4 / fabs(r);
    else if (is_reduced)
        close = 0.07;
    double place = is_reduced && method != RF_METHOD_SCATTER ? fabs(r) / 12 : 0.01;
    CHECK_NEAR(m.xx / m.sum / (r * r / 4), 1, close);
    CHECK_NEAR(m.yy / m.sum / (r * r / 4), 1, close);
    CHECK_NEAR(m.x / m.sum, 0, place);
    CHECK_NEAR(m.y / m.sum, 0, place);
    frame_free(&f);
}

/* A uniform disc of radius r has the mean square r^2 / 4 along each axis. */
static void a_disc_has_the_radius_of_the_thin_lens(void)
{
    static const double radii[] = {3, 5.5, 7.9, 8, 12.3, 20, 31, 64};
    for (size_t method = 0; method < n_methods; method++)
        for (int k = 0; k < 8; k++) {
            check_disc((int)method, radii[k], BRIGHT);
            check_disc((int)method, -radii[k], BRIGHT);
            check_disc((int)method, radii[k], 1);
            check_disc((int)method, -radii[k], 1);
        }
}

/* Flat inside, nothing outside: the rim may take two pixels. */
static void a_disc_is_uniform_with_a_sharp_rim(void)
{
    for (size_t method = 0; method < n_methods; method++) {
        struct rf_params params;
        plain_params(&params, (int)method);
        double r = 24;
        struct frame f = lamp(&params, r, BRIGHT);
        double level = BRIGHT / (3.14159265358979 * r * r), inside = 0, outside = 0;
        for (int y = 0; y < f.height; y++)
            for (int x = 0; x < f.width; x++) {
                double d = hypot(x - f.width / 2, y - f.height / 2);
                double v = *frame_at(&f, f.out, x, y);
                if (d < r - 2)
                    inside = fmax(inside, fabs(v / level - 1));
                if (d > r + 2)
                    outside = fmax(outside, fabs(v / level));
            }
        CHECK_NEAR(inside, 0, 0.05);
        CHECK_NEAR(outside, 0, 0.01);
        frame_free(&f);
    }
}

/* The exact moments of a regular polygon with corners at angles, x divided by ratio. */
static void polygon_moments(int n, double first, double ratio, struct moments *m)
{
    enum { STEPS = 900 };
    *m = (struct moments){0};
    for (int i = 0; i < STEPS; i++)
        for (int k = 0; k < STEPS; k++) {
            double x = (i + 0.5) / STEPS * 2 - 1, y = (k + 0.5) / STEPS * 2 - 1;
            double angle = atan2(y, x) - first, step = 2 * 3.14159265358979 / n;
            double within = angle - step * floor(angle / step) - step / 2;
            if (hypot(x, y) * cos(within) >= cos(step / 2))
                continue;
            m->sum += 1;
            m->x += x / ratio;
            m->y += y;
            m->xx += x * x / (ratio * ratio);
            m->yy += y * y;
            m->xxx += x * x * x / (ratio * ratio * ratio);
            m->yyy += y * y * y;
        }
}

static void check_polygon(int method, int blades, double rotation, double ratio,
                          double r)
{
    struct rf_params params;
    struct moments want, got;
    plain_params(&params, method);
    params.blades = blades;
    params.blade_rotation = rotation;
    params.aperture_ratio = ratio;
    double first = (rotation + 180.0 / blades) * 3.14159265358979 / 180;
    polygon_moments(blades, first, ratio, &want);
    struct frame f = lamp(&params, r, BRIGHT);
    got = moments_of(&f);
    CHECK_NEAR(got.xx / got.sum / (r * r), want.xx / want.sum,
               0.02 * want.xx / want.sum);
    CHECK_NEAR(got.yy / got.sum / (r * r), want.yy / want.sum,
               0.02 * want.yy / want.sum);
    /* The odd moments turn over before the focus. */
    CHECK_NEAR(got.x / got.sum / r, want.x / want.sum, 0.005);
    CHECK_NEAR(got.y / got.sum / r, want.y / want.sum, 0.005);
    CHECK_NEAR(got.xxx / got.sum / (r * r * r), want.xxx / want.sum, 0.006);
    CHECK_NEAR(got.yyy / got.sum / (r * r * r), want.yyy / want.sum, 0.006);
    frame_free(&f);
}

static void polygons_on_both_sides_of_the_focus(void)
{
    for (size_t method = 0; method < n_methods; method++)
        for (int blades = 3; knows_apertures(method) && blades <= 9; blades += 1)
            for (int sign = -1; sign <= 1; sign += 2) {
                check_polygon((int)method, blades, 0, 1, sign * 21.0);
                check_polygon((int)method, blades, 25, 1, sign * 13.0);
                check_polygon((int)method, blades, 10, 1.5, sign * 17.0);
            }
}

/* A triangle before the focus is the one behind it, turned by 180 degrees. */
static void polygons_flip_over_in_front_of_the_focus(void)
{
    for (size_t method = 0; method < n_methods; method++) {
        struct rf_params params;
        plain_params(&params, (int)method);
        params.blades = 3;
        params.blade_rotation = 20;
        struct frame far = lamp(&params, 15, BRIGHT);
        struct frame near = lamp(&params, -15, BRIGHT);
        double turned = 0, straight = 0;
        size_t n = frame_pixels(&far);
        double level = moments_of(&far).peak;
        for (size_t i = 0; i < n; i++) {
            turned = fmax(turned, fabs(near.out[i] - far.out[n - 1 - i]) / level);
            straight += fabs(near.out[i] - far.out[i]);
        }
        CHECK_NEAR(turned, 0, 0.02);
        if (knows_apertures(method))
            CHECK(straight > 0.3 * BRIGHT);
        frame_free(&far);
        frame_free(&near);
    }
}

static void a_highlight_keeps_its_shape_at_any_brightness(void)
{
    static const double lights[] = {5, 1e3, 1e4, 1e6};
    static const double radii[] = {1.5, 4, 11, 26};
    for (size_t method = 0; method < n_methods; method++)
        for (int i = 0; i < 4; i++)
            for (int k = 0; k < 4; k++) {
                struct rf_params params;
                plain_params(&params, (int)method);
                params.blades = i % 2 ? 6 : 0;
                struct frame dim = lamp(&params, radii[k], BRIGHT);
                struct frame lit = lamp(&params, radii[k], lights[i]);
                double peak = moments_of(&dim).peak, worst = 0;
                for (size_t p = 0; p < frame_pixels(&dim); p++)
                    worst =
                        fmax(worst, fabs(lit.out[p] / lights[i] - dim.out[p] / BRIGHT) /
                                        (peak / BRIGHT));
                CHECK_NEAR(worst, 0, 0.01);
                frame_free(&dim);
                frame_free(&lit);
            }
}

/*
 * Mean squares along x and y, px^2, that the blur adds to a panel of 8 x 8 px, about
 * the panel's middle; over all places of the panel in the blocks of a reduced
 * resolution.
 */
static void panel_growth(const struct rf_params *params, double r, double growth[2])
{
    enum { SIDE = 8, N_PLACES = 8 };
    double sum = 0, xx = 0, yy = 0;
    double wide = fabs(r) * fmax(1, 1 / params->aperture_ratio);
    int size = 2 * (int)ceil(wide) + 2 * SIDE + 16;
    for (int place = 0; place < N_PLACES; place++) {
        struct frame f = frame_make(size, size, 1);
        int x0 = size / 2 + place, y0 = size / 2 + place;
        for (size_t i = 0; i < frame_pixels(&f); i++)
            f.depth[i] = plain_depth(r);
        for (int i = 0; i < SIDE * SIDE; i++)
            *frame_at(&f, f.colour, x0 + i % SIDE - SIDE / 2,
                      y0 + i / SIDE - SIDE / 2) = 1;
        CHECK(frame_filter(&f, params, 2, NULL) == RF_OK);
        for (int i = 0; i < size * size; i++) {
            double dx = i % size + 0.5 - x0, dy = i / size + 0.5 - y0;
            sum += f.out[i];
            xx += f.out[i] * dx * dx;
            yy += f.out[i] * dy * dy;
        }
        frame_free(&f);
    }
    growth[0] = xx / sum - (SIDE * SIDE - 1) / 12.0;
    growth[1] = yy / sum - (SIDE * SIDE - 1) / 12.0;
}

/* The half-axes of anamorphic blur, of what is no highlight, within 1 %. */
static void a_panel_blurs_by_the_radius_along_both_axes(void)
{
    static const double radii[] = {5, -10, 24};
    static const double ratios[] = {0.5, 1, 2};
    for (int k = 0; k < 9; k++) {
        struct rf_params params;
        double r = radii[k / 3], ratio = ratios[k % 3], growth[2];
        plain_params(&params, RF_METHOD_LAYERED);
        params.aperture_ratio = ratio;
        params.sub_apertures = 1;
        panel_growth(&params, r, growth);
        CHECK_NEAR(2 * sqrt(growth[0]) / (fabs(r) / ratio), 1, 0.01);
        CHECK_NEAR(2 * sqrt(growth[1]) / fabs(r), 1, 0.01);
    }
}

/* The core's aperture in pixels that are not square: a circle of the scene. */
static void pixel_aspect_stretches_rows(void)
{
    for (size_t method = 0; method < n_methods; method++) {
        struct rf_params params;
        plain_params(&params, (int)method);
        params.pixel_aspect = 0.5; /* pixels half as wide as high */
        struct frame f = lamp(&params, 20, BRIGHT);
        struct moments m = moments_of(&f);
        /* Those of scatter move in whole pixels. */
        double most = knows_apertures(method) ? 0.02 : 0.03;
        CHECK_NEAR(m.xx / m.sum / 100, 1, most);
        CHECK_NEAR(m.yy / m.sum / 25, 1, most);
        frame_free(&f);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    n_methods = n_physical_methods();
    TEST(a_disc_has_the_radius_of_the_thin_lens);
    TEST(a_disc_is_uniform_with_a_sharp_rim);
    TEST(polygons_on_both_sides_of_the_focus);
    TEST(polygons_flip_over_in_front_of_the_focus);
    TEST(a_highlight_keeps_its_shape_at_any_brightness);
    TEST(a_panel_blurs_by_the_radius_along_both_axes);
    TEST(pixel_aspect_stretches_rows);
    return testing_end();
}
