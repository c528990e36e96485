/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus filter: a pinhole picture and its depth in, the lens's picture out. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commands/filter_command.h"
#include "common/frame_list.h"
#include "console/cli.h"
#include "console/pipes.h"
#include "console/progress.h"
#include "denoise/denoise.h"
#include "file.h"
#include "filter/filter_many.h"
#include "filter/filter_output.h"
#include "filter/filter_run.h"
#include "filter/filter_shrink.h"
#include "filter/seen.h"
#include "filter/temporal.h"
#include "sequence/sequence.h"
#include "sources/depth_repair.h"
#include "sources/looks.h"
#include "sources/params_file.h"
#include "sources/picture.h"
#include "sources/settings.h"
#include "sources/source.h"

/* As --preset names them. */
enum preset { PRESET_STILL, PRESET_SHOT };
#define PRESET_CHOICES "still|shot"

struct options {
    struct filter_options filter;
    struct sequence_options sequence;
    struct pipes pipes;
    int32_t format; /* of standard output: 0 EXR, 1 PNG */
    int32_t preset; /* enum preset */
    bool is_quiet, is_strict;
};

#define AT(member) offsetof(struct options, filter.member)
#define AT_SEQUENCE(member) offsetof(struct options, sequence.member)

static const struct option options[] = {
    OPTION_OUTPUT_ROW(AT(output), "The picture to write: .exr, with the input's "
                                  "windows and attributes, or .png, sRGB."),
    OPTION_DEPTH_FILE_ROW(AT(depth_file)),
    OPTION_DEPTH_CHANNEL_ROW(AT(depth_channel)),
    OPTION_LAYER_ROW(AT(layer), "filter"),
    OPTION_TEXT_ROW(
        "aperture-at", AT(aperture_at), "X,Y",
        "Several views: where the middle of the aperture is on their lens, scene units "
        "right and up; with a smaller aperture a change of viewpoint. [default 0,0]"),
    OPTION_INT_ROW(
        "max-memory", AT(max_memory_mib), "MIB", 1, 1 << 30,
        "Hold no more than so many MiB: what needs more is filtered in windows, "
        "to the same pixels, or fails before it takes them. [default no bound]"),
    OPTION_DISTRIBUTION_ROW(AT(distribution_image)),
    OPTION_FILE_ROW(
        "aperture-image", AT(aperture_image), "FILE",
        "Picture of the aperture for layered, views and scatter, EXR or "
        "PNG of any size, as the camera sees it; implies --aperture image."),
    OPTION_TEXT_ROW("look", AT(look), "NAME",
                    "Look of a kind of lens: " LOOK_NAMES
                    ", your own, or a FILE.params; options "
                    "and --params win over it."),
    OPTION_FILE_ROW("params", AT(params), "FILE",
                    "Parameters, a line 'key value' each, as rackfocus view saves "
                    "them; options win over them."),
    OPTION_FILE_ROW("output-coc", AT(output_coc), "FILE.exr",
                    "Also write the signed radius of every pixel in px (channel Y, "
                    "float; positive behind the focus)."),
    OPTION_CHOICE_ROW(
        "depth-repair", AT(depth_repair), "WHEN", DEPTH_REPAIR_CHOICES,
        "Depth that was multiplied by alpha, anti-aliased or wider than what is seen: "
        "auto undoes it and says "
        "so; off takes the depth as it is, whatever it looks like. [default auto]"),
    OPTION_CHOICE_ROW("mist-falloff", AT(mist_falloff), "KIND", MIST_CHOICES,
                      "Blender's Mist pass as depth: how it grows from start to end; "
                      "with --depth normalised. [default none]"),
    OPTION_TEXT_ROW("filter-layers", AT(filter_layers), "NAMES",
                    "Also write these layers (light groups, normals; separated by "
                    "commas) as the lens blurs them."),
    OPTION_FILE_ROW("holdout", AT(holdout), "FILE.exr",
                    "Deep input: another deep file whose samples hide what is behind "
                    "them and are not shown."),
    OPTION_FILE_ROW("flattened", AT(flattened), "FILE.exr",
                    "Deep input: also write it flat and without blur, with a depth."),
    OPTION_FILE_ROW(
        "reflections-from", AT(reflections_from), "VIEW.exr",
        "Blur what is seen in mirrors and through glass by its own distance, found "
        "from "
        "this second view of the scene with the same light passes (or several, "
        "separated by commas), taken beside the lens' middle; few samples do. Of "
        "several views as the input: views, the word itself; each is told by others."),
    OPTION_TEXT_ROW("reflections-at", AT(reflections_at), "X,Y",
                    "How far the camera of that view was moved to the right and up, "
                    "scene units, where its header does not say it "
                    "(rackfocus:lensOffset)."),
    OPTION_FILE_ROW("reflection-depth", AT(reflection_depth), "NAME",
                    "The same by a depth of what is seen in mirrors: a channel of the "
                    "input, or a file that ends in .exr, 0 where nothing is mirrored; "
                    "or denoising: Cycles' Denoising Depth, for flat mirrors."),
    OPTION_FILE_ROW("transmission-depth", AT(transmission_depth), "NAME",
                    "Likewise of what is seen through glass."),
    OPTION_TEXT_ROW("reflection-layers", AT(reflection_layers), "NAMES",
                    "Layers that hold the light of mirrors, to be added up, separated "
                    "by commas. [default Blender's Glossy passes, specular or "
                    "reflection, whichever are there]"),
    OPTION_TEXT_ROW("transmission-layers", AT(transmission_layers), "NAMES",
                    "Likewise of glass. [default Blender's Transmission passes, "
                    "transmission or refraction]"),
    OPTION_FLAG_ROW("denoise", AT(denoise),
                    "Take the grain out with Open Image Denoise, guided by albedo and "
                    "normals where the file has them; several views are denoised "
                    "before and after they are merged. Takes 16 sub-apertures unless "
                    "--sub-apertures says how many. RACKFOCUS_OIDN names the "
                    "library's folder where the system does not find it."),
    OPTION_DENOISE_QUALITY_ROW(AT(denoise_quality)),
    OPTION_GUIDE_FILE_ROWS(AT(albedo_file), AT(normal_file)),
    OPTION_INT_ROW("supersample", AT(supersample), "N", 1, FILTER_MOST_SUPERSAMPLE,
                   "The input was rendered at N times the size, with an N^2-th of the "
                   "samples, and the result has an N-th of its size. [default 1]"),
    OPTION_PIXEL_FILTER_ROWS(AT(pixel_filter), AT(pixel_filter_width)),
    OPTION_FLAG_ROW("over", AT(is_over),
                    "The inputs are layers: filter each with its own depth and put "
                    "them over each other, the first on top."),
    OPTION_FLAG_ROW(
        "stereo", AT(is_stereo),
        "Filter all views of a multi-view file, or two files, left and right, with the "
        "same parameters. The output is a multi-view file, or a file per view where "
        "its name holds %V, the view's name, or %v, its first letter."),
    OPTION_FLAG_ROW("pass-through", AT(pass_through),
                    "Also write the input's other layers and its depth, unchanged."),
    OPTION_CHOICE_ROW("format", offsetof(struct options, format), "KIND", "exr|png",
                      "Of standard output (-o -): exr or png. [default exr]"),
    OPTION_CHOICE_ROW("type", AT(type), "TYPE", "half|float",
                      "Samples of the EXR file: half or float. [default half]"),
    OPTION_CHOICE_ROW("compression", AT(compression), "KIND", FILTER_COMPRESSIONS,
                      "Compression of the EXR file: input (as there; zip for DWAA and "
                      "DWAB, which are only read), none, rle, zips, zip, piz, pxr24, "
                      "b44 or b44a. [default input]"),
    OPTION_CHOICE_ROW("png-bits", AT(png_bits), "BITS", "8|16",
                      "Bits per sample of the PNG file: 8 or 16. [default 8]"),
    OPTION_TEXT_ROW("frames", AT_SEQUENCE(frames), "LIST",
                    "Sequence (names with ####): these frames, such as 1-240x2,300. "
                    "[default those that there are]"),
    OPTION_FILE_ROW("frame-parameters", AT_SEQUENCE(parameters), "FILE.csv",
                    "Sequence: parameters per frame; the first line names the columns, "
                    "as in frame,focus-distance. With a column easing (hold, linear, "
                    "ease-in, ease-out, ease-in-out) rows are key frames."),
    OPTION_FLAG_ROW("anew", AT_SEQUENCE(is_anew),
                    "Sequence: also make the frames that are finished."),
    OPTION_INT_ROW("jobs", AT_SEQUENCE(n_jobs), "N", 1, 16,
                   "Sequence: frames at a time, so that files are read and written "
                   "while others are filtered. [default 2]"),
    OPTION_INT_ROW("temporal", AT(temporal), "N", 0, TEMPORAL_MOST,
                   "Sequence: what a frame hides is taken from so many frames before "
                   "and after it, by the camera in their headers (worldToCamera) or a "
                   "pass of motion vectors; 3 do for most shots. [default 0]"),
    OPTION_CHOICE_ROW("preset", offsetof(struct options, preset), "KIND",
                      PRESET_CHOICES,
                      "What the pictures are for: still, each by itself; shot, frames "
                      "that are seen one after the other: --temporal 3. Options win "
                      "over it. [default still]"),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(offsetof(struct options, is_quiet)),
    OPTION_STRICT_ROW(offsetof(struct options, is_strict)),
    OPTION_HELP_ROW,
};

static bool fail_usage(const char *text)
{
    message("%s; see rackfocus filter --help", text);
    return false;
}

/* Several pictures, each with its own depth. */
static bool check_many(const struct filter_options *tool, int n)
{
    if (tool->is_over && tool->is_stereo)
        return fail_usage("--over and --stereo do not go together");
    if (tool->is_over && n < 2)
        return fail_usage("--over takes two layers or more");
    if (tool->is_stereo && n > 2)
        return fail_usage("--stereo takes one multi-view file or two files");
    if (tool->depth_file)
        return fail_usage("--over and --stereo take the depth from each input; leave "
                          "out --depth-file");
    if (tool->pass_through || tool->output_coc || tool->flattened)
        return fail_usage("--pass-through, --output-coc and --flattened are of one "
                          "picture; leave out --over and --stereo");
    if (tool->temporal)
        return fail_usage("--temporal and --preset shot are of one picture; leave out "
                          "--over and --stereo, and filter the eyes one by one with "
                          "--layer");
    if (tool->is_over && tool->supersample > 1)
        return fail_usage("--supersample is of one picture; leave out --over, and "
                          "put the results over each other");
    if (seen_is_asked(tool))
        return fail_usage("--reflections-from and other reflection and transmission "
                          "options are of one picture; leave out --over and --stereo");
    if (tool->is_over && tool->filter_layers)
        return fail_usage("--filter-layers is of one picture; leave out --over");
    if (tool->is_stereo && tool->output && !filter_has_view_mark(tool->output) &&
        picture_kind(tool->output) == PICTURE_PNG)
        return fail_usage("--stereo writes a PNG per view; put %V into its name");
    return true;
}

static bool check_usage(const struct filter_options *tool,
                        const struct operands *operands)
{
    if (operands->n == 0)
        return fail_usage("filter needs an input, an EXR file with colour and depth");
    if (operands->n == 2 && tool->depth_file)
        return fail_usage("filter takes one file of colour and one of depth");
    if ((tool->is_over || tool->is_stereo) && !check_many(tool, operands->n))
        return false;
    if (operands->n > RF_MAX_VIEWS)
        return fail_usage("filter takes 64 views at most");
    const char *pixels =
        options_refuse_pixel_filter(operands, tool->supersample, tool->pixel_filter);
    if (pixels)
        return fail_usage(pixels);
    if (tool->denoise_quality != DENOISE_HIGH && !tool->denoise)
        return fail_usage("--denoise-quality goes with --denoise");
    if ((tool->albedo_file || tool->normal_file) && !tool->denoise)
        return fail_usage("--albedo-file and --normal-file go with --denoise");
    if (tool->normal_file && !tool->albedo_file)
        return fail_usage(
            "--normal-file goes with --albedo-file: the denoiser takes no "
            "normals alone");
    if (tool->albedo_file && (tool->is_over || tool->is_stereo))
        return fail_usage(
            "--albedo-file and --normal-file are of one picture; leave out "
            "--over and --stereo");
    if (!tool->output)
        return fail_usage("filter needs an output, -o FILE.exr or -o FILE.png");
    struct image_error error;
    if (options_given(operands, "format") &&
        picture_kind(tool->output) == PICTURE_UNKNOWN &&
        os_file_facts(tool->output).kind != OS_FILE_OTHER) {
        message("%s: --format is of the standard output, -o -; what a file is says the "
                "ending of its name: .exr or .png",
                tool->output);
        return false;
    }
    if (!picture_check_kind(tool->output, &error)) {
        message("%s", error.message);
        return false;
    }
    if (picture_kind(tool->output) == PICTURE_PNG && tool->pass_through)
        return fail_usage("--pass-through needs an output that ends in .exr");
    if (picture_kind(tool->output) == PICTURE_PNG && tool->filter_layers)
        return fail_usage("--filter-layers needs an output that ends in .exr");
    if (tool->output_coc && picture_kind(tool->output_coc) != PICTURE_EXR) {
        message("--output-coc: '%s' does not end in .exr; radii are written as EXR",
                tool->output_coc);
        return false;
    }
    if (tool->flattened && picture_kind(tool->flattened) != PICTURE_EXR) {
        message("--flattened: '%s' does not end in .exr; the flat picture has a depth "
                "and is written as EXR",
                tool->flattened);
        return false;
    }
    return true;
}

/* Only the inputs themselves can come through a pipe. */
static bool check_no_dash(const char *option, const char *name)
{
    char words[64];
    if (!name || strcmp(name, "-") != 0)
        return true;
    snprintf(words, sizeof(words), "%s", option);
    for (char *at = words; *at; at++)
        *at = *at == '_' ? '-' : *at;
    message("--%s: takes a file; - is the standard input as one of the inputs only%s",
            words,
            strcmp(words, "depth-file") == 0
                ? ", also that of the depth: rackfocus filter colour.exr - -o out.exr"
                : "");
    return false;
}

#define DASH_OUTPUT(name) true
#define DASH_TEXT(name) true
#define DASH_NUMBER(name) true
#define DASH_ASIDE(name) true
#define DASH_INPUT(name) check_no_dash(#name, tool->name)
#define DASH_INPUTS(name) DASH_INPUT(name)
#define DASH_INPUT_OR_TEXT(name) DASH_INPUT(name)
#define DASH(kind, type, name) &&DASH_##kind(name)

static bool check_no_dashes(const struct options *all)
{
    const struct filter_options *tool = &all->filter;
    return check_no_dash("params", tool->params) &&
           check_no_dash("frame-parameters", all->sequence.parameters)
               FILTER_OPTIONS(DASH);
}

/* A name with #### is for the frames of a sequence, which the input is not. */
static bool check_no_frames(const struct filter_options *tool, const char *input)
{
    const char *const outputs[] = {tool->output, tool->output_coc, tool->flattened};
    char pattern[4096];
    for (size_t i = 0; i < sizeof(outputs) / sizeof(outputs[0]); i++) {
        if (!outputs[i] || !frame_is_pattern(outputs[i]) || frame_is_pattern(input))
            continue;
        if (frame_guess_pattern(input, pattern, sizeof(pattern)))
            message("'%s' names frames of a sequence, and '%s' is one file; for the "
                    "sequence give '%s' as the input",
                    outputs[i], input, pattern);
        else
            message("'%s' names frames of a sequence, and the input '%s' is none; give "
                    "a name without %s",
                    outputs[i], input, strchr(outputs[i], '#') ? "####" : "a number");
        return false;
    }
    return true;
}

/* Names that no shell has expanded. */
static bool check_globs(const struct operands *operands)
{
    for (int i = 0; i < operands->n; i++) {
        char pattern[4096];
        const char *name = operands->items[i], *star = strpbrk(name, "*?[");
        if (os_file_facts(name).kind != OS_FILE_NONE)
            continue;
        if (frame_is_in_folder(name, pattern, sizeof(pattern))) {
            message("%s: the number of a frame is looked for in the name of its file, "
                    "not of a folder; link the files side by side: %s",
                    name, pattern);
            return false;
        }
        if (frame_guess_foreign(name, pattern, sizeof(pattern))) {
            message("%s: there is no such file; the number of a sequence's frames is "
                    "written with #, and which they are by --frames: '%s'",
                    name, pattern);
            return false;
        }
        if (!star)
            continue;
        snprintf(pattern, sizeof(pattern), "%.*s####%s", (int)(star - name), name,
                 star + 1);
        if (*star == '*')
            message(
                "%s: there is no such file; the frames of a sequence are named with "
                "# for the digits of their number: '%s'",
                name, pattern);
        else
            message(
                "%s: there is no such file; the frames of a sequence are named with "
                "# for the digits of their number, as in 'shot.####.exr'",
                name);
        return false;
    }
    return true;
}

/* What only a sequence has means nothing elsewhere. */
static bool check_sequence(const struct options *all, const struct operands *operands)
{
    const struct sequence_options *sequence = &all->sequence;
    const char *input = operands->items[0];
    if (sequence_is_pattern(operands->items[0]))
        return !all->filter.is_stereo || !filter_has_view_mark(all->filter.output) ||
               fail_usage("--stereo writes one multi-view file per frame of a "
                          "sequence; leave %V out of the name");
    const char *given = sequence->frames       ? "frames"
                        : sequence->parameters ? "frame-parameters"
                        : sequence->is_anew    ? "anew"
                        : sequence->n_jobs     ? "jobs"
                        : all->preset          ? "preset shot"
                        : all->filter.temporal ? "temporal"
                                               : NULL;
    if (given)
        message(
            "--%s: is for sequences; name them with # for the digits of the number, "
            "as in 'shot.####.exr'",
            given);
    return given == NULL && check_no_frames(&all->filter, input);
}

/* Options of the file that another kind of file does not have. */
static int warn_of_kind(const struct filter_options *tool, bool is_piped,
                        const struct operands *operands, struct image_error *error)
{
    static const struct {
        const char *name;
        enum picture_kind kind;
        const char *what;
    } options_of_kind[] = {{"png-bits", PICTURE_PNG, "PNG"},
                           {"type", PICTURE_EXR, "EXR"},
                           {"compression", PICTURE_EXR, "EXR"}};
    if (options_given(operands, "format") && !is_piped) {
        const int code = app_warn(tool->host, error,
                                  "--format: has no effect: the ending of the output's "
                                  "name says it");
        if (code != APP_DONE)
            return code;
    }
    for (size_t i = 0; i < sizeof(options_of_kind) / sizeof(options_of_kind[0]); i++) {
        if (!options_given(operands, options_of_kind[i].name) ||
            picture_kind(tool->output) == options_of_kind[i].kind)
            continue;
        const int code = app_warn(tool->host, error,
                                  "--%s: has no effect: read only for outputs in %s",
                                  options_of_kind[i].name, options_of_kind[i].what);
        if (code != APP_DONE)
            return code;
    }
    return APP_DONE;
}

static int run(struct options *all, struct settings *settings,
               const struct operands *operands, struct image_error *error)
{
    struct filter_options *tool = &all->filter;
    struct cli_host host;
    const struct settings typed = *settings;
    struct sequence_options sequence = all->sequence;
    sequence.typed = &typed;
    tool->host = cli_host_open(&host, all->is_quiet, all->is_strict);
    if (all->pipes.has_output) {
        host.results = stderr;
        tool->shown_output = "standard output";
    }
    int n_named = 0;
    if (tool->params && !params_file_read(tool->params, settings, &n_named, error)) {
        app_missing(error, "params", tool->params);
        return app_code_of(error);
    }
    if (tool->look && !look_read(tool->look, settings, error))
        return APP_USAGE;
    int code = APP_DONE;
    if (tool->params && n_named == 0)
        code =
            app_warn(tool->host, error, "--params " PARAMS_FILE_IS_EMPTY, tool->params);
    if (code == APP_DONE)
        code = warn_of_kind(tool, all->pipes.has_output, operands, error);
    if (code != APP_DONE)
        return code;
    if (all->sequence.report && !sequence_is_pattern(operands->items[0]))
        return app_fail(error, APP_USAGE,
                        "filter: '%s' is no sequence; name its frames with # for the "
                        "digits of the number, as in 'shot.####.exr'",
                        operands->items[0]);
    if (sequence_is_pattern(operands->items[0]))
        return sequence_run(&sequence, tool, settings, operands->items, operands->n,
                            error);
    code = filter_check_files(tool, operands->items, operands->n, NULL, error);
    if (code != APP_DONE)
        return code;
    return filter_any(tool, settings, operands->items, operands->n, error);
}

int filter_command_run(int argc, char **argv, struct frames_report *report)
{
    struct options all = {.sequence.report = report};
    const struct filter_options *tool = &all.filter;
    struct settings settings;
    struct operands operands;
    struct image_error error;
    enum app_code opened;
    int code = options_parse(&command_filter, argc, argv, &all, &settings, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    if (all.preset == PRESET_SHOT && !options_given(&operands, "temporal"))
        all.filter.temporal = TEMPORAL_OF_SHOTS;
    if (pipes_are_named(&operands, tool->output) &&
        (opened = pipes_open(&all.pipes, &operands, &all.filter.output, all.format == 1,
                             &error)) != APP_DONE)
        code = exit_code(opened, &error);
    else if (!check_usage(tool, &operands) || !check_no_dashes(&all) ||
             !check_globs(&operands) || !check_sequence(&all, &operands))
        code = EXIT_USAGE;
    else
        code = exit_code(run(&all, &settings, &operands, &error), &error);
    if (code == EXIT_DONE && all.pipes.has_output && !pipes_send(&all.pipes, &error))
        code = exit_code(APP_FAILED, &error);
    pipes_close(&all.pipes);
    operands_free(&operands);
    return code;
}

static int cmd_filter(int argc, char **argv)
{
    return filter_command_run(argc, argv, NULL);
}

const struct command command_filter = {
    .name = "filter",
    .summary = "give a rendered picture its lens",
    .usage = "IN.exr [DEPTH.exr] -o OUT [options]\n"
             "       rackfocus filter VIEW.exr VIEW.exr ... -o OUT [options]\n"
             "       rackfocus filter TOP.exr ... BOTTOM.exr --over -o OUT [options]\n"
             "       rackfocus filter LEFT.exr RIGHT.exr --stereo -o OUT [options]\n"
             "       rackfocus filter IN.####.exr -o OUT.####.exr [options]",
    .description =
        "Blurs a pinhole render by its depth, as the lens would have. IN.exr holds the "
        "colour and, unless a second file is given, the depth. What the camera was is "
        "read from the header where it says so; options win over the header.\n\n"
        "Several inputs that each hold colour and depth and say in the header where on "
        "the lens they were taken (rackfocus:lensOffset) are merged by the method "
        "views; the camera is that of the first.\n\n"
        "What is seen in flat mirrors and through panes is blurred by its own distance "
        "with --reflections-from.\n\n"
        "Transparent things are rendered as a layer of their own, with alpha and "
        "depth, and put over with --over.\n\n"
        "A deep file is filtered sample by sample: what is hidden, transparent or a "
        "volume is seen as the lens sees it.\n\n"
        "A name with #### is a sequence, #### the number of the frame. Frames that are "
        "finished and would be made in the same way are skipped, those that fail are "
        "listed at the end.\n\n"
        "- is standard input and output: 'render | rackfocus filter - -o -'.\n\n"
        "The output is written beside its place and renamed, so an old file survives "
        "any failure; one that is an input is refused, since its depth would be lost.",
    .examples =
        "rackfocus filter passes.exr -o out.exr --focus-distance 8 --f-stop 1.4\n"
        "rackfocus filter colour.exr --depth-file z.exr -o out.png --blades 6\n"
        "rackfocus filter passes_v*.exr -o out.exr --focus-distance 8\n"
        "rackfocus filter 'shot.####.exr' -o 'out.####.exr' --frames 1-240x2\n"
        "rackfocus filter glass.exr beauty.exr --over -o out.exr\n"
        "rackfocus filter passes.exr -o out.exr --reflections-from second.exr\n"
        "rackfocus filter stereo.exr --stereo -o out_%V.exr\n"
        "rackfocus filter ortho.exr -o out.exr --projection orthographic "
        "--ortho-scale 4",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_filter,
};
