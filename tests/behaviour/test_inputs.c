/* SPDX-License-Identifier: Apache-2.0 */
/* Sizes, strides, fence pages, in place, and values that are no colours. */
#include <stdio.h>
#include <sys/mman.h>
#include <unistd.h>

#include "physics/frames.h"
#include "testing.h"

static size_t n_methods;

/* ---- sizes --------------------------------------------------------------------- */

static void bad_sizes_are_rejected(void)
{
    static const int sizes[][2] = {
        {0, 0},        {0, 5},     {5, 0},     {-1, 5},
        {5, -1},       {65536, 1}, {1, 65536}, {INT32_MAX, INT32_MAX},
        {INT32_MIN, 1}};
    struct rf_context *context;
    struct rf_params params;
    rf_params_init(&params);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    for (int i = 0; i < 9; i++) {
        struct rf_filter *filter = NULL;
        struct rf_error error = {0};
        CHECK(rf_filter_create(&filter, context, &params, sizes[i][0], sizes[i][1],
                               &error) == RF_ERROR_ARGUMENT);
        bool is_width = sizes[i][0] < 1 || sizes[i][0] > 65535;
        CHECK_STR(error.field, is_width ? "width" : "height");
        CHECK_CONTAINS(error.message, "65535");
        CHECK(filter == NULL);
    }
    rf_context_destroy(context);
}

static void check_size(int width, int height, int channels, double r_px)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(width, height, channels);
        struct rf_params params;
        struct rf_error error = {0};
        scene_params(&params, (int)m);
        frame_fill_scene(&f, r_px);
        f.depth[0] = plain_depth(r_px);
        if (frame_filter(&f, &params, 2, &error) != RF_OK)
            printf("# %s\n", error.message);
        CHECK(error.code == RF_OK);
        bool is_finite = true;
        for (size_t i = 0; i < frame_pixels(&f) * (size_t)f.channels; i++)
            is_finite = is_finite && isfinite(f.out[i]);
        if (!testing_check(is_finite, __FILE__, __LINE__, "finite"))
            printf("#     method %zu, %d x %d, radius %g\n", m, width, height, r_px);
        frame_free(&f);
    }
}

static void odd_sizes_work(void)
{
    static const int sizes[][2] = {{1, 1},  {1, 2},  {2, 1},   {2, 2},   {1, 97},
                                   {97, 1}, {3, 50}, {63, 65}, {64, 64}, {129, 31}};
    static const int channels[] = {1, 3, 4};
    for (int i = 0; i < 10; i++)
        for (int k = 0; k < 3; k++) {
            int w = sizes[i][0], h = sizes[i][1];
            if (w * h > 1000 && k != i % 3)
                continue; /* takes as long as the rest: by turns */
            check_size(w, h, channels[k], 0.3);
            check_size(w, h, channels[k], i < 6 ? 40 : 5); /* some far larger */
        }
}

/* With the most channels, whose places lie the farthest apart. */
static void the_longest_side_works(void)
{
    check_size(65535, 1, 4, 2);
    check_size(1, 65535, 4, 2);
}

/* One pixel has no neighbour to mix with: layered gives it back. */
static void a_single_pixel_stays_itself(void)
{
    struct frame f = frame_make(1, 1, 3);
    struct rf_params params;
    scene_params(&params, RF_METHOD_LAYERED);
    f.colour[0] = 0.25f, f.colour[1] = 0.75f, f.colour[2] = 1e-3f;
    f.depth[0] = plain_depth(0.75);
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    CHECK_NEAR(f.out[2], 1e-3, 1e-6);
    CHECK_NEAR(f.out[0], 0.25, 1e-4);
    frame_free(&f);
}

/* ---- strides and fences -------------------------------------------------------- */

struct layout {
    const char *name;
    ptrdiff_t channel, pixel, row; /* in floats */
};

/* The layouts of a picture of width x height x channels. */
static int list_layouts(int w, int h, int c, struct layout *list)
{
    struct layout all[] = {
        {"packed", 1, c, c * w},
        {"planar", w * h, 1, w},
        {"rows apart", 1, c, c * w + 5},
        {"pixels apart", 1, c + 3, (c + 3) * w + 1},
        {"channels apart", 3, 3 * c, 3 * c * w},
        {"bottom up", 1, c, -c * w},
        {"right to left", 1, -c, c * w},
        {"blue first", -1, c, c * w},
        {"all backwards", -1, -(c + 1), -(c + 1) * w - 7},
        {"transposed", 1, c * h, c},
        {"planar bottom up", -w * h, 1, -w},
    };
    memcpy(list, all, sizeof all);
    return (int)(sizeof all / sizeof all[0]);
}

struct fenced {
    char *pages;
    size_t n_bytes, page;
    float *first; /* lowest address in use */
    size_t n_floats;
    struct rf_image image;
};

/* Memory with a forbidden page before and after; the picture touches one of them. */
static bool fenced_make(struct fenced *f, const struct layout *l, int w, int h, int c,
                        bool at_end)
{
    ptrdiff_t steps[3][2] = {{l->channel, c}, {l->pixel, w}, {l->row, h}};
    ptrdiff_t low = 0, high = 0;
    for (int i = 0; i < 3; i++) {
        ptrdiff_t reach = steps[i][0] * (steps[i][1] - 1);
        low += reach < 0 ? reach : 0;
        high += reach > 0 ? reach : 0;
    }
    f->n_floats = (size_t)(high - low + 1);
    f->page = (size_t)sysconf(_SC_PAGESIZE);
    size_t inner = (f->n_floats * 4 + f->page - 1) / f->page * f->page;
    f->n_bytes = inner + 2 * f->page;
    f->pages = mmap(NULL, f->n_bytes, PROT_READ | PROT_WRITE,
                    MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (f->pages == MAP_FAILED)
        return false;
    memset(f->pages, 0xff, f->n_bytes); /* NaN everywhere */
    mprotect(f->pages, f->page, PROT_NONE);
    mprotect(f->pages + f->page + inner, f->page, PROT_NONE);
    char *start = f->pages + f->page + (at_end ? inner - f->n_floats * 4 : 0);
    f->first = (float *)start;
    f->image = (struct rf_image){.data = f->first - low,
                                 .width = w,
                                 .height = h,
                                 .channels = c,
                                 .channel_bytes = l->channel * 4,
                                 .pixel_bytes = l->pixel * 4,
                                 .row_bytes = l->row * 4};
    return true;
}

static void fenced_free(struct fenced *f)
{
    munmap(f->pages, f->n_bytes);
}

static float *sample(const struct rf_image *image, int x, int y, int c)
{
    return (float *)((char *)image->data + y * image->row_bytes +
                     x * image->pixel_bytes + c * image->channel_bytes);
}

static void fill(const struct rf_image *to, const float *packed)
{
    for (int y = 0; y < to->height; y++)
        for (int x = 0; x < to->width; x++)
            for (int c = 0; c < to->channels; c++)
                *sample(to, x, y, c) = *packed++;
}

/* Do the samples agree bit for bit, and is all else as it was? */
static bool is_exactly(struct fenced *f, const float *packed)
{
    for (int y = 0; y < f->image.height; y++)
        for (int x = 0; x < f->image.width; x++)
            for (int c = 0; c < f->image.channels; c++, packed++) {
                if (memcmp(sample(&f->image, x, y, c), packed, 4))
                    return false;
                memset(sample(&f->image, x, y, c), 0xff, 4);
            }
    const unsigned char *bytes = (const unsigned char *)f->first;
    for (size_t i = 0; i < f->n_floats * 4; i++)
        if (bytes[i] != 0xff)
            return false;
    return true;
}

static void check_layout(const struct rf_filter *filter, const struct frame *want,
                         int index, bool at_end)
{
    struct layout list[16], flat[16];
    int w = want->width, h = want->height, c = want->channels;
    list_layouts(w, h, c, list);
    int n = list_layouts(w, h, 1, flat);
    struct fenced colour, depth, out;
    REQUIRE(fenced_make(&colour, &list[index], w, h, c, at_end));
    REQUIRE(fenced_make(&depth, &flat[(index + 3) % n], w, h, 1, at_end));
    REQUIRE(fenced_make(&out, &list[(index + 5) % n], w, h, c, at_end));
    fill(&colour.image, want->colour);
    fill(&depth.image, want->depth);
    struct rf_view view = {.colour = colour.image, .depth = depth.image};
    struct rf_error error = {0};
    if (rf_filter_process(filter, &view, 1, &out.image, NULL, &error) != RF_OK)
        printf("# %s\n", error.message);
    bool is_good = error.code == RF_OK && is_exactly(&out, want->out);
    is_good = is_good && is_exactly(&colour, want->colour);
    is_good = is_good && is_exactly(&depth, want->depth);
    if (!testing_check(is_good, __FILE__, __LINE__, "layout"))
        printf("#     colour %s, depth %s, out %s, %d channels\n", list[index].name,
               flat[(index + 3) % n].name, list[(index + 5) % n].name, c);
    fenced_free(&colour);
    fenced_free(&depth);
    fenced_free(&out);
}

/* Lets a border cross the middle of a small frame: hard, or soft and of three steps. */
static void split(struct rf_params *p, bool is_soft)
{
    p->split_diopter = 120;
    p->split_angle = 20;
    p->split_softness = is_soft ? 0.3 : 0;
}

/* A picture is put together of one for each focus, part by part. */
static void any_strides_of_a_split_diopter(void)
{
    for (int soft = 0; soft < 2; soft++) {
        struct frame f = frame_make(37, 19, 4);
        struct rf_params params;
        struct rf_context *context;
        struct rf_filter *filter;
        struct layout list[16];
        scene_params(&params, RF_METHOD_LAYERED);
        split(&params, soft);
        params.depth_infinity = 1e11;
        frame_fill_scene(&f, 5);
        REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
        REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
        REQUIRE(rf_filter_create(&filter, context, &params, 37, 19, NULL) == RF_OK);
        int n = list_layouts(37, 19, f.channels, list);
        for (int i = 0; i < n; i++)
            check_layout(filter, &f, i, i % 2);
        rf_filter_destroy(filter);
        rf_context_destroy(context);
        frame_free(&f);
    }
}

static void any_strides_between_fences(void)
{
    static const int channels[] = {1, 3, 4};
    for (size_t m = 0; m < n_methods; m++)
        for (int k = 0; k < 3; k++)
            for (int in_focus = 0; in_focus < 2; in_focus++) {
                struct frame f = frame_make(37, 19, channels[k]);
                struct rf_params params;
                struct rf_context *context;
                struct rf_filter *filter;
                struct layout list[16];
                scene_params(&params, (int)m);
                frame_fill_scene(&f, in_focus ? 0 : 5);
                params.depth_infinity = 1e11;
                if (in_focus)
                    for (size_t i = 0; i < frame_pixels(&f); i++)
                        f.depth[i] = PLAIN_FOCUS;
                REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
                REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
                REQUIRE(rf_filter_create(&filter, context, &params, 37, 19, NULL) ==
                        RF_OK);
                int n = list_layouts(37, 19, f.channels, list);
                for (int i = 0; i < 2 * n; i++)
                    check_layout(filter, &f, i / 2, i % 2);
                rf_filter_destroy(filter);
                rf_context_destroy(context);
                frame_free(&f);
            }
}

static void in_place(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(50, 40, 4);
        struct rf_params params;
        scene_params(&params, (int)m);
        frame_fill_scene(&f, 6);
        REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
        struct rf_image colour = rf_image_packed(f.colour, 50, 40, 4);
        struct rf_image depth = rf_image_packed(f.depth, 50, 40, 1);
        CHECK((memcmp(f.colour, f.out, frame_bytes(&f)) == 0) ==
              (m == RF_METHOD_ACCUMULATE));
        CHECK(rf_apply(&params, &colour, &depth, &colour, NULL) == RF_OK);
        CHECK(memcmp(f.colour, f.out, frame_bytes(&f)) == 0);
        frame_free(&f);
    }
}

/* No focus reads what another has written, above or beside it. */
static void a_split_diopter_in_place(void)
{
    for (int soft = 0; soft < 2; soft++) {
        struct frame f = frame_make(50, 40, 4);
        struct rf_params params;
        struct rf_image colour = rf_image_packed(f.colour, 50, 40, 4);
        struct rf_image depth = rf_image_packed(f.depth, 50, 40, 1);
        scene_params(&params, RF_METHOD_LAYERED);
        split(&params, soft);
        frame_fill_scene(&f, 6);
        REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
        CHECK(memcmp(f.colour, f.out, frame_bytes(&f)) != 0);
        CHECK(rf_apply(&params, &colour, &depth, &colour, NULL) == RF_OK);
        CHECK(memcmp(f.colour, f.out, frame_bytes(&f)) == 0);
        frame_free(&f);
    }
}

/* ---- values -------------------------------------------------------------------- */

static void nan_and_infinity_name_the_pixel(void)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    for (size_t m = 0; m < n_methods; m++)
        for (int k = 0; k < 3; k++) {
            struct frame f = frame_make(20, 15, 4);
            struct rf_params params;
            struct rf_error error = {0};
            scene_params(&params, (int)m);
            frame_fill_scene(&f, 3);
            frame_at(&f, f.colour, 7, 4)[k] = bad[k];
            CHECK(frame_filter(&f, &params, 2, &error) == RF_ERROR_PIXEL);
            CHECK_STR(error.field, "colour");
            CHECK_CONTAINS(error.message, "(7, 4)");
            CHECK_CONTAINS(error.message, "1 colour value is");
            frame_at(&f, f.colour, 2, 11)[3] = bad[k];
            frame_at(&f, f.colour, 19, 2)[0] = bad[k];
            CHECK(frame_filter(&f, &params, 7, &error) == RF_ERROR_PIXEL);
            CHECK_CONTAINS(error.message, "(19, 2)");
            CHECK_CONTAINS(error.message, "3 colour values are");
            frame_at(&f, f.colour, 3, 2)[2] = bad[k]; /* further left, later channel */
            CHECK(frame_filter(&f, &params, 2, &error) == RF_ERROR_PIXEL);
            CHECK_CONTAINS(error.message, "(3, 2)");
            frame_free(&f);
        }
}

static void light_too_large_for_the_blend_gamma_names_the_pixel(void)
{
    struct frame f = frame_make(20, 15, 4);
    struct rf_params params;
    struct rf_error error = {0};
    scene_params(&params, RF_METHOD_LAYERED);
    frame_fill_scene(&f, 3);
    frame_at(&f, f.colour, 7, 4)[1] = 65504;
    params.blend_gamma = 0.2;
    CHECK(frame_filter(&f, &params, 2, &error) == RF_OK); /* 1.2e24 */
    params.blend_gamma = 0.1;
    CHECK(frame_filter(&f, &params, 2, &error) == RF_ERROR_PIXEL);
    CHECK_STR(error.field, "colour");
    CHECK_CONTAINS(error.message, "1 colour value is");
    CHECK_CONTAINS(error.message, "in the blend gamma");
    CHECK_CONTAINS(error.message, "(7, 4)");
    frame_free(&f);
}

/* Negative colours (wide gamuts, ringing) are input as any other. */
static void negative_and_huge_colours_pass(void)
{
    static const float values[] = {-0.25f, 1e30f, 1e-40f, 3e8f, -1e10f};
    for (size_t m = 0; m < n_methods; m++)
        for (int k = 0; k < 5; k++) {
            struct frame f = frame_make(40, 30, 3);
            struct rf_params params;
            scene_params(&params, (int)m);
            frame_fill_scene(&f, 4);
            frame_at(&f, f.colour, 20, 15)[1] = values[k];
            CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
            bool is_finite = true;
            for (size_t i = 0; i < frame_pixels(&f) * 3; i++)
                is_finite = is_finite && isfinite(f.out[i]);
            CHECK(is_finite);
            frame_free(&f);
        }
}

/* Two surfaces and their edges, no pixel of which is black: by `gain` times the light. */
static void fill_bright(const struct frame *f, float gain)
{
    uint32_t state = 5;
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++) {
            float light = (float)(0.2 + 0.8 * random_unit(&state));
            bool is_near = x > 16 && x < 28 && y > 8 && y < 24;
            f->depth[y * f->width + x] = plain_depth(is_near ? -6 : y < 4 ? 4 : 9);
            for (int c = 0; c < 3; c++)
                frame_at(f, f->colour, x, y)[c] = gain * light * (1 - 0.1f * (float)c);
        }
}

/* Light is linear up to what the header promises: squares of it do not overflow. */
static void all_light_up_to_the_promised_is_linear(void)
{
    static const float gains[] = {0x1p40f, 0x1p63f, 0x1p64f, 0x1p90f, 1e36f};
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(44, 34, 3);
        float *first = malloc(frame_bytes(&f));
        struct rf_params params;
        scene_params(&params, (int)m);
        for (int k = 0; k < 5; k++) {
            double worst = 0;
            fill_bright(&f, gains[k]);
            CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
            for (size_t i = 0; i < frame_pixels(&f) * 3; i++) {
                f.out[i] /= gains[k];
                worst = fmax(worst, k ? fabs(f.out[i] - first[i]) : 0);
            }
            CHECK(worst < 1e-4);
            if (k == 0)
                memcpy(first, f.out, frame_bytes(&f));
        }
        free(first);
        frame_free(&f);
    }
}

/* Renderers' pixel filters write values below zero beside bright things. */
static void black_beside_negative_changes_little(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(40, 30, 3);
        struct rf_params params;
        scene_params(&params, (int)m);
        for (size_t i = 0; i < frame_pixels(&f); i++)
            f.depth[i] = 20;
        for (size_t i = 0; i < frame_pixels(&f) * 3; i++)
            f.colour[i] = 0.5f;
        memset(frame_at(&f, f.colour, 20, 15), 0, 2 * 3 * sizeof(float));
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        float *black = malloc(frame_bytes(&f));
        memcpy(black, f.out, frame_bytes(&f));
        for (int c = 0; c < 3; c++)
            frame_at(&f, f.colour, 21, 15)[c] = -0.01f;
        CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
        double worst = 0;
        for (size_t i = 0; i < frame_pixels(&f) * 3; i++)
            worst = fmax(worst, fabs(f.out[i] - black[i]));
        CHECK_NEAR(worst, 0, 0.0101);
        free(black);
        frame_free(&f);
    }
}

/* In a corner, beyond which the picture goes on with nothing else. */
static void negative_alpha_spreads_no_infinity(void)
{
    struct frame f = frame_make(40, 30, 4);
    struct rf_params params;
    scene_params(&params, RF_METHOD_LAYERED);
    frame_fill_scene(&f, 4);
    frame_at(&f, f.colour, 0, 0)[3] = -1;
    CHECK(frame_filter(&f, &params, 2, NULL) == RF_OK);
    bool is_finite = true, is_dark = false;
    for (size_t i = 0; i < frame_pixels(&f) * 4; i++)
        is_finite = is_finite && isfinite(f.out[i]);
    for (int x = 0; x < 8; x++)
        is_dark = is_dark || frame_at(&f, f.out, x, 1)[0] == 0;
    CHECK(is_finite);
    CHECK(!is_dark);
    frame_free(&f);
}

static void a_failed_frame_leaves_the_filter_usable(void)
{
    for (size_t m = 0; m < n_methods; m++) {
        struct frame f = frame_make(40, 30, 3);
        struct rf_params params;
        struct rf_context *context;
        struct rf_filter *filter;
        scene_params(&params, (int)m);
        frame_fill_scene(&f, 4);
        REQUIRE(frame_filter(&f, &params, 2, NULL) == RF_OK);
        float *again = calloc(1, frame_bytes(&f)), good = f.depth[0];
        REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
        REQUIRE(rf_filter_create(&filter, context, &params, 40, 30, NULL) == RF_OK);
        struct rf_view view = {.colour = rf_image_packed(f.colour, 40, 30, 3),
                               .depth = rf_image_packed(f.depth, 40, 30, 1)};
        struct rf_image out = rf_image_packed(again, 40, 30, 3);
        f.depth[0] = NAN;
        CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_ERROR_DEPTH);
        f.depth[0] = good;
        CHECK(rf_filter_process(filter, &view, 1, &out, NULL, NULL) == RF_OK);
        CHECK(memcmp(again, f.out, frame_bytes(&f)) == 0);
        rf_filter_destroy(filter);
        rf_context_destroy(context);
        free(again);
        frame_free(&f);
    }
}

/* ---- channels and strides -------------------------------------------------------- */

enum { W = 6, H = 4 };

/* A filter and memory for views that are not as they should be. */
static struct views {
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    float colour[W * H * 3], depth[W * H * 3], out[W * H * 4];
    struct rf_image one, three; /* of depth: as it is, and of three channels */
    struct rf_view view;
    struct rf_image to;
} v;

static void views_begin(void)
{
    scene_params(&v.params, RF_METHOD_LAYERED);
    for (int i = 0; i < W * H * 3; i++)
        v.depth[i] = 10;
    v.one = rf_image_packed(v.depth, W, H, 1);
    v.three = rf_image_packed(v.depth, W, H, 3);
    v.view =
        (struct rf_view){.colour = rf_image_packed(v.colour, W, H, 3), .depth = v.one};
    v.to = rf_image_packed(v.out, W, H, 3);
    REQUIRE(rf_context_create(&v.context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&v.filter, v.context, &v.params, W, H, NULL) == RF_OK);
}

static void views_end(void)
{
    rf_filter_destroy(v.filter);
    rf_context_destroy(v.context);
}

static void check_refused(rf_result result, const struct rf_error *error,
                          const char *field, const char *text)
{
    CHECK(result == RF_ERROR_ARGUMENT && error->code == RF_ERROR_ARGUMENT);
    CHECK_STR(error->field, field);
    CHECK_CONTAINS(error->message, field);
    CHECK_CONTAINS(error->message, text);
}

#define REFUSED(call, field, text)                                                     \
    do {                                                                               \
        struct rf_error error = {0};                                                   \
        check_refused(call, &error, field, text);                                      \
    } while (0)

/* Its first channel was taken without a word. */
static void a_depth_of_three_channels_is_refused(void)
{
    struct rf_window all = {0, 0, W, H};
    struct rf_survey survey = {.size = sizeof survey};
    views_begin();
    struct rf_view bad = v.view, behind = v.view, seen = v.view;
    bad.depth = v.three;
    behind.behind_colour = v.view.colour;
    behind.behind_depth = v.three;
    const struct rf_seen_light light = {v.view.colour, v.three};
    seen.seen = &light;
    seen.n_seen = 1;
    const struct rf_view two[] = {bad, v.view};
    const struct rf_image lights[] = {v.view.colour, v.view.colour};
    REFUSED(rf_filter_process(v.filter, &bad, 1, &v.to, NULL, &error), "depth",
            "3 channels");
    REFUSED(rf_filter_process(v.filter, &behind, 1, &v.to, NULL, &error),
            "behind_depth", "3 channels");
    behind.behind_colour.data = NULL; /* forgotten, which was taken for not known */
    behind.behind_depth = v.view.depth;
    REFUSED(rf_filter_process(v.filter, &behind, 1, &v.to, NULL, &error),
            "behind_colour", "has no pixels");
    REFUSED(rf_filter_process(v.filter, &seen, 1, &v.to, NULL, &error), "seen",
            "3 channels");
    REFUSED(rf_filter_survey(v.filter, &bad, &all, &all, &survey, &error), "depth",
            "3 channels");
    REFUSED(rf_filter_coc(v.filter, &v.three, &v.one, &error), "depth", "3 channels");
    REFUSED(rf_filter_planar_depth(v.filter, &v.three, &v.one, &error), "depth",
            "3 channels");
    REFUSED(rf_filter_seen_depth(v.filter, two, 2, lights, &v.one, &error), "depth",
            "3 channels");
    REFUSED(rf_filter_seen_way(v.filter, &bad, &v.view.colour, &v.one, &v.one, &error),
            "depth", "3 channels");
    REFUSED(
        rf_filter_seen_way(v.filter, &v.view, &v.view.colour, &v.three, &v.one, &error),
        "way", "3 channels");
    REFUSED(rf_apply(&v.params, &v.view.colour, &v.three, &v.to, &error), "depth",
            "3 channels");
    views_end();
}

static void maps_go_into_one_channel(void)
{
    views_begin();
    const size_t first[W * H + 1] = {0};
    const struct rf_deep deep = {W, H, first, NULL};
    const struct rf_view two[] = {v.view, v.view};
    const struct rf_image lights[] = {v.view.colour, v.view.colour};
    REFUSED(rf_filter_coc(v.filter, &v.one, &v.to, &error), "out", "it gets 1");
    REFUSED(rf_filter_planar_depth(v.filter, &v.one, &v.to, &error), "out",
            "it gets 1");
    REFUSED(rf_filter_seen_depth(v.filter, two, 2, lights, &v.to, &error), "out",
            "it gets 1");
    REFUSED(rf_filter_seen_way(v.filter, two, lights, &v.one, &v.to, &error), "out",
            "it gets 1");
    REFUSED(rf_deep_flatten(v.filter, &deep, &v.to, &v.three, &error), "depth",
            "it gets 1");
    CHECK(rf_deep_flatten(v.filter, &deep, &v.to, &v.one, NULL) == RF_OK);
    views_end();
}

/* What is read may have the same sample everywhere; what is written may not. */
static void outputs_with_a_stride_of_0_are_refused(void)
{
    struct rf_accumulator *sum;
    views_begin();
    struct rf_image flat = v.to, line = v.to, grey = v.to;
    flat.pixel_bytes = 0;
    line.row_bytes = 0;
    grey.channel_bytes = 0;
    const struct rf_image bad[] = {flat, line, grey};
    const size_t first[W * H + 1] = {0};
    const struct rf_deep deep = {W, H, first, NULL};
    REQUIRE(rf_accumulator_create(&sum, v.context, &v.params, W, H, 3, NULL) == RF_OK);
    CHECK(rf_accumulator_add(sum, &flat, NULL) == RF_OK);
    for (int i = 0; i < 3; i++) {
        const struct rf_image *to = &bad[i];
        struct rf_view view = v.view;
        view.colour = *to;
        view.depth.pixel_bytes = view.depth.row_bytes = 0;
        CHECK(rf_filter_process(v.filter, &view, 1, &v.to, NULL, NULL) == RF_OK);
        REFUSED(rf_filter_process(v.filter, &v.view, 1, to, NULL, &error), "out",
                "stride");
        REFUSED(rf_filter_process_deep(v.filter, &deep, to, NULL, &error), "out",
                "stride");
        REFUSED(rf_deep_flatten(v.filter, &deep, to, NULL, &error), "colour", "stride");
        REFUSED(rf_accumulator_mean(sum, to, &error), "out", "stride");
    }
    struct rf_image radii = v.one;
    radii.row_bytes = 0;
    REFUSED(rf_filter_coc(v.filter, &v.one, &radii, &error), "out", "stride");
    rf_accumulator_destroy(sum);
    views_end();
}

/* Values of one place, addresses that no float has, strides that lead out of memory. */
static void strides_that_cannot_be_are_refused(void)
{
    views_begin();
    struct rf_image rows = v.to, pixels = v.to, far = v.to, two = v.to;
    rows.row_bytes = rows.pixel_bytes = 4;
    pixels.pixel_bytes = 8;
    far.row_bytes = PTRDIFF_MAX - 3;
    two.pixel_bytes = PTRDIFF_MIN;
    const struct rf_image bad[] = {rows, pixels, far, two};
    for (int i = 0; i < 4; i++) {
        struct rf_view view = v.view;
        REFUSED(rf_filter_process(v.filter, &v.view, 1, &bad[i], NULL, &error), "out",
                "strides");
        view.colour = bad[i];
        if (i >= 2)
            REFUSED(rf_filter_process(v.filter, &view, 1, &v.to, NULL, &error),
                    "colour", "strides");
    }
    struct rf_image turned = rf_image_packed(v.to.data, W, H, v.to.channels);
    turned.row_bytes = v.to.channels * 4;
    turned.pixel_bytes = H * turned.row_bytes;
    CHECK(rf_filter_process(v.filter, &v.view, 1, &turned, NULL, NULL) == RF_OK);
    views_end();
}

/* The field that is wrong is the one that is named. */
static void shears_are_named(void)
{
    static const double bad[] = {-1, NAN};
    views_begin();
    for (int i = 0; i < 2; i++) {
        struct rf_view view = v.view;
        view.shear_distance = bad[i];
        REFUSED(rf_filter_process(v.filter, &view, 1, &v.to, NULL, &error),
                "shear_distance", "0 or more");
    }
    views_end();
}

/* ---- deep frames --------------------------------------------------------------- */

struct remarks {
    int n;
    char text[256];
};

static void keep_remark(void *user, enum rf_log_level level, const char *text)
{
    struct remarks *remarks = user;
    CHECK(level == RF_LOG_WARNING);
    remarks->n++;
    snprintf(remarks->text, sizeof remarks->text, "%s", text);
}

/* One sample, of this opacity, in the pixels (4, 2) and (5, 2). */
static rf_result filter_opacity(float opacity, struct remarks *remarks)
{
    const struct rf_context_params with = {
        .size = sizeof with, .log = keep_remark, .user = remarks};
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    size_t first[W * H + 1];
    float out[W * H * 4];
    const struct rf_image to = rf_image_packed(out, W, H, 4);
    const struct rf_deep_sample s = {10, 10, {0.5f, 0.5f, 0.5f, 1}, opacity};
    const struct rf_deep_sample samples[] = {s, s};
    const struct rf_deep deep = {W, H, first, samples};
    for (int i = 0; i <= W * H; i++)
        first[i] = i <= 2 * W + 4 ? 0 : i == 2 * W + 5 ? 1 : 2;
    *remarks = (struct remarks){0};
    scene_params(&params, RF_METHOD_LAYERED);
    CHECK(rf_context_create(&context, &with, NULL) == RF_OK &&
          rf_filter_create(&filter, context, &params, W, H, NULL) == RF_OK);
    const rf_result result = rf_filter_process_deep(filter, &deep, &to, NULL, NULL);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

static void opacity_above_1_is_remarked(void)
{
    struct remarks remarks;
    CHECK(filter_opacity(1, &remarks) == RF_OK && remarks.n == 0);
    CHECK(filter_opacity(1.0005f, &remarks) == RF_OK && remarks.n == 0);
    CHECK(filter_opacity(1.02f, &remarks) == RF_OK && remarks.n == 1);
    CHECK_STR(remarks.text,
              "2 deep samples have an opacity above 1, the first at pixel "
              "(4, 2): taken as 1");
    CHECK(filter_opacity(INFINITY, &remarks) == RF_ERROR_PIXEL);
    CHECK(filter_opacity(-0.1f, &remarks) == RF_ERROR_PIXEL);
    CHECK(filter_opacity(NAN, &remarks) == RF_ERROR_PIXEL);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    rf_method_list(&n_methods);
    TEST(a_depth_of_three_channels_is_refused);
    TEST(maps_go_into_one_channel);
    TEST(outputs_with_a_stride_of_0_are_refused);
    TEST(strides_that_cannot_be_are_refused);
    TEST(shears_are_named);
    TEST(opacity_above_1_is_remarked);
    TEST(bad_sizes_are_rejected);
    TEST(odd_sizes_work);
    TEST(the_longest_side_works);
    TEST(a_single_pixel_stays_itself);
    TEST(any_strides_between_fences);
    TEST(any_strides_of_a_split_diopter);
    TEST(in_place);
    TEST(a_split_diopter_in_place);
    TEST(nan_and_infinity_name_the_pixel);
    TEST(light_too_large_for_the_blend_gamma_names_the_pixel);
    TEST(negative_and_huge_colours_pass);
    TEST(all_light_up_to_the_promised_is_linear);
    TEST(black_beside_negative_changes_little);
    TEST(negative_alpha_spreads_no_infinity);
    TEST(a_failed_frame_leaves_the_filter_usable);
    return testing_end();
}
