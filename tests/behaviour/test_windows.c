/* SPDX-License-Identifier: Apache-2.0 */
/* Windows of a picture have the bits of the whole picture. */
#include <stdio.h>

#include "physics/frames.h"
#include "testing.h"

struct subject {
    struct frame f;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_survey survey;
};

struct setting {
    const char *key, *value;
};

static struct rf_image cut(float *samples, const struct frame *f, int channels,
                           const struct rf_window *w)
{
    struct rf_image image = rf_image_packed(samples, f->width, f->height, channels);
    image.data =
        samples + ((size_t)w->y * (size_t)f->width + (size_t)w->x) * (size_t)channels;
    image.width = w->width;
    image.height = w->height;
    return image;
}

static struct rf_view view_of(const struct frame *f, const struct rf_window *w)
{
    return (struct rf_view){.colour = cut(f->colour, f, f->channels, w),
                            .depth = cut(f->depth, f, 1, w)};
}

static int most(int a, int b)
{
    return a > b ? a : b;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* `counted` with its margin. */
static struct rf_window with_margin(const struct frame *f, const struct rf_window *w)
{
    int x0 = most(w->x - RF_SURVEY_MARGIN, 0), y0 = most(w->y - RF_SURVEY_MARGIN, 0);
    int x1 = least(w->x + w->width + RF_SURVEY_MARGIN, f->width);
    int y1 = least(w->y + w->height + RF_SURVEY_MARGIN, f->height);
    return (struct rf_window){x0, y0, x1 - x0, y1 - y0};
}

static rf_result survey(struct subject *s, int width, int height,
                        struct rf_survey *survey, struct rf_error *error)
{
    const struct frame *f = &s->f;
    *survey = (struct rf_survey){.size = sizeof *survey};
    rf_result result = RF_OK;
    for (int y = 0; y < f->height && result == RF_OK; y += height)
        for (int x = 0; x < f->width && result == RF_OK; x += width) {
            struct rf_window counted = {x, y, least(width, f->width - x),
                                        least(height, f->height - y)};
            struct rf_window given = with_margin(f, &counted);
            struct rf_view view = view_of(f, &given);
            result =
                rf_filter_survey(s->filter, &view, &given, &counted, survey, error);
        }
    return result;
}

static bool setting_apply(struct rf_params *params, const struct setting *setting)
{
    return rf_params_set(params, setting->key, setting->value, NULL) == RF_OK;
}

/* The frame f is the subject's from now on. */
static struct subject subject_of(struct frame f, double r_px,
                                 const struct setting *settings)
{
    const int width = f.width, height = f.height, channels = f.channels;
    struct subject s = {.f = f};
    struct rf_context_params run = {.size = sizeof run, .n_threads = 2};
    struct rf_params params;
    struct rf_window whole = {0, 0, width, height};
    bool is_good = true;
    scene_params(&params, RF_METHOD_LAYERED);
    params.sub_apertures = 1;
    params.max_radius = r_px;
    for (; settings && settings->key; settings++)
        is_good &= setting_apply(&params, settings);
    is_good &=
        rf_context_create(&s.context, &run, NULL) == RF_OK &&
        rf_filter_create(&s.filter, s.context, &params, width, height, NULL) == RF_OK;
    if (!is_good)
        abort();
    struct rf_view view = view_of(&s.f, &whole);
    struct rf_image out = cut(s.f.out, &s.f, channels, &whole);
    CHECK(rf_filter_process(s.filter, &view, 1, &out, NULL, NULL) == RF_OK);
    CHECK(survey(&s, width, 100, &s.survey, NULL) == RF_OK);
    return s;
}

static struct subject subject_make(int width, int height, int channels, double r_px,
                                   const struct setting *settings)
{
    struct frame f = frame_make(width, height, channels);
    frame_fill_scene(&f, r_px);
    return subject_of(f, r_px, settings);
}

static void subject_free(struct subject *s)
{
    rf_filter_destroy(s->filter);
    rf_context_destroy(s->context);
    frame_free(&s->f);
}

/* Pixels of a window that differ from the whole picture's; *given what it needed. */
static size_t n_different(const struct subject *s, const struct rf_window *kept,
                          struct rf_window *given)
{
    const struct frame *f = &s->f;
    struct rf_error error = {0};
    if (rf_filter_window(s->filter, &s->survey, 1, kept, given, &error) != RF_OK)
        return SIZE_MAX;
    struct frame part = frame_make(kept->width, kept->height, f->channels);
    struct rf_view view = view_of(f, given);
    struct rf_image out =
        rf_image_packed(part.out, kept->width, kept->height, f->channels);
    size_t n = SIZE_MAX;
    if (rf_filter_process_window(s->filter, &s->survey, &view, 1, given, kept, &out,
                                 NULL, &error) == RF_OK)
        n = frame_count_different(f, &part, kept->x, kept->y);
    else
        fprintf(stderr, "# %s\n", error.message);
    frame_free(&part);
    return n;
}

/* Strips of some heights, of which not all may be the whole picture. */
static void check_strips(const struct subject *s, const int *heights, int n_heights)
{
    bool is_smaller = false;
    for (int i = 0; i < n_heights; i++)
        for (int y = 0; y < s->f.height; y += heights[i]) {
            struct rf_window given,
                kept = {0, y, s->f.width, least(heights[i], s->f.height - y)};
            CHECK(n_different(s, &kept, &given) == 0);
            is_smaller |= given.height < s->f.height;
        }
    CHECK(is_smaller);
}

static void strips_of_any_height(void)
{
    static const int heights[] = {61, 100, 333};
    struct subject s = subject_make(150, 701, 3, 3, NULL);
    check_strips(&s, heights, 3);
    subject_free(&s);
}

/* Radii at reduced resolution, other apertures, alpha, qualities. */
static void every_kind_of_picture(void)
{
    static const struct {
        int width, height, channels, strip;
        double r_px;
        struct setting settings[5];
    } kinds[] = {
        {131, 1201, 3, 301, 9, {{"sub-apertures", "4"}, {NULL, NULL}}},
        {333, 1107, 4, 400, 14, {{"blades", "6"}, {"film-depth", "all"}, {NULL, NULL}}},
        {200, 899, 3, 250, 7.5, {{"aperture-ratio", "1.5"}, {"blades", "5"}}},
        {99, 1000, 1, 211, 5, {{"blend-gamma", "2.2"}, {"split-edges", "0"}}},
        {180, 900, 3, 301, 6, {{"depth", "radial"}, {"quality", "normal"}}},
        {150, 1003, 3, 500, 12, {{"exact-highlights", "0"}, {"pixel-aspect", "1.3"}}},
        {150, 903, 4, 301, 8, {{"fill-hidden", "0"}, {NULL, NULL}}},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        struct subject s =
            subject_make(kinds[i].width, kinds[i].height, kinds[i].channels,
                         kinds[i].r_px, kinds[i].settings);
        check_strips(&s, &kinds[i].strip, 1);
        subject_free(&s);
    }
}

/*
 * Discs with rims of 7 px over transparent film, which have no depth, or over a sky that
 * is seen through it: in the lower half alone, so that windows above have none.
 */
static struct frame film(int width, int height, double r_px, float sky)
{
    struct frame f = frame_make(width, height, 4);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            float *c = frame_at(&f, f.colour, x, y);
            double d = hypot(x % 60 - 30, y % 60 - 30);
            float a = y < height / 2 ? 1 : (float)fmin(fmax((21 - d) / 7, 0), 1);
            for (int k = 0; k < 3; k++)
                c[k] = a * (0.2f + 0.6f * (float)((x / 5 + y / 4 + k) % 2)) +
                       (1 - a) * sky;
            c[3] = a;
            f.depth[(size_t)y * (size_t)width + (size_t)x] =
                a < 0.6f ? 1e10f : plain_depth(r_px * (0.8 - 0.3 * (x / 60 % 5)));
        }
    return f;
}

static void films(void)
{
    static const struct setting settings[][2] = {
        {{"film-depth", "edges"}, {NULL, NULL}}, {{"film-depth", "all"}, {NULL, NULL}}};
    for (size_t i = 0; i < 2; i++)
        for (int is_lit = 0; is_lit < 2; is_lit++) {
            static const int height = 173;
            struct frame f = film(190, 1100, 9, is_lit ? 0.9f : 0);
            struct subject s = subject_of(f, 9, settings[i]);
            check_strips(&s, &height, 1);
            subject_free(&s);
        }
}

/* Stalks of all slants that both sides cut, which go on beyond them as they lean. */
static void leaning_stalks(void)
{
    static const double radii[] = {5, 11, 40};
    static const int height = 157;
    for (int i = 0; i < 3; i++) {
        struct frame f = frame_make(140, 1300, 3);
        for (int y = 0; y < f.height; y++)
            for (int x = 0; x < f.width; x++) {
                double r = radii[i];
                for (int k = 0; k < 60; k++)
                    if (fabs(y + 0.5 - 23.7 * k - 0.21 * (k % 25 - 12) * (x - 70)) <
                        2 + k % 7)
                        r = fmin(radii[i] * (0.1 * (k % 17) - 1), r);
                f.depth[y * f.width + x] = plain_depth(r);
                for (int c = 0; c < 3; c++)
                    frame_at(&f, f.colour, x, y)[c] =
                        (float)(0.1 + 0.4 * (r < 0) + 0.2 * ((x / 4 + y / 3 + c) % 2));
            }
        struct subject s = subject_of(f, radii[i], NULL);
        check_strips(&s, &height, 1);
        subject_free(&s);
    }
}

/* Cut off on all sides, some at the edges, with large radii. */
static void windows_within_a_picture(void)
{
    static const struct rf_window windows[] = {
        {700, 640, 65, 31}, {0, 700, 90, 77}, {1310, 1000, 93, 107}, {650, 0, 1, 1}};
    struct subject s = subject_make(1403, 1107, 3, 20, NULL);
    for (size_t i = 0; i < sizeof windows / sizeof windows[0]; i++) {
        struct rf_window given;
        CHECK(n_different(&s, &windows[i], &given) == 0);
        CHECK(given.width < s.f.width || given.height < s.f.height);
    }
    subject_free(&s);
}

/* Colours below 0 in one corner, and bright edges all over: what a cubic leaves below 0
 * is cut off where the whole picture's least value is. */
static void negative_colours_of_the_whole(void)
{
    static const int heights[] = {301};
    struct subject s = subject_make(150, 903, 3, 6, NULL);
    struct frame *f = &s.f;
    for (int y = 0; y < f->height; y++)
        for (int x = 0; x < f->width; x++)
            for (int c = 0; c < 3; c++)
                *(frame_at(f, f->colour, x, y) + c) = y < 20 && c == 0
                                                          ? -0.01f * (float)(1 + x % 5)
                                                          : (x / 9 + y / 7) % 2 * 0.9f;
    struct rf_window whole = {0, 0, f->width, f->height};
    struct rf_view view = view_of(f, &whole);
    struct rf_image out = cut(f->out, f, 3, &whole);
    REQUIRE(rf_filter_process(s.filter, &view, 1, &out, NULL, NULL) == RF_OK);
    s.survey = (struct rf_survey){.size = sizeof s.survey};
    REQUIRE(survey(&s, f->width, 100, &s.survey, NULL) == RF_OK);
    CHECK_NEAR(s.survey.least[0], -0.05, 1e-6);
    CHECK(s.survey.least[1] == 0 && s.survey.least[2] == 0);
    float least_red = 0, least_green = 0;
    for (size_t i = 0; i < frame_pixels(f); i++) {
        least_red = fminf(least_red, f->out[3 * i]);
        least_green = fminf(least_green, f->out[3 * i + 1]);
    }
    CHECK(least_red < -0.03f && least_red >= s.survey.least[0] && least_green == 0);
    check_strips(&s, heights, 1);
    subject_free(&s);
}

/* So many lamps that the threshold of highlights rises, in one corner only. */
static void highlights_of_the_whole(void)
{
    static const int heights[] = {401};
    struct subject s = subject_make(160, 1200, 3, 12, NULL);
    struct frame *f = &s.f;
    uint32_t seed = 3;
    for (int y = 0; y < 420; y++)
        for (int x = 0; x < f->width; x += 2)
            for (int c = 0; c < 3 && (y & 1); c++)
                frame_at(f, f->colour, x, y)[c] = 20 + 300 * (float)random_unit(&seed);
    for (int y = 700; y < 900; y++) /* something large, which is no highlight */
        for (int x = 40; x < 90 + y % 40; x++)
            for (int c = 0; c < 3; c++)
                frame_at(f, f->colour, x, y)[c] = 30 + 20 * (float)random_unit(&seed);
    struct rf_window whole = {0, 0, f->width, f->height};
    struct rf_view view = view_of(f, &whole);
    struct rf_image out = cut(f->out, f, 3, &whole);
    REQUIRE(rf_filter_process(s.filter, &view, 1, &out, NULL, NULL) == RF_OK);
    REQUIRE(survey(&s, f->width, 100, &s.survey, NULL) == RF_OK);
    CHECK(s.survey.disc_area[0] > 30 * s.survey.n_pixels);
    check_strips(&s, heights, 1);
    subject_free(&s);
}

static void surveys_of_any_windows(void)
{
    struct subject s = subject_make(301, 205, 4, 9, NULL);
    struct rf_survey other;
    REQUIRE(survey(&s, 301, 205, &other, NULL) == RF_OK);
    CHECK(other.largest_radius == s.survey.largest_radius);
    CHECK(other.n_pixels == s.survey.n_pixels);
    CHECK(memcmp(other.disc_area, s.survey.disc_area, sizeof other.disc_area) == 0);
    REQUIRE(survey(&s, 37, 11, &other, NULL) == RF_OK);
    CHECK(other.largest_radius == s.survey.largest_radius);
    CHECK(memcmp(other.disc_area, s.survey.disc_area, sizeof other.disc_area) == 0);
    CHECK(other.disc_area[0] > 0 && other.n_pixels == 301 * 205);
    subject_free(&s);
}

/* All in focus: the pixels as they are, from nothing but themselves. */
static void a_sharp_picture_is_copied(void)
{
    struct subject s = subject_make(90, 70, 3, 0.001, NULL);
    struct rf_window given, kept = {11, 9, 40, 30};
    CHECK(n_different(&s, &kept, &given) == 0);
    CHECK(memcmp(&given, &kept, sizeof kept) == 0);
    CHECK(memcmp(s.f.out, s.f.colour, frame_bytes(&s.f)) == 0);
    subject_free(&s);
}

/* In focus as well spherical aberration takes light to what is around. */
static void a_sharp_picture_that_glows(void)
{
    static const struct setting settings[] = {{"spherical", "3"}, {NULL, NULL}};
    static const int height = 101;
    struct subject s = subject_make(90, 701, 3, 0.001, settings);
    check_strips(&s, &height, 1);
    CHECK(memcmp(s.f.out, s.f.colour, frame_bytes(&s.f)) != 0);
    subject_free(&s);
}

/* What was said to be needed is enough, and a sixth of it is not. */
static void memory_is_as_announced(void)
{
    struct subject s = subject_make(700, 500, 3, 6, NULL);
    struct rf_window kept = {200, 200, 300, 200}, given;
    REQUIRE(rf_filter_window(s.filter, &s.survey, 1, &kept, &given, NULL) == RF_OK);
    size_t n_bytes = rf_window_bytes(s.filter, &s.survey, 1, &given);
    CHECK(n_bytes >= RF_WINDOW_BYTES + (size_t)given.width * (size_t)given.height *
                                           RF_WINDOW_BYTES_PER_PIXEL);
    for (int i = 0; i < 2; i++) {
        struct rf_context_params run = {
            .size = sizeof run, .n_threads = 2, .max_bytes = i ? n_bytes / 6 : n_bytes};
        struct rf_params params;
        struct subject bounded = s;
        struct rf_error error;
        scene_params(&params, RF_METHOD_LAYERED);
        params.max_radius = 6;
        params.sub_apertures = 1;
        REQUIRE(rf_context_create(&bounded.context, &run, NULL) == RF_OK);
        REQUIRE(rf_filter_create(&bounded.filter, bounded.context, &params, s.f.width,
                                 s.f.height, NULL) == RF_OK);
        struct frame part = frame_make(kept.width, kept.height, 3);
        struct rf_view view = view_of(&s.f, &given);
        struct rf_image out = rf_image_packed(part.out, kept.width, kept.height, 3);
        rf_result result = rf_filter_process_window(bounded.filter, &s.survey, &view, 1,
                                                    &given, &kept, &out, NULL, &error);
        CHECK(result == (i ? RF_ERROR_MEMORY : RF_OK));
        frame_free(&part);
        rf_filter_destroy(bounded.filter);
        rf_context_destroy(bounded.context);
    }
    subject_free(&s);
}

static rf_result process(const struct subject *s, const struct rf_survey *survey,
                         struct rf_window given, struct rf_window kept,
                         struct rf_error *error)
{
    struct frame part = frame_make(s->f.width, s->f.height, 3);
    struct rf_window clipped = {0, 0, least(most(given.width, 1), s->f.width),
                                least(most(given.height, 1), s->f.height)};
    struct rf_view view = view_of(&s->f, &clipped);
    struct rf_image out = rf_image_packed(part.out, kept.width, kept.height, 3);
    rf_result result = rf_filter_process_window(s->filter, survey, &view, 1, &given,
                                                &kept, &out, NULL, error);
    frame_free(&part);
    return result;
}

static void bad_windows_are_refused(void)
{
    struct subject s = subject_make(600, 500, 3, 2, NULL);
    struct rf_window kept = {300, 300, 50, 60}, given, wrong;
    struct rf_survey other = s.survey;
    struct rf_error error;
    REQUIRE(rf_filter_window(s.filter, &s.survey, 1, &kept, &given, NULL) == RF_OK);
    CHECK(process(&s, &s.survey, given, kept, &error) == RF_OK);
    wrong = given;
    wrong.x++;
    wrong.width--;
    CHECK(process(&s, &s.survey, wrong, kept, &error) == RF_ERROR_ARGUMENT);
    CHECK(strcmp(error.field, "given") == 0);
    wrong = (struct rf_window){580, 0, 30, 30};
    CHECK(rf_filter_window(s.filter, &s.survey, 1, &wrong, &given, &error) ==
          RF_ERROR_ARGUMENT);
    CHECK(strstr(error.message, "not within the picture") != NULL);
    wrong = (struct rf_window){0, 0, 0, 30};
    CHECK(rf_filter_window(s.filter, &s.survey, 1, &wrong, &given, &error) ==
          RF_ERROR_ARGUMENT);
    wrong = (struct rf_window){INT32_MAX, 0, INT32_MAX, 30};
    CHECK(rf_filter_window(s.filter, &s.survey, 1, &wrong, &given, &error) ==
          RF_ERROR_ARGUMENT);
    other.n_pixels--;
    CHECK(rf_filter_window(s.filter, &other, 1, &kept, &given, &error) ==
          RF_ERROR_ARGUMENT);
    CHECK(strstr(error.message, "has counted 299999 pixels of 300000") != NULL);
    other = (struct rf_survey){.size = sizeof other};
    CHECK(rf_filter_window(s.filter, &other, 1, &kept, &given, &error) ==
          RF_ERROR_ARGUMENT);
    other = s.survey;
    other.n_known = 0;
    CHECK(rf_filter_window(s.filter, &other, 1, &kept, &given, &error) ==
          RF_ERROR_DEPTH);
    subject_free(&s);
}

static void other_methods_are_refused(void)
{
    size_t n;
    rf_method_list(&n);
    for (size_t m = 0; m <= n; m++) {
        struct frame f = frame_make(20, 20, 3);
        struct subject s = {.f = f};
        struct rf_params params;
        struct rf_survey found;
        struct rf_error error;
        frame_fill_scene(&f, 2);
        scene_params(&params, m < n ? (int)m : RF_METHOD_LAYERED);
        params.quality = m < n ? RF_QUALITY_BEST : RF_QUALITY_PREVIEW;
        REQUIRE(rf_context_create(&s.context, NULL, NULL) == RF_OK);
        REQUIRE(rf_filter_create(&s.filter, s.context, &params, 20, 20, NULL) == RF_OK);
        rf_result result = survey(&s, 20, 20, &found, &error);
        bool is_local = m == RF_METHOD_LAYERED || m == RF_METHOD_VIEWS;
        CHECK(result == (is_local ? RF_OK : RF_ERROR_PARAMETER));
        if (result != RF_OK)
            CHECK(strcmp(error.field, m < n ? "method" : "quality") == 0);
        subject_free(&s);
    }
}

/* What needs the whole picture is named, with windows and in deep frames. */
static void the_parameter_that_is_refused_is_named(void)
{
    static const char *const names[] = {"tilt_x",          "tilt_y",
                                        "field_curvature", "split_diopter",
                                        "axial_chroma",    "lateral_chroma"};
    static const size_t first[20 * 20 + 1];
    const struct rf_deep_sample none = {1, 1, {0}, 0};
    const struct rf_deep deep = {20, 20, first, &none};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (int is_deep = 0; is_deep < 2; is_deep++) {
            struct subject s = {.f = frame_make(20, 20, 3)};
            struct rf_image out = rf_image_packed(s.f.out, 20, 20, 3);
            struct rf_params params;
            struct rf_survey found;
            struct rf_error error = {0};
            frame_fill_scene(&s.f, 2);
            scene_params(&params, is_deep ? RF_METHOD_LAYERED : RF_METHOD_VIEWS);
            CHECK(rf_params_set_number(&params, names[i], 0.01, NULL) == RF_OK);
            REQUIRE(rf_context_create(&s.context, NULL, NULL) == RF_OK);
            REQUIRE(rf_filter_create(&s.filter, s.context, &params, 20, 20, NULL) ==
                    RF_OK);
            rf_result result =
                is_deep ? rf_filter_process_deep(s.filter, &deep, &out, NULL, &error)
                        : survey(&s, 20, 20, &found, &error);
            CHECK(result == RF_ERROR_PARAMETER);
            CHECK_STR(error.field, names[i]);
            subject_free(&s);
        }
}

/* Pixels are named by their place in the whole picture. */
static void bad_pixels_are_named(void)
{
    struct subject s = subject_make(50, 300, 3, 2, NULL);
    struct rf_survey found;
    struct rf_error error;
    s.f.depth[250 * 50 + 7] = NAN;
    CHECK(survey(&s, 50, 40, &found, &error) == RF_ERROR_DEPTH);
    CHECK(strstr(error.message, "(7, 250)") != NULL);
    s.f.depth[250 * 50 + 7] = 1;
    frame_at(&s.f, s.f.colour, 9, 251)[1] = INFINITY;
    CHECK(survey(&s, 50, 40, &found, &error) == RF_ERROR_PIXEL);
    CHECK(strstr(error.message, "(9, 251)") != NULL);
    subject_free(&s);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(strips_of_any_height);
    TEST(every_kind_of_picture);
    TEST(films);
    TEST(leaning_stalks);
    TEST(windows_within_a_picture);
    TEST(highlights_of_the_whole);
    TEST(negative_colours_of_the_whole);
    TEST(surveys_of_any_windows);
    TEST(a_sharp_picture_is_copied);
    TEST(a_sharp_picture_that_glows);
    TEST(memory_is_as_announced);
    TEST(bad_windows_are_refused);
    TEST(other_methods_are_refused);
    TEST(the_parameter_that_is_refused_is_named);
    TEST(bad_pixels_are_named);
    return testing_end();
}
