/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus finish: the renderer's own lens without its grain, guided by ours. */
#include <stddef.h>

#include "console/cli.h"
#include "console/progress.h"
#include "denoise/denoise.h"
#include "filter/filter_run.h"
#include "filter/filter_shrink.h"
#include "filter/finish.h"
#include "filter/finish_headers.h"
#include "sources/picture.h"
#include "sources/settings.h"

struct options {
    struct finish_options finish;
    const char *guide;
    bool is_quiet, is_strict;
};

#define AT(member) offsetof(struct options, finish.member)

static const struct option options[] = {
    OPTION_OUTPUT_ROW(AT(output), "The picture to write: .exr, with the windows and "
                                  "attributes of OWN.exr, or .png, sRGB."),
    OPTION_FILE_ROW("guide", offsetof(struct options, guide), "FILE",
                    "The only guide, in place of the files after OWN.exr."),
    OPTION_FILE_ROW(
        "half", AT(half), "FILE.exr",
        "A second render like OWN.exr with another seed: each has half of "
        "the samples. Their mean is finished, and what they differ by tells "
        "the grain."),
    OPTION_INT_ROW(
        "samples", AT(samples), "N", 1, FINISH_MOST_SAMPLES,
        "Samples in a pixel of OWN.exr; of fewer than 10 the grain is told by "
        "more pixels. [default: what Cycles wrote into the header]"),
    OPTION_FILE_ROW("output-error", AT(output_error), "FILE.exr",
                    "Also write the estimate of the error of every pixel, after "
                    "clipping to [0, 1] and gamma 2.2 (channel Y, float)."),
    OPTION_GUIDE_FILE_ROWS(AT(albedo_file), AT(normal_file)),
    OPTION_DENOISE_QUALITY_ROW(AT(quality)),
    OPTION_INT_ROW("supersample", AT(supersample), "N", 1, FILTER_MOST_SUPERSAMPLE,
                   "The passes were rendered at N times the size of OWN.exr, with an "
                   "N^2-th of the samples, as for filter. [default 1]"),
    OPTION_PIXEL_FILTER_ROWS(AT(pixel_filter), AT(pixel_filter_width)),
    OPTION_CHOICE_ROW("type", AT(type), "TYPE", "half|float",
                      "Samples of the EXR file: half or float. [default half]"),
    OPTION_CHOICE_ROW("png-bits", AT(png_bits), "BITS", "8|16",
                      "Bits per sample of the PNG file: 8 or 16. [default 8]"),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(offsetof(struct options, is_quiet)),
    OPTION_STRICT_ROW(offsetof(struct options, is_strict)),
    OPTION_HELP_ROW,
};

static bool check_usage(const struct options *all, const struct operands *operands)
{
    const struct finish_options *tool = &all->finish;
    struct image_error error;
    const char *text = NULL;
    const char *pixels =
        options_refuse_pixel_filter(operands, tool->supersample, tool->pixel_filter);
    if (operands->n == 0)
        text = "finish needs a picture that was rendered with the lens, OWN.exr";
    else if (!tool->output)
        text = "finish needs an output, -o FILE.exr or -o FILE.png";
    else if (!picture_check_kind(tool->output, &error))
        text = error.message;
    else if (all->guide && operands->n > 1)
        text = "finish takes its guides after OWN.exr or by --guide, not both";
    else if (tool->output_error && picture_kind(tool->output_error) != PICTURE_EXR)
        text = "--output-error is written as EXR; end its name in .exr";
    else if (tool->supersample > 1 && !all->guide && operands->n == 1)
        text = "--supersample is of passes, which come after OWN.exr";
    else if (tool->samples > 0 && !all->guide && operands->n == 1)
        text = "--samples is for a guide, which comes after OWN.exr";
    else if (pixels)
        text = pixels;
    else if (tool->normal_file && !tool->albedo_file)
        text = "--normal-file goes with --albedo-file: the denoiser takes no normals "
               "alone";
    if (text)
        message("%s; see rackfocus finish --help", text);
    return text == NULL && options_are_of_one_frame(operands, "finish");
}

static int run(struct options *all, struct settings *settings,
               const struct operands *operands, struct image_error *error)
{
    struct cli_host host;
    char *guide[] = {(char *)all->guide};
    const bool has_one = all->guide != NULL;
    all->finish.host = cli_host_open(&host, all->is_quiet, all->is_strict);
    return finish_run(&all->finish, settings, operands->items[0],
                      has_one ? guide : operands->items + 1,
                      has_one ? 1 : operands->n - 1, error);
}

static int cmd_finish(int argc, char **argv)
{
    struct options all = {0};
    struct settings settings;
    struct operands operands;
    struct image_error error;
    int code = options_parse(&command_finish, argc, argv, &all, &settings, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    code = check_usage(&all, &operands)
               ? exit_code(run(&all, &settings, &operands, &error), &error)
               : EXIT_USAGE;
    operands_free(&operands);
    return code;
}

const struct command command_finish = {
    .name = "finish",
    .summary = "take the grain out of the renderer's own depth of field",
    .usage = "OWN.exr [PASSES.exr ... | OURS] -o OUT [options]",
    .description =
        "OWN.exr was rendered with the renderer's own depth of field, with few "
        "samples. "
        "It is denoised by Open Image Denoise with the picture of Rack Focus as a "
        "guide, and that picture is kept where the grain does not contradict it. "
        "Mirrors, glass, smoke, fur and motion blur come out as the renderer sees "
        "them, since its own samples decide.\n\n"
        "The guide is a filtered picture, or passes that filter would take: colour and "
        "depth in one file, or several views from points of the lens. Passes are "
        "filtered first, with --denoise and the lens that their header or the options "
        "name. Without a guide OWN.exr is denoised by its own albedo and normals, if "
        "it has them (Blender: Denoising Data).\n\n"
        "RACKFOCUS_OIDN names the folder of libOpenImageDenoise where the system does "
        "not find it.",
    .examples =
        "rackfocus finish own.exr passes.exr -o out.exr\n"
        "rackfocus finish own.exr passes_v*.exr -o out.exr --output-error e.exr\n"
        "rackfocus finish own_a.exr --half own_b.exr passes.exr -o out.exr\n"
        "rackfocus finish own.exr twice_as_large_v*.exr --supersample 2 -o out.exr\n"
        "rackfocus finish own.exr --guide filtered.exr -o out.png",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_finish,
};
