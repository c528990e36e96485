/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus info: what a file holds and what the lens would do to it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands/info_print.h"
#include "console/cli.h"
#include "console/pipes.h"
#include "sources/alpha.h"
#include "sources/deep.h"
#include "sources/settings.h"
#include "sources/source.h"

struct info_options {
    const char *depth_file, *depth_channel, *layer;
    int32_t n_threads;
    bool is_json, is_all;
};

#define AT(member) offsetof(struct info_options, member)

static const struct option options[] = {
    OPTION_DEPTH_FILE_ROW(AT(depth_file)),
    OPTION_DEPTH_CHANNEL_ROW(AT(depth_channel)),
    OPTION_LAYER_ROW(AT(layer), "look at"),
    OPTION_FLAG_ROW("json", AT(is_json), "Print everything as JSON."),
    OPTION_FLAG_ROW("all", AT(is_all),
                    "Also print the parameters that have their defaults."),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_HELP_ROW,
};

static void explain_radii(struct info *info, const struct rf_params *params,
                          const struct rf_error *error)
{
    char way_out[500] = "";
    if (error->code == RF_ERROR_DEPTH)
        depth_explain(&info->depth.numbers, &info->source, params, way_out,
                      sizeof(way_out));
    snprintf(info->radius_problem, sizeof(info->radius_problem), "%s%s", error->message,
             way_out);
}

/* The radii of every pixel; leaves has_radii false where the depth does not allow it.
 */
static void measure_radii(struct info *info, const struct rf_params *params,
                          float *depth)
{
    const struct source *source = &info->source;
    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    struct rf_error error;
    const struct rf_image image =
        rf_image_packed(depth, source->width, source->height, 1);
    if (rf_context_create(&context, NULL, &error) == RF_OK &&
        rf_filter_create(&filter, context, params, source->width, source->height,
                         &error) == RF_OK &&
        rf_filter_coc(filter, &image, &image, &error) == RF_OK)
        info_count_radii(info, depth);
    else
        explain_radii(info, params, &error);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
}

/* The flat depth and colour of a deep file, and how many samples it has. */
static bool read_deep(struct info *info, const struct rf_params *params, int n_threads,
                      float **depth, float **colour, struct image_error *error)
{
    const struct source *source = &info->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    struct deep_frame deep;
    struct rf_context *context = NULL;
    struct rf_filter *filter = NULL;
    struct rf_error core_error;
    if (!deep_read(&deep, source, NULL, n_threads, error))
        return false;
    *depth = app_memory(n, sizeof(float), error);
    *colour = app_memory(n, (size_t)source->n_channels * sizeof(float), error);
    const bool has_memory = *depth && *colour;
    const bool is_flat =
        has_memory && rf_context_create(&context, NULL, &core_error) == RF_OK &&
        rf_filter_create(&filter, context, params, source->width, source->height,
                         &core_error) == RF_OK &&
        deep_flatten(&deep, filter, source, *colour, *depth, &core_error) == RF_OK;
    if (has_memory && !is_flat)
        set_error(error, "%s: %s", image_path(source->colour), core_error.message);
    info_count_deep(info, &deep.frame);
    rf_filter_destroy(filter);
    rf_context_destroy(context);
    deep_free(&deep);
    return is_flat;
}

static bool has_straight_alpha(const struct source *source, const float *colour)
{
    struct alpha_tally tally = {0};
    const size_t width = (size_t)source->width, height = (size_t)source->height;
    for (size_t y = 0; source->n_channels == 4 && y < height; y++)
        alpha_tally_add(&tally, colour + 4 * width * y, width);
    return alpha_is_straight(&tally);
}

static bool measure_depth(struct info *info, const struct rf_params *params,
                          int n_threads, struct image_error *error)
{
    const struct source *source = &info->source;
    const bool has_colour = source->layer.r >= 0;
    float *colour = NULL, *depth = NULL;
    bool is_read;
    if (source->info.is_deep && source->layer.r >= 0) {
        is_read = read_deep(info, params, n_threads, &depth, &colour, error);
    } else {
        depth = source_read_depth(source, n_threads, error);
        if (depth && has_colour)
            colour = source_read_colour(source, n_threads, error);
        is_read = depth && (!has_colour || colour);
    }
    const struct rf_depth_channel channel = {
        depth,
        rf_image_packed(colour, source->width, source->height, source->n_channels),
        source->width, source->height, info->settings.params.depth_infinity};
    if (is_read && !depth_find(&info->depth, source, &info->settings,
                               info->has_lens ? &info->lens : NULL, &channel))
        is_read = set_error(error, "%s: out of memory", image_path(source->depth));
    if (is_read) {
        info->has_stats = true;
        info->is_straight =
            colour && !source->info.is_deep && has_straight_alpha(source, colour);
        if (info->has_lens)
            measure_radii(info, params, depth);
    }
    free(colour);
    free(depth);
    return is_read;
}

static int look(struct info *info, const struct info_options *tool)
{
    char text[1024];
    struct image_error error;
    struct rf_error lens_error;
    struct rf_params params;
    const struct source *source = &info->source;
    if (!source_read_facts(source, &info->settings, text, sizeof(text))) {
        message("%s", text);
        return EXIT_FAILED;
    }
    info->has_lens = settings_fit_window(&info->settings, &source->info, &params,
                                         &lens_error) == RF_OK &&
                     rf_lens_init(&info->lens, &params, source->width, source->height,
                                  &lens_error) == RF_OK;
    if (!info->has_lens)
        snprintf(info->lens_problem, sizeof(info->lens_problem), "%s",
                 lens_error.message);
    const bool is_bare_deep = source->info.is_deep && source->layer.r < 0;
    const bool is_one_size = source->z >= 0 && !is_bare_deep &&
                             (source->layer.r < 0 || source_check(source, &error));
    if (is_bare_deep)
        message("%s: its deep samples have no colour, as those of a shadow map: there "
                "is nothing to blur",
                image_path(source->colour));
    else if (source->z >= 0 && !is_one_size)
        message("%s", error.message);
    if (is_one_size &&
        !measure_depth(info, &params, thread_count(tool->n_threads), &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    if (tool->is_json)
        info_print_json(info);
    else
        info_print_text(info, tool->is_all);
    return EXIT_DONE;
}

static int cmd_info(int argc, char **argv)
{
    struct info_options tool = {0};
    struct info *info = app_memory(1, sizeof(*info), NULL);
    if (!info)
        return exit_without_memory();
    struct operands operands;
    int code =
        options_parse(&command_info, argc, argv, &tool, &info->settings, &operands);
    if (code != OPTIONS_GO_ON) {
        free(info);
        return code;
    }
    const struct source_request request = {.paths = operands.items,
                                           .n_paths = operands.n,
                                           .layer = tool.layer,
                                           .depth_file = tool.depth_file,
                                           .depth_channel = tool.depth_channel};
    struct image_error error;
    struct pipes pipes = {.folder = ""};
    enum app_code opened;
    if (operands.n < 1 || operands.n > 2) {
        message("info takes one EXR file, and one of depth at most, not %d; see "
                "rackfocus info --help",
                operands.n);
        code = EXIT_USAGE;
    } else if (!options_are_of_one_frame(&operands, "info")) {
        code = EXIT_USAGE;
    } else if (pipes_are_named(&operands, NULL) &&
               (opened = pipes_open(&pipes, &operands, NULL, false, &error)) !=
                   APP_DONE) {
        code = exit_code(opened, &error);
    } else if (!source_open(&info->source, &request, &error)) {
        message("%s", error.message);
        code = EXIT_FAILED;
    } else {
        code = look(info, &tool);
        source_close(&info->source);
    }
    pipes_close(&pipes);
    operands_free(&operands);
    free(info);
    return code;
}

const struct command command_info = {
    .name = "info",
    .summary = "show what a file holds and what the lens would do to it",
    .usage = "IN.exr [DEPTH.exr] [options]",
    .description =
        "Shows the channels and windows of a file, the blur radii that the lens gives, "
        "the limits of the depth of field and the hyperfocal distance, the range of "
        "the "
        "depth and the kind it seems to be, the camera's facts and where each value "
        "came from; --all shows all parameters.",
    .examples = "rackfocus info passes.exr\n"
                "rackfocus info passes.exr --focus-distance 8 --f-stop 1.4 --json",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_info,
};
