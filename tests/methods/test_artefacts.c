/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What docs/methods.md says about the artefacts of each technique, in numbers: each is
 * there, and its remedy works.
 */
#include "physics/frames.h"
#include "testing.h"

enum { SIZE = 96 };

/* A white square in focus before a black ground at radius r_px. */
static struct frame sharp_square(double r_px)
{
    struct frame f = frame_make(SIZE, SIZE, 1);
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            bool is_square = abs(x - SIZE / 2) < 12 && abs(y - SIZE / 2) < 12;
            f.depth[y * SIZE + x] = is_square ? PLAIN_FOCUS : plain_depth(r_px);
            f.colour[y * SIZE + x] = is_square;
        }
    return f;
}

/* Light of the square on the ground, per pixel of its outline: should be none. */
static double leak(const struct frame *f)
{
    double sum = 0;
    for (int i = 0; i < SIZE * SIZE; i++)
        if (f->depth[i] != PLAIN_FOCUS)
            sum += f->out[i];
    return sum / (4 * 23);
}

static double leak_of(int method, int blend, int control, bool is_left_out)
{
    struct rf_params p;
    plain_params(&p, method);
    p.blend = blend;
    p.blur_radius = 12;
    p.region_size = 0.1;
    p.region_slope = 10;
    p.leak_control = control;
    p.leave_focus_out = is_left_out;
    struct frame f = sharp_square(12);
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    double value = leak(&f);
    frame_free(&f);
    return value;
}

static void colour_leaks_and_leak_control_helps(void)
{
    const struct rf_method_info *methods = rf_method_list(NULL);
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++)
        for (int blend = 0; blend <= RF_BLEND_SLICES; blend++) {
            double none = leak_of(m, blend, RF_LEAK_NONE, false);
            double hint = leak_of(m, blend, RF_LEAK_HINT, false);
            double product = leak_of(m, blend, RF_LEAK_PRODUCT, false);
            double left_out = leak_of(m, blend, RF_LEAK_NONE, true);
            printf("# %s, blend %d: leak %.3f, hint %.3f, product %.3f, left out "
                   "%.3f\n",
                   methods[m].name, blend, none, hint, product, left_out);
            CHECK(none > 0.5);
            CHECK(hint < 0.8 * none);
            CHECK(product < 0.8 * none);
            CHECK_NEAR(left_out, 0, 0.01);
        }
}

/* Gathering: a blurred foreground ends at its outline, where scattering softens it. */
static void a_blurred_foreground_keeps_its_outline(void)
{
    for (int m = RF_METHOD_SCATTER; m <= RF_METHOD_RECURSIVE_OFFSET; m++) {
        struct rf_params p;
        struct frame f = sharp_square(12);
        plain_params(&p, m);
        for (int i = 0; i < SIZE * SIZE; i++)
            f.depth[i] = f.depth[i] == PLAIN_FOCUS ? plain_depth(-12) : PLAIN_FOCUS;
        CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
        double outside = *frame_at(&f, f.out, SIZE / 2 + 12, SIZE / 2);
        double inside = *frame_at(&f, f.out, SIZE / 2 + 11, SIZE / 2);
        printf("# method %d: %.3f inside, %.3f outside\n", m, inside, outside);
        if (m == RF_METHOD_SCATTER)
            CHECK(outside > 0.3);
        else
            CHECK(outside == 0 && inside > 0.2 && inside < 0.8);
        frame_free(&f);
    }
}

/* Local maxima of the picture of a lamp, of at least a quarter of the brightest. */
static int count_spots(const struct frame *f)
{
    float most = 0;
    int n = 0;
    for (int i = 0; i < SIZE * SIZE; i++)
        most = fmaxf(most, f->out[i]);
    for (int y = 1; y < SIZE - 1; y++)
        for (int x = 1; x < SIZE - 1; x++) {
            const float *p = f->out + y * SIZE + x;
            n += p[0] > most / 4 && p[0] >= p[-1] && p[0] > p[1] && p[0] >= p[-SIZE] &&
                 p[0] > p[SIZE];
        }
    return n;
}

static int spots(int method, int copies, int recursions)
{
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 1);
    plain_params(&p, method);
    p.copies = copies;
    p.recursions = recursions;
    for (int i = 0; i < SIZE * SIZE; i++)
        f.depth[i] = plain_depth(30);
    *frame_at(&f, f.colour, SIZE / 2, SIZE / 2) = 1;
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    int n = count_spots(&f);
    frame_free(&f);
    return n;
}

static void separate_copies_show_at_large_radii(void)
{
    CHECK(spots(RF_METHOD_OFFSET, 4, 1) == 4);
    CHECK(spots(RF_METHOD_OFFSET, 16, 1) == 16);
    CHECK(spots(RF_METHOD_RECURSIVE_OFFSET, 4, 1) == 4);
    CHECK(spots(RF_METHOD_RECURSIVE_OFFSET, 4, 2) > 4);
}

static struct frame moving_lamp(int method, int place)
{
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 1);
    plain_params(&p, method);
    for (int i = 0; i < SIZE * SIZE; i++)
        f.depth[i] = plain_depth(8);
    *frame_at(&f, f.colour, SIZE / 2 + place, SIZE / 2) = 1;
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    return f;
}

/* How much the picture of a lamp changes when it moves on, pixel by pixel: the largest
 * difference to where it began, in parts of its brightest pixel. */
static double creep(int method)
{
    struct frame first = moving_lamp(method, 0);
    double most = 0, change = 0;
    for (int place = 1; place < 16; place++) {
        struct frame f = moving_lamp(method, place);
        for (int i = 0; i < SIZE * SIZE - place; i++) {
            most = fmax(most, first.out[i]);
            change = fmax(change, fabs(f.out[i + place] - first.out[i]));
        }
        frame_free(&f);
    }
    frame_free(&first);
    return change / most;
}

/* From the worst to the best, as the thesis has it. */
static void small_pictures_creep(void)
{
    double lowres = creep(RF_METHOD_LOWRES), mipmap = creep(RF_METHOD_MIPMAP);
    double offset = creep(RF_METHOD_MIPMAP_OFFSET);
    double recursive = creep(RF_METHOD_RECURSIVE_OFFSET);
    printf("# change of a moving lamp: lowres %.3f, mipmap %.3f, mipmap-offset %.3f, "
           "recursive-offset %.3f\n",
           lowres, mipmap, offset, recursive);
    CHECK(lowres > 0.2 && mipmap > 0.05);
    CHECK(offset < mipmap && mipmap <= lowres);
    CHECK_NEAR(recursive, 0, 1e-6);
    CHECK_NEAR(creep(RF_METHOD_BOX), 0, 1e-6);
}

/* The largest step between neighbours on a ramp of depth that is white all over but for
 * a fine check, which each strength of blur makes grey in its own way. */
static double border(int n_slices)
{
    double most = 0;
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 1);
    plain_params(&p, RF_METHOD_BOX);
    p.blend = RF_BLEND_SLICES;
    p.slices = n_slices;
    p.blur_radius = 8;
    for (int i = 0; i < SIZE * SIZE; i++) {
        f.depth[i] = plain_depth(8.0 * (i % SIZE) / SIZE);
        f.colour[i] = i / SIZE / 4 % 2;
    }
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    for (int i = SIZE * SIZE / 2; i < SIZE * SIZE / 2 + SIZE - 1; i++)
        most = fmax(most, fabs(f.out[i + 1] - f.out[i]));
    frame_free(&f);
    return most;
}

static void slices_show_their_borders(void)
{
    printf("# largest step: 1 slice %.3f, 4 slices %.3f, 16 slices %.3f\n", border(1),
           border(4), border(16));
    CHECK(border(1) > 0.3);
    CHECK(border(16) < 0.5 * border(1));
}

/* Region mixes: half way up its ramp a lamp is both a point and a blur. */
static void region_shows_the_sharp_picture_through_the_blur(void)
{
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 1);
    plain_params(&p, RF_METHOD_BOX);
    p.blend = RF_BLEND_REGION;
    p.blur_radius = 9;
    p.region_size = 1;
    p.region_slope = 0.1;
    for (int i = 0; i < SIZE * SIZE; i++)
        f.depth[i] = PLAIN_FOCUS + 1 + 5;
    *frame_at(&f, f.colour, SIZE / 2, SIZE / 2) = 1;
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    CHECK_NEAR(*frame_at(&f, f.out, SIZE / 2, SIZE / 2), 0.5, 0.01);
    CHECK(*frame_at(&f, f.out, SIZE / 2 + 6, SIZE / 2) > 0);
    frame_free(&f);
}

/* Light of a bright ground at radius 12 px on a black square in focus before it, at one
 * pixel within its edge: should be none. */
static double light_on_square(int method)
{
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 1);
    plain_params(&p, method);
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            bool is_square =
                x >= SIZE / 4 && x < 3 * SIZE / 4 && y >= SIZE / 4 && y < 3 * SIZE / 4;
            f.depth[y * SIZE + x] = is_square ? PLAIN_FOCUS : plain_depth(12);
            f.colour[y * SIZE + x] = is_square ? 0 : 1;
        }
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    double light = *frame_at(&f, f.out, SIZE / 4 + 1, SIZE / 2);
    frame_free(&f);
    return light;
}

/* Scatter knows no occlusion. */
static void scatter_runs_over_what_is_sharp_before_it(void)
{
    double scatter = light_on_square(RF_METHOD_SCATTER);
    double layered = light_on_square(RF_METHOD_LAYERED);
    printf("# light on the square: scatter %.3f, layered %.3f\n", scatter, layered);
    CHECK(scatter > 0.3);
    CHECK(layered < 0.02);
}

/* Scatter: nothing comes in over the border, which darkens. */
static void scatter_darkens_the_border(void)
{
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 1);
    plain_params(&p, RF_METHOD_SCATTER);
    for (int i = 0; i < SIZE * SIZE; i++) {
        f.depth[i] = plain_depth(10);
        f.colour[i] = 1;
    }
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    CHECK_NEAR(*frame_at(&f, f.out, 0, SIZE / 2), 0.5, 0.05);
    CHECK_NEAR(*frame_at(&f, f.out, SIZE / 2, SIZE / 2), 1, 1e-5);
    frame_free(&f);
}

/* Least light of a white wall in focus behind two black wires that cross. */
static float darkest_behind_wires(bool is_filled)
{
    struct rf_params p;
    struct frame f = frame_make(SIZE, SIZE, 3);
    plain_params(&p, RF_METHOD_LAYERED);
    p.fill_hidden = is_filled;
    for (int y = 0; y < SIZE; y++)
        for (int x = 0; x < SIZE; x++) {
            bool is_near = abs(x - y) < 2, is_far = abs(x - SIZE / 2) < 1;
            f.depth[y * SIZE + x] = plain_depth(is_near ? -9 : is_far ? -7 : 0);
            for (int c = 0; c < 3; c++)
                *(frame_at(&f, f.colour, x, y) + c) = !is_near && !is_far;
        }
    CHECK(frame_filter(&f, &p, 2, NULL) == RF_OK);
    float least = 1;
    for (int i = 0; i < SIZE * SIZE * 3; i++)
        least = fminf(least, f.out[i]);
    frame_free(&f);
    return least;
}

/* Behind the one lies the other, and the wall shows through both. */
static void crossing_wires_leave_no_dark_point(void)
{
    float least = darkest_behind_wires(true);
    printf("# least light behind crossing wires %.3f\n", (double)least);
    CHECK(least > 0.5f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(colour_leaks_and_leak_control_helps);
    TEST(a_blurred_foreground_keeps_its_outline);
    TEST(separate_copies_show_at_large_radii);
    TEST(small_pictures_creep);
    TEST(slices_show_their_borders);
    TEST(region_shows_the_sharp_picture_through_the_blur);
    TEST(scatter_darkens_the_border);
    TEST(scatter_runs_over_what_is_sharp_before_it);
    TEST(crossing_wires_leave_no_dark_point);
    return testing_end();
}
