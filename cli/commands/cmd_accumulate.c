/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus accumulate: the mean of several views, one in memory at a time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "commands/accumulate_command.h"
#include "common/outputs.h"
#include "console/cli.h"
#include "console/progress.h"
#include "interrupt.h"
#include "rackfocus/rackfocus.h"
#include "sequence/frames_check.h"
#include "sequence/sequence.h"
#include "sources/alpha.h"
#include "sources/beside.h"
#include "sources/choice.h"
#include "sources/looks.h"
#include "sources/picture.h"
#include "sources/png_picture.h"
#include "sources/primaries.h"
#include "sources/settings.h"
#include "sources/source.h"
#include "sources/views.h"
#include "sources/views_light.h"

struct accumulate_options {
    const char *output, *layer, *frames, *look;
    double blend_gamma;                        /* NAN: from the header */
    double clamp, threshold, gain, saturation; /* of highlights */
    int32_t n_threads;
    bool is_quiet, is_anew;
};

#define AT(member) offsetof(struct accumulate_options, member)

static const struct option options[] = {
    OPTION_OUTPUT_ROW(AT(output), "The picture to write: .exr, float, with the "
                                  "attributes of the first view, or .png, sRGB."),
    OPTION_LAYER_ROW(AT(layer), "average"),
    OPTION_NUMBER_ROW(
        "blend-gamma", AT(blend_gamma), "GAMMA", 0.1, 10,
        "Gamma of the space in which light is summed: 1 is physically linear. [default "
        "rackfocus:blendGamma of the first view, else 1]"),
    OPTION_NUMBER_ROW("highlight-clamp", AT(clamp), "LIGHT", 0, 1e9,
                      "Light that a pixel of a view may have at the most, against "
                      "fireflies. [default 0, no limit]"),
    OPTION_NUMBER_ROW("highlight-threshold", AT(threshold), "LIGHT", 0, 1e9,
                      "Light above which a pixel is a highlight, for gain and "
                      "saturation. [default 1]"),
    OPTION_NUMBER_ROW("highlight-gain", AT(gain), "FACTOR", 0, 1000,
                      "Multiplies what is above the threshold in each view, before the "
                      "mean. [default 1]"),
    OPTION_NUMBER_ROW("highlight-saturation", AT(saturation), "FACTOR", 0, 4,
                      "Saturation of what is above the threshold. [default 1]"),
    OPTION_TEXT_ROW("look", AT(look), "NAME",
                    "Take blend gamma and highlights from a look: " LOOK_NAMES
                    ", your own, or a FILE.params. What it says of the lens is in the "
                    "views already, "
                    "or never will be."),
    OPTION_TEXT_ROW("frames", AT(frames), "LIST",
                    "Sequence (names with ####): these frames, such as 1-240x2,300. "
                    "[default those that there are of the first view]"),
    OPTION_FLAG_ROW("anew", AT(is_anew),
                    "Sequence: also make the frames that are finished."),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_HELP_ROW,
};

struct sum {
    const struct accumulate_options *tool;
    int n_threads;
    struct source first; /* stays open: its attributes go into the output */
    struct rf_context *context;
    struct rf_accumulator *accumulator;
    struct views_light *light;
    struct alpha_tally alpha;
    struct cli_host host;
    bool has_told_primaries;
};

static bool open_view(const struct accumulate_options *tool, char *const *path,
                      struct source *view, struct image_error *error)
{
    const struct source_request request = {
        .paths = path, .n_paths = 1, .layer = tool->layer};
    if (!source_open(view, &request, error))
        return false;
    char text[500];
    const bool is_data = source_has_only_data(view, text, sizeof(text));
    if (view->layer.r >= 0 && !is_data)
        return true;
    if (is_data)
        set_error(error, "%s: %s", *path, text);
    else
        set_error(error,
                  "%s: there is no colour; views are pictures, name their layer with "
                  "--layer",
                  *path);
    source_close(view);
    return false;
}

static bool check_view(const struct sum *sum, const struct source *view,
                       struct image_error *error)
{
    const struct source *first = &sum->first;
    if (memcmp(&view->info.data_window, &first->info.data_window,
               sizeof(view->info.data_window)) == 0 &&
        view->n_channels == first->n_channels && view->is_grey == first->is_grey)
        return true;
    if (view->width == first->width && view->height == first->height &&
        !picture_check_place(image_path(view->colour), &view->info.data_window,
                             image_path(first->colour), &first->info.data_window,
                             error))
        return false;
    set_error(
        error,
        "%s: is %d x %d with %d channels, but %s is %d x %d with %d; views of one "
        "window and kind can be averaged",
        image_path(view->colour), view->width, view->height, view->n_channels,
        image_path(first->colour), first->width, first->height, first->n_channels);
    return false;
}

/* The mean so far has the samples of the first view's kind. */
static struct rf_image image_of(const struct sum *sum, float *samples)
{
    const struct source *first = &sum->first;
    return rf_image_packed(samples, first->width, first->height, first->n_channels);
}

static bool fail_core(const char *path, const struct rf_error *core_error,
                      struct image_error *error)
{
    set_error(error, "%s: %s", path, core_error->message);
    return false;
}

static bool start_sum(struct sum *sum, struct image_error *error)
{
    const struct rf_context_params run = {.size = sizeof(run),
                                          .cpu = getenv("RACKFOCUS_CPU"),
                                          .n_threads = sum->n_threads};
    const struct source *first = &sum->first;
    struct rf_error core_error;
    struct rf_params params;
    rf_params_init(&params);
    params.highlight_clamp = sum->tool->clamp;
    params.highlight_threshold = sum->tool->threshold;
    params.highlight_gain = sum->tool->gain;
    params.highlight_saturation = sum->tool->saturation;
    if (!isnan(sum->tool->blend_gamma))
        params.blend_gamma = sum->tool->blend_gamma;
    else
        image_attribute_number(first->colour, rf_param_find("blend-gamma")->attribute,
                               &params.blend_gamma);
    if (rf_context_create(&sum->context, &run, &core_error) == RF_OK &&
        rf_accumulator_create(&sum->accumulator, sum->context, &params, first->width,
                              first->height, first->n_channels, &core_error) == RF_OK)
        return true;
    return fail_core(image_path(first->colour), &core_error, error);
}

static bool add_samples(struct sum *sum, const struct source *view, int view_index,
                        struct image_error *error)
{
    struct rf_error core_error;
    float *samples = source_read_colour(view, sum->n_threads, error);
    if (!samples)
        return false;
    const size_t width = (size_t)view->width;
    for (size_t y = 0; view->n_channels == 4 && y < (size_t)view->height; y++)
        alpha_tally_add(&sum->alpha, samples + 4 * width * y, width);
    const struct rf_image image = image_of(sum, samples);
    views_light_add(sum->light, view_index, &image, 0);
    const rf_result result = rf_accumulator_add(sum->accumulator, &image, &core_error);
    free(samples);
    return result == RF_OK || fail_core(image_path(view->colour), &core_error, error);
}

/* Of the first view whose numbers are other colours than those of the first one. */
static void warn_of_primaries(struct sum *sum, const struct source *view,
                              char *const *names)
{
    struct image_error ignored;
    struct primaries first, own;
    primaries_read(sum->first.colour, sum->first.part, &first);
    primaries_read(view->colour, view->part, &own);
    if (!sum->has_told_primaries)
        primaries_warn(&sum->host.host, image_path(view->colour), &own, names[0],
                       &first, "the mean is taken of them", &ignored);
    sum->has_told_primaries |= primaries_differ(&own, &first);
}

static bool add_view(struct sum *sum, const struct operands *views, int i,
                     struct image_error *error)
{
    struct source view;
    if (!open_view(sum->tool, &views->items[i], &view, error))
        return false;
    const bool is_added =
        check_view(sum, &view, error) && add_samples(sum, &view, i, error);
    if (is_added)
        warn_of_primaries(sum, &view, views->items);
    source_close(&view);
    return is_added;
}

/* The mean of one eye says which, and is alone in its file, as filter has it. */
static void describe_eye(const struct source *first, const char *eye,
                         struct source_description *description)
{
    if (!first->info.view[0])
        header_facts_add_text(&description->facts, "view", eye);
    for (int i = 0; i < description->output.n_channels; i++) {
        char name[sizeof(description->own_names[i])];
        beside_drop_view(description->own_names[i], eye, name, sizeof(name));
        strcpy(description->own_names[i], name);
    }
}

/* The mean is no view, and has the focus of the plane that stays in place in them. */
static void describe_lens(const struct sum *sum, int n_views,
                          struct source_description *description)
{
    static const char *const of_eye[] = {"multiView", VIEWS_OFFSET "*", VIEWS_SHEAR "*",
                                         NULL};
    const struct source *first = &sum->first;
    const bool is_eye = image_view_count(first->colour) > 1;
    double offset[2], shear_distance;
    if (n_views < 2)
        return;
    description->output.dropped = is_eye ? of_eye : of_eye + 1;
    if (is_eye)
        describe_eye(first, image_view_of(first->colour, first->layer.r), description);
    if (views_find_place(sum->first.colour, NULL, offset, &shear_distance))
        header_facts_add_focus(&description->facts, shear_distance);
    description->output.n_attributes = description->facts.n;
}

static bool write_exr(const struct sum *sum, float *samples, int n_views,
                      struct image_error *error)
{
    char made[96];
    snprintf(made, sizeof(made), "rackfocus %s accumulate, %d views", rf_version(),
             n_views);
    const struct source_output how = {
        .type = IMAGE_SAMPLE_FLOAT, .made = made, .n_threads = sum->n_threads};
    struct source_description description;
    source_describe(&sum->first, &how, &description);
    describe_lens(sum, n_views, &description);
    return source_write_described(&sum->first, sum->tool->output, samples, &description,
                                  sum->n_threads, error);
}

static bool write_png(const struct sum *sum, const float *samples,
                      struct image_error *error)
{
    const struct png_picture png = {
        .source = &sum->first, .samples = samples, .bits = 8};
    return png_picture_write(&sum->host.host, sum->tool->output, &png, error);
}

static bool write_mean(const struct sum *sum, int n_views, struct image_error *error)
{
    const struct source *first = &sum->first;
    struct rf_error core_error;
    float *samples = app_memory((size_t)first->width * (size_t)first->height *
                                    (size_t)first->n_channels,
                                sizeof(*samples), error);
    if (!samples)
        return false;
    const struct rf_image image = image_of(sum, samples);
    bool is_written =
        rf_accumulator_mean(sum->accumulator, &image, &core_error) == RF_OK;
    if (!is_written)
        fail_core(sum->tool->output, &core_error, error);
    else
        is_written = picture_kind(sum->tool->output) == PICTURE_EXR
                         ? write_exr(sum, samples, n_views, error)
                         : write_png(sum, samples, error);
    free(samples);
    return is_written;
}

/* Views whose mean is not that of their light. */
static void warn_of_light(const struct sum *sum, const struct operands *views)
{
    char text[500];
    struct views_light_found found;
    const char *path = image_path(sum->first.colour);
    if (source_is_coded(&sum->first, text, sizeof(text)))
        warning(sum->tool->is_quiet, "%s: %s", path, text);
    if (alpha_is_straight(&sum->alpha))
        warning(sum->tool->is_quiet,
                "%s: %s: oiiotool FILE --ch R,G,B,A --premult -o colour.exr, for each",
                path, alpha_straight_words);
    if (!views_light_differs(sum->light, &found))
        return;
    views_light_explain(&found, text, sizeof(text));
    warning(sum->tool->is_quiet, "%s: %s", views->items[found.view], text);
}

static int add_all(struct sum *sum, const struct operands *views)
{
    struct image_error error;
    struct progress bar;
    bool is_good = start_sum(sum, &error);
    sum->light = views_light_create(views->n, sum->first.width, sum->first.height);
    if (is_good && !sum->light)
        is_good = set_error(&error, "out of memory for %d views", views->n);
    progress_start(&bar, "averaging", sum->tool->is_quiet);
    for (int i = 0; i < views->n && is_good && !os_is_interrupted(); i++) {
        is_good = add_view(sum, views, i, &error);
        progress_report(&bar, (double)(i + 1) / views->n);
    }
    progress_end(&bar);
    if (is_good && os_is_interrupted())
        return os_interrupt_code();
    if (is_good)
        warn_of_light(sum, views);
    if (is_good && write_mean(sum, views->n, &error))
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

/* A pattern and a name beside it may give a view twice; the first that is. By its name,
 * since many views are many pairs. */
static void warn_of_twins(const struct accumulate_options *tool,
                          const struct operands *views)
{
    for (int i = 1; i < views->n; i++)
        for (int k = 0; k < i; k++)
            if (strcmp(views->items[i], views->items[k]) == 0) {
                warning(tool->is_quiet,
                        "%s: is given twice, and counts twice; name each view once",
                        views->items[i]);
                return;
            }
}

static int accumulate(const struct accumulate_options *tool,
                      const struct operands *views)
{
    char text[500];
    struct image_error error;
    struct sum sum = {.tool = tool, .n_threads = thread_count(tool->n_threads)};
    cli_host_open(&sum.host, tool->is_quiet, false);
    if (!picture_check_writable(tool->output, &error) ||
        !open_view(tool, &views->items[0], &sum.first, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    if (tool->threshold != 1 && tool->gain == 1 && tool->saturation == 1)
        warning(tool->is_quiet,
                "--highlight-threshold: has no effect: read only with a highlight-gain "
                "or highlight-saturation other than 1");
    if (choice_is_doubtful(sum.first.colour, &sum.first.layer, tool->layer, text,
                           sizeof(text)))
        warning(tool->is_quiet, "%s: %s; name one with --layer", views->items[0], text);
    warn_of_twins(tool, views);
    const int code = add_all(&sum, views);
    views_light_free(sum.light);
    rf_accumulator_destroy(sum.accumulator);
    rf_context_destroy(sum.context);
    source_close(&sum.first);
    return code;
}

/* ---- sequences ------------------------------------------------------------------ */

/* The names of one frame. */
struct frame {
    struct accumulate_options tool;
    struct operands views;
    uint64_t hash; /* of what it is made of and with */
};

static void frame_free(struct frame *frame)
{
    for (int i = 0; i < frame->views.n; i++)
        free(frame->views.items[i]);
    free(frame->views.items);
    free((char *)frame->tool.output);
}

/* False without memory; to be freed in either case. */
static bool frame_make(struct frame *frame, const struct accumulate_options *tool,
                       const struct operands *views, int32_t number,
                       struct image_error *error)
{
    *frame = (struct frame){.tool = *tool, .hash = FRAME_HASH_START};
    frame->tool.output = frame_name(tool->output, number, error);
    frame->views.items = app_memory((size_t)views->n, sizeof(char *), error);
    frame_hash_text(&frame->hash, rf_version());
    frame_hash_text(&frame->hash, tool->layer);
    frame_hash_bytes(&frame->hash, &tool->blend_gamma, sizeof(tool->blend_gamma));
    const double light[] = {tool->clamp, tool->threshold, tool->gain, tool->saturation};
    frame_hash_bytes(&frame->hash, light, sizeof(light));
    frame_hash_text(&frame->hash, frame->tool.output);
    if (!frame->tool.output || !frame->views.items)
        return false;
    for (int i = 0; i < views->n; i++) {
        char *name = frame_name(views->items[i], number, error);
        if (!name)
            return false;
        frame->views.items[frame->views.n++] = name;
        frame_hash_file(&frame->hash, name);
    }
    return true;
}

/* How many frames ended how. */
struct tally {
    int n_made, n_skipped, n_failed;
};

static int make_frame(const struct frame *frame, int32_t number,
                      struct journal *journal, struct tally *tally)
{
    char sums[FRAME_SUMS];
    const struct frame_files files = {{frame->tool.output}};
    if (!frame->tool.is_anew &&
        frame_is_finished(journal, number, frame->hash, &files)) {
        tally->n_skipped++;
        return EXIT_DONE;
    }
    const double started_s = os_clock_s();
    const int code = accumulate(&frame->tool, &frame->views);
    const double seconds = os_clock_s() - started_s;
    if (code == EXIT_FAILED) {
        message("failed: frame %d", (int)number);
        journal_add_note(journal, number, JOURNAL_FAILED, "the views, see the log");
        tally->n_failed++;
    } else if (code == EXIT_DONE) {
        tally->n_made++;
        if (!frame_sum_files(&files, sums) ||
            journal_add_finished(journal, number, frame->hash, sums, seconds) != 0)
            warning(frame->tool.is_quiet,
                    "%s: cannot be written; frame %d will not be "
                    "skipped",
                    journal->path, (int)number);
        if (!frame->tool.is_quiet) {
            printf("frame %d: %s, %.1f s\n", (int)number, frame->tool.output, seconds);
            fflush(stdout);
        }
    }
    return code;
}

static int check_frame(const struct frame *frame, struct frame_check *check,
                       struct journal *journal)
{
    struct image_error error;
    const struct frame_files files = {{frame->tool.output}};
    check->path = frame_name(frame->tool.output, check->number, NULL);
    if (check->path && frame_check_files(check, journal, &frame->hash, &files, &error))
        return EXIT_DONE;
    return exit_without_memory();
}

/* Frames that fail do not stop the others. */
static int run_frames(const struct accumulate_options *tool,
                      const struct operands *views, const struct frame_list *list,
                      struct frames_report *report)
{
    struct journal journal;
    struct image_error error;
    struct tally tally = {0};
    int code = EXIT_DONE;
    if (!journal_open(&journal, tool->output, &error))
        return exit_without_memory();
    for (int i = 0; i < list->n && !os_is_interrupted(); i++) {
        struct frame frame;
        const bool is_good = frame_make(&frame, tool, views, list->numbers[i], &error);
        if (!is_good)
            code = exit_without_memory();
        else if (report)
            code = check_frame(&frame, &report->frames[i], &journal);
        else
            make_frame(&frame, list->numbers[i], &journal, &tally);
        frame_free(&frame);
        if (code != EXIT_DONE)
            break;
    }
    journal_close(&journal);
    if (!report && !tool->is_quiet)
        printf("%d frame%s: %d averaged, %d skipped, %d failed, %d left\n", list->n,
               list->n == 1 ? "" : "s", tally.n_made, tally.n_skipped, tally.n_failed,
               list->n - tally.n_made - tally.n_skipped - tally.n_failed);
    if (os_is_interrupted())
        return os_interrupt_code();
    return tally.n_failed ? EXIT_FAILED : code;
}

static int warn_of_missing(const struct accumulate_options *tool,
                           const struct operands *views, const struct frame_list *list)
{
    struct image_error error;
    char holes[FRAME_LIST_HOLES];
    if (!frame_list_holes(list, holes, &error))
        return exit_without_memory();
    if (*holes)
        warning(tool->is_quiet, "%s: %s; name with --frames what is to be averaged",
                views->items[0], holes);
    return EXIT_DONE;
}

/* Every view stays; `list` NULL: no sequence. */
static int check_files(const struct accumulate_options *tool,
                       const struct operands *views, const struct frame_list *list)
{
    struct image_error error;
    struct outputs outputs = {.frames = list, .error = &error};
    outputs_add(&outputs, "output", tool->output);
    for (int i = 0; i < views->n; i++)
        outputs_spare(&outputs, NULL, views->items[i]);
    return exit_code(outputs.code, &error);
}

static int accumulate_sequence(const struct accumulate_options *tool,
                               const struct operands *views,
                               struct frames_report *report)
{
    struct frame_list list;
    struct image_error error;
    if (!frame_is_pattern(tool->output)) {
        message("--output: '%s' has no #### for the number of the frame, as the views "
                "have",
                tool->output);
        return EXIT_USAGE;
    }
    if (!(tool->frames ? frame_list_parse(&list, tool->frames, &error)
                       : frame_list_find(&list, views->items[0], &error))) {
        message("%s%s", tool->frames ? "--frames: " : "", error.message);
        return EXIT_USAGE;
    }
    int code = check_files(tool, views, &list);
    if (code == EXIT_DONE && !tool->frames)
        code = warn_of_missing(tool, views, &list);
    if (code == EXIT_DONE && report)
        code = frames_report_start(report, &list, &error) ? EXIT_DONE
                                                          : exit_without_memory();
    if (code == EXIT_DONE)
        code = run_frames(tool, views, &list, report);
    frame_list_free(&list);
    return code;
}

/* What only a sequence has means nothing elsewhere. */
static int accumulate_any(const struct accumulate_options *tool,
                          const struct operands *views, struct frames_report *report)
{
    if (sequence_is_pattern(views->items[0]))
        return accumulate_sequence(tool, views, report);
    if (!report && !tool->frames && !tool->is_anew) {
        int code = check_files(tool, views, NULL);
        if (code == EXIT_DONE)
            code = accumulate(tool, views);
        if (code == EXIT_DONE && !tool->is_quiet)
            printf("%s: mean of %d view%s\n", tool->output, views->n,
                   views->n == 1 ? "" : "s");
        return code;
    }
    message("'%s' is no sequence, for which --frames, --anew and submit are; name its "
            "frames with # for the digits of the number, as in 'view_0.####.exr'",
            views->items[0]);
    return EXIT_USAGE;
}

/* ---- looks ----------------------------------------------------------------------- */

/* Where a parameter of a look goes; NULL: the mean has no use for it. */
static double *option_of(struct accumulate_options *tool, const char *key)
{
    const struct {
        const char *key;
        double *value;
    } all[] = {{"blend-gamma", &tool->blend_gamma},
               {"highlight-clamp", &tool->clamp},
               {"highlight-threshold", &tool->threshold},
               {"highlight-gain", &tool->gain},
               {"highlight-saturation", &tool->saturation}};
    for (size_t i = 0; i < sizeof(all) / sizeof(all[0]); i++)
        if (strcmp(all[i].key, key) == 0)
            return all[i].value;
    return NULL;
}

/* Takes from a look what a mean can have, and says what it cannot. */
static bool take_look(struct accumulate_options *tool, const struct operands *operands)
{
    struct settings settings;
    struct image_error error;
    char unused[256] = "", text[32];
    size_t n, n_used = 0;
    const struct rf_param_info *list = rf_param_list(&n);
    settings_init(&settings);
    if (!look_read(tool->look, &settings, &error)) {
        message("%s", error.message);
        return false;
    }
    for (size_t i = 0; i < n; i++) {
        double *value = option_of(tool, list[i].key);
        if (settings_origin(&settings, list[i].key) == ORIGIN_DEFAULT)
            continue;
        rf_params_get(&settings.params, list[i].key, text, sizeof(text));
        if (!value)
            snprintf(unused + strlen(unused), sizeof(unused) - strlen(unused), "%s%s",
                     *unused ? ", " : "", list[i].key);
        else if (!options_given(operands, list[i].key))
            *value = strtod(text, NULL);
        n_used += value != NULL;
    }
    if (n_used == 0) {
        message("--look %s: %s: of the lens, and cannot be had in a mean of "
                "views that are rendered; where they have depth: rackfocus filter "
                "VIEW.exr ... -o OUT --look %s",
                tool->look, *unused ? unused : "nothing", tool->look);
        return false;
    }
    if (*unused)
        warning(tool->is_quiet, "--look %s: no effect on views that are rendered: %s",
                tool->look, unused);
    return true;
}

int accumulate_command_run(int argc, char **argv, struct frames_report *report)
{
    struct accumulate_options tool = {
        .blend_gamma = NAN, .threshold = 1, .gain = 1, .saturation = 1};
    struct image_error error;
    struct operands operands;
    int code = options_parse(&command_accumulate, argc, argv, &tool, NULL, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    code = EXIT_USAGE;
    if (operands.n == 0)
        message("accumulate needs views, EXR files; see rackfocus accumulate --help");
    else if (!tool.output)
        message("accumulate needs an output, -o FILE.exr or -o FILE.png; see rackfocus "
                "accumulate --help");
    else if (!picture_check_kind(tool.output, &error))
        message("%s", error.message);
    else if (!tool.look || take_look(&tool, &operands)) {
        if (operands.n == 1)
            warning(tool.is_quiet, VIEWS_ONE_IS_MEAN, operands.items[0]);
        code = accumulate_any(&tool, &operands, report);
    }
    operands_free(&operands);
    return code;
}

static int cmd_accumulate(int argc, char **argv)
{
    return accumulate_command_run(argc, argv, NULL);
}

const struct command command_accumulate = {
    .name = "accumulate",
    .summary = "average views from points of the lens",
    .usage =
        "VIEW.exr ... -o OUT [options]\n"
        "       rackfocus accumulate VIEW_0.####.exr ... -o OUT.####.exr [options]",
    .description =
        "Writes the mean of any number of pictures of one size: renders from points of "
        "the lens, each with the frustum sheared so that the plane in focus stays, "
        "give the lens's picture. Needs no depth. One view is in memory at a time; "
        "sums are in double precision.\n\n"
        "Names with #### are sequences, #### the number of the frame: frame by frame, "
        "those that are finished are skipped.",
    .examples = "rackfocus accumulate view_*.exr -o out.exr\n"
                "rackfocus accumulate 'left.####.exr' 'right.####.exr' -o "
                "'out.####.exr' --frames 1-240",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .run = cmd_accumulate,
};
