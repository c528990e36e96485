/* SPDX-License-Identifier: Apache-2.0 */
#include "commands/povray_command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands/povray_job.h"
#include "common/outputs.h"
#include "common/report.h"
#include "console/cli.h"
#include "interrupt.h"
#include "povray/povray_lens.h"
#include "sources/picture.h"

/* ---- the command line ----------------------------------------------------------- */

static bool fail_usage(const char *text)
{
    message("%s; see rackfocus povray --help", text);
    return false;
}

bool povray_command_frames(const char *text, const struct povray_plan *plan,
                           struct povray_frames *frames)
{
    char range[48];
    struct image_error error;
    *frames = (struct povray_frames){.animation_first = plan->first,
                                     .animation_last = plan->last,
                                     .is_animation = text || plan->is_animation};
    if (!frames->is_animation)
        return true;
    snprintf(range, sizeof(range), "%d-%dx%d", (int)plan->from, (int)plan->to,
             (int)plan->step);
    if (!frame_list_parse(&frames->list, text ? text : range, &error)) {
        message("--frames: %s", error.message);
        return false;
    }
    /* POV-Ray's own options win where they say how long the animation is. */
    if (!plan->is_animation) {
        frames->animation_first = frames->list.numbers[0];
        frames->animation_last = frames->list.numbers[frames->list.n - 1];
    }
    return true;
}

static bool parse_point(const char *text, double point[3])
{
    const char *at = text + strspn(text, " <");
    for (int i = 0; i < 3; i++) {
        char *end;
        point[i] = strtod(at, &end);
        if (end == at || !isfinite(point[i]) || (i < 2 && !strchr(", ", *end)))
            return fail_usage("--focal-point takes three numbers such as 5,10,5");
        at = end + strspn(end, i < 2 ? ", " : " >");
    }
    return *at == 0 || fail_usage("--focal-point takes three numbers such as 5,10,5");
}

static bool check_files(const struct povray_tool *tool)
{
    struct image_error error;
    struct outputs outputs = {.error = &error};
    outputs_add(&outputs, "output", tool->output);
    outputs_add(&outputs, "keep", tool->keep);
    outputs_add(&outputs, "reference-output", tool->reference);
    outputs_spare(&outputs, "distribution-image", tool->distribution_image);
    return exit_code(outputs.code, &error) == EXIT_DONE;
}

static bool check_usage(const struct povray_tool *tool, const struct operands *operands)
{
    if (operands->n == 0)
        return fail_usage("povray needs a scene, a file of POV-Ray's language");
    if (operands->n > 1)
        return fail_usage("povray takes one scene; options for POV-Ray follow --");
    if (tool->is_camera_only)
        return true;
    if (tool->reference && tool->n_reference == 0)
        return fail_usage(
            "--reference-output needs --reference, the number of samples");
    if (tool->reference && picture_kind(tool->reference) != PICTURE_EXR)
        return fail_usage("--reference-output takes a file that ends with .exr");
    if (!tool->output)
        return fail_usage("povray needs an output, -o FILE.exr or -o FILE.png");
    struct image_error error;
    if (!picture_check_kind(tool->output, &error)) {
        message("%s", error.message);
        return false;
    }
    return check_files(tool);
}

/* ---- what the scene reads ------------------------------------------------------ */

struct spared {
    const struct povray_tool *tool;
    const struct povray_frames *frames;
    int code; /* enum exit_code */
};

/* Is the input no output of frame i of `frames`, of the still? */
static void spare_of_frame(struct spared *spared, const char *input, int i)
{
    const struct povray_tool *tool = spared->tool;
    const bool keeps_file = tool->keep && picture_kind(tool->keep) == PICTURE_EXR;
    const struct output_file files[] = {{"output", tool->output},
                                        {"keep", keeps_file ? tool->keep : NULL},
                                        {"reference-output", tool->reference}};
    const struct povray_frames *frames = spared->frames;
    for (size_t k = 0; k < sizeof(files) / sizeof(files[0]); k++) {
        struct image_error error;
        struct outputs outputs = {.error = &error};
        if (!files[k].path || spared->code != EXIT_DONE)
            continue;
        char *path = povray_picture_name(
            files[k].path, frames->is_animation ? frames->list.numbers[i] : -1);
        outputs_add(&outputs, files[k].option, path);
        outputs_spare(&outputs, NULL, input);
        spared->code = path ? exit_code(outputs.code, &error) : exit_without_memory();
        free(path);
    }
}

static void spare_input(void *user, const char *text, bool is_file)
{
    struct spared *spared = user;
    const struct povray_frames *frames = spared->frames;
    const int n = frames->is_animation ? frames->list.n : 1;
    for (int i = 0; is_file && i < n; i++)
        spare_of_frame(spared, text, i);
}

int povray_command_spares(const struct povray_tool *tool,
                          const struct povray_plan *plan,
                          const struct povray_frames *frames)
{
    struct spared spared = {.tool = tool, .frames = frames, .code = EXIT_DONE};
    bool has_computed;
    /* A scene that cannot be read is told of when it is rendered. */
    if (!tool->is_camera_only)
        povray_list_inputs(plan, spare_input, &spared, &has_computed);
    return spared.code;
}

/* ---- the lens ------------------------------------------------------------------- */

static bool is_typed(const struct settings *settings, const char *name)
{
    return settings_origin(settings, name) == ORIGIN_COMMAND_LINE;
}

/* What is said twice would be silently one of the two. */
static bool check_lens(const struct povray_tool *tool, const struct settings *settings)
{
    const bool has_aperture = !isnan(tool->aperture);
    if (tool->focal_point && is_typed(settings, "focus-distance"))
        return fail_usage(
            "--focal-point and --focus-distance both say what is in focus; "
            "leave one out");
    if (has_aperture && is_typed(settings, "lens-radius"))
        return fail_usage("--aperture and --lens-radius both say how wide the lens is; "
                          "leave one out");
    if (has_aperture && is_typed(settings, "f-stop"))
        return fail_usage(
            "--aperture and --f-stop both say how wide the lens is; leave "
            "one out");
    return true;
}

static bool fail_number_of_views(int32_t n, const char *method, int least, int most)
{
    message("--views: %d; the method %s takes %d to %d; see rackfocus povray --help", n,
            method, least, most);
    return false;
}

/* Options that only the averaging of views has a use for. */
static bool check_average_only(const struct povray_tool *tool)
{
    if (tool->move == POVRAY_MOVE_LOOK_AT || tool->shutter > 0 || tool->has_subpixel)
        return fail_usage("--camera-move, --shutter and --subpixel are for --method "
                          "accumulate");
    return true;
}

/* What only renders with a depth have. False where a warning is an error. */
static bool check_depth_only(const struct povray_tool *tool)
{
    const struct {
        const char *option, *why;
        bool is_given;
    } unread[] = {
        {"supersample",
         "its views smooth each other's edges; more --views do, or an anti-aliasing "
         "after --, as +A0.05 +AM2 +R3",
         tool->n_samples > 1},
        {"overscan", "its views show what the lens sees beyond the border",
         tool->overscan_px > 0},
        {"through-glass", "its views show what is behind glass and in mirrors",
         tool->is_through_glass}};
    for (size_t i = 0; i < sizeof(unread) / sizeof(unread[0]); i++) {
        if (!unread[i].is_given)
            continue;
        warning(tool->is_quiet, "--%s has no effect with --method accumulate: %s",
                unread[i].option, unread[i].why);
        if (tool->is_strict)
            return false;
    }
    return true;
}

/* The mean of views has what the views have: a plane in focus, tilted or not, and the
 * lens' points. What else was asked for is refused, or said to be nothing. */
static bool check_average_params(const struct povray_tool *tool,
                                 const struct settings *settings)
{
    static const char *const other_planes[] = {"field-curvature", "split-diopter"};
    static const char *const tilts[] = {"tilt-x", "tilt-y"};
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    bool is_tilted = false;
    for (int i = 0; i < 2; i++) {
        is_tilted |= is_typed(settings, tilts[i]);
        if (!is_typed(settings, other_planes[i]))
            continue;
        message("--%s: the views of --method accumulate are rendered for a plane in "
                "focus; take --method views, or --tilt-x and --tilt-y",
                other_planes[i]);
        return false;
    }
    if (is_tilted && tool->move == POVRAY_MOVE_LOOK_AT)
        return fail_usage(
            "--camera-move look-at has no plane in focus that --tilt-x and "
            "--tilt-y could tilt; leave it out");
    for (size_t i = 0; i < n; i++) {
        const char *why;
        if (strncmp(list[i].key, "tilt-", 5) == 0 || !is_typed(settings, list[i].key) ||
            rf_param_is_read(&settings->params, list[i].key, &why))
            continue;
        warning(tool->is_quiet, "--%s has no effect with --method accumulate: %s",
                list[i].key, why);
        if (tool->is_strict)
            return false;
    }
    return check_depth_only(tool);
}

/* Several views are merged by one method or averaged by another, and are taken over a
 * lens that is known. Completes the number of views. */
static bool check_views(struct povray_tool *tool, const struct settings *settings)
{
    enum { DEFAULT_AVERAGE = 32 };
    const int method = settings->params.method;
    tool->is_average = method == RF_METHOD_ACCUMULATE;
    if (tool->n_views == 0)
        tool->n_views = tool->is_average ? DEFAULT_AVERAGE : 1;
    if (tool->is_average && tool->n_views < 2)
        return fail_number_of_views(tool->n_views, "accumulate", 2, RF_MAX_LENS_POINTS);
    if (!tool->is_average && tool->n_views > RF_MAX_VIEWS)
        return fail_number_of_views(tool->n_views, "views", 1, RF_MAX_VIEWS);
    if (!(tool->is_average ? check_average_params(tool, settings)
                           : check_average_only(tool)))
        return false;
    if (tool->n_views == 1)
        return true;
    if (is_typed(settings, "f-stop"))
        return fail_usage("--views needs the lens as --aperture or --lens-radius, not "
                          "as --f-stop");
    if (tool->is_average && tool->keep && picture_kind(tool->keep) == PICTURE_EXR)
        return fail_usage("--keep takes a folder with --method accumulate");
    if (is_typed(settings, "method") && rf_method_find(method)->max_views == 1)
        return fail_usage("--method: several views are merged by the method views or "
                          "averaged by accumulate");
    return true;
}

static bool is_cancelled(void *user)
{
    (void)user;
    return os_is_interrupted();
}

/* Where nobody says: passes that are kept have the picture's size, and who says how the
 * colour is anti-aliased has chosen its samples. */
static int32_t choose_samples(const struct povray_tool *tool,
                              const struct povray_plan *plan)
{
    if (tool->n_samples > 0)
        return tool->n_samples;
    return tool->keep || plan->has_antialiasing ? 1 : 0;
}

bool povray_command_plan(const struct povray_tool *tool,
                         const struct settings *settings,
                         const struct povray_plan *plan, struct povray_options *made)
{
    *made = (struct povray_options){
        .scene = plan->scene,
        .program = tool->program,
        .args = plan->args,
        .n_args = plan->n_args,
        .frame = -1,
        .supersample = choose_samples(tool, plan),
        /* Who keeps passes wants them as the picture is. */
        .is_through_glass = tool->is_through_glass,
        .warns_by_look = !tool->is_quiet || tool->is_strict,
        .overscan_px = tool->overscan_px < 0 && tool->keep ? 0 : tool->overscan_px,
        .is_cancelled = is_cancelled,
        .n_threads = thread_count(tool->n_threads)};
    povray_lens_options(made, settings, &tool->stop);
    made->wants_lens = !made->has_f_stop;
    made->wants_reference = tool->n_reference > 0;
    if (!isnan(tool->aperture)) {
        made->has_aperture = true;
        made->aperture = tool->aperture;
    }
    made->has_focal_point = tool->focal_point != NULL;
    return !tool->focal_point || parse_point(tool->focal_point, made->focal_point);
}

/* Views that are rendered alone are kept, for who merges them. */
static bool check_only_views(const struct povray_tool *tool)
{
    struct frame_list list;
    struct image_error error;
    if (!tool->only_views)
        return true;
    if (tool->is_average || tool->n_views < 2 || !tool->keep ||
        picture_kind(tool->keep) == PICTURE_EXR)
        return fail_usage("--only-views needs --views, and --keep with a folder, where "
                          "the same command without it finds them");
    if (!frame_list_parse(&list, tool->only_views, &error)) {
        message("--only-views: '%s' is no list of views; write 0-3 or 0,2",
                tool->only_views);
        return false;
    }
    const int32_t last = list.numbers[list.n - 1];
    frame_list_free(&list);
    if (last < tool->n_views)
        return true;
    message("--only-views: the last of --views %d is %d", (int)tool->n_views,
            (int)tool->n_views - 1);
    return false;
}

/* Is it given, not at its default, and something that POV-Ray's round lens with its
 * plane in focus lacks? */
static bool is_of_look(const struct settings *settings,
                       const struct rf_param_info *info)
{
    static const char *const planes[] = {"tilt-x", "tilt-y", "field-curvature",
                                         "split-diopter"};
    char text[RF_PARAM_TEXT_BYTES], plain_text[RF_PARAM_TEXT_BYTES];
    struct settings plain;
    const char *why;
    bool is_look =
        info->group == RF_GROUP_APERTURE || info->group == RF_GROUP_HIGHLIGHTS;
    for (size_t i = 0; i < sizeof(planes) / sizeof(planes[0]); i++)
        is_look |= strcmp(info->key, planes[i]) == 0;
    settings_init(&plain);
    return is_look && is_typed(settings, info->key) &&
           rf_param_is_read(&settings->params, info->key, &why) &&
           rf_params_get(&settings->params, info->key, text, sizeof(text)) == RF_OK &&
           rf_params_get(&plain.params, info->key, plain_text, sizeof(plain_text)) ==
               RF_OK &&
           strcmp(text, plain_text) != 0;
}

/* A reference without the look says nothing of how good the picture is. */
static bool check_reference(const struct povray_tool *tool,
                            const struct settings *settings)
{
    char names[400] = "";
    size_t n, n_names = 0;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; tool->n_reference > 0 && i < n; i++)
        if (is_of_look(settings, &list[i]) && n_names < sizeof(names))
            n_names += (size_t)snprintf(names + n_names, sizeof(names) - n_names,
                                        "%s--%s", n_names > 0 ? ", " : "", list[i].key);
    if (n_names == 0)
        return true;
    warning(tool->is_quiet,
            "--reference: POV-Ray's focal blur has no %s, so its figure is how much "
            "they change; leave them out to see how good the blur is",
            names);
    return !tool->is_strict;
}

bool povray_command_check(struct povray_tool *tool, struct settings *settings,
                          const struct operands *operands)
{
    if (!check_usage(tool, operands) || !check_lens(tool, settings) ||
        !check_reference(tool, settings))
        return false;
    povray_lens_take_stop(settings, &tool->stop);
    return check_views(tool, settings) && check_only_views(tool);
}
