/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One case per parameter, driven by rf_param_list(): a value that changes something,
 * and settings that are the same thing said in another way (its neutral value). A new
 * parameter without a case fails.
 */
#include <stdio.h>

#include "physics/frames.h"
#include "portable.h"
#include "testing.h"

/* What a parameter acts on. */
enum output { PICTURE, FILM, RADIUS, LIMITS, POINTS };

struct param_case {
    const char *key;
    enum output output;
    const char *setup;   /* "key=value key=value", before the parameter is touched */
    const char *changed; /* a value that must change the output */
    /* The output with `equal` is that with `equal_to`: settings, as in setup. */
    const char *equal, *equal_to;
    double tolerance; /* of that equality; 0: bit for bit */
};

/* `equal_to` "sharp": the input itself. */
#define SHARP "sharp"

static const struct param_case cases[] = {
    {"focus-distance", PICTURE, "", "6", "focus-distance=1e9 lens-radius=1e-9", SHARP,
     1e-4},
    {"f-stop", PICTURE, "", "1.4", "f-stop=1e6", SHARP, 1e-3},
    {"focal-length", PICTURE, "", "85", "focal-length=0.001", SHARP, 1e-4},
    {"sensor-width", PICTURE, "", "24", "sensor-width=1e6", SHARP, 1e-3},
    {"sensor-height", PICTURE, "sensor-fit=vertical", "36", "sensor-height=1e6", SHARP,
     1e-3},
    {"sensor-fit", PICTURE, "", "vertical", "sensor-fit=horizontal", "sensor-fit=auto",
     0},
    {"unit-scale", PICTURE, "", "2", "unit-scale=1e-9", SHARP, 1e-4},
    {"lens-radius", PICTURE, "", "0.3", "lens-radius=0", "lens-radius=0.25", 0},
    {"focal-length-px", PICTURE, "", "150", "focal-length-px=0", "focal-length-px=100",
     0},
    {"projection", PICTURE, "", "orthographic", "projection=perspective", "", 0},
    {"ortho-scale", PICTURE, "projection=orthographic", "4", "ortho-scale=1e9", SHARP,
     1e-3},
    {"shift-x", RADIUS, "depth=radial", "0.5", "depth=planar shift-x=0.5",
     "depth=planar", 0},
    {"shift-y", RADIUS, "depth=radial", "0.5", "depth=planar shift-y=0.5",
     "depth=planar", 0},
    {"pixel-aspect", PICTURE, "", "2", "pixel-aspect=1", "", 0},
    {"optics", PICTURE, "", "lens", "optics=yu", "optics=lens", 1e-5},
    {"screen-position", PICTURE, "optics=yu", "0.52", "screen-position=0",
     "screen-position=0.52631578947368418", 1e-5},
    {"aperture-coefficient", PICTURE, "optics=yu", "50", "aperture-coefficient=0",
     "aperture-coefficient=100", 1e-5},
    {"coc-limit", LIMITS, "", "2", "coc-limit=0.5", "", 0},
    {"aperture", PICTURE, "blades=5", "disc", "aperture=polygon", "aperture=auto", 0},
    {"blades", PICTURE, "", "5", "blades=0", "aperture=disc blades=7", 0},
    {"blade-rotation", PICTURE, "blades=3", "30", "blade-rotation=360",
     "blade-rotation=0", 2e-3},
    {"blade-curvature", PICTURE, "blades=5", "0.5", "blade-curvature=0", "", 0},
    {"blade-orientation", PICTURE, "blades=5", "povray",
     "blades=0 blade-orientation=povray", "blades=0", 0},
    {"aperture-ratio", PICTURE, "", "2", "aperture-ratio=1", "", 0},
    {"depth", RADIUS, "", "inverse", "depth=radial projection=orthographic",
     "depth=planar projection=orthographic", 0},
    {"depth-near", RADIUS, "depth=normalised depth-near=1", "2",
     "depth=planar depth-near=3", "depth=planar", 0},
    {"depth-far", RADIUS, "depth=normalised", "200", "depth=planar depth-far=7",
     "depth=planar", 0},
    {"depth-scale", RADIUS, "", "1.5", "depth-scale=1", "", 0},
    {"depth-offset", RADIUS, "", "2", "depth-offset=0", "", 0},
    {"depth-infinity", RADIUS, "", "12", "depth-infinity=1e8", "", 0},
    {"film-depth", FILM, "", "keep", "film-depth=edges", "", 0},
    {"method", PICTURE, "", "scatter", "method=layered", "", 0},
    {"max-radius", PICTURE, "", "1", "max-radius=16384", "max-radius=0", 0},
    {"sub-apertures", PICTURE, "", "1", "sub-apertures=4", "", 0},
    {"split-edges", PICTURE, "", "false", "split-edges=true", "", 0},
    {"fill-hidden", PICTURE, "", "false", "fill-hidden=true", "", 0},
    {"exact-highlights", PICTURE, "", "false", "exact-highlights=true", "", 0},
    {"distribution", PICTURE, "method=scatter", "gaussian", "distribution=uniform", "",
     0},
    {"blend-gamma", PICTURE, "", "2.2", "blend-gamma=1", "", 0},
    {"blend", PICTURE, "method=box", "region", "blend=coc", "", 0},
    {"blur-radius", PICTURE, "method=box blend=region", "7", "blur-radius=0",
     "blur-radius=2.5", 1e-5},
    {"box-repeats", PICTURE, "method=box", "3", "box-repeats=1", "", 0},
    {"lowres-factor", PICTURE, "method=lowres", "4", "lowres-factor=8", "", 0},
    {"mipmap-bias", PICTURE, "method=mipmap", "1", "mipmap-bias=0", "", 0},
    {"copies", PICTURE, "method=offset", "4", "copies=8", "", 0},
    {"recursions", PICTURE, "method=recursive-offset", "1", "recursions=3", "", 0},
    {"region-size", PICTURE, "method=box blend=region", "3", "region-size=1e9", SHARP,
     1e-6},
    {"region-slope", PICTURE, "method=box blend=region", "1", "region-slope=0",
     "region-slope=0.1", 1e-5},
    {"slices", PICTURE, "method=box blend=slices", "4", "slices=2", "", 0},
    {"leak-control", PICTURE, "method=box blend=region", "hint", "leak-control=none",
     "", 0},
    {"leak-weight", PICTURE, "method=box blend=region leak-control=product", "1",
     "leak-weight=0.5", "", 0},
    {"leave-focus-out", PICTURE, "method=box blend=region", "true",
     "leave-focus-out=false", "", 0},
    {"lens-pattern", POINTS, "", "circle", "lens-pattern=auto", "lens-pattern=disc", 0},
    {"lens-random", POINTS, "", "true", "lens-random=false", "", 0},
    {"lens-seed", POINTS, "lens-pattern=grid", "7", "lens-seed=7 lens-pattern=disc",
     "lens-pattern=disc", 0},
    {"quality", PICTURE, "", "preview", "quality=normal sub-apertures=2",
     "sub-apertures=2", 0},
    {"cat-eye", PICTURE, "", "0.8", "cat-eye=0", "", 0},
    {"cat-eye-exposure", PICTURE, "cat-eye=0.8", "keep", "cat-eye-exposure=fall", "",
     0},
    {"astigmatism", PICTURE, "", "0.5", "astigmatism=0", "", 0},
    {"swirl", PICTURE, "", "0.5", "swirl=0", "", 0},
    {"barn-left", PICTURE, "", "1", "barn-left=0", "", 0},
    {"barn-right", PICTURE, "", "1", "barn-right=0", "", 0},
    {"barn-top", PICTURE, "", "1.5", "barn-top=0", "", 0},
    {"barn-bottom", PICTURE, "", "1.5", "barn-bottom=0", "", 0},
    {"spherical", PICTURE, "", "1", "spherical=0", "", 0},
    {"axial-chroma", PICTURE, "", "1", "axial-chroma=0", "", 0},
    {"lateral-chroma", PICTURE, "", "0.02", "lateral-chroma=0", "", 0},
    {"obstruction", PICTURE, "", "0.6", "obstruction=0", "", 0},
    {"highlight-clamp", PICTURE, "", "0.3", "highlight-clamp=1e6", "", 0},
    {"highlight-threshold", PICTURE, "highlight-gain=3", "0.2",
     "highlight-threshold=0.5 highlight-gain=1", "highlight-gain=1", 0},
    {"highlight-gain", PICTURE, "highlight-threshold=0.2", "3", "highlight-gain=1",
     "highlight-threshold=0.2", 0},
    {"highlight-saturation", PICTURE, "highlight-threshold=0.2", "0",
     "highlight-saturation=1", "", 0},
    {"stage", PICTURE, "method=box blend=region", "alpha", "stage=result", "", 0},
    {"box-direction", PICTURE, "method=box", "horizontal", "box-direction=both", "", 0},
    {"white", PICTURE, "", "0.02", "white=1.2", "", 0},
    {"tilt-x", PICTURE, "", "10", "tilt-x=0", "", 0},
    {"tilt-y", PICTURE, "", "10", "tilt-y=0", "", 0},
    {"field-curvature", RADIUS, "", "0.1", "field-curvature=0", "", 0},
    {"split-diopter", PICTURE, "", "4", "split-diopter=10", "", 1e-5},
    {"split-angle", RADIUS, "split-diopter=4", "90", "split-angle=360", "", 1e-6},
    {"split-offset", RADIUS, "split-diopter=4", "0.3", "split-offset=0", "", 0},
    {"split-softness", RADIUS, "split-diopter=4", "1", "split-softness=0.1", "", 0},
};
enum { N_CASES = sizeof cases / sizeof cases[0] };

enum { WIDTH = 72, HEIGHT = 48, N = WIDTH * HEIGHT };

static const struct rf_param_info *rows;
static size_t n_rows;
static struct frame scene;

static const struct param_case *case_of(const char *key)
{
    for (int i = 0; i < N_CASES; i++)
        if (!strcmp(cases[i].key, key))
            return &cases[i];
    return NULL;
}

/*
 * The lens of all cases: 500 mm at f/1 in metres, so R = 0.25; f_px 100 comes from the
 * sensor. Radii up to about 9 px for depths 2 to 40, focus at 10.
 */
static void base_params(struct rf_params *p)
{
    rf_params_init(p);
    p->focal_length = 500;
    p->f_stop = 1;
    p->sensor_width = WIDTH * 5.0;
    p->sensor_height = WIDTH * 5.0;
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
        struct rf_error error;
        if (rf_params_set(p, word, value, &error) != RF_OK) {
            printf("# %s\n", error.message);
            return false;
        }
    }
    return true;
}

/*
 * Depth for every kind: planar numbers of 2 to 40 mean something as radial, inverse and
 * disparity too; kinds that want 0 to 1 get them.
 */
static void make_scene(void)
{
    scene = frame_make(WIDTH, HEIGHT, 3);
    frame_fill_scene(&scene, 1);
    for (int i = 0; i < N; i++) {
        double r = 400 - 40000 / (scene.depth[i] > 1e9 ? 100.3 : scene.depth[i]);
        scene.depth[i] = (float)(10 / (1 - r * 0.75)); /* -1..1 to 5.7 .. 40 */
    }
}

static void normalise_depth(const struct rf_params *p, float *depth)
{
    for (int i = 0; i < N; i++)
        depth[i] = p->depth >= RF_DEPTH_BUFFER && p->depth != RF_DEPTH_INVERSE
                       ? scene.depth[i] / 50
                       : scene.depth[i];
}

static rf_result list_points(const struct rf_params *p, float *out, int *n,
                             struct rf_error *error)
{
    struct rf_lens_point points[20];
    rf_result result = rf_lens_points(p, 20, 3, points, error);
    for (int i = 0; i < 20 && result == RF_OK; i++) {
        out[3 * i] = (float)points[i].u;
        out[3 * i + 1] = (float)points[i].v;
        out[3 * i + 2] = (float)points[i].time;
    }
    *n = 60;
    return result;
}

/*
 * A bar of alpha 0.3 and 0.7 at its rims before transparent film: the rims' depth is
 * missing.
 */
static bool filter_film(const struct rf_params *p, float *out, struct rf_error *error)
{
    struct frame f = frame_make(WIDTH / 2, HEIGHT, 4);
    static const float alphas[] = {0.3f, 0.7f, 1, 1, 0.7f, 0.3f};
    for (size_t i = 0; i < frame_pixels(&f); i++) {
        int x = (int)(i % (WIDTH / 2)) - 12;
        float alpha = x >= 0 && x < 6 ? alphas[x] : 0;
        for (int c = 0; c < 4; c++)
            f.colour[4 * i + (size_t)c] = alpha;
        f.depth[i] = alpha == 1 ? 10 : 1e10f;
    }
    rf_result result = frame_filter(&f, p, 2, error);
    memcpy(out, f.out, frame_bytes(&f));
    frame_free(&f);
    return result == RF_OK;
}

/* The output as floats; n receives their number. */
static bool output_of(enum output kind, const struct rf_params *p, float *out, int *n)
{
    struct rf_error error = {0};
    struct frame f = scene;
    float depth[N];
    normalise_depth(p, depth);
    f.depth = depth;
    f.out = out;
    if (kind == FILM) {
        *n = N * 2;
        if (filter_film(p, out, &error))
            return true;
    } else if (kind == PICTURE) {
        *n = N * 3;
        if (frame_filter(&f, p, 2, &error) == RF_OK)
            return true;
    } else if (kind == POINTS) {
        if (list_points(p, out, n, &error) == RF_OK)
            return true;
    } else {
        struct rf_context *context;
        struct rf_filter *filter;
        double limits[2];
        struct rf_image in = rf_image_packed(depth, WIDTH, HEIGHT, 1);
        struct rf_image to = rf_image_packed(out, WIDTH, HEIGHT, 1);
        if (rf_context_create(&context, NULL, &error) != RF_OK)
            return false;
        if (rf_filter_create(&filter, context, p, WIDTH, HEIGHT, &error) == RF_OK) {
            rf_filter_coc(filter, &in, &to, &error);
            if (kind == LIMITS) {
                rf_lens_depth_of_field(rf_filter_lens(filter), &limits[0], &limits[1]);
                out[0] = (float)limits[0];
                out[1] = (float)limits[1];
            }
            rf_filter_destroy(filter);
        }
        rf_context_destroy(context);
        *n = kind == LIMITS ? 2 : N;
    }
    if (error.code != RF_OK)
        printf("# %s: %s\n", error.field, error.message);
    return error.code == RF_OK;
}

static double difference(const float *a, const float *b, int n)
{
    double worst = 0;
    for (int i = 0; i < n; i++)
        if (memcmp(&a[i], &b[i], 4))
            worst = fmax(worst, fabs(a[i] - b[i]) / (1 + fabs(b[i])) + 1e-30);
    return worst;
}

static void complain(bool is_good, const char *key, const char *what)
{
    if (!testing_check(is_good, __FILE__, __LINE__, what))
        printf("#     parameter %s\n", key);
}

static void every_parameter_has_a_case(void)
{
    for (size_t i = 0; i < n_rows; i++)
        complain(case_of(rows[i].key) != NULL, rows[i].key, "has a case");
    for (int i = 0; i < N_CASES; i++)
        complain(rf_param_find(cases[i].key) != NULL, cases[i].key, "still exists");
    CHECK((int)n_rows == N_CASES);
}

static void every_parameter_changes_something(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        const struct param_case *c = case_of(rows[i].key);
        struct rf_params before, after;
        float a[N * 3], b[N * 3];
        int n;
        if (!c)
            continue;
        base_params(&before);
        REQUIRE(apply_settings(&before, c->setup));
        after = before;
        CHECK(rf_params_set(&after, c->key, c->changed, NULL) == RF_OK);
        REQUIRE(output_of(c->output, &before, a, &n));
        REQUIRE(output_of(c->output, &after, b, &n));
        complain(difference(a, b, n) > 1e-4, c->key, "changes the output");
    }
}

static void the_neutral_value_is_the_identity(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        const struct param_case *c = case_of(rows[i].key);
        struct rf_params one, other;
        float a[N * 3], b[N * 3];
        int n = N * 3;
        if (!c)
            continue;
        base_params(&one);
        REQUIRE(apply_settings(&one, c->setup));
        other = one;
        REQUIRE(apply_settings(&one, c->equal));
        REQUIRE(output_of(c->output, &one, a, &n));
        if (!strcmp(c->equal_to, SHARP)) {
            memcpy(b, scene.colour, sizeof b);
        } else {
            REQUIRE(apply_settings(&other, c->equal_to));
            REQUIRE(output_of(c->output, &other, b, &n));
        }
        double worst = difference(a, b, n);
        if (!testing_check(worst <= c->tolerance, __FILE__, __LINE__, "neutral"))
            printf("#     parameter %s: \"%s\" and \"%s\" differ by %g\n", c->key,
                   c->equal, c->equal_to, worst);
    }
}

/* Whatever a parameter says, what lies in the plane in focus comes out bit for bit. */
/* Is the focus another in parts of the picture? */
static bool moves_focus(const char *key)
{
    static const char *const keys[] = {
        "tilt-x",       "tilt-y",        "field-curvature", "split-diopter",
        "split-angle",  "split-offset",  "split-softness",  "spherical",
        "axial-chroma", "lateral-chroma"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (!strcmp(key, keys[i]))
            return true;
    return false;
}

static void in_focus_no_parameter_matters(void)
{
    for (size_t i = 0; i < n_rows; i++) {
        const struct param_case *c = case_of(rows[i].key);
        struct rf_params p;
        struct frame f = scene;
        float depth[N], out[N * 3];
        if (!c || rows[i].group == RF_GROUP_DEPTH ||
            rows[i].group == RF_GROUP_HIGHLIGHTS ||
            !strcmp(c->key, "screen-position") || moves_focus(c->key))
            continue;
        base_params(&p);
        REQUIRE(apply_settings(&p, c->setup));
        CHECK(rf_params_set(&p, c->key, c->changed, NULL) == RF_OK);
        p.depth = RF_DEPTH_PLANAR;
        p.focus_distance = 8; /* 1/8 is exact, so the radius is exactly 0 */
        if (strcmp(c->key, "cat-eye-exposure")) /* what darkens does so in focus, too */
            p.cat_eye_exposure = RF_EXPOSURE_KEEP;
        if (p.optics == RF_OPTICS_LENS || p.optics == RF_OPTICS_YU)
            continue;
        for (int k = 0; k < N; k++)
            depth[k] = 8;
        f.depth = depth;
        f.out = out;
        REQUIRE(frame_filter(&f, &p, 2, NULL) == RF_OK);
        complain(!memcmp(out, scene.colour, sizeof out), c->key, "sharp in focus");
    }
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rows = rf_param_list(&n_rows);
    make_scene();
    TEST(every_parameter_has_a_case);
    TEST(every_parameter_changes_something);
    TEST(the_neutral_value_is_the_identity);
    TEST(in_focus_no_parameter_matters);
    frame_free(&scene);
    return testing_end();
}
