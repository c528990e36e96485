/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rf_param_is_read() against the truth: under every method and a list of settings each
 * parameter is given other values. Where it is said not to be read nothing may change,
 * not one bit: not the picture, nor what the lens says, nor the points of the lens.
 * Where it is said to be read something must change for one of the values, under each
 * method, in one of the settings at least.
 */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#include "portable.h"
#include "rackfocus/rackfocus.h"
#include "testing.h"

enum { WIDTH = 30, HEIGHT = 36, N = WIDTH * HEIGHT, N_POINTS = 9, MOST_PARAMS = 128 };

static const char *const setups[] = {
    "",
    "projection=orthographic ortho-scale=0.4",
    "projection=orthographic optics=yu lens-radius=0.1",
    "optics=yu",
    "optics=yu screen-position=0.0556 aperture-coefficient=11",
    "optics=lens lens-radius=0.1 focal-length-px=50",
    "lens-radius=0.1 focal-length-px=50",
    "lens-radius=0.1 focal-length-px=50 depth=radial shift-x=0.2",
    "sensor-fit=vertical depth=radial",
    "sensor-fit=horizontal",
    "depth=normalised depth-far=3",
    "depth=buffer optics=buffer",
    "depth=buffer-reversed-infinite",
    "blades=5",
    "aperture=disc blades=5",
    "blend=region",
    "box-direction=horizontal sensor-fit=horizontal",
    "blend=slices leak-control=product",
    "blend=region leak-control=hint leave-focus-out=true",
    "quality=preview",
    "lens-pattern=circle blades=5",
    "lens-pattern=disc blades=5",
    "lens-pattern=polygon blades=5 aperture=disc",
    "lens-pattern=grid",
    "lens-random=true",
    "cat-eye=0.7",
    "tilt-x=5 lens-radius=0.1 focal-length-px=50",
    "split-diopter=0.3",
    "highlight-gain=3",
    "stage=alpha highlight-gain=3",
    "stage=alpha leak-control=product blend=region",
    "stage=slices blend=slices leak-control=hint",
    "stage=levels blend=slices leave-focus-out=true",
};
enum { N_SETUPS = sizeof setups / sizeof *setups };

static const struct rf_param_info *rows;
static size_t n_rows;
static struct rf_context *context;

/* A texture, lamps, an object before it, a rim of film without depth; of each view. */
static float colour[2][N * 4], depth[2][N];

static void make_scene(void)
{
    for (int j = 0; j < 2; j++)
        for (int y = 0; y < HEIGHT; y++)
            for (int x = 0; x < WIDTH; x++) {
                int i = y * WIDTH + x, u = x + 2 * j;
                bool is_near = u > 8 && u < 16 && y > 6 && y < 30;
                float v = is_near ? 0.2f + 0.05f * (float)(u % 3)
                                  : 0.5f + 0.3f * (float)((u / 4 + y / 4) % 2);
                float alpha = y < 3 ? 0.7f : 1;
                if (u == 20 && y % 9 == 4)
                    v = 40;
                for (int c = 0; c < 3; c++)
                    colour[j][4 * i + c] = v * alpha * (c == j ? 0.9f : 1);
                colour[j][4 * i + 3] = alpha;
                depth[j][i] = is_near ? 0.2f : 0.45f + 0.015f * (float)y;
                if (y < 3 || (u > 24 && y > 30)) /* nothing was hit, but for a spot */
                    depth[j][i] = y == 2 && u > 5 && u < 9 ? 0.3f : 0;
            }
}

static bool apply_settings(struct rf_params *p, const char *settings)
{
    char text[256], *rest = text;
    snprintf(text, sizeof text, "%s", settings);
    for (char *word; (word = strsep(&rest, " "));) {
        char *value = strchr(word, '=');
        if (!value)
            continue;
        *value++ = '\0';
        if (rf_params_set(p, word, value, NULL) != RF_OK)
            return false;
    }
    return true;
}

static void base_params(struct rf_params *p, int method)
{
    rf_params_init(p);
    p->focus_distance = 0.5;
    p->f_stop = 0.25;
    p->method = method;
    p->lens_seed = 3;
}

/* ---- what comes out -------------------------------------------------------------- */

struct output {
    float picture[N * 4];
    double lens[6];
    struct rf_lens_point points[2 * N_POINTS];
};

static bool process(const struct rf_params *p, struct rf_filter *filter,
                    struct output *out)
{
    int n_views = rf_method_list(NULL)[p->method].max_views > 1 ? 2 : 1;
    struct rf_view views[2];
    struct rf_image to = rf_image_packed(out->picture, WIDTH, HEIGHT, 4);
    for (int j = 0; j < 2; j++)
        views[j] = (struct rf_view){
            .colour = rf_image_packed(colour[j], WIDTH, HEIGHT, 4),
            .depth = rf_image_packed(depth[j], WIDTH, HEIGHT, 1),
            .lens_offset = {n_views == 2 ? 0.03 * (2 * j - 1) : 0, 0},
            .shear_distance = 0.5,
        };
    return rf_filter_process(filter, views, n_views, &to, NULL, NULL) == RF_OK;
}

/* False: these parameters cannot be. */
static bool find_output(const struct rf_params *p, struct output *out)
{
    memset(out, 0, sizeof *out);
    struct rf_filter *filter;
    if (rf_filter_create(&filter, context, p, WIDTH, HEIGHT, NULL) != RF_OK)
        return false;
    const struct rf_lens *lens = rf_filter_lens(filter);
    rf_lens_depth_of_field(lens, &out->lens[0], &out->lens[1]);
    out->lens[2] = rf_lens_hyperfocal(lens);
    out->lens[3] = lens->lens_radius;
    out->lens[4] = lens->focus_distance;
    bool is_good = process(p, filter, out);
    rf_filter_destroy(filter);
    if (rf_method_list(NULL)[p->method].max_views > 1)
        for (int k = 0; k < 2 && is_good; k++)
            is_good = rf_lens_points(p, k ? 3 : N_POINTS, 4, out->points + k * N_POINTS,
                                     NULL) == RF_OK;
    return is_good;
}

/* ---- other values ---------------------------------------------------------------- */

/* The k-th other value of a parameter; NAN: there is none. */
static double other_value(const struct rf_param_info *info, double value, int k)
{
    if (info->type == RF_TYPE_BOOL || info->type == RF_TYPE_ENUM)
        return k > info->max ? NAN : k == value ? k + 1 : k;
    if (info->type == RF_TYPE_INT) {
        const double ints[] = {value + 1, value - 1, 2 * value, 5, 40};
        return k < 5 ? ints[k] : NAN;
    }
    const double zero[] = {0.3, 5, 60, 0.04}, others[] = {1.3, 0.5, 0.1};
    if (value == 0)
        return k < 4 ? zero[k] : NAN;
    return k < 3 ? value * others[k] : k == 3 ? 0.6 : NAN;
}

static double value_of(const struct rf_params *p, const struct rf_param_info *info)
{
    const char *member = (const char *)p + info->offset;
    return info->type == RF_TYPE_FLOAT ? *(const double *)member
                                       : *(const int32_t *)member;
}

/* Does the output change for any value? Stops at the first. */
static bool changes(const struct rf_params *before, const struct output *out,
                    const struct rf_param_info *info)
{
    static struct output other;
    double value = value_of(before, info);
    for (int k = 0; !isnan(other_value(info, value, k)); k++) {
        struct rf_params after = *before;
        if (rf_params_set_number(&after, info->key, other_value(info, value, k),
                                 NULL) == RF_OK &&
            find_output(&after, &other) && memcmp(&other, out, sizeof other) != 0)
            return true;
    }
    return false;
}

/* Does the output change where all of some parameters have another value, the first,
 * second and so on of each? Unsure where they cannot be together. */
static bool may_change_together(const struct rf_params *before,
                                const struct output *out, const bool is_one_of[])
{
    static struct output other;
    bool has_more = true;
    for (int k = 0; has_more; k++) {
        struct rf_params after = *before;
        has_more = false;
        for (size_t i = 0; i < n_rows; i++) {
            double value = is_one_of[i] ? value_of(before, &rows[i]) : NAN;
            double next = is_one_of[i] ? other_value(&rows[i], value, k) : NAN;
            has_more |= !isnan(next);
            if (!isnan(next))
                (void)rf_params_set_number(&after, rows[i].key, next, NULL);
        }
        if (has_more &&
            (!find_output(&after, &other) || memcmp(&other, out, sizeof other) != 0))
            return true;
    }
    return false;
}

/* ---- tests ----------------------------------------------------------------------- */

/* Is a parameter read under a method, as said and as seen? */
struct seen {
    bool is_said, has_changed;
};

static void check_setup(int method, const char *setup, struct seen seen[])
{
    static struct output out;
    bool is_unread[MOST_PARAMS];
    struct rf_params p;
    base_params(&p, method);
    REQUIRE(apply_settings(&p, setup));
    if (rf_params_check(&p, NULL) != RF_OK) /* levels of a method without them */
        return;
    REQUIRE(find_output(&p, &out));
    for (size_t i = 0; i < n_rows; i++)
        is_unread[i] = !rf_param_is_read(&p, rows[i].key, NULL);
    bool is_sure = !may_change_together(&p, &out, is_unread);
    for (size_t i = 0; i < n_rows; i++) {
        const char *why_not;
        bool is_read = rf_param_is_read(&p, rows[i].key, &why_not);
        CHECK(is_read == !why_not);
        seen[i].is_said |= is_read;
        if (is_read ? seen[i].has_changed : is_sure)
            continue; /* seen before */
        bool has_changed = changes(&p, &out, &rows[i]);
        if (!is_read && !testing_check(!has_changed, __FILE__, __LINE__, "not read"))
            printf("#     %s, method %s, \"%s\": %s\n", rows[i].key,
                   rf_method_list(NULL)[method].name, setup, why_not);
        seen[i].has_changed |= is_read && has_changed;
    }
}

static void what_is_read_changes_something_and_nothing_else_does(void)
{
    size_t n_methods;
    rf_method_list(&n_methods);
    REQUIRE(n_rows <= MOST_PARAMS);
    for (int m = 0; m < (int)n_methods; m++) {
        struct seen seen[MOST_PARAMS] = {{false, false}};
        for (int s = 0; s < N_SETUPS; s++)
            check_setup(m, setups[s], seen);
        for (size_t i = 0; i < n_rows; i++)
            if (!testing_check(seen[i].is_said == seen[i].has_changed, __FILE__,
                               __LINE__, "changes something"))
                printf("#     %s, method %s\n", rows[i].key,
                       rf_method_list(NULL)[m].name);
    }
}

/* What a stage has no use for, and what it has. */
static void stages_read_little(void)
{
    static const struct {
        enum rf_method method;
        const char *setup, *key;
        bool is_read;
    } rows_of_stages[] = {
        {RF_METHOD_BOX, "stage=alpha", "highlight-gain", false},
        {RF_METHOD_BOX, "stage=alpha", "highlight-clamp", false},
        {RF_METHOD_BOX, "stage=alpha highlight-gain=3", "highlight-threshold", false},
        {RF_METHOD_BOX, "stage=alpha", "box-repeats", false},
        {RF_METHOD_BOX, "stage=alpha leak-control=hint", "box-repeats", true},
        {RF_METHOD_BOX, "stage=alpha", "leave-focus-out", false},
        {RF_METHOD_BOX, "stage=alpha", "leak-control", true},
        {RF_METHOD_BOX, "stage=alpha blend=region", "blur-radius", false},
        {RF_METHOD_BOX, "stage=slices blend=slices", "blur-radius", true},
        {RF_METHOD_OFFSET, "stage=slices blend=slices", "blades", false},
        {RF_METHOD_OFFSET, "stage=slices leak-control=product", "blades", true},
        {RF_METHOD_LAYERED, "stage=alpha", "highlight-gain", true},
        {RF_METHOD_LAYERED, "stage=alpha", "stage", false},
        {RF_METHOD_MIPMAP, "stage=levels", "stage", true},
        {RF_METHOD_MIPMAP, "stage=levels", "highlight-gain", true},
        {RF_METHOD_MIPMAP, "stage=levels", "mipmap-bias", false},
        {RF_METHOD_MIPMAP, "stage=levels blend=slices", "slices", false},
        {RF_METHOD_MIPMAP, "stage=levels", "blend", false},
    };
    for (size_t i = 0; i < sizeof rows_of_stages / sizeof *rows_of_stages; i++) {
        struct rf_params p;
        base_params(&p, rows_of_stages[i].method);
        REQUIRE(apply_settings(&p, rows_of_stages[i].setup));
        const bool is_read = rf_param_is_read(&p, rows_of_stages[i].key, NULL);
        if (!testing_check(is_read == rows_of_stages[i].is_read, __FILE__, __LINE__,
                           "read"))
            printf("#     %s: %s\n", rows_of_stages[i].setup, rows_of_stages[i].key);
    }
}

static void reasons_say_what_to_set(void)
{
    struct rf_params p;
    const char *why_not = "";
    rf_params_init(&p);
    CHECK(!rf_param_is_read(&p, "ortho-scale", &why_not));
    CHECK_STR(why_not, "read only with projection orthographic");
    p.projection = RF_PROJECTION_ORTHOGRAPHIC;
    CHECK(rf_param_is_read(&p, "ortho_scale", &why_not) && !why_not);
    CHECK(!rf_param_is_read(&p, "leak-weight", NULL));
    CHECK(!rf_param_is_read(&p, "no such thing", &why_not));
    CHECK_STR(why_not, "there is no such parameter");
    CHECK(!rf_param_is_read(NULL, "f-stop", &why_not) && why_not);
    CHECK(!rf_param_is_read(&p, NULL, NULL));
    p.method = 1000;
    CHECK(!rf_param_is_read(&p, "f-stop", &why_not));
    CHECK_STR(why_not, "there is no such method");
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rows = rf_param_list(&n_rows);
    make_scene();
    struct rf_context_params own = {.size = sizeof own, .n_threads = 1};
    if (rf_context_create(&context, &own, NULL) != RF_OK)
        return 1;
    TEST(what_is_read_changes_something_and_nothing_else_does);
    TEST(stages_read_little);
    TEST(reasons_say_what_to_set);
    rf_context_destroy(context);
    return testing_end();
}
