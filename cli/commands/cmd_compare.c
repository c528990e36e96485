/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus compare: how far a picture is from its reference. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/outputs.h"
#include "console/cli.h"
#include "console/json.h"
#include "console/pipes.h"
#include "measure/flip.h"
#include "measure/measure.h"
#include "pages/canvas.h"
#include "sources/picture.h"

struct compare_options {
    const char *layer, *heatmap, *side_by_side;
    int32_t n_threads;
    bool is_json;
};

#define AT(member) offsetof(struct compare_options, member)

static const struct option options[] = {
    OPTION_LAYER_ROW(AT(layer), "compare"),
    OPTION_FILE_ROW("heatmap", AT(heatmap), "FILE.png",
                    "Write a picture of the error: black for none, white for 0.25 or "
                    "more of the tone mapped range."),
    OPTION_FILE_ROW("side-by-side", AT(side_by_side), "FILE.png",
                    "Write A, B and the picture of the error next to each other."),
    OPTION_FLAG_ROW("json", AT(is_json), "Print the figures as JSON."),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_HELP_ROW,
};

static void print_text(const struct measures *m, double flip)
{
    printf("PSNR %.2f dB\n", m->psnr_db);
    printf("SSIM %.6f\n", m->ssim);
    printf("FLIP %.4f\n", flip);
    printf("RMSE %.6g\n", m->rmse);
    printf("energy ratio %.6f\n", m->energy_ratio);
    printf("maximum error %.6g at pixel (%d, %d), %s\n", m->max_error, m->max_x,
           m->max_y, ((const char *const[]){"red", "green", "blue"})[m->max_channel]);
    printf("tPSNR %.2f dB\n", m->tpsnr_db);
}

static void print_json(const char *a, const char *b, const struct picture *picture,
                       const struct measures *m, double flip)
{
    struct json json = {0};
    json_open(&json, NULL, '{');
    json_text(&json, "a", a);
    json_text(&json, "b", b);
    json_number(&json, "width", picture->width);
    json_number(&json, "height", picture->height);
    json_number(&json, "psnr", m->psnr_db);
    json_number(&json, "ssim", m->ssim);
    json_number(&json, "rmse", m->rmse);
    json_number(&json, "energy_ratio", m->energy_ratio);
    json_number(&json, "max_error", m->max_error);
    json_open(&json, "max_error_pixel", '[');
    json_number(&json, NULL, m->max_x);
    json_number(&json, NULL, m->max_y);
    json_close(&json, ']');
    json_bool(&json, "identical", m->max_error == 0);
    json_number(&json, "tpsnr", m->tpsnr_db);
    json_number(&json, "flip", flip);
    json_close(&json, '}');
}

/* A, B and the picture of the error, next to each other. */
static bool write_side_by_side(const char *path, const struct picture *a,
                               const struct picture *b, const float *heat,
                               struct image_error *error)
{
    const int32_t width = a->width, height = a->height;
    const struct canvas_picture pictures[] = {{a->samples, width, height, true},
                                              {b->samples, width, height, true},
                                              {heat, width, height, false}};
    enum { N = sizeof pictures / sizeof *pictures };
    struct canvas canvas;
    if (!canvas_make(&canvas, N * width, height, 0))
        return app_fail(error, APP_NO_MEMORY, "out of memory") == APP_DONE;
    for (int32_t i = 0; i < N; i++)
        canvas_crop(&canvas, (struct canvas_box){i * width, 0, width, height},
                    &pictures[i], 0, 0);
    const bool is_written =
        image_write_png(path, canvas.rgb, canvas.width, height, 3, 8, true, error);
    canvas_free(&canvas);
    return is_written;
}

static bool write_pictures(const struct compare_options *tool, const struct picture *a,
                           const struct picture *b, struct image_error *error)
{
    const int32_t width = a->width, height = a->height;
    if (!tool->heatmap && !tool->side_by_side)
        return true;
    float *heat = app_memory(3 * (size_t)width * (size_t)height, sizeof(*heat), error);
    if (!heat)
        return false;
    measure_heatmap(a->samples, b->samples, width, height, heat);
    const bool is_done =
        (!tool->heatmap ||
         image_write_png(tool->heatmap, heat, width, height, 3, 8, true, error)) &&
        (!tool->side_by_side ||
         write_side_by_side(tool->side_by_side, a, b, heat, error));
    free(heat);
    return is_done;
}

/* Programs lose the aspect on the way, so that such pictures may show the same. */
static void warn_of_aspect(const char *path_a, const struct picture *a,
                           const char *path_b, const struct picture *b)
{
    if (a->pixel_aspect != b->pixel_aspect && a->pixel_aspect != 0 &&
        b->pixel_aspect != 0)
        warning(
            false,
            "%s: its pixelAspectRatio is %.9g, that of %s %.9g; pixels are compared "
            "as if they were alike; render both with one pixel aspect",
            path_a, (double)a->pixel_aspect, path_b, (double)b->pixel_aspect);
}

static void warn_of_choice(const char *path, const struct picture *picture)
{
    if (picture->doubt[0])
        warning(false, "%s: %s; name one with --layer", path, picture->doubt);
}

/* Is the data window all that is to be seen? */
static bool is_whole(const struct picture *picture)
{
    return !picture->has_window ||
           memcmp(&picture->display, &picture->window, sizeof(picture->window)) == 0;
}

/* A PNG shows the display window: of an EXR picture beside it the same is looked at. */
static bool show_as_png(struct picture *exr, const struct picture *png,
                        struct image_error *error)
{
    const struct image_box *box = &exr->display;
    const int64_t width = (int64_t)box->max_x - box->min_x + 1;
    const int64_t height = (int64_t)box->max_y - box->min_y + 1;
    if (png->has_window || is_whole(exr) || width != png->width ||
        height != png->height)
        return true;
    float *shown = picture_show_window(exr->samples, 3, &exr->window, box, error);
    if (!shown)
        return false;
    free(exr->samples);
    exr->samples = shown;
    exr->width = png->width;
    exr->height = png->height;
    exr->window = *box;
    return true;
}

/* Pictures of other sizes may be crops of one. */
static int fail_sizes(const char *path_a, const struct picture *a, const char *path_b,
                      const struct picture *b)
{
    const bool are_alike = a->has_window && b->has_window &&
                           memcmp(&a->display, &b->display, sizeof(a->display)) == 0;
    char way[400] = "";
    if (are_alike)
        snprintf(
            way, sizeof(way),
            "; their display windows are alike: oiiotool -a %.300s --croptofull -o "
            "whole.exr",
            is_whole(a) ? path_b : path_a);
    message("%s: is %d x %d, but %s is %d x %d; pictures of one size can be compared%s",
            path_a, a->width, a->height, path_b, b->width, b->height, way);
    return EXIT_FAILED;
}

static int compare(const struct compare_options *tool, const char *path_a,
                   const char *path_b, struct picture *a, struct picture *b)
{
    struct image_error error;
    struct cli_host host;
    if (!show_as_png(a, b, &error) || !show_as_png(b, a, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    if (a->width != b->width || a->height != b->height)
        return fail_sizes(path_a, a, path_b, b);
    if (a->has_window && b->has_window &&
        !picture_check_place(path_a, &a->window, path_b, &b->window, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    warn_of_choice(path_a, a);
    warn_of_choice(path_b, b);
    warn_of_aspect(path_a, a, path_b, b);
    primaries_warn(cli_host_open(&host, false, false), path_a, &a->primaries, path_b,
                   &b->primaries, "they are compared", &error);
    struct measures measures;
    double flip;
    if (!measure_pictures(a->samples, b->samples, a->width, a->height, &measures,
                          NULL) ||
        !flip_measure(a->samples, b->samples, a->width, a->height, &flip, NULL))
        return exit_without_memory();
    measures.max_x += a->window.min_x;
    measures.max_y += a->window.min_y;
    if (!write_pictures(tool, a, b, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    if (tool->is_json)
        print_json(path_a, path_b, a, &measures, flip);
    else
        print_text(&measures, flip);
    return EXIT_DONE;
}

static bool check_png_name(const char *option, const char *path)
{
    if (!path || picture_kind(path) == PICTURE_PNG)
        return true;
    message("--%s: '%s' does not end in .png; it is written as PNG", option, path);
    return false;
}

static int check_files(const struct compare_options *tool, char *const *pictures)
{
    struct image_error error;
    struct outputs outputs = {.error = &error};
    outputs_add(&outputs, "heatmap", tool->heatmap);
    outputs_add(&outputs, "side-by-side", tool->side_by_side);
    for (int i = 0; i < 2; i++)
        outputs_spare(&outputs, NULL, pictures[i]);
    return exit_code(outputs.code, &error);
}

static int cmd_compare(int argc, char **argv)
{
    struct compare_options tool = {0};
    struct operands operands;
    int code = options_parse(&command_compare, argc, argv, &tool, NULL, &operands);
    if (code != OPTIONS_GO_ON)
        return code;
    code = EXIT_USAGE;
    if (operands.n != 2) {
        message("compare takes two pictures, not %d; see rackfocus compare --help",
                operands.n);
    } else if (options_are_of_one_frame(&operands, "compare") &&
               check_png_name("heatmap", tool.heatmap) &&
               check_png_name("side-by-side", tool.side_by_side) &&
               check_files(&tool, operands.items) == EXIT_DONE) {
        struct picture a = {0}, b = {0};
        struct pipes pipes = {.folder = ""};
        enum app_code opened;
        struct image_error error;
        const int n_threads = thread_count(tool.n_threads);
        code = EXIT_FAILED;
        if (pipes_are_named(&operands, NULL) &&
            (opened = pipes_open(&pipes, &operands, NULL, false, &error)) != APP_DONE)
            code = exit_code(opened, &error);
        else if (picture_read(operands.items[0], tool.layer, n_threads, &a, &error) &&
                 picture_read(operands.items[1], tool.layer, n_threads, &b, &error))
            code = compare(&tool, operands.items[0], operands.items[1], &a, &b);
        else
            message("%s", error.message);
        picture_free(&a);
        picture_free(&b);
        pipes_close(&pipes);
    }
    operands_free(&operands);
    return code;
}

const struct command command_compare = {
    .name = "compare",
    .summary = "measure how far a picture is from a reference",
    .usage = "A B [options]",
    .description =
        "Compares picture A with the reference B, EXR or PNG (- is standard input; "
        "beside a PNG the display window of an EXR is compared, as the PNG shows it): "
        "PSNR, tPSNR, SSIM, FLIP, RMSE, energy ratio (sum of A / sum of B) and the "
        "largest error with its pixel. The last line is the tPSNR: both pictures "
        "clipped to [0, 1], raised to 1/2.2, mean squared error over red, green and "
        "blue, in dB.\n\n"
        "SSIM is measured on the same tone mapped values, per channel, and averaged. "
        "FLIP is the mean of LDR-FLIP (Andersson et al. 2020), what an observer sees "
        "who flips between both on a screen: 0 alike, 1 as far apart as can be. PSNR "
        "is measured on the linear values clipped to [0, 1]; RMSE, energy ratio and "
        "largest error on the linear values as they are. Alpha is not compared.",
    .examples = "rackfocus compare out.exr reference.exr --side-by-side look.png",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .run = cmd_compare,
};
