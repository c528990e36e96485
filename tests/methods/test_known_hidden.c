/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rf_view.behind_colour: what the caller knows to lie behind things takes the place of
 * what would be estimated, lamps included, and nothing else changes.
 * rf_view.unseen_lights: lamps behind things and beyond the border shine into the
 * picture as far as the lens sees them.
 */
#include "physics/frames.h"
#include "testing.h"

enum { SIZE = 64, BAR_LEFT = 28, BAR_END = 36, BAR_RADIUS = -12, N_CHANNELS = 3 };

/* A bar before the focus and a pattern of single pixels that is in focus, or behind it
 * by `far_px`; `behind` has what the bar hides. */
struct scene {
    struct frame f;
    float behind[SIZE * SIZE * N_CHANNELS], behind_depth[SIZE * SIZE];
    struct rf_unseen_light light;
    bool has_light;
};

static void fill(struct scene *s, double far_px)
{
    uint32_t state = 7;
    s->f = frame_make(SIZE, SIZE, N_CHANNELS);
    s->has_light = false;
    for (int i = 0; i < SIZE * SIZE; i++) {
        bool is_bar = i % SIZE >= BAR_LEFT && i % SIZE < BAR_END;
        float grey = (float)random_unit(&state);
        s->f.depth[i] = is_bar ? plain_depth(BAR_RADIUS) : plain_depth(far_px);
        s->behind_depth[i] = is_bar ? plain_depth(far_px) : NAN;
        for (int c = 0; c < N_CHANNELS; c++) {
            s->behind[i * N_CHANNELS + c] = grey;
            s->f.colour[i * N_CHANNELS + c] = is_bar ? 0.2f : grey;
        }
    }
}

static rf_result run(struct scene *s, bool is_known, int n_threads)
{
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    const struct rf_context_params how = {.size = sizeof how, .n_threads = n_threads};
    struct rf_view view = {.colour =
                               rf_image_packed(s->f.colour, SIZE, SIZE, N_CHANNELS),
                           .depth = rf_image_packed(s->f.depth, SIZE, SIZE, 1)};
    const struct rf_image out = rf_image_packed(s->f.out, SIZE, SIZE, N_CHANNELS);
    if (is_known) {
        view.behind_colour = rf_image_packed(s->behind, SIZE, SIZE, N_CHANNELS);
        view.behind_depth = rf_image_packed(s->behind_depth, SIZE, SIZE, 1);
    }
    if (s->has_light) {
        view.size = sizeof view;
        view.unseen_lights = &s->light;
        view.n_unseen_lights = 1;
    }
    plain_params(&params, RF_METHOD_LAYERED);
    if (rf_context_create(&context, &how, NULL) != RF_OK ||
        rf_filter_create(&filter, context, &params, SIZE, SIZE, NULL) != RF_OK)
        abort();
    rf_result result = rf_filter_process(filter, &view, 1, &out, NULL, NULL);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    return result;
}

/* Green of what the lens sees of the pattern in focus, through and beside the bar. */
static double truth(const struct scene *s, int x, int y)
{
    double open = 0, all = 0;
    for (int v = -24; v <= 24; v++)
        for (int u = -24; u <= 24; u++) {
            double at = x + 0.5 + u / 24.0 * BAR_RADIUS;
            if (u * u + v * v > 24 * 24)
                continue;
            all++;
            open += !(at >= BAR_LEFT && at < BAR_END);
        }
    open /= all;
    return open * (double)s->behind[(y * SIZE + x) * N_CHANNELS + 1] +
           (1 - open) * (double)0.2f;
}

/* Mean squared error where the bar is, away from the border. */
static double error_of(const struct scene *s)
{
    double sum = 0;
    int n = 0;
    for (int y = 16; y < SIZE - 16; y++)
        for (int x = BAR_LEFT; x < BAR_END; x++, n++) {
            double d = (double)s->f.out[(y * SIZE + x) * N_CHANNELS + 1];
            d -= truth(s, x, y);
            sum += d * d;
        }
    return sum / n;
}

static void known_surfaces_are_seen(void)
{
    struct scene s;
    fill(&s, 0);
    REQUIRE(run(&s, false, 1) == RF_OK);
    double guessed = error_of(&s);
    REQUIRE(run(&s, true, 1) == RF_OK);
    double known = error_of(&s);
    printf("# mean squared error %.5f, known %.5f\n", guessed, known);
    CHECK(known < guessed / 10);
    frame_free(&s.f);
}

static void nothing_known_changes_nothing(void)
{
    struct scene s;
    fill(&s, 6);
    REQUIRE(run(&s, false, 2) == RF_OK);
    float *alone = malloc(frame_bytes(&s.f));
    REQUIRE(alone != NULL);
    memcpy(alone, s.f.out, frame_bytes(&s.f));
    for (int i = 0; i < SIZE * SIZE; i++)
        s.behind_depth[i] = i % 2 ? NAN : 0;
    REQUIRE(run(&s, true, 2) == RF_OK);
    CHECK(memcmp(alone, s.f.out, frame_bytes(&s.f)) == 0);
    /* What is said to lie before the bar is not behind it. */
    for (int i = 0; i < SIZE * SIZE; i++)
        s.behind_depth[i] = plain_depth(2 * BAR_RADIUS);
    REQUIRE(run(&s, true, 2) == RF_OK);
    CHECK(memcmp(alone, s.f.out, frame_bytes(&s.f)) == 0);
    free(alone);
    frame_free(&s.f);
}

static void bits_are_those_of_every_thread_count(void)
{
    struct scene s;
    fill(&s, 6);
    s.behind[(32 * SIZE + 32) * N_CHANNELS] = 100; /* a lamp, too */
    REQUIRE(run(&s, true, 1) == RF_OK);
    float *alone = malloc(frame_bytes(&s.f));
    REQUIRE(alone != NULL);
    memcpy(alone, s.f.out, frame_bytes(&s.f));
    REQUIRE(run(&s, true, 5) == RF_OK);
    CHECK(memcmp(alone, s.f.out, frame_bytes(&s.f)) == 0);
    free(alone);
    frame_free(&s.f);
}

static double sum_of(const struct scene *s)
{
    double sum = 0;
    for (size_t i = 0; i < SIZE * SIZE; i++)
        sum += (double)s->f.out[i * N_CHANNELS + 1];
    return sum;
}

/* A bar of 8 px at radius -12 lets most of a lamp behind it through. */
static void hidden_lamps_shine(void)
{
    struct scene s;
    fill(&s, 6);
    for (int i = 0; i < SIZE * SIZE * N_CHANNELS; i++)
        s.behind[i] *= 0.2f;
    for (int i = 0; i < SIZE * SIZE; i++)
        for (int c = 0; c < N_CHANNELS && (i % SIZE < BAR_LEFT || i % SIZE >= BAR_END);
             c++)
            s.f.colour[i * N_CHANNELS + c] = s.behind[i * N_CHANNELS + c];
    REQUIRE(run(&s, true, 1) == RF_OK);
    double dark = sum_of(&s);
    for (int c = 0; c < N_CHANNELS; c++)
        s.behind[(32 * SIZE + 32) * N_CHANNELS + c] = 500;
    REQUIRE(run(&s, true, 1) == RF_OK);
    double shown = (sum_of(&s) - dark) / 500;
    /* Rays to the lamp pass the bar at u (6 + 12) px from it: dark where that is less
     * than 4 px, a band of half width 4 / 18 of the disc. */
    double half = 4.0 / 18,
           hidden = 2 / 3.14159265 * (half * sqrt(1 - half * half) + asin(half));
    printf("# %.3f of the lamp, %.3f expected\n", shown, 1 - hidden);
    CHECK_NEAR(shown, 1 - hidden, 0.1);
    frame_free(&s.f);
}

static struct rf_unseen_light white_light(double x, double y, double radius_px)
{
    return (struct rf_unseen_light){
        .x = x, .y = y, .depth = plain_depth(radius_px), .colour = {500, 500, 500}};
}

/* How much of a light of 500 is in the picture. */
static double shown_of(struct scene *s, bool is_known)
{
    s->has_light = false;
    rf_result dark_result = run(s, is_known, 1);
    double dark = sum_of(s);
    s->has_light = true;
    if (dark_result != RF_OK || run(s, is_known, 1) != RF_OK)
        return NAN;
    return (sum_of(s) - dark) / 500;
}

/* Of a disc of radius 6 whose middle is 2.5 px outside a segment is inside. */
static void lights_beyond_the_border_shine(void)
{
    struct scene s;
    const double outside = 2.5 / 6;
    fill(&s, 6);
    s.light = white_light(-2.3, 32.1, 6);
    double shown = shown_of(&s, false);
    double expected =
        (acos(outside) - outside * sqrt(1 - outside * outside)) / 3.14159265;
    printf("# %.3f of the light, %.3f expected\n", shown, expected);
    CHECK_NEAR(shown, expected, 0.03);
    s.light = white_light(-14.5, 32.5, 6);
    CHECK(shown_of(&s, false) == 0);
    s.light = white_light(64e6, -1e300, 6);
    CHECK(shown_of(&s, false) == 0);
    frame_free(&s.f);
}

/* Behind a bar most of a light is seen past it; where nothing hides it, the picture
 * shows it itself. */
static void hidden_lights_shine(void)
{
    struct scene s;
    fill(&s, 6);
    s.light = white_light(32.5, 32.5, 6);
    double half = 4.0 / 18,
           hidden = 2 / 3.14159265 * (half * sqrt(1 - half * half) + asin(half));
    CHECK_NEAR(shown_of(&s, false), 1 - hidden, 0.1);
    s.light = white_light(12.5, 32.5, 6);
    CHECK(shown_of(&s, false) == 0);
    frame_free(&s.f);
}

/* A surface in focus goes on behind the bar and hides the light behind both, whether that
 * is known or estimated; where nothing is known to be there, the light passes. */
static void hidden_surfaces_hide_lights(void)
{
    struct scene s;
    fill(&s, 0);
    s.f.depth[0] = plain_depth(6); /* so far may radii go */
    s.light = white_light(32.5, 32.5, 6);
    double estimated = shown_of(&s, false), known = shown_of(&s, true);
    for (int i = 0; i < SIZE * SIZE; i++)
        if (!isnan(s.behind_depth[i]))
            s.behind_depth[i] = plain_depth(6);
    double through = shown_of(&s, true);
    printf(
        "# %.3f of the light, %.3f past what is known, %.3f past what is estimated\n",
        through, known, estimated);
    CHECK(through > 0.1);
    CHECK(known < 0.01);
    CHECK(estimated < 0.01);
    frame_free(&s.f);
}

static void wrong_lights_are_refused(void)
{
    const struct rf_unseen_light good = white_light(32.5, 32.5, 6);
    struct rf_unseen_light wrong[] = {good, good, good, good};
    struct scene s;
    fill(&s, 6);
    s.has_light = true;
    wrong[0].x = NAN;
    wrong[1].y = INFINITY;
    wrong[2].depth = 0;
    wrong[3].colour[2] = NAN;
    for (int i = 0; i < 4; i++) {
        s.light = wrong[i];
        CHECK(run(&s, false, 1) == RF_ERROR_ARGUMENT);
    }
    s.light = good;
    s.light.depth = INFINITY;
    CHECK(run(&s, false, 1) == RF_OK);
    frame_free(&s.f);
}

static void wrong_shapes_are_refused(void)
{
    struct frame f = frame_make(8, 8, 3);
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_params params;
    struct rf_error error;
    const struct rf_image out = rf_image_packed(f.out, 8, 8, 3);
    struct rf_view view = {.colour = rf_image_packed(f.colour, 8, 8, 3),
                           .depth = rf_image_packed(f.depth, 8, 8, 1),
                           .behind_colour = rf_image_packed(f.colour, 8, 8, 1),
                           .behind_depth = rf_image_packed(f.depth, 8, 8, 1)};
    plain_params(&params, RF_METHOD_LAYERED);
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, 8, 8, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "behind_colour");
    view.behind_colour = view.colour;
    view.behind_depth.data = NULL;
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "behind_depth");
    view.behind_depth = rf_image_packed(f.depth, 7, 8, 1);
    CHECK(rf_filter_process(filter, &view, 1, &out, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "behind_depth");
    view.behind_depth = view.depth;
    struct rf_survey survey = {.size = sizeof survey};
    const struct rf_window whole = {0, 0, 8, 8};
    CHECK(rf_filter_survey(filter, &view, &whole, &whole, &survey, &error) ==
          RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "behind_colour");
    const struct rf_unseen_light light = white_light(4.5, 4.5, 6);
    struct rf_view lit = {.size = sizeof lit,
                          .colour = view.colour,
                          .depth = view.depth,
                          .unseen_lights = &light,
                          .n_unseen_lights = 1};
    CHECK(rf_filter_survey(filter, &lit, &whole, &whole, &survey, &error) ==
          RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "unseen_lights");
    lit.unseen_lights = NULL;
    CHECK(rf_filter_process(filter, &lit, 1, &out, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "unseen_lights");
    CHECK(rf_filter_process_window(filter, &survey, &view, 1, &whole, &whole, &out,
                                   NULL, &error) == RF_ERROR_ARGUMENT);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    frame_free(&f);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(known_surfaces_are_seen);
    TEST(nothing_known_changes_nothing);
    TEST(bits_are_those_of_every_thread_count);
    TEST(hidden_lamps_shine);
    TEST(lights_beyond_the_border_shine);
    TEST(hidden_lights_shine);
    TEST(hidden_surfaces_hide_lights);
    TEST(wrong_lights_are_refused);
    TEST(wrong_shapes_are_refused);
    return testing_end();
}
