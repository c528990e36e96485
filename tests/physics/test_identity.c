/* SPDX-License-Identifier: Apache-2.0 */
/* What must not change: a picture in focus, a constant picture, a mirrored one. */
#include <float.h>

#include "frames.h"
#include "testing.h"

static size_t n_methods;

static void fill_odd_values(struct frame *f)
{
    static const float odd[] = {0.0f,  -0.0f, -1.5f,           FLT_MIN, 1e-42f,
                                1e30f, 1e6f,  0.333333343267f, 65504,   -1e-30f};
    uint32_t seed = 5;
    size_t n = frame_pixels(f) * (size_t)f->channels;
    for (size_t i = 0; i < n; i++)
        f->colour[i] = i % 3 ? odd[i % 10] : (float)random_unit(&seed);
}

static void in_focus_is_bit_for_bit(void)
{
    static const int channels[] = {1, 3, 4};
    for (size_t m = 0; m < n_methods; m++)
        for (int k = 0; k < 3; k++)
            for (int gamma = 0; gamma < 2; gamma++) {
                struct frame f = frame_make(53, 31, channels[k]);
                struct rf_params params;
                plain_params(&params, (int)m);
                params.blend_gamma = gamma ? 2.2 : 1;
                params.blades = 5 * gamma;
                fill_odd_values(&f);
                for (size_t i = 0; i < frame_pixels(&f); i++)
                    f.depth[i] = PLAIN_FOCUS;
                CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
                CHECK(memcmp(f.out, f.colour, frame_bytes(&f)) == 0);
                frame_free(&f);
            }
}

/* A lamp before a wall, both of radius r_px, with a lens of spherical aberration. */
static struct frame glow(double r_px, int quality)
{
    struct frame f = frame_make(64, 48, 3);
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.spherical = 3;
    params.quality = quality;
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        f.depth[i] = plain_depth(r_px);
        for (size_t c = 0; c < 3; c++)
            f.colour[3 * i + c] = 0.2f + 0.4f * (float)((i / 4 + i / 256) % 2);
    }
    for (int c = 0; c < 3; c++)
        frame_at(&f, f.colour, 40, 20)[c] = 60;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    return f;
}

/* What is in focus glows also where the whole picture is, as it does next to it. */
static void in_focus_glows_with_spherical_aberration(void)
{
    for (int quality = RF_QUALITY_PREVIEW; quality <= RF_QUALITY_BEST; quality++) {
        struct frame at = glow(0, quality), next = glow(0.02, quality);
        double off = 0, sum = 0;
        for (size_t i = 0; i < frame_pixels(&at) * 3; i++) {
            off += fabs((double)at.out[i] - (double)next.out[i]);
            sum += (double)next.out[i];
        }
        CHECK(off < 0.01 * sum);
        CHECK(frame_at(&at, at.out, 40, 20)[0] < 0.75f * 60);
        frame_free(&at);
        frame_free(&next);
    }
}

/* The aperture closed as far as it goes: nothing is blurred, whatever the depth. */
static void a_pinhole_gives_the_input(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(64, 48, 3);
        struct rf_params params;
        scene_params(&params, (int)m);
        params.lens_radius = 1e-6;
        frame_fill_scene(&f, 30);
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        double worst = 0;
        for (size_t i = 0; i < frame_pixels(&f) * 3; i++)
            worst = fmax(worst, fabs(f.out[i] - f.colour[i]) / (1 + f.colour[i]));
        CHECK_NEAR(worst, 0, 1e-5);
        frame_free(&f);
    }
}

static double constant_error(int method, double r_px, int kind, int channels)
{
    struct frame f = frame_make(90, 70, channels);
    struct rf_params params;
    uint32_t seed = 3;
    plain_params(&params, method);
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        size_t x = i % 90, y = i / 90;
        double r = kind == 0   ? r_px
                   : kind == 1 ? r_px * (2 * random_unit(&seed) - 1)
                   : kind == 2 ? r_px * (x / 45.0 - 1)
                               : (x / 9 + y / 7) % 3 * r_px - r_px;
        f.depth[i] = kind == 3 && (x / 9 + y / 7) % 5 == 0 ? INFINITY : plain_depth(r);
        for (int c = 0; c < channels; c++)
            f.colour[i * (size_t)channels + (size_t)c] = 0.25f + 0.2f * (float)c;
    }
    params.max_radius = 40;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    double worst = 0;
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        int x = (int)(i % 90), y = (int)(i / 90), edge = (int)ceil(r_px) + 1;
        /* Scatter darkens the border: nothing comes in from outside. */
        if (method == RF_METHOD_SCATTER &&
            (x < edge || y < edge || x >= 90 - edge || y >= 70 - edge))
            continue;
        for (int c = 0; c < channels; c++)
            worst = fmax(
                worst, fabs(f.out[i * (size_t)channels + (size_t)c] - 0.25 - 0.2 * c));
    }
    frame_free(&f);
    return worst;
}

static void constant_stays_constant_at_any_depth(void)
{
    static const double radii[] = {0.4, 2, 6.5, 20, 33};
    for (int k = 0; k < 5; k++) {
        for (int kind = 0; kind < 4; kind++)
            for (int channels = 3; channels <= 4; channels++) {
                double worst =
                    constant_error(RF_METHOD_LAYERED, radii[k], kind, channels);
                if (!testing_check(worst <= 2e-5, __FILE__, __LINE__, "constant"))
                    printf("#     kind %d, radius %g, %d channels: off by %g\n", kind,
                           radii[k], channels, worst);
            }
        CHECK_NEAR(constant_error(RF_METHOD_SCATTER, radii[k], 0, 3), 0, 2e-6);
    }
}

/*
 * A disc before a wall whose radii rise to r_px at the right. Oval, stretched and glowing
 * footprints go to the next level within a bin; the wall there is closed after it is
 * composited, not before.
 */
static double constant_wall_error(double r_px, double ratio, double swirl,
                                  double spherical)
{
    struct frame f = frame_make(80, 96, 1);
    struct rf_params params;
    plain_params(&params, RF_METHOD_LAYERED);
    params.aperture_ratio = ratio;
    params.swirl = swirl;
    params.spherical = spherical;
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        double x = (double)(i % 80), y = (double)(i / 80);
        f.depth[i] = plain_depth(hypot(x - 72, y) < 9 ? -18 : r_px * (0.5 + x / 158));
        f.colour[i] = 0.25f;
    }
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    double worst = 0;
    for (size_t i = 0; i < frame_pixels(&f); i++)
        worst = fmax(worst, fabs(f.out[i] - 0.25));
    frame_free(&f);
    return worst;
}

static void constant_walls_beyond_the_first_level(void)
{
    for (double r = 3; r < 10; r += 0.5) {
        CHECK_NEAR(constant_wall_error(r, 0.6, 0, 0), 0, 1e-5);
        CHECK_NEAR(constant_wall_error(r, 1, 0.5, 0), 0, 1e-5);
        CHECK_NEAR(constant_wall_error(r, 1, 0, -3.8), 0, 1e-5);
        CHECK_NEAR(constant_wall_error(r, 1, 0, 3.8), 0, 1e-5);
    }
}

/* Which of the eight ways to turn a picture over. */
static void turned(const struct frame *from, struct frame *to, bool flip_x, bool flip_y)
{
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++) {
            int sx = flip_x ? to->width - 1 - x : x;
            int sy = flip_y ? to->height - 1 - y : y;
            memcpy(frame_at(to, to->colour, x, y), frame_at(from, from->colour, sx, sy),
                   sizeof(float) * (size_t)to->channels);
            to->depth[y * to->width + x] = from->depth[sy * to->width + sx];
        }
}

/* tPSNR of the outputs, `b` turned back. */
static double agreement(struct frame *a, struct frame *b, bool flip_x, bool flip_y)
{
    double sum = 0;
    for (int y = 0; y < a->height; y++)
        for (int x = 0; x < a->width; x++) {
            const float *p = frame_at(a, a->out, x, y);
            const float *q = frame_at(b, b->out, flip_x ? a->width - 1 - x : x,
                                      flip_y ? a->height - 1 - y : y);
            for (int c = 0; c < a->channels; c++) {
                double d = pow(fmin(fmax(p[c], 0), 1), 1 / 2.2) -
                           pow(fmin(fmax(q[c], 0), 1), 1 / 2.2);
                sum += d * d;
            }
        }
    return -10 * log10(sum / (double)(frame_pixels(a) * (size_t)a->channels) + 1e-14);
}

static void check_mirror(int method, int sub_apertures, double want_db)
{
    for (int way = 1; way < 4; way++) {
        struct frame a = frame_make(96, 64, 3), b = frame_make(96, 64, 3);
        struct rf_params params;
        scene_params(&params, method);
        params.sub_apertures = sub_apertures;
        frame_fill_scene(&a, 9);
        turned(&a, &b, way & 1, way & 2);
        CHECK(frame_filter(&a, &params, 2, NULL) == RF_OK);
        CHECK(frame_filter(&b, &params, 2, NULL) == RF_OK);
        double db = agreement(&a, &b, way & 1, way & 2);
        if (!testing_check(db >= want_db, __FILE__, __LINE__, "mirrored"))
            printf("#     method %d, k %d, way %d: %.1f dB\n", method, sub_apertures,
                   way, db);
        frame_free(&a);
        frame_free(&b);
    }
}

static void mirrored_input_gives_a_mirrored_picture(void)
{
    check_mirror(RF_METHOD_SCATTER, 1, 100);
    check_mirror(RF_METHOD_LAYERED, 1, 60);
    /* The cells of the lens are no mirror images of each other. */
    check_mirror(RF_METHOD_LAYERED, 4, 35);
}

/* A bar before the focus: its left and right rims are mirror images, bit by bit or so.
 * Its place is tried at every phase, since blocks of pixels share some work.
 */
static void rims_are_alike_on_all_sides(void)
{
    for (int phase = 0; phase < 8; phase++)
        for (int upright = 0; upright < 2; upright++) {
            struct frame f = frame_make(96, 96, 3);
            struct rf_params params;
            scene_params(&params, RF_METHOD_LAYERED);
            params.sub_apertures = 1;
            int from = 25 + phase, to = 64 + 2 * phase;
            for (int y = 0; y < 96; y++)
                for (int x = 0; x < 96; x++) {
                    int t = upright ? x : y;
                    bool is_bar = t >= from && t < to;
                    for (int c = 0; c < 3; c++)
                        frame_at(&f, f.colour, x, y)[c] = is_bar ? 0.75f : 0.25f;
                    f.depth[y * 96 + x] = plain_depth(is_bar ? -3 : 0);
                }
            REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
            for (int i = -8; i < 8; i++) {
                int a = from + i, b = to - 1 - i;
                float *left =
                    upright ? frame_at(&f, f.out, a, 48) : frame_at(&f, f.out, 48, a);
                float *right =
                    upright ? frame_at(&f, f.out, b, 48) : frame_at(&f, f.out, 48, b);
                CHECK_NEAR(*left, *right, 2e-4);
            }
            frame_free(&f);
        }
}

/*
 * Where a ball rests on the ground its surface turns away within a few pixels, and the
 * ground comes back. Both are dark, and nothing of what lies far behind the ground's
 * edge and is bright shines through; these radii let 15 % through.
 */
static void a_fold_near_the_focus_has_no_holes(void)
{
    static const double fold[] = {-0.25, -0.17, -0.02, 0.09, 0.36,
                                  0.88,  0.69,  0.41,  0.18, -0.11};
    enum { FROM = 20, N_FOLD = sizeof fold / sizeof *fold, EDGE = 50 };
    struct rf_params params;
    struct frame f = frame_make(48, 70, 3);
    plain_params(&params, RF_METHOD_LAYERED);
    for (int y = 0; y < f.height; y++)
        for (int x = 0; x < f.width; x++) {
            bool is_fold = y >= FROM && y < FROM + N_FOLD;
            double r = is_fold ? fold[y - FROM] : y < FROM ? -0.3 : -0.35;
            for (int c = 0; c < 3; c++)
                frame_at(&f, f.colour, x, y)[c] = y < EDGE ? 0.1f : 0.9f;
            f.depth[y * f.width + x] = plain_depth(y < EDGE ? r : 49);
        }
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (int y = FROM - 5; y < FROM + N_FOLD + 5; y++)
        CHECK_NEAR(frame_at(&f, f.out, 24, y)[1], 0.1, 0.002);
    frame_free(&f);
}

/*
 * What a wire shows at a place: nothing beside it, and from one rim to the other it is
 * shaded from light to dark. Its width is 3.4 px, its slope 0.2.
 */
static bool is_on_wire(double x, double y, double *shade)
{
    double across = (y - 40 - 0.2 * (x - 60)) / 1.7;
    *shade = 0.34 - 0.3 * across;
    return fabs(across) < 1;
}

/*
 * A shaded grey wire, blurred by 30 px, crosses an even orange wall in focus: it takes a
 * little of the light of all that is near it, and leaves no lines along its rims.
 */
static void a_shaded_wire_leaves_no_lines(void)
{
    enum { PARTS = 8, NEAR_PX = 6 };
    static const float wall[] = {0.5f, 0.3f, 0.1f};
    struct rf_params params;
    struct frame f = frame_make(120, 80, 3);
    plain_params(&params, RF_METHOD_LAYERED);
    for (int y = 0; y < f.height; y++)
        for (int x = 0; x < f.width; x++) {
            double shade;
            for (int part = 0; part < PARTS * PARTS; part++) {
                double at_x = x + (part % PARTS + 0.5) / PARTS;
                double at_y = y + (part / PARTS + 0.5) / PARTS;
                bool is_wire = is_on_wire(at_x, at_y, &shade);
                for (int n = 0; n < 3; n++)
                    frame_at(&f, f.colour, x, y)[n] +=
                        (is_wire ? (float)shade : wall[n]) / (PARTS * PARTS);
            }
            bool is_wire = is_on_wire(x + 0.5, y + 0.5, &shade);
            f.depth[y * f.width + x] = is_wire ? plain_depth(-30) : PLAIN_FOCUS;
        }
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    double squares = 0, n_samples = 0;
    for (int x = 35; x < 85; x++) {
        int middle = (int)(40 + 0.2 * (x + 0.5 - 60));
        for (int n = 0; n < 3; n++) {
            float beside = frame_at(&f, f.out, x, middle - NEAR_PX)[n];
            for (int y = middle - NEAR_PX; y < middle + NEAR_PX; y++, n_samples++)
                squares += pow(frame_at(&f, f.out, x, y)[n] - beside, 2);
        }
    }
    printf("# off by %g\n", sqrt(squares / n_samples));
    CHECK(squares < 0.02 * 0.02 * n_samples);
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rf_method_list(&n_methods);
    TEST(in_focus_is_bit_for_bit);
    TEST(in_focus_glows_with_spherical_aberration);
    TEST(a_pinhole_gives_the_input);
    TEST(constant_stays_constant_at_any_depth);
    TEST(constant_walls_beyond_the_first_level);
    TEST(rims_are_alike_on_all_sides);
    TEST(a_fold_near_the_focus_has_no_holes);
    TEST(a_shaded_wire_leaves_no_lines);
    TEST(mirrored_input_gives_a_mirrored_picture);
    return testing_end();
}
