/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus aperture: what a lamp becomes at many places of the picture. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/outputs.h"
#include "console/cli.h"
#include "sources/looks.h"
#include "sources/picture.h"
#include "sources/settings.h"

struct aperture_options {
    const char *output, *look, *aperture_image;
    double radius_px;
    int32_t width, n_threads;
    bool is_quiet;
};

#define AT(member) offsetof(struct aperture_options, member)

static const struct option options[] = {
    OPTION_OUTPUT_ROW(AT(output), "Where to draw: .exr or .png."),
    OPTION_TEXT_ROW("look", AT(look), "NAME",
                    "Look of a kind of lens, as rackfocus looks lists them, or a "
                    "FILE.params; options win over it."),
    OPTION_FILE_ROW("aperture-image", AT(aperture_image), "FILE",
                    "Picture of the aperture, EXR or PNG of any size, as the camera "
                    "sees it; implies --aperture image."),
    OPTION_NUMBER_ROW("radius", AT(radius_px), "PX", 2, 200,
                      "Radius of the blur in the middle of the picture. [default 24]"),
    OPTION_INT_ROW("width", AT(width), "PX", 64, 8192,
                   "Width of the picture; each of its halves is as 16 to 9. [default "
                   "960]"),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_HELP_ROW,
};

/* The upper half is behind the focus, the lower one before it. */
struct sheet_of_lamps {
    int32_t width, height; /* of one half */
    struct rf_params params;
    bool has_stop;           /* its lens is that of an f-stop */
    struct picture aperture; /* without samples: none */
    float *rgb;              /* both halves, width x 2 height */
    float *depth;            /* of one half */
};

static bool is_tilted(const struct rf_params *params)
{
    return params->tilt_x != 0 || params->tilt_y != 0;
}

/*
 * Sets the lens so that what is far away (orthographic: at the camera) has twice the
 * radius. `has_stop`: with the diameter that focal length and f-stop give, focused as
 * near as that takes: a tilt changes the radius along the picture by lens radius / focal
 * length for each px, which for a far focus is that of no real lens.
 */
static rf_result set_lens(struct sheet_of_lamps *sheet, double radius_px, bool has_stop,
                          struct rf_error *error)
{
    struct rf_lens lens;
    struct rf_params *params = &sheet->params;
    params->lens_radius = has_stop ? 0 : 1;
    rf_result result = rf_lens_init(&lens, params, sheet->width, sheet->height, error);
    if (result == RF_OK && has_stop) {
        params->lens_radius = lens.lens_radius;
        params->focus_distance *= fabs(lens.bias_px) / (2 * radius_px);
        result = rf_lens_init(&lens, params, sheet->width, sheet->height, error);
    }
    if (result == RF_OK)
        params->lens_radius *= 2 * radius_px / fabs(lens.bias_px);
    return result;
}

/* Bright rims shall show on a screen. */
#define BRIGHTNESS 0.5

/* Single pixels of the light of a disc, as many as find room. */
static void put_lamps(const struct sheet_of_lamps *sheet, double radius_px, float *rgb)
{
    const double step = 3.5 * radius_px, pi = 3.14159265358979323846;
    const int columns = (int)fmax(1, sheet->width / step) | 1;
    const int rows = (int)fmax(1, sheet->height / step) | 1;
    for (int j = 0; j < rows; j++)
        for (int i = 0; i < columns; i++) {
            const size_t x = (size_t)((i + 0.5) * sheet->width / columns);
            const size_t y = (size_t)((j + 0.5) * sheet->height / rows);
            for (int c = 0; c < 3; c++)
                rgb[3 * (y * (size_t)sheet->width + x) + (size_t)c] =
                    (float)(BRIGHTNESS * pi * radius_px * radius_px);
        }
}

/* Lamps at the depth of this radius, > 0 behind the focus, through the lens. */
static rf_result draw_half(const struct sheet_of_lamps *sheet,
                           struct rf_context *context, double radius_px, float *rgb,
                           struct rf_error *error)
{
    struct rf_lens lens;
    struct rf_filter *filter = NULL;
    const size_t n = (size_t)sheet->width * (size_t)sheet->height;
    rf_result result =
        rf_lens_init(&lens, &sheet->params, sheet->width, sheet->height, error);
    if (result != RF_OK)
        return result;
    for (size_t i = 0; i < n; i++)
        sheet->depth[i] = (float)rf_lens_depth_at(&lens, radius_px);
    put_lamps(sheet, fabs(radius_px), rgb);
    const struct picture *aperture = &sheet->aperture;
    const struct rf_image light =
        rf_image_packed(aperture->samples, aperture->width, aperture->height, 3);
    result =
        rf_filter_create_with(&filter, context, &sheet->params, sheet->width,
                              sheet->height, aperture->samples ? &light : NULL, error);
    if (result != RF_OK)
        return result;
    const struct rf_image colour = rf_image_packed(rgb, sheet->width, sheet->height, 3);
    const struct rf_view view = {
        .colour = colour,
        .depth = rf_image_packed(sheet->depth, sheet->width, sheet->height, 1)};
    result = rf_filter_process(filter, &view, 1, &colour, NULL, error);
    rf_filter_destroy(filter);
    return result;
}

static rf_result draw(struct sheet_of_lamps *sheet, const struct aperture_options *tool,
                      struct rf_error *error)
{
    struct rf_context *context;
    const struct rf_context_params run = {.size = sizeof(run),
                                          .cpu = getenv("RACKFOCUS_CPU"),
                                          .n_threads = tool->n_threads};
    float *lower = sheet->rgb + 3 * (size_t)sheet->width * (size_t)sheet->height;
    rf_result result = set_lens(sheet, tool->radius_px, sheet->has_stop, error);
    if (result != RF_OK)
        return result;
    result = rf_context_create(&context, &run, error);
    if (result != RF_OK)
        return result;
    result = draw_half(sheet, context, tool->radius_px, sheet->rgb, error);
    if (result == RF_OK)
        result = draw_half(sheet, context, -tool->radius_px, lower, error);
    rf_context_destroy(context);
    return result;
}

static bool write_sheet(const struct sheet_of_lamps *sheet, const char *path,
                        int n_threads, struct image_error *error)
{
    static const char *const names[] = {"R", "G", "B"};
    static const enum image_sample_type types[] = {IMAGE_SAMPLE_HALF, IMAGE_SAMPLE_HALF,
                                                   IMAGE_SAMPLE_HALF};
    const struct image_output output = {.width = sheet->width,
                                        .height = 2 * sheet->height,
                                        .n_channels = 3,
                                        .channel_names = names,
                                        .types = types,
                                        .samples = sheet->rgb};
    if (picture_kind(path) == PICTURE_PNG)
        return image_write_png(path, sheet->rgb, sheet->width, 2 * sheet->height, 3, 8,
                               false, error);
    return image_write(path, &output, n_threads, error);
}

static void tell_error(const struct aperture_options *tool,
                       const struct rf_error *error)
{
    const struct rf_param_info *info = rf_param_find(error->field);
    if (tool->aperture_image && strcmp(error->field, "distribution") == 0)
        message("%s: %s", tool->aperture_image, error->message);
    else
        message("%s%s: %s", info ? "--" : "", info ? info->key : "aperture",
                error->message);
}

static bool is_one_of(const char *key, const char *const *list)
{
    for (; *list; list++)
        if (strcmp(key, *list) == 0)
            return true;
    return false;
}

/* Why a parameter changes nothing of the sheet; NULL: it does. */
static const char *why_unread(const struct rf_params *params,
                              const struct rf_param_info *info)
{
    static const char *const of_tilt[] = {
        "focal-length",  "focal-length-px", "sensor-width",
        "sensor-height", "sensor-fit",      "unit-scale",
        "shift-x",       "shift-y",         NULL};
    static const char *const of_none[] = {"optics", "coc-limit", "split-edges", NULL};
    const char *why_not = NULL;
    if (info->group == RF_GROUP_DEPTH)
        return "the lamps have a depth of their own";
    if (!rf_param_is_read(params, info->key, &why_not))
        return why_not;
    if (!is_tilted(params) && is_one_of(info->key, of_tilt))
        return "read only with a tilt: --radius says how large the blur is";
    return is_one_of(info->key, of_none)
               ? "the lamps are points, and --radius says how large the blur is"
               : NULL;
}

/* Says what was given for nothing; the depth of the sheet is planar. */
static void leave_out_unread(const struct aperture_options *tool,
                             const struct settings *settings, struct rf_params *params)
{
    size_t n;
    struct rf_params defaults;
    const struct rf_param_info *list = rf_param_list(&n);
    rf_params_init(&defaults);
    for (size_t i = 0; i < n; i++) {
        const char *why_not = why_unread(&settings->params, &list[i]);
        const size_t at = list[i].offset;
        const size_t size =
            list[i].type == RF_TYPE_FLOAT ? sizeof(double) : sizeof(int32_t);
        if (list[i].group == RF_GROUP_DEPTH)
            memcpy((char *)params + at, (const char *)&defaults + at, size);
        if (why_not && settings_origin(settings, list[i].key) == ORIGIN_COMMAND_LINE)
            warning(tool->is_quiet, "--%s: has no effect: %s", list[i].key, why_not);
    }
}

/* Is the lens that of an f-stop? */
static bool has_stop(const struct settings *settings)
{
    return is_tilted(&settings->params) &&
           settings->params.projection != RF_PROJECTION_ORTHOGRAPHIC &&
           settings_origin(settings, "focus-distance") == ORIGIN_DEFAULT;
}

/* The core cuts radii at half of the longer side. */
static void tell_cut(const struct aperture_options *tool,
                     const struct settings *settings)
{
    if (settings->params.max_radius == 0 && tool->radius_px > tool->width / 2.0)
        warning(tool->is_quiet,
                "--radius %g: the blur is cut at %g px, half the width; --width %d or "
                "more has room for it",
                tool->radius_px, tool->width / 2.0, (int)ceil(4 * tool->radius_px));
}

static int make_sheet(const struct aperture_options *tool,
                      const struct settings *settings)
{
    struct rf_error error;
    struct image_error image_error;
    struct sheet_of_lamps sheet = {.width = tool->width,
                                   .height = tool->width * 9 / 16,
                                   .params = settings->params,
                                   .has_stop = has_stop(settings)};
    const size_t n = (size_t)sheet.width * (size_t)sheet.height;
    leave_out_unread(tool, settings, &sheet.params);
    tell_cut(tool, settings);
    sheet.rgb = app_memory(2 * 3 * n, sizeof(float), NULL);
    sheet.depth = app_memory(n, sizeof(float), NULL);
    int code = EXIT_FAILED;
    if (!sheet.rgb || !sheet.depth) {
        code = exit_without_memory();
    } else if (!picture_check_writable(tool->output, &image_error)) {
        message("%s", image_error.message);
    } else if (tool->aperture_image &&
               !picture_read(tool->aperture_image, NULL, thread_count(tool->n_threads),
                             &sheet.aperture, &image_error)) {
        app_missing(&image_error, "aperture-image", tool->aperture_image);
        message("%s", image_error.message);
    } else if (draw(&sheet, tool, &error) != RF_OK) {
        tell_error(tool, &error);
    } else if (!write_sheet(&sheet, tool->output, thread_count(tool->n_threads),
                            &image_error)) {
        message("%s", image_error.message);
    } else {
        code = EXIT_DONE;
    }
    free(sheet.rgb);
    free(sheet.depth);
    picture_free(&sheet.aperture);
    return code;
}

/* --aperture-image says which aperture. */
static bool check_aperture_image(const struct aperture_options *tool,
                                 struct settings *settings)
{
    const bool is_image = settings->params.aperture == RF_APERTURE_IMAGE;
    if (!tool->aperture_image && is_image)
        message("--aperture image: needs its picture, --aperture-image FILE");
    else if (tool->aperture_image && !is_image &&
             settings_origin(settings, "aperture") == ORIGIN_COMMAND_LINE)
        message("--aperture-image: goes with --aperture image, which can be left out");
    else
        return !tool->aperture_image ||
               settings_set(settings, "aperture", "image", NULL) == RF_OK;
    return false;
}

/* What says how large the blur is, beside --radius. */
static bool refuse_useless(const char *key)
{
    message(
        "--%s has no place here: --radius says how large the blur is, and the method "
        "is layered",
        key);
    return false;
}

/* The picture must not be that of the aperture, which is read. */
static bool check_output(const struct aperture_options *tool)
{
    struct image_error error;
    struct outputs outputs = {.error = &error};
    outputs_add(&outputs, "output", tool->output);
    outputs_spare(&outputs, "aperture-image", tool->aperture_image);
    return exit_code(outputs.code, &error) == EXIT_DONE;
}

static bool check_usage(const struct aperture_options *tool, struct settings *settings,
                        int n_operands)
{
    static const char *const useless[] = {"lens-radius", "method"};
    struct image_error error = {.message = ""};
    const bool has_typed_stop =
        settings_origin(settings, "f-stop") == ORIGIN_COMMAND_LINE;
    for (size_t i = 0; i < sizeof(useless) / sizeof(useless[0]); i++)
        if (settings_origin(settings, useless[i]) == ORIGIN_COMMAND_LINE)
            return refuse_useless(useless[i]);
    if (n_operands > 0)
        message("aperture takes no file; see rackfocus aperture --help");
    else if (!tool->output)
        message("aperture needs an output, -o FILE.png or -o FILE.exr; see rackfocus "
                "aperture --help");
    else if (!picture_check_kind(tool->output, &error) ||
             (tool->look && !look_read(tool->look, settings, &error)))
        message("%s", error.message);
    else if (has_typed_stop && !has_stop(settings))
        return refuse_useless("f-stop");
    else
        return check_output(tool) && check_aperture_image(tool, settings);
    return false;
}

static int cmd_aperture(int argc, char **argv)
{
    struct aperture_options tool = {.radius_px = 24, .width = 960};
    struct settings settings;
    struct operands operands;
    const int code =
        options_parse(&command_aperture, argc, argv, &tool, &settings, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    const int n_operands = operands.n;
    operands_free(&operands);
    return check_usage(&tool, &settings, n_operands) ? make_sheet(&tool, &settings)
                                                     : EXIT_USAGE;
}

const struct command command_aperture = {
    .name = "aperture",
    .summary = "draw what a lamp becomes all over the picture",
    .usage = "-o PICTURE [--look NAME] [parameters]",
    .description =
        "Draws lamps through the lens: the upper half of the picture shows them behind "
        "the focus, the lower half before it, each half the whole field of view. Lamps "
        "have the light of a disc of brightness 0.5. With a tilt the lens is that of "
        "--focal-length and --f-stop, unless --focus-distance is given.",
    .examples = "rackfocus aperture -o lemons.png --cat-eye 0.7\n"
                "rackfocus aperture -o bubble.exr --look bubble --radius 40",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_aperture,
};
