/* SPDX-License-Identifier: Apache-2.0 */
/* The stages of the real-time family are those of which the result is made; a box along
 * one side of the picture. */
#include "models.h"
#include "physics/failing_memory.h"

enum { W = 30, H = 23, N = W * H };

static void stage_params(struct rf_params *p, int method, int blend)
{
    plain_params(p, method);
    p->blend = blend;
    p->blur_radius = 5;
    p->region_size = 0.5;
    p->region_slope = 3;
    p->slices = 2;
}

/* Something before the focus, a slope through it, something behind. */
static struct frame scene(void)
{
    struct frame f = frame_make(W, H, 3);
    uint32_t seed = 4;
    for (int i = 0; i < N; i++) {
        int x = i % W, y = i / W;
        f.depth[i] = plain_depth(x < 9    ? -4.1
                                 : x < 20 ? 0.03 * (y - 11.3)
                                          : 0.9 + y * 0.21);
        for (int c = 0; c < 3; c++)
            f.colour[3 * i + c] = (float)random_unit(&seed);
    }
    return f;
}

/* Filters the scene; the result belongs to the caller. */
static float *filtered(const struct rf_params *p)
{
    struct frame f = scene();
    float *out = malloc(sizeof(float) * 3 * N);
    if (!out || frame_filter(&f, p, 2, NULL) != RF_OK)
        abort();
    memcpy(out, f.out, sizeof(float) * 3 * N);
    frame_free(&f);
    return out;
}

/* out = c + w (B - c), with w the stage and B what a region without size gives. */
static void alpha_is_the_weight_of_the_blend(void)
{
    struct frame f = scene();
    for (int leak = 0; leak <= RF_LEAK_HINT; leak++) {
        struct rf_params p, all;
        stage_params(&p, RF_METHOD_BOX, RF_BLEND_REGION);
        p.leak_control = leak;
        all = p;
        all.leak_control = RF_LEAK_NONE;
        all.region_size = 1e-9;
        all.region_slope = 1e9;
        float *result = filtered(&p), *blurred = filtered(&all);
        p.stage = RF_STAGE_ALPHA;
        float *weight = filtered(&p);
        double worst = 0, least = 1, most = 0;
        for (int i = 0; i < 3 * N; i++) {
            double c = f.colour[i], w = weight[i];
            worst = fmax(worst, fabs(result[i] - (c + w * (blurred[i] - c))));
            least = fmin(least, w);
            most = fmax(most, w);
        }
        CHECK_NEAR(worst, 0, 1e-5);
        CHECK(least < 0.1 && most > 0.6 && most < 1.0001);
        free(result);
        free(blurred);
        free(weight);
    }
    frame_free(&f);
}

static void slices_have_colours(void)
{
    struct frame f = scene();
    struct rf_params p;
    stage_params(&p, RF_METHOD_MIPMAP, RF_BLEND_SLICES);
    p.stage = RF_STAGE_SLICES;
    float *out = filtered(&p);
    double *radius = radii_of(&f, &p), step = p.blur_radius / p.slices;
    int n_colours[3] = {0};
    for (int i = 0; i < N; i++) {
        const float *rgb = out + 3 * i;
        double slice = fmin(floor(fabs(radius[i]) / step + 0.5), p.slices);
        bool is_before = slice > 0 && radius[i]<0, is_behind = slice> 0 && !is_before;
        CHECK(is_before == (rgb[0] > rgb[2]) && is_behind == (rgb[2] > rgb[0]));
        double value = fmax(rgb[0], rgb[2]);
        CHECK_NEAR(value, slice > 0 ? 0.3 + 0.7 * slice / p.slices : 0, 1e-6);
        n_colours[is_before ? 0 : is_behind ? 1 : 2]++;
    }
    CHECK(n_colours[0] > 50 && n_colours[1] > 50 && n_colours[2] > 50);
    free(radius);
    free(out);
    frame_free(&f);
}

static void levels_are_those_that_are_sampled(void)
{
    struct frame f = scene();
    struct rf_params p;
    stage_params(&p, RF_METHOD_MIPMAP, RF_BLEND_COC);
    p.stage = RF_STAGE_LEVELS;
    float *out = filtered(&p);
    struct plane in = plane_of(&f, 1);
    double worst = 0;
    int left = 0, top = 0, n_samples = 0;
    for (int level = 1; level <= 5; level++) {
        struct plane want = level_of_detail(&in, level);
        for (int i = 0; i < want.width * want.height; i++, n_samples++) {
            int x = left + i % want.width, y = top + i / want.width;
            worst = fmax(worst, fabs(out[3 * (y * W + x) + 1] - want.at[i]));
        }
        top += level > 1 ? want.height : 0;
        left = level == 1 ? want.width : left;
        CHECK(level < 5 || (want.width == 1 && want.height == 1));
        plane_free(&want);
    }
    CHECK_NEAR(worst, 0, 1e-6);
    CHECK(n_samples == 15 * 12 + 8 * 6 + 4 * 3 + 2 * 2 + 1);
    CHECK(out[3 * (N - 1)] == 0); /* nothing lies there */
    plane_free(&in);
    free(out);
    frame_free(&f);
}

static void without_levels_there_is_none(void)
{
    struct rf_params p;
    struct rf_error error = {0};
    stage_params(&p, RF_METHOD_BOX, RF_BLEND_COC);
    p.stage = RF_STAGE_LEVELS;
    CHECK(rf_params_check(&p, &error) == RF_ERROR_PARAMETER);
    CHECK_STR(error.field, "stage");
    CHECK_CONTAINS(error.message, "mipmap-offset");
    p.method = RF_METHOD_LAYERED; /* reads no stage at all */
    CHECK(rf_params_check(&p, &error) == RF_OK);
}

/* ---- the box along one side -------------------------------------------------------- */

static void one_direction_is_its_formula(void)
{
    for (int direction = RF_DIRECTION_HORIZONTAL; direction <= RF_DIRECTION_VERTICAL;
         direction++)
        for (int repeats = 1; repeats <= 2; repeats++) {
            struct frame f = scene();
            struct rf_params p;
            stage_params(&p, RF_METHOD_BOX, RF_BLEND_COC);
            p.box_direction = direction;
            p.box_repeats = repeats;
            float *out = filtered(&p);
            double *radius = radii_of(&f, &p), worst = 0;
            struct plane from = plane_of(&f, 0), to = plane_make(W, H);
            bool is_row = direction == RF_DIRECTION_HORIZONTAL;
            for (int n = 0; n < repeats; n++) {
                for (int i = 0; i < N; i++)
                    to.at[i] = line_mean(from.at + (is_row ? i / W * W : i % W),
                                         is_row ? 1 : W, is_row ? W : H,
                                         (is_row ? i % W : i / W) + 0.5,
                                         box_size(radius[i], repeats));
                memcpy(from.at, to.at, sizeof(double) * N);
            }
            for (int i = 0; i < N; i++)
                worst = fmax(worst, fabs(out[3 * i] - from.at[i]));
            CHECK_NEAR(worst, 0, 1e-4);
            plane_free(&from);
            plane_free(&to);
            free(radius);
            free(out);
            frame_free(&f);
        }
}

static void every_allocation_may_fail(void)
{
    struct memory memory = {.lock = PTHREAD_MUTEX_INITIALIZER};
    struct rf_context_params how = memory_context(&memory);
    struct frame f = scene();
    struct rf_params p;
    stage_params(&p, RF_METHOD_MIPMAP_OFFSET, RF_BLEND_COC);
    p.stage = RF_STAGE_LEVELS;
    REQUIRE(frame_filter_by(&f, &p, &how, NULL) == RF_OK);
    int n = memory.n_requests;
    CHECK(memory.n_live == 0 && n > 6);
    for (int k = 1; k <= n; k++) {
        memory.n_requests = 0;
        memory.fails_from = k;
        CHECK(frame_filter_by(&f, &p, &how, NULL) == RF_ERROR_MEMORY);
        CHECK(memory.n_live == 0);
    }
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(alpha_is_the_weight_of_the_blend);
    TEST(slices_have_colours);
    TEST(levels_are_those_that_are_sampled);
    TEST(without_levels_there_is_none);
    TEST(one_direction_is_its_formula);
    TEST(every_allocation_may_fail);
    return testing_end();
}
