/* SPDX-License-Identifier: Apache-2.0 */
/* What the user sets, and what follows from it. */
#include "model/state.h"
#include "sources/looks.h"
#include "testing.h"

/* A header that gives the lens by its radius, as POV-Ray's passes do. */
static bool resolve(void *user, const struct settings *typed, struct settings *settings,
                    struct rf_params *params, char *text, size_t n_bytes)
{
    (void)text;
    (void)n_bytes;
    *settings = *typed;
    settings_set_header(settings, "focus-distance", 8, "(test)", NULL);
    if (user)
        settings_set_header(settings, "lens-radius", 0.1, "(test)", NULL);
    *params = settings->params;
    return true;
}

static struct state open(void *user)
{
    struct state state;
    struct settings typed;
    const struct resolver resolver = {resolve, user};
    settings_init(&typed);
    state_init(&state, &typed, 0);
    state_open(&state, &resolver, 480, 270, 1);
    return state;
}

static void the_header_is_taken(void)
{
    const struct state state = open(NULL);
    CHECK(state.is_valid);
    CHECK(state.settings.params.focus_distance == 8);
    CHECK(state.lens.focus_distance == 8);
    CHECK(settings_origin(&state.typed, "focus-distance") == ORIGIN_DEFAULT);
}

static void what_is_set_counts_as_typed(void)
{
    struct state state = open(NULL);
    const uint64_t before = state.id;
    CHECK(state_set(&state, "f-stop", 1.4));
    CHECK(state.id > before);
    CHECK(state.params.f_stop == 1.4);
    CHECK(settings_origin(&state.typed, "f-stop") == ORIGIN_COMMAND_LINE);
    CHECK(state_set(&state, "method", RF_METHOD_SCATTER));
    CHECK(state.params.method == RF_METHOD_SCATTER);
    CHECK(state_set(&state, "blades", 6) && state.params.blades == 6);
}

static void what_makes_no_lens_changes_nothing(void)
{
    struct state state = open(NULL);
    CHECK(state_set(&state, "optics", RF_OPTICS_YU));
    const uint64_t before = state.id;
    CHECK(!state_focus(&state, 0.01)); /* inside 50 mm */
    CHECK(state.id == before);
    CHECK_NEAR(state.lens.focus_distance, 8, 1e-12);
    CHECK(strstr(state.problem, "focal length") != NULL);
    CHECK(!state_set(&state, "blades", 2));
    CHECK(state.params.blades == 0);
    CHECK(state_set(&state, "f-stop", 4));
    CHECK(state.problem[0] == 0);
}

/* Yu 2004: s = f d / (d - f). */
static void the_screen_follows_the_focus(void)
{
    struct state state = open(NULL);
    const double f = 0.05;
    for (int yu = 0; yu < 2; yu++) {
        state_set(&state, "optics", yu ? RF_OPTICS_YU : RF_OPTICS_CAMERA);
        for (double d = 0.5; d < 20; d *= 1.7) {
            state_focus(&state, d);
            const double kept = state.lens.focus_distance;
            CHECK_NEAR(kept, d, 1e-5 * d);
            CHECK_NEAR(state_screen(&state), f * kept / (kept - f), 1e-12);
        }
    }
    CHECK(state_set_screen(&state, 0.0526315789473684));
    CHECK_NEAR(state.lens.focus_distance, 1, 1e-5);
    CHECK(!state_set_screen(&state, 0.05));
    CHECK_NEAR(state.lens.focus_distance, 1, 1e-5);
}

static void infinity_can_be_in_focus(void)
{
    struct state state = open(NULL);
    CHECK(state_focus(&state, INFINITY));
    CHECK(fabs(rf_lens_radius_px(&state.lens, INFINITY)) < 1e-3);
}

static void the_f_stop_of_a_radius_is_shown(void)
{
    int yes;
    struct state state = open(&yes);
    CHECK(state_set(&state, "focal-length", 50));
    CHECK_NEAR(state_f_stop(&state), 0.05 / 0.2, 1e-12);
    CHECK(state_set(&state, "lens-radius", 0.01));
    CHECK_NEAR(state_f_stop(&state), 2.5, 1e-12);
    state = open(NULL);
    CHECK(state_f_stop(&state) == 2.8);
}

/* A focal length that nobody gave is no reason to show an f-stop. */
static void without_millimetres_nothing_is_invented(void)
{
    int yes;
    struct state state = open(&yes);
    CHECK(isnan(state_f_stop(&state)) && isnan(state_screen(&state)));
    const char *const keys[] = {"f-stop", "unit-scale"};
    for (int i = 0; i < 2; i++) {
        const char *why = state_why_off(&state, keys[i]);
        CHECK(why && strstr(why, "set the lens radius"));
    }
    CHECK(!state_why_off(&state, "lens-radius"));
    CHECK(!state_is_guess(&state, "f-stop"));
    state = open(NULL);
    CHECK(!state_why_off(&state, "f-stop") && !state_why_off(&state, "unit-scale"));
}

static void what_is_not_read_says_why(void)
{
    struct state state = open(NULL);
    CHECK(!state_why_off(&state, "blades"));
    CHECK(strstr(state_why_off(&state, "copies"), "offset"));
    state_set(&state, "method", RF_METHOD_BOX);
    CHECK(state_why_off(&state, "blades") != NULL);
    CHECK(strstr(state_why_off(&state, "slices"), "blend slices"));
    state_set(&state, "blend", RF_BLEND_SLICES);
    CHECK(!state_why_off(&state, "slices"));
}

static void a_guess_is_what_nobody_gave(void)
{
    struct state state = open(NULL);
    CHECK(state_is_guess(&state, "f-stop") && state_is_guess(&state, "focal-length"));
    CHECK(!state_is_guess(&state, "focus-distance")); /* the header gives it */
    CHECK(!state_is_guess(&state, "blades"));
    state_set(&state, "f-stop", 4);
    CHECK(!state_is_guess(&state, "f-stop"));
}

static void the_last_of_two_that_say_the_same_counts(void)
{
    struct state state = open(NULL);
    CHECK(state_set(&state, "lens-radius", 0.01));
    CHECK(state_set(&state, "f-stop", 5));
    CHECK_NEAR(state.lens.lens_radius, 0.005, 1e-12);
    CHECK(state_set(&state, "lens-radius", 0.02));
    CHECK_NEAR(state.lens.lens_radius, 0.02, 1e-12);
}

static void reset_goes_back_to_what_was_given(void)
{
    struct state state = open(NULL);
    state_set(&state, "focus-distance", 3);
    CHECK(state_reset(&state, "focus-distance"));
    CHECK(state.lens.focus_distance == 8); /* the header's */
    state_set(&state, "lens-radius", 0.02);
    CHECK(state_reset(&state, "f-stop")); /* the radius says the same */
    CHECK(state.params.f_stop == 2.8 && state.params.lens_radius == 0);
    struct settings typed;
    settings_init(&typed);
    settings_set(&typed, "blades", "7", NULL);
    const struct resolver resolver = state.resolver;
    state_init(&state, &typed, 0);
    state_open(&state, &resolver, 480, 270, 1);
    state_set(&state, "blades", 5);
    CHECK(state_reset(&state, "blades") && state.params.blades == 7);
}

static void a_look_is_taken_and_comes_back(void)
{
    static struct look before, again;
    struct state state = open(NULL);
    state_set(&state, "f-stop", 4);
    state_set_exposure(&state, 1);
    state_look(&state, &before);
    CHECK(state_set_look(&state, "bubble") && state.params.spherical != 0);
    CHECK(state.params.f_stop == 4);
    CHECK(!state_set_look(&state, "nosuch") && strstr(state.problem, "nosuch"));
    state_set_exposure(&state, 2);
    CHECK(state_apply(&state, &before));
    CHECK(state.params.spherical == 0 && state.exposure == 1);
    state_look(&state, &again);
    CHECK(memcmp(&before, &again, sizeof(before)) == 0);
}

/* What --look would set, and nothing of the look before. */
static void a_look_takes_the_place_of_another(void)
{
    struct state state = open(NULL);
    CHECK(state_set_look(&state, "vintage") && state.params.swirl == 0.35);
    CHECK(state_setter(&state, "swirl") == SETTER_LOOK);
    CHECK(state_set_look(&state, "bubble"));
    CHECK(state.params.spherical == 3 && state.params.cat_eye == 0.4);
    CHECK(state.params.swirl == 0 && state.params.astigmatism == 0);
    CHECK_STR(state.setters.look, "bubble");
    CHECK(state_setter(&state, "swirl") == SETTER_COMMAND_LINE);
    CHECK(state_set_look(&state, ""));
    CHECK(state.params.spherical == 0 && state.params.cat_eye == 0);
    CHECK_STR(state.setters.look, "");
    CHECK(settings_origin(&state.typed, "cat-eye") == ORIGIN_DEFAULT);
}

/* What the user set since the look stays, what was set before it comes back. */
static void a_look_leaves_what_is_the_user_s(void)
{
    static struct look before, again;
    struct state state = open(NULL);
    state_set(&state, "cat-eye", 0.9);
    state_set_look(&state, "vintage");
    CHECK(state.params.cat_eye == 0.6 &&
          state_setter(&state, "cat-eye") == SETTER_LOOK);
    state_set(&state, "swirl", 0.1);
    CHECK(state_setter(&state, "swirl") == SETTER_USER);
    state_look(&state, &before);
    state_set_look(&state, "miniature");
    CHECK(state.params.cat_eye == 0.9 && state.params.swirl == 0.1);
    CHECK(state_setter(&state, "cat-eye") == SETTER_USER);
    CHECK(state.params.astigmatism == 0 && state.params.tilt_y == 8);
    CHECK(state_reset(&state, "cat-eye") && state.params.cat_eye == 0);
    CHECK(state_setter(&state, "cat-eye") == SETTER_COMMAND_LINE);
    /* One step back is the other look, with all that belongs to it. */
    CHECK(state_apply(&state, &before) && state.params.cat_eye == 0.6);
    CHECK_STR(state.setters.look, "vintage");
    state_look(&state, &again);
    CHECK(memcmp(&before, &again, sizeof(before)) == 0);
    CHECK(state_set_look(&state, "") && state.params.cat_eye == 0.9);
}

/* A look of the command line is the menu's: the next one takes its place. */
static void the_command_line_has_a_look(void)
{
    struct state state;
    struct settings below, typed;
    const struct resolver resolver = {resolve, NULL};
    settings_init(&below);
    settings_set(&below, "cat-eye", "0.8", NULL);
    typed = below;
    CHECK(look_read("vintage", &typed, NULL));
    state_init(&state, &typed, 0);
    state_begin_look(&state, "vintage", &below);
    state_open(&state, &resolver, 480, 270, 1);
    CHECK(state.params.swirl == 0.35 && state.params.cat_eye == 0.8);
    CHECK(state_setter(&state, "swirl") == SETTER_LOOK &&
          state_setter(&state, "cat-eye") == SETTER_COMMAND_LINE);
    CHECK(state_set_look(&state, "mirror"));
    CHECK(state.params.swirl == 0 && state.params.obstruction == 0.45);
    CHECK(state_set_look(&state, "") && state.params.cat_eye == 0.8);
}

static void modes_toggle(void)
{
    struct state state = open(NULL);
    state_toggle_mode(&state, MODE_DEPTH);
    CHECK(state.mode == MODE_DEPTH);
    state_toggle_mode(&state, MODE_COC);
    CHECK(state.mode == MODE_COC);
    state_toggle_mode(&state, MODE_COC);
    CHECK(state.mode == MODE_PICTURE);
}

static void the_job_has_what_is_seen(void)
{
    struct state state = open(NULL);
    struct job job;
    state_job(&state, NULL, NULL, &job);
    CHECK(job.wants_filter && !job.wants_pinhole && job.id == state.id);
    state_toggle_filter(&state);
    state_job(&state, NULL, NULL, &job);
    CHECK(!job.wants_filter && job.wants_pinhole);
    state_toggle_mode(&state, MODE_DEPTH);
    state_job(&state, NULL, NULL, &job);
    CHECK(job.wants_filter && !job.wants_pinhole && job.mode == MODE_DEPTH);
    state_toggle_mode(&state, MODE_DEPTH);
    state_toggle_filter(&state);
    state_toggle_split(&state);
    state_job(&state, NULL, NULL, &job);
    CHECK(job.wants_filter && job.wants_pinhole);
}

static void the_eye_stays_on_the_lens(void)
{
    struct state state = open(NULL);
    state_set_eye(&state, true, 3, 4);
    CHECK(state.has_eye);
    CHECK_NEAR(state.eye[0], 0.6, 1e-12);
    CHECK_NEAR(state.eye[1], 0.8, 1e-12);
    state_set_eye(&state, false, 1, 1);
    CHECK(!state.has_eye && state.eye[0] == 0 && state.eye[1] == 0);
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    TEST(the_header_is_taken);
    TEST(what_is_set_counts_as_typed);
    TEST(what_makes_no_lens_changes_nothing);
    TEST(the_screen_follows_the_focus);
    TEST(infinity_can_be_in_focus);
    TEST(the_f_stop_of_a_radius_is_shown);
    TEST(without_millimetres_nothing_is_invented);
    TEST(what_is_not_read_says_why);
    TEST(a_guess_is_what_nobody_gave);
    TEST(the_last_of_two_that_say_the_same_counts);
    TEST(reset_goes_back_to_what_was_given);
    TEST(a_look_is_taken_and_comes_back);
    TEST(a_look_takes_the_place_of_another);
    TEST(a_look_leaves_what_is_the_user_s);
    TEST(the_command_line_has_a_look);
    TEST(modes_toggle);
    TEST(the_job_has_what_is_seen);
    TEST(the_eye_stays_on_the_lens);
    return testing_end();
}
