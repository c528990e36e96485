/* SPDX-License-Identifier: Apache-2.0 */
/* Windows of several views have the bits of the whole picture. */
#include <stdio.h>

#include "physics/frames.h"
#include "testing.h"

enum { MOST_VIEWS = 13 };

struct setting {
    const char *key, *value;
};

/* A scene from some points of the lens, and what the method makes of it as a whole. */
struct subject {
    int n_views;
    struct frame f[MOST_VIEWS];
    struct rf_view views[MOST_VIEWS]; /* all their pixels */
    struct rf_survey surveys[MOST_VIEWS];
    struct rf_context *context;
    struct rf_filter *filter;
};

static int most(int a, int b)
{
    return a > b ? a : b;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* What a point of the unit lens sees of a frame: its pixels moved by their radius. */
static void look_from(const struct frame *base, const double lens[2], double max_radius,
                      struct frame *view)
{
    int w = base->width, h = base->height;
    size_t pixel = (size_t)base->channels * sizeof(float);
    memcpy(view->colour, base->colour, frame_bytes(base));
    memcpy(view->depth, base->depth, frame_pixels(base) * sizeof(float));
    for (int near = 0; near < 2; near++) /* what is far first */
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++) {
                float z = base->depth[y * w + x];
                double r = fmin(400 - 40000.0 / z, max_radius);
                int to_x = x + (int)floor(lens[0] * r + 0.5);
                int to_y = y - (int)floor(lens[1] * r + 0.5);
                if ((r < 0) != near || to_x < 0 || to_y < 0 || to_x >= w || to_y >= h)
                    continue;
                memcpy(frame_at(view, view->colour, to_x, to_y),
                       frame_at(base, base->colour, x, y), pixel);
                view->depth[to_y * w + to_x] = z;
            }
}

static struct rf_image cut(const struct rf_image *image, const struct rf_window *w)
{
    struct rf_image part = *image;
    part.data = (char *)image->data + w->y * image->row_bytes +
                w->x * (ptrdiff_t)image->pixel_bytes;
    part.width = w->width;
    part.height = w->height;
    return part;
}

static struct rf_view cut_view(const struct rf_view *view, const struct rf_window *w)
{
    struct rf_view part = *view;
    part.colour = cut(&view->colour, w);
    part.depth = cut(&view->depth, w);
    return part;
}

/* Counts view j in strips. */
static rf_result survey(struct subject *s, int j, int height, struct rf_error *error)
{
    const struct frame *f = &s->f[j];
    struct rf_survey *found = &s->surveys[j];
    *found = (struct rf_survey){.size = sizeof *found};
    rf_result result = RF_OK;
    for (int y = 0; y < f->height && result == RF_OK; y += height) {
        struct rf_window counted = {0, y, f->width, least(height, f->height - y)};
        int y0 = most(y - RF_SURVEY_MARGIN, 0);
        int y1 = least(y + counted.height + RF_SURVEY_MARGIN, f->height);
        struct rf_window given = {0, y0, f->width, y1 - y0};
        struct rf_view view = cut_view(&s->views[j], &given);
        result = rf_filter_survey(s->filter, &view, &given, &counted, found, error);
    }
    return result;
}

static struct rf_params params_of(double r_px, const struct setting *settings)
{
    struct rf_params params;
    scene_params(&params, RF_METHOD_VIEWS);
    params.max_radius = r_px;
    for (; settings && settings->key; settings++)
        if (rf_params_set(&params, settings->key, settings->value, NULL) != RF_OK)
            abort();
    return params;
}

static struct subject subject_make(int n_views, int width, int height, int channels,
                                   double r_px, const struct setting *settings)
{
    struct subject s = {.n_views = n_views};
    struct rf_context_params run = {.size = sizeof run, .n_threads = 2};
    struct rf_params params = params_of(r_px, settings);
    struct frame base = frame_make(width, height, channels);
    frame_fill_scene(&base, r_px);
    for (int j = 0; j < n_views; j++) {
        double radius = sqrt((j + 0.5) / n_views), angle = 2.39996 * j;
        double lens[2] = {radius * cos(angle), radius * sin(angle)};
        s.f[j] = frame_make(width, height, channels);
        look_from(&base, lens, r_px, &s.f[j]);
        s.views[j] = (struct rf_view){
            .colour = rf_image_packed(s.f[j].colour, width, height, channels),
            .depth = rf_image_packed(s.f[j].depth, width, height, 1),
            .lens_offset = {40 * lens[0], 40 * lens[1]},
            .shear_distance = PLAIN_FOCUS};
    }
    frame_free(&base);
    if (rf_context_create(&s.context, &run, NULL) != RF_OK ||
        rf_filter_create(&s.filter, s.context, &params, width, height, NULL) != RF_OK)
        abort();
    struct rf_image out = rf_image_packed(s.f[0].out, width, height, channels);
    CHECK(rf_filter_process(s.filter, s.views, n_views, &out, NULL, NULL) == RF_OK);
    for (int j = 0; j < n_views; j++)
        CHECK(survey(&s, j, 100, NULL) == RF_OK);
    return s;
}

static void subject_free(struct subject *s)
{
    rf_filter_destroy(s->filter);
    rf_context_destroy(s->context);
    for (int j = 0; j < s->n_views; j++)
        frame_free(&s->f[j]);
}

/* Filters a window by `filter` to `part`; *given receives what it needed. */
static rf_result process(const struct subject *s, const struct rf_filter *filter,
                         const struct rf_window *kept, struct frame *part,
                         struct rf_window *given, struct rf_error *error)
{
    struct rf_view views[MOST_VIEWS];
    rf_result result =
        rf_filter_window(filter, s->surveys, s->n_views, kept, given, error);
    if (result != RF_OK)
        return result;
    for (int j = 0; j < s->n_views; j++)
        views[j] = cut_view(&s->views[j], given);
    struct rf_image out =
        rf_image_packed(part->out, kept->width, kept->height, part->channels);
    return rf_filter_process_window(filter, s->surveys, views, s->n_views, given, kept,
                                    &out, NULL, error);
}

/* Pixels of a window that differ from the whole picture's. */
static size_t n_different(const struct subject *s, const struct rf_window *kept,
                          struct rf_window *given)
{
    const struct frame *f = &s->f[0];
    struct rf_error error = {0};
    struct frame part = frame_make(kept->width, kept->height, f->channels);
    size_t n = SIZE_MAX;
    if (process(s, s->filter, kept, &part, given, &error) == RF_OK)
        n = frame_count_different(f, &part, kept->x, kept->y);
    else
        fprintf(stderr, "# %s\n", error.message);
    frame_free(&part);
    return n;
}

/* Strips of a height, of which not all may be the whole picture. */
static void check_strips(const struct subject *s, int height)
{
    const struct frame *f = &s->f[0];
    bool is_smaller = false;
    for (int y = 0; y < f->height; y += height) {
        struct rf_window given, kept = {0, y, f->width, least(height, f->height - y)};
        CHECK(n_different(s, &kept, &given) == 0);
        is_smaller |= given.height < f->height;
    }
    CHECK(is_smaller);
}

/* Cells, shared or not, all views as one, refocused, with lamps and without, one view. */
static void every_kind_of_picture(void)
{
    static const struct {
        int n_views, width, height, channels, strip;
        double r_px;
        struct setting settings[4];
    } kinds[] = {
        {1, 60, 601, 3, 200, 3, {{NULL, NULL}}},
        {2, 91, 601, 3, 333, 3, {{NULL, NULL}}},
        {8, 61, 603, 3, 300, 4, {{"blades", "5"}, {NULL, NULL}}},
        {13, 62, 603, 3, 300, 4, {{NULL, NULL}}},
        {12, 63, 601, 3, 301, 7, {{NULL, NULL}}},
        {5, 70, 607, 4, 301, 3, {{"focus-distance", "98.8"}, {NULL, NULL}}},
        {4, 71, 601, 3, 301, 6, {{"lens-radius", "11"}, {"sub-apertures", "2"}}},
        {3, 69, 603, 1, 300, 4, {{"exact-highlights", "0"}, {"quality", "normal"}}},
        {4, 80, 601, 3, 250, 4, {{"fill-hidden", "0"}, {"aperture-ratio", "1.4"}}},
    };
    for (size_t i = 0; i < sizeof kinds / sizeof kinds[0]; i++) {
        struct subject s =
            subject_make(kinds[i].n_views, kinds[i].width, kinds[i].height,
                         kinds[i].channels, kinds[i].r_px, kinds[i].settings);
        check_strips(&s, kinds[i].strip);
        subject_free(&s);
    }
}

/* Cut off on all sides, with radii that are spread at less resolution. */
static void windows_within_a_picture(void)
{
    static const struct rf_window windows[] = {
        {330, 290, 65, 31}, {0, 530, 90, 77}, {650, 0, 1, 1}};
    struct subject s = subject_make(3, 703, 607, 3, 16, NULL);
    for (size_t i = 0; i < sizeof windows / sizeof windows[0]; i++) {
        struct rf_window given;
        CHECK(n_different(&s, &windows[i], &given) == 0);
        CHECK(given.width < s.f[0].width || given.height < s.f[0].height);
    }
    subject_free(&s);
}

/*
 * Views that move a plane by 2.3 px, which as a sum with the pixel's centre lies where
 * one sub-pixel phase ends: which one it is must not depend on where pixels are counted
 * from.
 */
static void places_do_not_depend_on_the_window(void)
{
    static const struct setting stopped[] = {{"lens-radius", "11"}, {NULL, NULL}};
    struct subject s = subject_make(3, 70, 701, 3, 4, stopped);
    for (int j = 0; j < s.n_views; j++) {
        for (size_t i = 0; i < frame_pixels(&s.f[j]); i++)
            s.f[j].depth[i] = plain_depth(4);
        s.views[j].lens_offset[0] = s.views[j].lens_offset[1] = 23 * (j - 1);
        CHECK(survey(&s, j, 100, NULL) == RF_OK);
    }
    struct rf_image out = rf_image_packed(s.f[0].out, 70, 701, 3);
    CHECK(rf_filter_process(s.filter, s.views, s.n_views, &out, NULL, NULL) == RF_OK);
    check_strips(&s, 250);
    subject_free(&s);
}

/* What was said to be needed is enough, and a sixth of it is not. */
static void memory_is_as_announced(void)
{
    static const int counts[] = {2, 4, 8, MOST_VIEWS};
    for (int k = 0; k < 4; k++) {
        int n_views = counts[k];
        struct subject s = subject_make(n_views, 500, 400, 3, 3, NULL);
        struct rf_window kept = {150, 150, 200, 100}, given;
        REQUIRE(rf_filter_window(s.filter, s.surveys, n_views, &kept, &given, NULL) ==
                RF_OK);
        size_t n_bytes = rf_window_bytes(s.filter, s.surveys, n_views, &given);
        for (int i = 0; i < 2; i++) {
            struct rf_context_params run = {.size = sizeof run,
                                            .n_threads = 2,
                                            .max_bytes = i ? n_bytes / 6 : n_bytes};
            struct rf_params params = params_of(3, NULL);
            struct rf_context *context;
            struct rf_filter *filter;
            struct frame part = frame_make(kept.width, kept.height, 3);
            REQUIRE(rf_context_create(&context, &run, NULL) == RF_OK);
            REQUIRE(rf_filter_create(&filter, context, &params, 500, 400, NULL) ==
                    RF_OK);
            rf_result result = process(&s, filter, &kept, &part, &given, NULL);
            CHECK(result == (i ? RF_ERROR_MEMORY : RF_OK));
            frame_free(&part);
            rf_filter_destroy(filter);
            rf_context_destroy(context);
        }
        subject_free(&s);
    }
}

static void views_that_were_not_surveyed_are_refused(void)
{
    struct subject s = subject_make(2, 300, 400, 3, 2, NULL);
    struct rf_window kept = {0, 0, 300, 50}, given;
    struct frame part = frame_make(300, 50, 3);
    struct rf_error error;
    s.views[1].lens_offset[1] += 1e-9;
    CHECK(process(&s, s.filter, &kept, &part, &given, &error) == RF_ERROR_ARGUMENT);
    CHECK(strcmp(error.field, "lens_offset") == 0);
    s.views[1].lens_offset[1] = s.surveys[1].lens_offset[1];
    CHECK(process(&s, s.filter, &kept, &part, &given, &error) == RF_OK);
    s.surveys[1].n_pixels--;
    CHECK(process(&s, s.filter, &kept, &part, &given, &error) == RF_ERROR_ARGUMENT);
    CHECK(rf_filter_window(s.filter, s.surveys, RF_MAX_VIEWS + 1, &kept, &given,
                           &error) == RF_ERROR_ARGUMENT);
    CHECK(strcmp(error.field, "n_views") == 0);
    frame_free(&part);
    subject_free(&s);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(every_kind_of_picture);
    TEST(windows_within_a_picture);
    TEST(places_do_not_depend_on_the_window);
    TEST(memory_is_as_announced);
    TEST(views_that_were_not_surveyed_are_refused);
    return testing_end();
}
