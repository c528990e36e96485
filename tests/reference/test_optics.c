/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The circle of confusion in four letters, each from its own derivation, none from the
 * core: radii in px, W width in px, S sensor width, f focal length, N f-number, s focus
 * distance, z depth; all lengths in one unit.
 */
#include "rackfocus/rackfocus.h"
#include "testing.h"

struct camera {
    double f, n_stop, sensor, width, s;
};

/* CG camera: a ray through the rim of a lens at the pinhole, projected with f_px. */
static double model_cg(const struct camera *c, double z)
{
    double lens = c->f / (2 * c->n_stop), f_px = c->width * c->f / c->sensor;
    /* From the lens point to the point in focus on the axis, continued to z. */
    double height_at_z = lens * (1 - z / c->s);
    return -f_px * height_at_z / z;
}

/* Real lens: a point at z is imaged at v_z; the cone meets the sensor, which is at v.
 */
static double model_real_lens(const struct camera *c, double z)
{
    double v = 1 / (1 / c->f - 1 / c->s), v_z = 1 / (1 / c->f - 1 / z);
    double diameter = c->f / c->n_stop * (v - v_z) / v_z;
    return diameter / 2 * c->width / c->sensor;
}

/* Yu 2004: c = a (v (1/f - 1/d) - 1), the screen from v = f d / (d - f). */
static double model_yu(const struct camera *c, double d, double a)
{
    double v = c->f * c->s / (c->s - c->f);
    return a * (v * (1 / c->f - 1 / d) - 1) / 2;
}

/*
 * Reed 2012: linear in the value d of the depth buffer, d = far/(far - n) - (n far /
 * (far - n)) / z; scale S is the radius at infinity.
 */
static double model_reed(double d, double at_infinity, double s, double n, double far)
{
    return at_infinity * (1 - s / n) + at_infinity * s * (far - n) / (n * far) * d;
}

/* The value that OpenGL stores: perspective matrix, division by w, depth range. */
static double gl_depth(double z, double n, double far)
{
    double clip_z = (far + n) / (far - n) * z - 2 * far * n / (far - n);
    return clip_z / z / 2 + 0.5;
}

static const struct camera cameras[] = {
    {0.05, 2.8, 0.036, 1920, 10}, {0.085, 1.4, 0.036, 4096, 2.5},
    {0.018, 8, 0.0236, 640, 0.4}, {0.3, 4, 0.036, 1920, 80},
    {50, 1.8, 36, 1280, 3000},    {0.1, 2.8, 0.036, 1920, 0.3},
};
enum { N_CAMERAS = sizeof cameras / sizeof cameras[0] };

static void params_of(struct rf_params *p, const struct camera *c, int optics)
{
    rf_params_init(p);
    p->optics = optics;
    p->focal_length = c->f * 1000; /* scene units are metres */
    p->sensor_width = c->sensor * 1000;
    p->sensor_fit = RF_SENSOR_FIT_HORIZONTAL;
    p->f_stop = c->n_stop;
    p->focus_distance = c->s;
    p->max_radius = 16384;
}

static struct rf_lens lens_of(const struct rf_params *p, const struct camera *c)
{
    struct rf_lens lens = {0};
    struct rf_error error = {0};
    if (!testing_check(rf_lens_init(&lens, p, (int)c->width, 480, &error) == RF_OK,
                       __FILE__, __LINE__, "rf_lens_init"))
        printf("#     %s\n", error.message);
    return lens;
}

static double closeness(double a)
{
    return 1e-10 * (1 + fabs(a));
}

/* One curve: the three models agree with each other, before the core is asked. */
static void yu_reed_and_the_real_lens_are_one_curve(void)
{
    for (int i = 0; i < N_CAMERAS; i++) {
        const struct camera *c = &cameras[i];
        double a =
            c->f / c->n_stop * c->width / c->sensor; /* aperture's diameter, px */
        double near = c->f * 1.5, far = c->s * 50;
        double at_infinity = c->f / (2 * c->n_stop) * c->width / c->sensor * c->f *
                             c->s / (c->s - c->f) / c->s;
        for (double z = near; z < far; z *= 1.13) {
            double lens = model_real_lens(c, z);
            CHECK_NEAR(model_yu(c, z, a), lens, closeness(lens));
            double d = gl_depth(z, near, far);
            CHECK_NEAR(model_reed(d, at_infinity, c->s, near, far), lens,
                       1e-8 * (1 + fabs(lens)));
        }
        CHECK_NEAR(model_real_lens(c, c->s), 0, 1e-9);
        CHECK_NEAR(model_real_lens(c, 1e15 * c->s), at_infinity,
                   1e-9 * (1 + at_infinity));
    }
}

/* The CG camera is the real lens less its breathing, the factor s / (s - f). */
static void the_camera_lacks_the_breathing(void)
{
    for (int i = 0; i < N_CAMERAS; i++) {
        const struct camera *c = &cameras[i];
        for (double z = c->f * 1.5; z < c->s * 50; z *= 1.13) {
            double lens = model_real_lens(c, z);
            CHECK_NEAR(model_cg(c, z) * c->s / (c->s - c->f), lens, closeness(lens));
        }
    }
}

static void core_camera_and_lens(void)
{
    for (int i = 0; i < N_CAMERAS; i++) {
        const struct camera *c = &cameras[i];
        struct rf_params p;
        params_of(&p, c, RF_OPTICS_CAMERA);
        struct rf_lens camera = lens_of(&p, c);
        params_of(&p, c, RF_OPTICS_LENS);
        struct rf_lens lens = lens_of(&p, c);
        for (double z = c->f * 1.5; z < c->s * 50; z *= 1.13) {
            double want = model_cg(c, z);
            CHECK_NEAR(rf_lens_radius_px(&camera, z), want, closeness(want));
            want = model_real_lens(c, z);
            CHECK_NEAR(rf_lens_radius_px(&lens, z), want, closeness(want));
        }
    }
}

static void core_yu(void)
{
    for (int i = 0; i < N_CAMERAS; i++) {
        const struct camera *c = &cameras[i];
        struct rf_params p;
        params_of(&p, c, RF_OPTICS_YU);
        struct rf_lens automatic = lens_of(&p, c);
        p.screen_position = c->f * c->s / (c->s - c->f);
        p.aperture_coefficient = 123;
        p.focus_distance = 1; /* the screen decides */
        struct rf_lens given = lens_of(&p, c);
        double a = c->f / c->n_stop * c->width / c->sensor;
        for (double z = c->f * 1.5; z < c->s * 50; z *= 1.13) {
            double want = model_yu(c, z, a);
            CHECK_NEAR(rf_lens_radius_px(&automatic, z), want, closeness(want));
            want = model_yu(c, z, 123);
            CHECK_NEAR(rf_lens_radius_px(&given, z), want, closeness(want));
        }
        CHECK_NEAR(given.focus_distance, c->s, 1e-8 * c->s);
    }
}

/* optics buffer: Reed's scale and bias, from the camera's K, on every kind of buffer.
 */
static void core_reed(void)
{
    for (int i = 0; i < N_CAMERAS; i++) {
        const struct camera *c = &cameras[i];
        double n = c->f * 1.5, far = c->s * 50;
        double k = c->f / (2 * c->n_stop) * c->width * c->f / c->sensor;
        struct rf_params p;
        params_of(&p, c, RF_OPTICS_BUFFER);
        p.depth_near = n;
        p.depth_far = far;
        p.depth = RF_DEPTH_BUFFER;
        struct rf_lens plain = lens_of(&p, c);
        p.depth = RF_DEPTH_BUFFER_REVERSED;
        struct rf_lens reversed = lens_of(&p, c);
        p.depth = RF_DEPTH_BUFFER_INFINITE;
        struct rf_lens infinite = lens_of(&p, c);
        p.depth = RF_DEPTH_BUFFER_REVERSED_INFINITE;
        struct rf_lens both = lens_of(&p, c);
        for (double d = 0; d <= 1; d += 1 / 64.0) {
            double want = model_reed(d, k / c->s, c->s, n, far),
                   close = closeness(want);
            CHECK_NEAR(plain.buffer_bias_px + plain.buffer_scale_px * d, want, close);
            CHECK_NEAR(reversed.buffer_bias_px + reversed.buffer_scale_px * (1 - d),
                       want, close);
            want = k * (1 / c->s - (1 - d) / n); /* far at infinity: z = n / (1 - d) */
            close = closeness(want);
            CHECK_NEAR(infinite.buffer_bias_px + infinite.buffer_scale_px * d, want,
                       close);
            CHECK_NEAR(both.buffer_bias_px + both.buffer_scale_px * (1 - d), want,
                       close);
        }
    }
}

/* The three windows of a depth buffer, from the matrices that fill them. */
static double planar_of(int kind, float value, double n, double far)
{
    struct rf_params p;
    struct rf_context *context;
    struct rf_filter *filter;
    float planar = NAN;
    rf_params_init(&p);
    p.depth = kind;
    p.depth_near = n;
    p.depth_far = far;
    struct rf_image in = rf_image_packed(&value, 1, 1, 1);
    struct rf_image out = rf_image_packed(&planar, 1, 1, 1);
    if (rf_context_create(&context, NULL, NULL) != RF_OK)
        return NAN;
    if (rf_filter_create(&filter, context, &p, 1, 1, NULL) == RF_OK) {
        if (rf_filter_planar_depth(filter, &in, &out, NULL) != RF_OK)
            planar = NAN;
        rf_filter_destroy(filter);
    }
    rf_context_destroy(context);
    return planar;
}

static void depth_buffers_come_from_matrices(void)
{
    double n = 0.25, far = 40;
    for (double z = 0.26; z < 39; z *= 1.2) {
        double d = gl_depth(z, n, far);
        double rounding = 1.2e-7 * z * z / n + 1e-6 * z;
        CHECK_NEAR(planar_of(RF_DEPTH_BUFFER, (float)d, n, far), z, rounding);
        /* Reversed: the rows of the matrix for n and far exchanged, range [0, 1]. */
        double reversed = (n / (n - far) * z - far * n / (n - far)) / z;
        CHECK_NEAR(planar_of(RF_DEPTH_BUFFER_REVERSED, (float)reversed, n, far), z,
                   rounding);
        /* Far at infinity: clip z = z - 2 n before the depth range. */
        double infinite = (z - 2 * n) / z / 2 + 0.5;
        CHECK_NEAR(planar_of(RF_DEPTH_BUFFER_INFINITE, (float)infinite, n, far), z,
                   rounding);
        /* Reversed infinite: clip z is the constant n. */
        CHECK_NEAR(planar_of(RF_DEPTH_BUFFER_REVERSED_INFINITE, (float)(n / z), n, far),
                   z, rounding);
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(yu_reed_and_the_real_lens_are_one_curve);
    TEST(the_camera_lacks_the_breathing);
    TEST(core_camera_and_lens);
    TEST(core_yu);
    TEST(core_reed);
    TEST(depth_buffers_come_from_matrices);
    return testing_end();
}
