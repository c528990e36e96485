/* SPDX-License-Identifier: Apache-2.0 */
/* A picture that is brighter by a power of two, with as much more white, becomes the
 * same, brighter: in all its bits. */
#include "physics/frames.h"
#include "testing.h"

enum { WIDTH = 96, HEIGHT = 72, N = WIDTH * HEIGHT, R_PX = 12, N_VIEWS = 2 };

static const float SCALES[] = {1 / 128.0f, 0.5f, 64};

/* What is filtered: `by` times as bright as drawn, but for alpha. */
struct subject {
    struct frame f;
    float behind[4 * N], behind_depth[N], light[3 * N], light_depth[N];
    struct rf_unseen_light lamp;
    struct rf_seen_light seen;
    struct rf_view views[N_VIEWS];
};

static void scale(float *samples, int channels, float by)
{
    for (int i = 0; i < N * channels; i++)
        samples[i] *= channels == 4 && i % 4 == 3 ? 1 : by;
}

static void draw(struct subject *s, int channels, float by)
{
    s->f = frame_make(WIDTH, HEIGHT, channels);
    frame_fill_scene(&s->f, R_PX);
    int lit = channels == 1 ? 1 : 3;
    for (int i = 0; i < N; i++) {
        s->behind_depth[i] = s->light_depth[i] = plain_depth(R_PX);
        for (int c = 0; c < channels; c++)
            s->behind[i * channels + c] = c == 3 ? 1 : (float)(i % 7) / 7;
        for (int c = 0; c < lit; c++)
            s->light[i * lit + c] = s->f.colour[i * channels + c] / 2;
    }
    scale(s->f.colour, channels, by);
    scale(s->behind, channels, by);
    scale(s->light, lit, by);
    s->lamp = (struct rf_unseen_light){
        -3, HEIGHT / 2, (double)plain_depth(R_PX), {900 * by, 700 * by, 500 * by, 1}};
    s->seen = (struct rf_seen_light){rf_image_packed(s->light, WIDTH, HEIGHT, lit),
                                     rf_image_packed(s->light_depth, WIDTH, HEIGHT, 1)};
    for (int j = 0; j < N_VIEWS; j++)
        s->views[j] = (struct rf_view){
            .size = sizeof(struct rf_view),
            .colour = rf_image_packed(s->f.colour, WIDTH, HEIGHT, channels),
            .depth = rf_image_packed(s->f.depth, WIDTH, HEIGHT, 1),
            .lens_offset = {20.0 * j, 0},
            .shear_distance = PLAIN_FOCUS};
}

/* What more there is than a picture; NULL: nothing. */
typedef void (*more_fn)(struct subject *s, struct rf_params *params, float by);

static void with_known(struct subject *s, struct rf_params *params, float by)
{
    s->views->behind_colour = rf_image_packed(s->behind, WIDTH, HEIGHT, s->f.channels);
    s->views->behind_depth = rf_image_packed(s->behind_depth, WIDTH, HEIGHT, 1);
    s->views->unseen_lights = &s->lamp;
    s->views->n_unseen_lights = 1;
}

static void with_mirror(struct subject *s, struct rf_params *params, float by)
{
    s->views->seen = &s->seen;
    s->views->n_seen = 1;
}

static void with_highlights(struct subject *s, struct rf_params *params, float by)
{
    params->highlight_clamp = 50 * (double)by;
    params->highlight_threshold = 0.5 * (double)by;
    params->highlight_gain = 3;
}

static void with_cells(struct subject *s, struct rf_params *params, float by)
{
    params->sub_apertures = 4;
    params->spherical = 2;
}

static struct rf_filter *make_filter(struct rf_context *context,
                                     const struct rf_params *params)
{
    struct rf_filter *filter;
    if (rf_filter_create(&filter, context, params, WIDTH, HEIGHT, NULL) != RF_OK)
        abort();
    return filter;
}

/* The picture of a subject, in s->f.out, with this white. */
static void run(struct subject *s, more_fn more, int n_views, float by, float white)
{
    struct rf_context *context;
    struct rf_params params;
    const struct rf_context_params how = {.size = sizeof how, .n_threads = 2};
    const struct rf_image out = rf_image_packed(s->f.out, WIDTH, HEIGHT, s->f.channels);
    scene_params(&params, n_views > 1 ? RF_METHOD_VIEWS : RF_METHOD_LAYERED);
    params.white = (double)white;
    if (more)
        more(s, &params, by);
    if (rf_context_create(&context, &how, NULL) != RF_OK)
        abort();
    struct rf_filter *filter = make_filter(context, &params);
    CHECK(rf_filter_process(filter, s->views, n_views, &out, NULL, NULL) == RF_OK);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

static bool are_alike(const struct subject *a, const struct subject *b)
{
    return memcmp(a->f.out, b->f.out, frame_bytes(&a->f)) == 0;
}

static void check_brightness(more_fn more, int channels, int n_views)
{
    static struct subject plain, bright;
    draw(&plain, channels, 1);
    run(&plain, more, n_views, 1, 1);
    for (int k = 0; k < 3; k++) {
        draw(&bright, channels, SCALES[k]);
        run(&bright, more, n_views, SCALES[k], SCALES[k] * 1.3f);
        scale(bright.f.out, channels, 1 / SCALES[k]);
        CHECK(are_alike(&plain, &bright));
        frame_free(&bright.f);
    }
    frame_free(&plain.f);
}

static void a_brighter_picture_is_the_same(void)
{
    static const more_fn more[] = {NULL, with_known, with_mirror, with_highlights,
                                   with_cells};
    for (int i = 0; i < 5; i++)
        for (int channels = 1; channels <= 4; channels += channels > 1 ? 1 : 2)
            check_brightness(more[i], channels, 1);
}

static void several_views_too(void)
{
    check_brightness(NULL, 3, N_VIEWS);
    check_brightness(with_highlights, 4, N_VIEWS);
}

/* Else nothing above would tell anything. */
static void lamps_are_told_by_white(void)
{
    static struct subject dark, known;
    draw(&dark, 3, SCALES[0]);
    draw(&known, 3, SCALES[0]);
    run(&dark, NULL, 1, 1, 1);
    run(&known, NULL, 1, 1, SCALES[0]);
    CHECK(!are_alike(&dark, &known));
    frame_free(&dark.f);
    frame_free(&known.f);
}

/* Half the picture, then the other. */
static void windows_have_the_same_bits(void)
{
    static struct subject s;
    struct rf_context *context;
    struct rf_params params;
    struct rf_survey survey = {.size = sizeof survey};
    const struct rf_window whole = {0, 0, WIDTH, HEIGHT};
    draw(&s, 3, SCALES[0]);
    s.views->lens_offset[0] = s.views->shear_distance = 0;
    run(&s, NULL, 1, 1, SCALES[0]);
    float *part = malloc(frame_bytes(&s.f));
    scene_params(&params, RF_METHOD_LAYERED);
    params.white = (double)SCALES[0];
    if (!part || rf_context_create(&context, NULL, NULL) != RF_OK)
        abort();
    struct rf_filter *filter = make_filter(context, &params);
    CHECK(rf_filter_survey(filter, s.views, &whole, &whole, &survey, NULL) == RF_OK);
    for (int x = 0; x < WIDTH; x += WIDTH / 2) {
        const struct rf_window kept = {x, 0, WIDTH / 2, HEIGHT};
        struct rf_window given;
        struct rf_image out = rf_image_packed(part + 3 * x, WIDTH, HEIGHT, 3);
        struct rf_view view = s.views[0];
        out.width = kept.width;
        REQUIRE(rf_filter_window(filter, &survey, 1, &kept, &given, NULL) == RF_OK);
        view.colour.data = (float *)view.colour.data + 3 * (given.y * WIDTH + given.x);
        view.depth.data = (float *)view.depth.data + given.y * WIDTH + given.x;
        view.colour.width = view.depth.width = given.width;
        view.colour.height = view.depth.height = given.height;
        CHECK(rf_filter_process_window(filter, &survey, &view, 1, &given, &kept, &out,
                                       NULL, NULL) == RF_OK);
    }
    CHECK(memcmp(part, s.f.out, frame_bytes(&s.f)) == 0);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    free(part);
    frame_free(&s.f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(a_brighter_picture_is_the_same);
    TEST(several_views_too);
    TEST(lamps_are_told_by_white);
    TEST(windows_have_the_same_bits);
    return testing_end();
}
