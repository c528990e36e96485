/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Where the members of the public structs lie. Programs that were built with an older
 * header rely on it: a member may come at the end of a struct that says its size, but
 * none may move. What fails here was inserted or removed; move it to the end (of
 * params.def, whatever its group is), or raise the library's soversion and then mend
 * the numbers. New members at the end are added to the lists.
 */
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "rackfocus/rackfocus.h"
#include "testing.h"

struct member {
    const char *name;
    size_t at, want;
};

/* The members of struct rf_params, in bytes from its beginning. */
static const struct {
    const char *name;
    size_t offset;
} golden[] = {
    {"focus_distance", 8},
    {"f_stop", 16},
    {"focal_length", 24},
    {"sensor_width", 32},
    {"sensor_height", 40},
    {"sensor_fit", 48},
    {"unit_scale", 56},
    {"lens_radius", 64},
    {"focal_length_px", 72},
    {"projection", 80},
    {"ortho_scale", 88},
    {"shift_x", 96},
    {"shift_y", 104},
    {"pixel_aspect", 112},
    {"optics", 120},
    {"screen_position", 128},
    {"aperture_coefficient", 136},
    {"coc_limit", 144},
    {"aperture", 152},
    {"blades", 156},
    {"blade_rotation", 160},
    {"blade_orientation", 168},
    {"aperture_ratio", 176},
    {"depth", 184},
    {"depth_near", 192},
    {"depth_far", 200},
    {"depth_scale", 208},
    {"depth_offset", 216},
    {"depth_infinity", 224},
    {"film_depth", 232},
    {"method", 236},
    {"max_radius", 240},
    {"sub_apertures", 248},
    {"split_edges", 252},
    {"fill_hidden", 256},
    {"exact_highlights", 260},
    {"distribution", 264},
    {"blend_gamma", 272},
    {"blend", 280},
    {"blur_radius", 288},
    {"box_repeats", 296},
    {"lowres_factor", 300},
    {"mipmap_bias", 304},
    {"copies", 312},
    {"recursions", 316},
    {"region_size", 320},
    {"region_slope", 328},
    {"slices", 336},
    {"leak_control", 340},
    {"leak_weight", 344},
    {"leave_focus_out", 352},
    {"lens_pattern", 356},
    {"lens_random", 360},
    {"lens_seed", 364},
    {"quality", 368},
    {"blade_curvature", 376},
    {"cat_eye", 384},
    {"cat_eye_exposure", 392},
    {"astigmatism", 400},
    {"swirl", 408},
    {"barn_left", 416},
    {"barn_right", 424},
    {"barn_top", 432},
    {"barn_bottom", 440},
    {"tilt_x", 448},
    {"tilt_y", 456},
    {"field_curvature", 464},
    {"split_diopter", 472},
    {"split_angle", 480},
    {"split_offset", 488},
    {"split_softness", 496},
    {"spherical", 504},
    {"axial_chroma", 512},
    {"lateral_chroma", 520},
    {"obstruction", 528},
    {"highlight_clamp", 536},
    {"highlight_threshold", 544},
    {"highlight_gain", 552},
    {"highlight_saturation", 560},
    {"stage", 568},
    {"box_direction", 572},
    {"white", 576},
};
enum { N_PARAMS = sizeof golden / sizeof *golden };

#define SIZE(type, want)                                                               \
    {                                                                                  \
        "sizeof " #type, sizeof(struct type), want                                     \
    }
#define MEMBER(type, name, want)                                                       \
    {                                                                                  \
#type "." #name, offsetof(struct type, name), want                             \
    }

static const struct member members[] = {
    SIZE(rf_error, 308),
    MEMBER(rf_error, code, 0),
    MEMBER(rf_error, field, 4),
    MEMBER(rf_error, message, 52),
    SIZE(rf_choice, 16),
    MEMBER(rf_choice, name, 0),
    MEMBER(rf_choice, help, 8),
    SIZE(rf_param_info, 96),
    MEMBER(rf_param_info, key, 0),
    MEMBER(rf_param_info, field, 8),
    MEMBER(rf_param_info, attribute, 16),
    MEMBER(rf_param_info, unit, 24),
    MEMBER(rf_param_info, help, 32),
    MEMBER(rf_param_info, type, 40),
    MEMBER(rf_param_info, group, 44),
    MEMBER(rf_param_info, offset, 48),
    MEMBER(rf_param_info, min, 56),
    MEMBER(rf_param_info, max, 64),
    MEMBER(rf_param_info, def, 72),
    MEMBER(rf_param_info, choices, 80),
    MEMBER(rf_param_info, n_choices, 88),
    SIZE(rf_method_info, 48),
    MEMBER(rf_method_info, name, 0),
    MEMBER(rf_method_info, help, 8),
    MEMBER(rf_method_info, cost, 16),
    MEMBER(rf_method_info, source, 24),
    MEMBER(rf_method_info, max_views, 32),
    MEMBER(rf_method_info, needs_depth, 36),
    MEMBER(rf_method_info, has_blend, 37),
    MEMBER(rf_method_info, has_layers, 38),
    MEMBER(rf_method_info, reads_aperture, 39),
    MEMBER(rf_method_info, can_window, 40),
    MEMBER(rf_method_info, can_deep, 41),
    SIZE(rf_lens, 128),
    MEMBER(rf_lens, size, 0),
    MEMBER(rf_lens, bias_px, 8),
    MEMBER(rf_lens, scale, 16),
    MEMBER(rf_lens, focus_distance, 24),
    MEMBER(rf_lens, lens_radius, 32),
    MEMBER(rf_lens, focal_length, 40),
    MEMBER(rf_lens, focal_length_px, 48),
    MEMBER(rf_lens, px_per_unit, 56),
    MEMBER(rf_lens, principal_px, 64),
    MEMBER(rf_lens, max_radius_px, 80),
    MEMBER(rf_lens, coc_limit_px, 88),
    MEMBER(rf_lens, screen_position, 96),
    MEMBER(rf_lens, buffer_scale_px, 104),
    MEMBER(rf_lens, buffer_bias_px, 112),
    MEMBER(rf_lens, projection, 120),
    MEMBER(rf_lens, optics, 124),
    SIZE(rf_lens_point, 24),
    MEMBER(rf_lens_point, u, 0),
    MEMBER(rf_lens_point, v, 8),
    MEMBER(rf_lens_point, time, 16),
    SIZE(rf_image, 48),
    MEMBER(rf_image, data, 0),
    MEMBER(rf_image, width, 8),
    MEMBER(rf_image, height, 12),
    MEMBER(rf_image, channels, 16),
    MEMBER(rf_image, channel_bytes, 24),
    MEMBER(rf_image, pixel_bytes, 32),
    MEMBER(rf_image, row_bytes, 40),
    SIZE(rf_context_params, 72),
    MEMBER(rf_context_params, size, 0),
    MEMBER(rf_context_params, n_threads, 8),
    MEMBER(rf_context_params, allocate, 16),
    MEMBER(rf_context_params, release, 24),
    MEMBER(rf_context_params, log, 32),
    MEMBER(rf_context_params, user, 40),
    MEMBER(rf_context_params, cpu, 48),
    MEMBER(rf_context_params, max_bytes, 56),
    MEMBER(rf_context_params, parallel_for, 64),
    SIZE(rf_progress, 16),
    MEMBER(rf_progress, report, 0),
    MEMBER(rf_progress, user, 8),
    SIZE(rf_view, 304),
    MEMBER(rf_view, size, 0),
    MEMBER(rf_view, colour, 8),
    MEMBER(rf_view, depth, 56),
    MEMBER(rf_view, lens_offset, 104),
    MEMBER(rf_view, shear_distance, 120),
    MEMBER(rf_view, behind_colour, 128),
    MEMBER(rf_view, behind_depth, 176),
    MEMBER(rf_view, unseen_lights, 224),
    MEMBER(rf_view, n_unseen_lights, 232),
    MEMBER(rf_view, seen, 240),
    MEMBER(rf_view, n_seen, 248),
    MEMBER(rf_view, mean_depth, 256),
    SIZE(rf_seen_light, 96),
    MEMBER(rf_seen_light, colour, 0),
    MEMBER(rf_seen_light, depth, 48),
    SIZE(rf_unseen_light, 40),
    MEMBER(rf_unseen_light, x, 0),
    MEMBER(rf_unseen_light, y, 8),
    MEMBER(rf_unseen_light, depth, 16),
    MEMBER(rf_unseen_light, colour, 24),
    SIZE(rf_window, 16),
    MEMBER(rf_window, x, 0),
    MEMBER(rf_window, y, 4),
    MEMBER(rf_window, width, 8),
    MEMBER(rf_window, height, 12),
    SIZE(rf_survey, 272),
    MEMBER(rf_survey, size, 0),
    MEMBER(rf_survey, largest_radius, 8),
    MEMBER(rf_survey, n_pixels, 16),
    MEMBER(rf_survey, n_known, 24),
    MEMBER(rf_survey, n_transparent, 32),
    MEMBER(rf_survey, disc_area, 40),
    MEMBER(rf_survey, lens_offset, 232),
    MEMBER(rf_survey, shear_distance, 248),
    MEMBER(rf_survey, least, 256),
    SIZE(rf_deep_sample, 28),
    MEMBER(rf_deep_sample, depth, 0),
    MEMBER(rf_deep_sample, depth_back, 4),
    MEMBER(rf_deep_sample, colour, 8),
    MEMBER(rf_deep_sample, opacity, 24),
    SIZE(rf_deep, 24),
    MEMBER(rf_deep, width, 0),
    MEMBER(rf_deep, height, 4),
    MEMBER(rf_deep, first, 8),
    MEMBER(rf_deep, samples, 16),
    SIZE(rf_depth_channel, 72),
    MEMBER(rf_depth_channel, depth, 0),
    MEMBER(rf_depth_channel, colour, 8),
    MEMBER(rf_depth_channel, width, 56),
    MEMBER(rf_depth_channel, height, 60),
    MEMBER(rf_depth_channel, infinity, 64),
    SIZE(rf_depth_stats, 208),
    MEMBER(rf_depth_stats, size, 0),
    MEMBER(rf_depth_stats, n_pixels, 8),
    MEMBER(rf_depth_stats, n_nan, 16),
    MEMBER(rf_depth_stats, n_negative, 24),
    MEMBER(rf_depth_stats, n_no_hit, 32),
    MEMBER(rf_depth_stats, n_zero, 40),
    MEMBER(rf_depth_stats, n_one, 48),
    MEMBER(rf_depth_stats, min, 56),
    MEMBER(rf_depth_stats, max, 64),
    MEMBER(rf_depth_stats, median, 72),
    MEMBER(rf_depth_stats, inner_median, 80),
    MEMBER(rf_depth_stats, mixed_share, 88),
    MEMBER(rf_depth_stats, premultiplied_share, 96),
    MEMBER(rf_depth_stats, near_shares, 104),
    MEMBER(rf_depth_stats, kind, 128),
    MEMBER(rf_depth_stats, kind_reason, 136),
    MEMBER(rf_depth_stats, is_mixed, 144),
    MEMBER(rf_depth_stats, is_premultiplied, 145),
    MEMBER(rf_depth_stats, is_widened, 146),
    MEMBER(rf_depth_stats, n_divided, 152),
    MEMBER(rf_depth_stats, n_snapped, 160),
    MEMBER(rf_depth_stats, n_narrowed, 168),
    MEMBER(rf_depth_stats, n_holes, 176),
    MEMBER(rf_depth_stats, hole_share, 184),
    MEMBER(rf_depth_stats, is_speckled, 192),
    MEMBER(rf_depth_stats, n_filled, 200),
};

static void parameters_stay_where_they_are(void)
{
    size_t n;
    const struct rf_param_info *rows = rf_param_list(&n);
    REQUIRE(n >= N_PARAMS);
    CHECK(offsetof(struct rf_params, size) == 0);
    for (size_t i = 0; i < N_PARAMS; i++) {
        CHECK_STR(rows[i].field, golden[i].name);
        if (!testing_check(rows[i].offset == golden[i].offset, __FILE__, __LINE__,
                           "stays where it is"))
            printf("#     %s lies at %zu\n", rows[i].field, rows[i].offset);
    }
    if (!testing_check(n == N_PARAMS, __FILE__, __LINE__, "is listed here"))
        printf("#     add {\"%s\", %zu}\n", rows[N_PARAMS].field,
               rows[N_PARAMS].offset);
}

static void members_stay_where_they_are(void)
{
    for (size_t i = 0; i < sizeof members / sizeof *members; i++)
        if (!testing_check(members[i].at == members[i].want, __FILE__, __LINE__,
                           "stays where it is"))
            printf("#     %s is %zu, and was %zu\n", members[i].name, members[i].at,
                   members[i].want);
}

/* The views of a program whose struct has grown since: size is the step. */
struct newer_view {
    struct rf_view view;
    double more[3];
};

enum { SIDE = 4, N = SIDE * SIDE };

static void arrays_of_newer_structs_are_stepped_through(void)
{
    float colour[2][N], depth[N], plain[N], out[N];
    struct rf_params params;
    struct rf_context *context;
    struct rf_filter *filter;
    struct rf_view views[2];
    struct newer_view newer[2];
    struct rf_image to = rf_image_packed(plain, SIDE, SIDE, 1);
    rf_params_init(&params);
    params.method = RF_METHOD_ACCUMULATE;
    memset(newer, 0x55, sizeof newer);
    for (int i = 0; i < N; i++) {
        colour[0][i] = (float)i;
        colour[1][i] = 2;
        depth[i] = 3;
    }
    for (int j = 0; j < 2; j++) {
        views[j] = (struct rf_view){.colour = rf_image_input(colour[j], SIDE, SIDE, 1),
                                    .depth = rf_image_input(depth, SIDE, SIDE, 1)};
        newer[j].view = views[j];
        newer[j].view.size = sizeof newer[j];
    }
    REQUIRE(rf_context_create(&context, NULL, NULL) == RF_OK);
    REQUIRE(rf_filter_create(&filter, context, &params, SIDE, SIDE, NULL) == RF_OK);
    CHECK(rf_filter_process(filter, views, 2, &to, NULL, NULL) == RF_OK);
    to.data = out;
    CHECK(rf_filter_process(filter, &newer->view, 2, &to, NULL, NULL) == RF_OK);
    CHECK(memcmp(out, plain, sizeof out) == 0 && out[4] == 3);
    struct rf_error error;
    views->size = 8;
    CHECK(rf_filter_process(filter, views, 2, &to, NULL, &error) == RF_ERROR_ARGUMENT);
    CHECK_STR(error.field, "size");
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

static void what_an_older_program_does_not_know_stays(void)
{
    struct rf_params params;
    struct rf_lens lens, whole;
    rf_params_init(&params);
    memset(&lens, 0x55, sizeof lens);
    size_t size = offsetof(struct rf_lens, coc_limit_px);
    REQUIRE(rf_lens_init(&whole, &params, 40, 30, NULL) == RF_OK);
    REQUIRE(rf_lens_init_sized(&lens, size, &params, 40, 30, NULL) == RF_OK);
    CHECK(whole.size == sizeof whole && lens.size == size);
    CHECK(lens.scale == whole.scale && lens.max_radius_px == whole.max_radius_px);
    const unsigned char *bytes = (const unsigned char *)&lens;
    for (size_t i = size; i < sizeof lens; i++)
        CHECK(bytes[i] == 0x55);
    CHECK(rf_lens_init_sized(&lens, 0, &params, 40, 30, NULL) == RF_ERROR_ARGUMENT);
}

static void rows_have_places(void)
{
    size_t n;
    const struct rf_param_info *rows = rf_param_list(&n);
    CHECK(rf_param_at(0) == rows && rf_param_at(n - 1) == &rows[n - 1]);
    CHECK(!rf_param_at(n) && !rf_method_find(-1) && !rf_method_find(1000));
}

int main(int argc, char **argv)
{
    testing_begin(argc, argv);
    if (sizeof(void *) != 8) {
        printf("1..0 # SKIP the numbers are those of 64 bit machines\n");
        return 0;
    }
    TEST(parameters_stay_where_they_are);
    TEST(members_stay_where_they_are);
    TEST(arrays_of_newer_structs_are_stepped_through);
    TEST(what_an_older_program_does_not_know_stays);
    TEST(rows_have_places);
    return testing_end();
}
