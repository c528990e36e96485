/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The blends and leak control against their formulas, with the generators of models.h.
 * R, S, region and slope are given, so that no default of the core comes in.
 */
#include "models.h"
#include "physics/failing_memory.h"

enum { W = 30, H = 23, N = W * H };

static void blend_params(struct rf_params *p, int method, int blend, int leak, bool out)
{
    plain_params(p, method);
    p->blend = blend;
    p->leak_control = leak;
    p->leave_focus_out = out;
    p->leak_weight = 0.3;
    p->blur_radius = 5;
    p->region_size = 0.5;
    p->region_slope = 0.7;
    p->slices = 2;
}

/* One blurred copy, mixed into base by its alpha: see core/methods/leak.c. */
static void model_layer(const struct plane *in, const double *radius,
                        const double *alpha, const struct rf_params *p,
                        struct plane *base)
{
    struct plane weighted = plane_make(W, H), mask = plane_make(W, H);
    struct plane blurred = plane_make(W, H), a = plane_make(W, H);
    for (int i = 0; i < N; i++) {
        mask.at[i] = alpha[i];
        weighted.at[i] = in->at[i] * (p->leave_focus_out ? alpha[i] : 1);
    }
    model_generate(&weighted, radius, p, &blurred);
    model_generate(&mask, radius, p, &a);
    for (int i = 0; i < N; i++) {
        int x = i % W, y = i / W, d = (int)floor(fabs(radius[i]) / 2 + 0.5);
        double b = blurred.at[i], w = alpha[i], u = p->leak_weight;
        double four[4] = {pixel(&a, x - d, y - d), pixel(&a, x + d, y - d),
                          pixel(&a, x - d, y + d), pixel(&a, x + d, y + d)};
        if (p->leave_focus_out)
            b = a.at[i] > 1e-3 ? b / a.at[i] : in->at[i];
        if (p->leak_control == RF_LEAK_HINT)
            w = a.at[i];
        if (p->leak_control == RF_LEAK_PRODUCT)
            w = (1 - u) * (four[0] + four[1] + four[2] + four[3]) / 4 +
                u * four[0] * four[1] * four[2] * four[3];
        base->at[i] += w * (b - base->at[i]);
    }
    plane_free(&weighted);
    plane_free(&mask);
    plane_free(&blurred);
    plane_free(&a);
}

static void model_region(const struct plane *in, const struct frame *f,
                         const struct rf_params *p, struct plane *out)
{
    double alpha[N], radius[N];
    for (int i = 0; i < N; i++) {
        double off = fabs(f->depth[i] - p->focus_distance) - p->region_size;
        alpha[i] = fmin(fmax(p->region_slope * off, 0), 1);
        radius[i] = p->blur_radius;
    }
    model_layer(in, radius, alpha, p, out);
}

static void model_slices(const struct plane *in, const double *r,
                         const struct rf_params *p, struct plane *out)
{
    double step = p->blur_radius / p->slices, alpha[N], radius[N];
    for (int s = p->slices; s >= -p->slices; s--) {
        for (int i = 0; i < N; i++) {
            double from = s == -p->slices ? -INFINITY : (s - 0.5) * step;
            double to = s == p->slices ? INFINITY : (s + 0.5) * step;
            alpha[i] = r[i] >= from && r[i] < to;
            radius[i] = fabs(s * step);
            if (s == 0 && alpha[i] > 0)
                out->at[i] = in->at[i];
        }
        if (s != 0)
            model_layer(in, radius, alpha, p, out);
    }
}

static void model_coc(const struct plane *in, const double *r,
                      const struct rf_params *p, struct plane *out)
{
    double alpha[N];
    if (p->leak_control == RF_LEAK_NONE && !p->leave_focus_out) {
        model_generate(in, r, p, out);
        return;
    }
    for (int i = 0; i < N; i++)
        alpha[i] = fmin(1, fabs(r[i]));
    model_layer(in, r, alpha, p, out);
}

/* Things at three depths with straight edges, so that no pixel lies on a threshold. */
static struct frame scene(void)
{
    struct frame f = frame_make(W, H, 3);
    uint32_t seed = 4;
    for (int i = 0; i < N; i++) {
        int x = i % W, y = i / W;
        double r = x < 9 ? -4.1 : x < 20 ? 0.03 * (y - 11.3) : 0.9 + y * 0.21;
        f.depth[i] = plain_depth(r);
        for (int c = 0; c < 3; c++)
            f.colour[3 * i + c] = (float)random_unit(&seed);
    }
    return f;
}

static void compare(const struct rf_params *p)
{
    struct frame f = scene();
    double *radius = radii_of(&f, p), worst = 0;
    CHECK(frame_filter(&f, p, 2, NULL) == RF_OK);
    for (int c = 0; c < 3; c++) {
        struct plane in = plane_of(&f, c), want = plane_of(&f, c);
        if (p->blend == RF_BLEND_COC)
            model_coc(&in, radius, p, &want);
        else if (p->blend == RF_BLEND_REGION)
            model_region(&in, &f, p, &want);
        else
            model_slices(&in, radius, p, &want);
        for (int i = 0; i < N; i++)
            worst = fmax(worst, fabs(f.out[3 * i + c] - want.at[i]));
        plane_free(&in);
        plane_free(&want);
    }
    if (!testing_check(worst <= 2e-4, __FILE__, __LINE__, "formula"))
        printf("#     method %d, blend %d, leak %d, out %d: off by %g\n", p->method,
               p->blend, p->leak_control, p->leave_focus_out, worst);
    free(radius);
    frame_free(&f);
}

static void every_combination_is_its_formula(void)
{
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++)
        for (int blend = 0; blend <= RF_BLEND_SLICES; blend++)
            for (int leak = 0; leak <= RF_LEAK_HINT; leak++)
                for (int out = 0; out < 2; out++) {
                    struct rf_params p;
                    blend_params(&p, m, blend, leak, out);
                    compare(&p);
                }
}

/* With the defaults the region is the depth of field and R the radius at infinity. */
static void the_defaults_come_from_the_lens(void)
{
    struct rf_params p, given;
    struct frame a = scene(), b = scene();
    blend_params(&p, RF_METHOD_BOX, RF_BLEND_REGION, 0, false);
    p.blur_radius = p.region_size = p.region_slope = 0;
    p.max_radius = 6; /* below the 400 px at infinity */
    given = p;
    given.blur_radius = 6;
    given.region_slope = 0.01;
    CHECK(frame_filter(&a, &p, 2, NULL) == RF_OK);
    CHECK(frame_filter(&b, &given, 2, NULL) == RF_OK);
    double worst = 0;
    for (int i = 0; i < 3 * N; i++)
        worst = fmax(worst, fabs(a.out[i] - b.out[i]));
    CHECK_NEAR(worst, 0, 1e-6);
    for (int i = 0; i < N; i++)
        if (i % W >= 9 && i % W < 20)
            CHECK(memcmp(a.out + 3 * i, a.colour + 3 * i, 12) == 0);
    frame_free(&a);
    frame_free(&b);
}

static void same_bits_for_any_number_of_threads(void)
{
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++)
        for (int blend = 0; blend <= RF_BLEND_SLICES; blend++)
            for (int leak = 0; leak <= RF_LEAK_HINT; leak++) {
                struct rf_params p;
                struct frame f = scene();
                blend_params(&p, m, blend, leak, leak > 0);
                CHECK(frame_filter(&f, &p, 1, NULL) == RF_OK);
                uint64_t one = hash_bytes(0, f.out, frame_bytes(&f));
                CHECK(frame_filter(&f, &p, 5, NULL) == RF_OK);
                CHECK(hash_bytes(0, f.out, frame_bytes(&f)) == one);
                frame_free(&f);
            }
}

/* ---- memory -------------------------------------------------------------------- */

static rf_result run(struct frame *f, const struct rf_params *p, struct memory *memory)
{
    struct rf_context_params how = memory_context(memory);
    return frame_filter_by(f, p, &how, NULL);
}

static void every_allocation_may_fail(void)
{
    for (int m = RF_METHOD_BOX; m <= RF_METHOD_RECURSIVE_OFFSET; m++)
        for (int blend = 0; blend <= RF_BLEND_SLICES; blend++) {
            struct memory memory = {.lock = PTHREAD_MUTEX_INITIALIZER};
            struct frame f = scene();
            struct rf_params p;
            blend_params(&p, m, blend, RF_LEAK_PRODUCT, true);
            p.box_repeats = 2;
            REQUIRE(run(&f, &p, &memory) == RF_OK);
            int n = memory.n_requests;
            CHECK(memory.n_live == 0 && n > 6);
            for (int k = 1; k <= n; k++) {
                memory.n_requests = 0;
                memory.fails_from = k;
                CHECK(run(&f, &p, &memory) == RF_ERROR_MEMORY);
                CHECK(memory.n_live == 0);
            }
            frame_free(&f);
        }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_combination_is_its_formula);
    TEST(the_defaults_come_from_the_lens);
    TEST(same_bits_for_any_number_of_threads);
    TEST(every_allocation_may_fail);
    return testing_end();
}
