/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Yu's uniform distribution word for word: every pixel whose offset satisfies
 * hypot(row, col) < radius receives colour / (number of such pixels); the pixel itself
 * always does. Pixels outside the picture count, and their light is lost. Alpha, which Yu
 * has not, ends at 1, or at the pixel's own.
 */
#include "physics/frames.h"
#include "testing.h"

static int count_of(double radius)
{
    int reach = (int)ceil(radius), n = 0;
    for (int row = -reach; row <= reach; row++)
        for (int col = -reach; col <= reach; col++)
            n += hypot(row, col) < radius || (row == 0 && col == 0);
    return n;
}

static void model(const struct frame *f, const float *radius, double *out)
{
    memset(out, 0, frame_pixels(f) * (size_t)f->channels * sizeof *out);
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            double r = fabs((double)radius[y * f->width + x]);
            int reach = (int)ceil(r), n = count_of(r);
            for (int row = -reach; row <= reach; row++)
                for (int col = -reach; col <= reach; col++) {
                    int qx = x + col, qy = y + row;
                    if (!(hypot(row, col) < r || (row == 0 && col == 0)) || qx < 0 ||
                        qy < 0 || qx >= f->width || qy >= f->height)
                        continue;
                    for (int c = 0; c < f->channels; c++)
                        out[(qy * f->width + qx) * f->channels + c] +=
                            (double)frame_at(f, f->colour, x, y)[c] / n;
                }
        }
    for (size_t i = 3; f->channels == 4 && i < 4 * frame_pixels(f); i += 4)
        out[i] = fmin(out[i], fmax(f->colour[i], 1));
}

static void coc(const struct frame *f, const struct rf_params *params, float *radius)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_image in = rf_image_packed(f->depth, f->width, f->height, 1);
    struct rf_image out = rf_image_packed(radius, f->width, f->height, 1);
    CHECK(rf_context_create(&context, NULL, NULL) == RF_OK);
    CHECK(rf_filter_create(&filter, context, params, f->width, f->height, NULL) ==
          RF_OK);
    CHECK(rf_filter_coc(filter, &in, &out, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

static void compare(int width, int height, int channels, double r_px, double light)
{
    struct frame f = frame_make(width, height, channels);
    size_t n = frame_pixels(&f) * (size_t)channels;
    float *radius = calloc(frame_pixels(&f), sizeof *radius);
    double *want = calloc(n, sizeof *want), worst = 0;
    uint32_t seed = (uint32_t)(width * 31 + channels);
    struct rf_params params;
    plain_params(&params, RF_METHOD_SCATTER);
    for (size_t i = 0; i < n; i++)
        f.colour[i] = (float)(random_unit(&seed) * (i % 97 ? 1 : light));
    for (size_t i = 0; i < frame_pixels(&f); i++)
        f.depth[i] = plain_depth((random_unit(&seed) * 2 - 1) * r_px);
    coc(&f, &params, radius);
    model(&f, radius, want);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    for (size_t i = 0; i < n; i++)
        worst = fmax(worst, fabs(f.out[i] - want[i]) / (1 + fabs(want[i])));
    CHECK_NEAR(worst, 0, 1e-5);
    free(radius);
    free(want);
    frame_free(&f);
}

static void random_pictures(void)
{
    compare(64, 48, 3, 0.9, 1);
    compare(64, 48, 4, 3, 1);
    compare(48, 64, 1, 12, 1);
    compare(37, 41, 3, 40, 1);
    compare(1, 50, 3, 9, 1);
    compare(50, 1, 3, 9, 1);
}

/* The differences of the fast code leave no trace of a lamp beside its circle. */
static void highlights(void)
{
    compare(64, 48, 3, 5, 1e4);
    compare(64, 48, 4, 15, 1e6);
}

/* Radii on the edge of taking one more pixel in: sqrt(row^2 + col^2) and beside it. */
static void radii_at_the_thresholds(void)
{
    enum { SIZE = 33 };
    for (int row = 0; row <= 8; row++)
        for (int col = row; col <= 8; col++)
            for (int side = -1; side <= 1; side++) {
                struct frame f = frame_make(SIZE, SIZE, 1);
                float radius[SIZE * SIZE];
                double want[SIZE * SIZE], worst = 0, sum = 0;
                struct rf_params params;
                plain_params(&params, RF_METHOD_SCATTER);
                float r = sqrtf((float)(row * row + col * col));
                for (int i = 0; i < SIZE * SIZE; i++)
                    f.depth[i] = plain_depth(r * (1 + side * 1e-4));
                *frame_at(&f, f.colour, SIZE / 2, SIZE / 2) = 1;
                coc(&f, &params, radius);
                model(&f, radius, want);
                CHECK(frame_filter(&f, &params, 1, NULL) == RF_OK);
                for (int i = 0; i < SIZE * SIZE; i++) {
                    worst = fmax(worst, fabs(f.out[i] - want[i]));
                    sum += f.out[i];
                }
                CHECK_NEAR(worst, 0, 1e-7);
                if (r < 16)
                    CHECK_NEAR(sum, 1, 1e-6);
                frame_free(&f);
            }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(random_pictures);
    TEST(highlights);
    TEST(radii_at_the_thresholds);
    return testing_end();
}
