/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus povray: a POV-Ray scene in, the picture its lens would have made out. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "commands/povray_command.h"
#include "commands/povray_job.h"
#include "commands/povray_journal.h"
#include "console/cli.h"
#include "console/progress.h"
#include "filter/filter_run.h"
#include "image.h"
#include "interrupt.h"
#include "path.h"
#include "povray.h"
#include "povray/povray_average.h"
#include "povray/povray_files.h"
#include "povray/povray_lens.h"
#include "sources/depth_repair.h"
#include "sources/looks.h"
#include "sources/picture.h"
#include "sources/settings.h"

#define AT(member) offsetof(struct povray_tool, member)

static const struct option options[] = {
    OPTION_OUTPUT_ROW(AT(output),
                      "The picture to write: .exr or .png. With --frames the number of "
                      "the frame takes the place of ####, or goes before the ending."),
    OPTION_NUMBER_ROW("aperture", AT(aperture), "SIZE", 0, 1e9,
                      "POV-Ray's aperture in place of the scene's; the lens radius is "
                      "a quarter of it."),
    OPTION_TEXT_ROW("focal-point", AT(focal_point), "X,Y,Z",
                    "Point in focus, in place of the scene's."),
    OPTION_TEXT_ROW("look", AT(look), "NAME",
                    "Look of a kind of lens: " LOOK_NAMES
                    ", your own, or a FILE.params; options "
                    "that are typed win."),
    OPTION_INT_ROW("views", AT(n_views), "COUNT", 1, RF_MAX_LENS_POINTS,
                   "Render so many views from points of the lens and merge them (64 at "
                   "most): real background behind near things. With --method "
                   "accumulate 2 to 1024 are averaged. [default 1; accumulate 32]"),
    OPTION_CHOICE_ROW(
        "camera-move", AT(move), "MOVE", "shift|look-at",
        "Method accumulate, how the camera goes to a point of the lens: shift shears "
        "its frustum, so that the plane in focus stays; look-at turns it to the middle "
        "of that plane, which blurs the plane's borders. [default shift]"),
    OPTION_NUMBER_ROW(
        "shutter", AT(shutter), "TIME", 0, 1e6,
        "Method accumulate: motion blur. The views are spread over so many frames "
        "about the picture's own (a still: units of the clock). [default 0]"),
    OPTION_FLAG_ROW("subpixel", AT(has_subpixel),
                    "Method accumulate: each view looks through another part of the "
                    "pixels, which smooths edges; views are then rendered with -A "
                    "unless another anti-aliasing is given."),
    OPTION_INT_ROW(
        "supersample", AT(n_samples), "COUNT", 0, 4,
        "Render colour and depth with so many samples along a side of each "
        "pixel, filter all of them, and take their mean: thin things in focus "
        "stay whole. 1 is fastest, 3 finest. [default 0: 3 up to 800 x 600, 2 beyond, "
        "but 1 with "
        "--views, --keep or an anti-aliasing of yours after --]"),
    OPTION_INT_ROW(
        "overscan", AT(overscan_px), "PX", -1, 4096,
        "Render so much beyond the border of the picture, which the lens sees. "
        "[default -1: as far as the blur reaches, but 0 with --keep]"),
    OPTION_FLAG_ROW("through-glass", AT(is_through_glass),
                    "Blur what is seen through flat clear glass and in flat mirrors by "
                    "its own distance, not by that of the glass; six short renders "
                    "more. Balls and lenses keep the depth of their surface."),
    OPTION_FILE_ROW("keep", AT(keep), "DIR|FILE.exr",
                    "Keep the passes as DIR/passes.exr, or DIR/passes_v00.exr and so "
                    "on, or in one FILE.exr with all views, which rackfocus filter "
                    "refocuses without rendering. With --method accumulate the views, "
                    "DIR/view_0000.exr ..., for rackfocus accumulate."),
    OPTION_TEXT_ROW("only-views", AT(only_views), "LIST",
                    "With --views and --keep DIR: render these views, such as 0-3, and "
                    "make no picture. The same command without it renders those that "
                    "are missing, and merges."),
    OPTION_INT_ROW(
        "reference", AT(n_reference), "COUNT", 1, 100000,
        "Also render POV-Ray's own focal blur with so many samples, and compare."),
    OPTION_FILE_ROW("reference-output", AT(reference), "FILE.exr",
                    "Also write that focal blur; for rackfocus compare and view."),
    OPTION_TEXT_ROW("frames", AT(frames), "LIST",
                    "Frames of an animation, such as 1-240 or 1-9x2,20: POV-Ray's "
                    "+KFI1 +KFF240, one picture each."),
    OPTION_FLAG_ROW("anew", AT(is_anew),
                    "Animation: also make the frames that are finished."),
    OPTION_DISTRIBUTION_ROW(AT(distribution_image)),
    OPTION_FLAG_ROW(
        "linear-light", AT(is_linear),
        "Sum light physically, not in the scene's assumed_gamma as POV-Ray does."),
    OPTION_FILE_ROW("povray", AT(program), "PROGRAM",
                    "POV-Ray to start. [default povray on the PATH; on Windows also "
                    "pvengine64 and pvengine, there or where they are installed]"),
    OPTION_FLAG_ROW("camera", AT(is_camera_only),
                    "Print the scene's camera, checked by a small render, and stop."),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_STRICT_ROW(AT(is_strict)),
    OPTION_HELP_ROW,
};

static void show_progress(void *bar, double fraction)
{
    progress_report(bar, fraction);
}

/* ---- names ---------------------------------------------------------------------- */

/* Those that return a text: the caller frees; NULL without memory. */

static char *format_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

static char *format_text(const char *format, ...)
{
    char *text = NULL;
    va_list arguments;
    va_start(arguments, format);
    if (vasprintf(&text, format, arguments) < 0)
        text = NULL;
    va_end(arguments);
    return text;
}

/* ---- the run -------------------------------------------------------------------- */

/* Says a sentence about the scene, which may be "". With --strict it is the error. */
static bool warn_scene(void *user, const char *text, struct povray_error *error)
{
    const struct povray_job *job = user;
    if (text[0] && job->tool->is_strict) {
        snprintf(error->message, sizeof(error->message), "%s: %s", job->options.scene,
                 text);
        return false;
    }
    if (text[0])
        warning(job->tool->is_quiet, "%s: %s", job->options.scene, text);
    return true;
}

static bool fail_memory(struct povray_error *error)
{
    snprintf(error->message, sizeof(error->message), "out of memory");
    return false;
}

/* A view in the journal: each frame may have RF_MAX_VIEWS. */
static int32_t number_of_view(const struct povray_job *job, int view)
{
    const int32_t frame = job->options.frame < 0 ? 0 : job->options.frame;
    return frame * RF_MAX_VIEWS + view;
}

/* Writes a view as soon as it is rendered; keeps what the end needs to know. */
static bool receive_view(void *user, int view, const struct povray_passes *passes,
                         struct povray_error *error)
{
    struct povray_job *job = user;
    struct image_error image_error;
    const bool is_first = job->passes.supersample == 0;
    if (is_first && !warn_scene(job, passes->warning, error))
        return false;
    job->passes = *passes;
    job->passes.colour = job->passes.depth = NULL;
    if (!povray_file_write(job->paths[view], passes, POVRAY_FILE_VIEW, NULL,
                           job->options.n_threads, &image_error)) {
        snprintf(error->message, sizeof(error->message), "%s", image_error.message);
        return false;
    }
    const double now_s = os_clock_s();
    if (job->keeps_views)
        povray_journal_add(&job->views, number_of_view(job, view),
                           &(struct frame_files){{job->paths[view]}},
                           now_s - job->view_started_s);
    job->view_started_s = now_s;
    return true;
}

static bool render_one(struct povray_job *job, struct povray_error *error)
{
    struct image_error image_error;
    if (!povray_render(job->scene, &job->passes, error) ||
        !warn_scene(job, job->passes.warning, error))
        return false;
    if (povray_file_write(job->paths[0], &job->passes, POVRAY_FILE_PASSES, NULL,
                          job->options.n_threads, &image_error))
        return true;
    snprintf(error->message, sizeof(error->message), "%s", image_error.message);
    return false;
}

/* Which views are not to be rendered: they are there, or others were asked for. */
static bool find_views(struct povray_job *job)
{
    const struct povray_tool *tool = job->tool;
    struct frame_list list = {0};
    struct image_error error;
    job->options.has_view = job->has_view;
    if (tool->only_views && !frame_list_parse(&list, tool->only_views, &error))
        return false;
    for (int i = 0; i < tool->n_views; i++) {
        bool is_wanted = !tool->only_views;
        for (int k = 0; k < list.n; k++)
            is_wanted |= list.numbers[k] == i;
        job->has_view[i] =
            !is_wanted ||
            (job->keeps_views && !tool->is_anew &&
             povray_journal_finds(&job->views, number_of_view(job, i),
                                  &(struct frame_files){{job->paths[i]}}));
    }
    frame_list_free(&list);
    return true;
}

/* Views of other runs that read another time may show another scene. */
static bool check_time(struct povray_job *job, struct povray_error *error)
{
    bool is_mixed = false;
    for (int i = 0; i < job->tool->n_views; i++)
        is_mixed |= job->has_view[i];
    return !is_mixed || !povray_reads_time(job->scene) ||
           warn_scene(job,
                      "the scene reads the time (now), so that views of several runs "
                      "may differ; render all of them in one run",
                      error);
}

static bool render_views(struct povray_job *job, struct povray_error *error)
{
    double total_s = 0;
    job->view_started_s = os_clock_s();
    const bool is_good = check_time(job, error) &&
                         povray_files_views(job->scene, job->tool->n_views,
                                            receive_view, job, &total_s, error);
    if (is_good && job->passes.supersample == 0)
        povray_describe(job->scene, &job->passes);
    job->passes.total_s = total_s;
    return is_good;
}

/* Is --keep one file for all views, not a folder? */
static bool keeps_one_file(const struct povray_tool *tool)
{
    return tool->keep && picture_kind(tool->keep) == PICTURE_EXR;
}

static char *pass_path(const struct povray_job *job, int view)
{
    const bool is_kept = job->tool->keep && !keeps_one_file(job->tool);
    char number[16] = "", frame[16] = "";
    if (job->tool->n_views > 1)
        snprintf(number, sizeof(number), "_v%02d", view);
    if (job->options.frame >= 0)
        snprintf(frame, sizeof(frame), "%04d", job->options.frame);
    return format_text("%s%spasses%s%s.exr",
                       is_kept ? job->tool->keep : povray_folder(job->scene),
                       is_kept ? "/" : "", frame, number);
}

/* Joins the files of all views to one, as compressed. */
static bool join_views(const struct povray_job *job, const char *path,
                       struct image_error *error)
{
    struct image_input *inputs[RF_MAX_VIEWS] = {NULL};
    char names[RF_MAX_VIEWS][16];
    const char *views[RF_MAX_VIEWS];
    bool is_good = true;
    int n = 0;
    for (; n < job->tool->n_views && is_good; n++) {
        is_good = image_open(&inputs[n], job->paths[n], error);
        snprintf(names[n], sizeof(names[n]), "v%02d", n);
        views[n] = names[n];
    }
    is_good = is_good && image_join_views(path, inputs, views, n, error);
    for (int i = 0; i < n; i++)
        if (inputs[i])
            image_close(inputs[i]);
    return is_good;
}

static int keep_passes(struct povray_job *job)
{
    struct image_error error;
    if (!keeps_one_file(job->tool))
        return EXIT_DONE;
    char *path = povray_picture_name(job->tool->keep, job->options.frame);
    if (!path)
        return exit_without_memory();
    const bool is_good = job->tool->n_views > 1
                             ? join_views(job, path, &error)
                             : povray_file_write(path, &job->passes, POVRAY_FILE_PASSES,
                                                 NULL, job->options.n_threads, &error);
    free(path);
    if (is_good)
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

static bool name_passes(struct povray_job *job)
{
    for (int i = 0; i < job->tool->n_views; i++) {
        free(job->paths[i]);
        job->paths[i] = pass_path(job, i);
        if (!job->paths[i])
            return false;
    }
    return true;
}

static bool render_passes(struct povray_job *job, struct povray_error *error)
{
    if (!name_passes(job))
        return fail_memory(error);
    return job->tool->n_views > 1 ? render_views(job, error) : render_one(job, error);
}

/* Renders and averages views, and writes the result. */
static bool render_average(struct povray_job *job, const char *output,
                           struct povray_error *error)
{
    const struct povray_tool *tool = job->tool;
    const int32_t frame = job->options.frame;
    char number[16] = "";
    if (frame >= 0)
        snprintf(number, sizeof(number), "%04d", frame);
    char *keep = tool->keep ? format_text("%s/view%s", tool->keep, number) : NULL;
    if (tool->keep && !keep)
        return fail_memory(error);
    const struct povray_average how = {.scene = job->scene,
                                       .settings = &job->settings,
                                       .n_views = tool->n_views,
                                       .move = (enum povray_move)tool->move,
                                       .shutter = tool->shutter,
                                       .has_subpixel = tool->has_subpixel,
                                       .frame = frame < 0 ? 0 : frame,
                                       .n_threads = job->options.n_threads,
                                       .keep = keep,
                                       .warn = warn_scene,
                                       .user = job,
                                       .output = output};
    const bool is_good = povray_average_render(&how, &job->passes, error);
    free(keep);
    return is_good;
}

/* What is said of a scene once. */
static bool remark_scene(struct povray_job *job, struct povray_error *error)
{
    if (!warn_scene(job, povray_remark(job->scene), error))
        return false;
    return job->tool->n_views < 2 || !povray_keeps_light(job->scene) ||
           warn_scene(
               job,
               "Radiosity_To_File (+RFO): several views write no file; render one "
               "view for it, without --views",
               error);
}

/* All that POV-Ray does for one picture: into files, or straight into the output. */
static int render(struct povray_job *job, const char *output)
{
    struct povray_error error = {.is_interrupted = false};
    struct progress bar;
    progress_start(&bar, "rendering", job->tool->is_quiet);
    job->options.progress = show_progress;
    job->options.user = &bar;
    bool is_good = !job->keeps_views || (name_passes(job) && find_views(job)) ||
                   fail_memory(&error);
    job->options.warns_by_look &= job->n_pictures == 0;
    is_good = is_good && povray_open(&job->scene, &job->options, &error);
    if (is_good && job->n_pictures++ == 0)
        is_good = remark_scene(job, &error);
    if (is_good)
        is_good = job->tool->is_average ? render_average(job, output, &error)
                                        : render_passes(job, &error);
    progress_end(&bar);
    return is_good ? EXIT_DONE : povray_fail(&error);
}

/* Parameters in pixels are those of the picture: the passes have more. */
static void scale_pixels(struct settings *settings, int32_t n_samples)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n && n_samples > 1; i++) {
        char text[64];
        if (strcmp(list[i].unit, "px") != 0 ||
            settings_origin(settings, list[i].key) != ORIGIN_COMMAND_LINE ||
            rf_params_get(&settings->params, list[i].key, text, sizeof(text)) != RF_OK)
            continue;
        snprintf(text, sizeof(text), "%.17g", n_samples * strtod(text, NULL));
        settings_set(settings, list[i].key, text, NULL);
    }
}

/* The picture of filtered passes that are larger than it. */
static int reduce_passes(struct povray_job *job, const char *from, const char *output)
{
    struct image_error error;
    char used[1000], made[1100];
    settings_print_options(&job->settings.params, used, sizeof(used));
    snprintf(made, sizeof(made), "rackfocus %.60s povray %s", rf_version(), used);
    const bool is_good =
        povray_file_reduce(from, output, &job->passes, (double)job->used.blend_gamma,
                           made, job->options.n_threads, &error);
    if (is_good)
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

static int filter_passes(struct povray_job *job, const char *picture)
{
    const bool is_whole = povray_file_is_whole(&job->passes);
    char *output = is_whole ? format_text("%s", picture)
                            : format_text("%sfiltered.exr", povray_folder(job->scene));
    struct cli_host host;
    struct image_error error;
    if (!output)
        return exit_without_memory();
    cli_host_open(&host, job->tool->is_quiet, job->tool->is_strict);
    host.host.say = NULL; /* print_lens says what was done, of the picture */
    const struct filter_options filter = {
        .output = output,
        .depth_repair = DEPTH_REPAIR_OFF, /* it is that of one sample in any case */
        .type = is_whole ? FILTER_TYPE_HALF : FILTER_TYPE_FLOAT,
        .distribution_image = job->tool->distribution_image,
        .scene = job->options.scene,
        .scene_samples = job->passes.supersample,
        .n_threads = job->tool->n_threads,
        .host = &host.host};
    struct settings settings = job->settings;
    scale_pixels(&settings, job->passes.supersample);
    if (!job->passes.camera.is_orthographic && job->passes.camera.aperture != 0)
        povray_lens_keep(&settings, job->passes.camera.aperture / 4,
                         povray_file_focal_px(&job->passes));
    int code = exit_code(
        filter_run(&filter, &settings, job->paths, job->tool->n_views, &error), &error);
    job->used = settings.params;
    if (code == EXIT_DONE && !is_whole)
        code = reduce_passes(job, output, picture);
    free(output);
    return code;
}

/* What the passes become, which have been rendered. */
static int finish_picture(struct povray_job *job, const char *output)
{
    int code = EXIT_DONE;
    if (!job->tool->is_average)
        code = keep_passes(job);
    if (code == EXIT_DONE && !job->tool->is_average)
        code = filter_passes(job, output);
    const double own_s = os_clock_s() - job->started_s;
    if (code == EXIT_DONE && !job->tool->is_quiet) {
        povray_print_lens(job);
        printf("%s: %.2f s, %.2f s of it POV-Ray's\n", output, own_s,
               job->passes.total_s);
        povray_explain_time(job);
    }
    if (code == EXIT_DONE && job->tool->n_reference > 0)
        code = povray_compare_reference(job, output, own_s);
    return code;
}

static int make_picture(struct povray_job *job)
{
    job->started_s = os_clock_s();
    char *output = povray_picture_name(job->tool->output, job->options.frame);
    int code = output ? render(job, output) : exit_without_memory();
    if (code == EXIT_DONE && !job->tool->only_views)
        code = finish_picture(job, output);
    else if (code == EXIT_DONE && !job->tool->is_quiet)
        printf("views %s of %s: %.2f s\n", job->tool->only_views, output,
               os_clock_s() - job->started_s);
    free(output);
    return code;
}

/* Can the files of the (first) picture be made? */
static bool prepare_output(const struct povray_tool *tool,
                           const struct povray_frames *frames)
{
    const bool keeps_file = keeps_one_file(tool);
    const char *const files[] = {tool->output, keeps_file ? tool->keep : NULL,
                                 tool->reference};
    for (size_t i = 0; i < sizeof(files) / sizeof(files[0]); i++) {
        if (!files[i])
            continue;
        struct image_error error;
        char *name = povray_picture_name(
            files[i], frames->is_animation ? frames->list.numbers[0] : -1);
        const bool is_writable = name ? picture_check_writable(name, &error)
                                      : set_error(&error, "out of memory");
        free(name);
        if (!is_writable) {
            message("%s", error.message);
            return false;
        }
    }
    struct image_error error;
    if (tool->keep && !keeps_file &&
        !picture_need_folder(tool->keep, OS_FOLDER_GOES_IF_EMPTY, &error)) {
        message("%s", error.message);
        return false;
    }
    return true;
}

static void set_frame(struct povray_job *job, const struct povray_frames *frames,
                      int32_t frame)
{
    if (!frames->is_animation)
        return;
    job->options.frame = frame;
    job->options.first_frame = frames->animation_first;
    job->options.last_frame = frames->animation_last;
}

/* What a frame writes: the picture, its passes (the first file of them), the reference.
 */
static bool name_files(const struct povray_job *job, struct frame_files *files)
{
    const struct povray_tool *tool = job->tool;
    const int32_t frame = job->options.frame;
    const bool keeps_passes = tool->keep && !tool->is_average;
    *files = (struct frame_files){
        {povray_picture_name(tool->output, frame),
         !keeps_passes          ? NULL
         : keeps_one_file(tool) ? povray_picture_name(tool->keep, frame)
                                : pass_path(job, 0),
         tool->reference ? povray_picture_name(tool->reference, frame) : NULL}};
    return files->paths[0] && (!keeps_passes || files->paths[1]) &&
           (!tool->reference || files->paths[2]);
}

static void free_files(struct frame_files *files)
{
    for (int i = 0; i < FRAME_MAX_FILES; i++)
        free((char *)files->paths[i]);
}

static void free_picture(struct povray_job *job)
{
    for (int i = 0; i < RF_MAX_VIEWS; i++) {
        free(job->paths[i]);
        job->paths[i] = NULL;
    }
    povray_passes_free(&job->passes);
    povray_close(job->scene);
    job->scene = NULL;
}

/* Makes a frame that is not there, or looks at it. */
static int run_frame(struct povray_job *job, const struct povray_frames *frames, int i)
{
    struct frame_files files;
    const int32_t number = frames->list.numbers[i];
    set_frame(job, frames, number);
    int code = name_files(job, &files) ? EXIT_DONE : exit_without_memory();
    if (code == EXIT_DONE && job->report)
        code = povray_journal_check(&job->journal, &job->report->frames[i], &files);
    else if (code == EXIT_DONE &&
             (job->tool->is_anew ||
              !povray_journal_has(&job->journal, number, &files))) {
        code = make_picture(job);
        if (code == EXIT_DONE && !job->tool->only_views)
            povray_journal_add(&job->journal, number, &files,
                               os_clock_s() - job->started_s);
        free_picture(job);
    }
    free_files(&files);
    return code;
}

static int run_frames(struct povray_job *job, const struct povray_frames *frames)
{
    int code = EXIT_DONE, i = 0;
    if (!frames->is_animation) {
        code = make_picture(job);
        free_picture(job);
    }
    for (; i < frames->list.n && code == EXIT_DONE && !os_is_interrupted(); i++)
        code = run_frame(job, frames, i);
    /* Interrupted after the last one, all is done. */
    return code == EXIT_DONE && i < frames->list.n ? os_interrupt_code() : code;
}

static int run_camera(struct povray_job *job)
{
    struct povray_error error = {.is_interrupted = false};
    if (!povray_open(&job->scene, &job->options, &error))
        return povray_fail(&error);
    const int code = povray_print_camera(job);
    povray_close(job->scene);
    return code;
}

static int run_job(struct povray_job *job, const struct povray_frames *frames)
{
    if (job->tool->is_camera_only) {
        job->options.wants_lens = job->options.wants_reference = false;
        if (frames->is_animation)
            set_frame(job, frames, frames->list.numbers[0]);
        return run_camera(job);
    }
    if (!job->report && !prepare_output(job->tool, frames))
        return EXIT_FAILED;
    return run_frames(job, frames);
}

/* The frames with their journal, which a still has none of. */
static int run_animation(struct povray_job *job, const struct povray_plan *plan,
                         const struct povray_frames *frames)
{
    if (!frames->is_animation || job->tool->is_camera_only) {
        if (!job->report)
            return run_job(job, frames);
        message("povray: the frames are not known; give --frames A-B");
        return EXIT_USAGE;
    }
    if (job->report && !frames_report_start(job->report, &frames->list, NULL))
        return exit_without_memory();
    int code = povray_journal_open(&job->journal, job->tool->output, job->tool,
                                   &job->settings, plan, frames);
    if (code != EXIT_DONE)
        return code;
    code = run_job(job, frames);
    povray_journal_close(&job->journal);
    return code;
}

/* The same with the journal of views that are kept in a folder. */
static int run_with_views(struct povray_job *job, const struct povray_plan *plan,
                          const struct povray_frames *frames)
{
    const struct povray_tool *tool = job->tool;
    if (tool->n_views < 2 || tool->is_average || !tool->keep || keeps_one_file(tool))
        return run_animation(job, plan, frames);
    char *pattern = format_text("%s/views", tool->keep);
    int code = pattern ? povray_journal_open(&job->views, pattern, tool, &job->settings,
                                             plan, frames)
                       : exit_without_memory();
    free(pattern);
    if (code != EXIT_DONE)
        return code;
    job->keeps_views = true;
    code = run_animation(job, plan, frames);
    povray_journal_close(&job->views);
    return code;
}

static int run_tool(struct povray_tool *tool, struct settings *settings,
                    const struct operands *operands, struct frames_report *report)
{
    struct povray_job job = {.tool = tool, .report = report};
    struct povray_frames frames = {0};
    struct povray_plan plan;
    struct povray_error error = {.is_interrupted = false};
    int code = EXIT_USAGE;
    if (!povray_command_check(tool, settings, operands))
        return EXIT_USAGE;
    if (tool->is_linear)
        settings_set(settings, "blend-gamma", "1", NULL);
    job.settings = *settings;
    if (!povray_plan_make(&plan, operands->items[0], operands->rest, operands->n_rest,
                          &error)) {
        message("%s", error.message);
        code = EXIT_FAILED;
    } else if (povray_command_frames(tool->frames, &plan, &frames)) {
        code = povray_command_spares(tool, &plan, &frames);
        if (code == EXIT_DONE)
            code = povray_command_plan(tool, settings, &plan, &job.options)
                       ? run_with_views(&job, &plan, &frames)
                       : EXIT_USAGE;
    }
    frame_list_free(&frames.list);
    povray_plan_free(&plan);
    return code;
}

int povray_command_run(int argc, char **argv, struct frames_report *report)
{
    struct povray_tool tool = {.aperture = NAN, .overscan_px = -1};
    struct settings settings;
    struct operands operands;
    int code = options_parse(&command_povray, argc, argv, &tool, &settings, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    struct image_error error;
    if (!tool.look || look_read(tool.look, &settings, &error)) {
        code = run_tool(&tool, &settings, &operands, report);
    } else {
        message("%s", error.message);
        code = EXIT_USAGE;
    }
    operands_free(&operands);
    return code;
}

static int cmd_povray(int argc, char **argv)
{
    return povray_command_run(argc, argv, NULL);
}

const struct command command_povray = {
    .name = "povray",
    .summary = "render a POV-Ray scene with its lens",
    .usage = "SCENE.pov -o OUT [options] [-- POV-Ray's options]",
    .description =
        "Renders an unmodified scene as a pinhole picture with depth, finds its camera "
        "and lens, and filters: the picture of POV-Ray's focal blur, without its grain "
        "and in a fraction of its time.\n\n"
        "The aperture and the focal point are the scene's unless options give others. "
        "What follows -- goes to POV-Ray: +W640 +H480 +Lpath +A0.1. The colour is "
        "rendered with +A0.05 +AM2 +R3, views with +A0.1 +AM1 +R3 -J, those of the "
        "method accumulate with +R2, unless another anti-aliasing is given there.",
    .examples = "rackfocus povray scene.pov -o out.exr -- +W640 +H480\n"
                "rackfocus povray scene.pov -o out.png --aperture 0.4 "
                "--focal-point 0,1,0 --keep passes\n"
                "rackfocus filter passes/passes.exr -o nearer.exr --focus-distance 4\n"
                "rackfocus povray scene.pov --views 8 -o out.exr --keep views.exr\n"
                "rackfocus povray scene.pov --method accumulate --views 64 -o out.exr",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .keeps_rest = true,
    .run = cmd_povray,
};
