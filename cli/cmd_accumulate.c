/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus accumulate: the mean of several views, one in memory at a time. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "interrupt.h"
#include "picture.h"
#include "progress.h"
#include "rackfocus/rackfocus.h"
#include "source.h"

struct accumulate_options {
    const char *output, *layer;
    double blend_gamma; /* NAN: from the header */
    int32_t n_threads;
    bool is_quiet;
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
};

static bool open_view(const struct accumulate_options *tool, char *const *path,
                      struct source *view, struct image_error *error)
{
    const struct source_request request = {
        .paths = path, .n_paths = 1, .layer = tool->layer};
    if (!source_open(view, &request, error))
        return false;
    if (view->layer.r >= 0)
        return true;
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

static bool add_samples(struct sum *sum, const struct source *view,
                        struct image_error *error)
{
    struct rf_error core_error;
    float *samples = source_read_colour(view, sum->n_threads, error);
    if (!samples)
        return false;
    const struct rf_image image = image_of(sum, samples);
    const rf_result result = rf_accumulator_add(sum->accumulator, &image, &core_error);
    free(samples);
    return result == RF_OK || fail_core(image_path(view->colour), &core_error, error);
}

static bool add_view(struct sum *sum, char *const *path, struct image_error *error)
{
    struct source view;
    if (!open_view(sum->tool, path, &view, error))
        return false;
    const bool is_added =
        check_view(sum, &view, error) && add_samples(sum, &view, error);
    source_close(&view);
    return is_added;
}

static bool write_exr(const struct sum *sum, float *samples, int n_views,
                      struct image_error *error)
{
    char made[96];
    snprintf(made, sizeof(made), "rackfocus %s accumulate, %d views", rf_version(),
             n_views);
    const struct source_output how = {
        .type = IMAGE_SAMPLE_FLOAT, .made = made, .n_threads = sum->n_threads};
    return source_write_colour(&sum->first, sum->tool->output, samples, &how, error);
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
        is_written =
            picture_kind(sum->tool->output) == PICTURE_EXR
                ? write_exr(sum, samples, n_views, error)
                : image_write_png(sum->tool->output, samples, first->width,
                                  first->height, first->n_channels, 8, false, error);
    free(samples);
    return is_written;
}

static int add_all(struct sum *sum, const struct operands *views)
{
    struct image_error error;
    struct progress bar;
    bool is_good = start_sum(sum, &error);
    progress_start(&bar, "averaging", sum->tool->is_quiet);
    for (int i = 0; i < views->n && is_good && !os_is_interrupted(); i++) {
        is_good = add_view(sum, &views->items[i], &error);
        progress_report(&bar, (double)(i + 1) / views->n);
    }
    progress_end(&bar);
    if (is_good && os_is_interrupted())
        return os_interrupt_code();
    if (is_good && write_mean(sum, views->n, &error))
        return EXIT_DONE;
    message("%s", error.message);
    return EXIT_FAILED;
}

static int accumulate(const struct accumulate_options *tool,
                      const struct operands *views)
{
    struct image_error error;
    struct sum sum = {.tool = tool, .n_threads = thread_count(tool->n_threads)};
    if (!picture_check_writable(tool->output, &error) ||
        !open_view(tool, &views->items[0], &sum.first, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    const int code = add_all(&sum, views);
    rf_accumulator_destroy(sum.accumulator);
    rf_context_destroy(sum.context);
    source_close(&sum.first);
    return code;
}

static int cmd_accumulate(int argc, char **argv)
{
    struct accumulate_options tool = {.blend_gamma = NAN};
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
    else
        code = accumulate(&tool, &operands);
    operands_free(&operands);
    return code;
}

const struct command command_accumulate = {
    .name = "accumulate",
    .summary = "average views from points of the lens",
    .usage = "VIEW.exr ... -o OUT [options]",
    .description =
        "Writes the mean of any number of pictures of one size: renders from points of "
        "the lens, each with the frustum sheared so that the plane in focus stays, "
        "give the lens's picture. Needs no depth. One view is in memory at a time; "
        "sums are in double precision.",
    .examples = "rackfocus accumulate view_*.exr -o out.exr",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .run = cmd_accumulate,
};
