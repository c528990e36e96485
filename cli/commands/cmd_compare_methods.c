/* SPDX-License-Identifier: Apache-2.0 */
/* rackfocus compare-methods: every method on one scene, against a reference. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "common/outputs.h"
#include "console/cli.h"
#include "console/json.h"
#include "console/progress.h"
#include "folder.h"
#include "interrupt.h"
#include "measure/flip.h"
#include "measure/measure.h"
#include "pages/html.h"
#include "pages/methods_page.h"
#include "pages/methods_sheet.h"
#include "parallel.h"
#include "path.h"
#include "sources/picture.h"
#include "sources/settings.h"
#include "sources/source.h"
#include "sources/views.h"

enum { MAX_ENTRIES = 128 };

struct compare_methods_options {
    const char *reference, *sheet, *html, *results, *depth_file, *depth_channel, *layer;
    int32_t n_repeats, n_threads;
    bool is_json, is_quiet;
};

#define AT(member) offsetof(struct compare_methods_options, member)

static const struct option options[] = {
    OPTION_FILE_ROW("reference", AT(reference), "FILE",
                    "The picture that all are compared with, EXR or PNG: the host's "
                    "own depth of field."),
    OPTION_FILE_ROW("sheet", AT(sheet), "FILE.png",
                    "Write a sheet of all results: a row for each generator, a column "
                    "for each blend, with errors, details and figures."),
    OPTION_FILE_ROW("html", AT(html), "FILE.html",
                    "Write a page on which any two results can be wiped over each "
                    "other; its pictures go into FILE_pictures."),
    OPTION_FILE_ROW("results", AT(results), "DIR",
                    "Keep every result, DIR/layered.exr, DIR/box_coc.exr and so on."),
    OPTION_DEPTH_FILE_ROW(AT(depth_file)),
    OPTION_DEPTH_CHANNEL_ROW(AT(depth_channel)),
    OPTION_LAYER_ROW(AT(layer), "filter"),
    OPTION_INT_ROW("repeats", AT(n_repeats), "COUNT", 1, 1000,
                   "Runs of each method; the fastest is shown. [default 3]"),
    OPTION_FLAG_ROW("json", AT(is_json), "Print the table as JSON."),
    OPTION_THREADS_ROW(AT(n_threads)),
    OPTION_QUIET_ROW(AT(is_quiet)),
    OPTION_HELP_ROW,
};

struct comparison {
    const struct compare_methods_options *tool;
    struct settings settings;
    struct rf_params params;
    struct source source;
    struct picture reference;
    struct view_list list; /* of views beside the picture; empty: none */
    struct views views;
    float *colour, *depth, *out; /* out: as colour, and radii before */
    float *rgb;                  /* the result without alpha */
    unsigned char *is_exposed;   /* pixels that sharp things can leak into */
    struct rf_context *context;
    struct methods_entry entries[MAX_ENTRIES];
    int n_entries;
    struct methods_subject subject;
    struct methods_sheet sheet;
    char *page_folder; /* of the page's pictures; NULL: no page */
    float *error_map;  /* for the page */
};

/* ---- the list ------------------------------------------------------------------- */

static bool is_typed(const struct comparison *c, const char *key)
{
    return settings_origin(&c->settings, key) == ORIGIN_COMMAND_LINE;
}

static void add_entry(struct comparison *c, int method, int blend, const char *name,
                      const char *blend_name)
{
    if (c->n_entries == MAX_ENTRIES)
        return;
    struct methods_entry *e = &c->entries[c->n_entries++];
    *e = (struct methods_entry){.method = method, .blend = blend, .time_s = INFINITY};
    snprintf(e->name, sizeof(e->name), "%s%s%s", name, *blend_name ? " " : "",
             blend_name);
}

/* The input, then every method that can be applied to it, the previews with every
 * blend. --method and --blend leave one. */
static void list_entries(struct comparison *c)
{
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    const struct rf_param_info *blends = rf_param_find("blend");
    add_entry(c, -1, 0, "pinhole", "");
    for (int m = 0; m < (int)n; m++) {
        const bool has_blend = methods[m].has_blend;
        const bool is_of_views = methods[m].max_views > 1;
        if (is_typed(c, "method") ? m != c->params.method
                                  : is_of_views && c->list.n == 0)
            continue;
        if (!has_blend)
            add_entry(c, m, c->params.blend, methods[m].name, "");
        for (int b = 0; has_blend && b < blends->n_choices; b++)
            if (!is_typed(c, "blend") || b == c->params.blend)
                add_entry(c, m, b, methods[m].name, blends->choices[b].name);
    }
}

/* ---- measuring ------------------------------------------------------------------ */

static int fail_core(const struct comparison *c, const struct rf_error *error)
{
    if (error->code == RF_ERROR_CANCELLED)
        return os_interrupt_code();
    const struct rf_param_info *info = rf_param_find(error->field);
    if (error->code == RF_ERROR_PARAMETER && info && is_typed(c, info->key)) {
        message("--%s: %s", info->key, error->message);
        return EXIT_USAGE;
    }
    message("%s: %s", image_path(c->source.colour), error->message);
    return EXIT_FAILED;
}

static size_t count_pixels(const struct comparison *c)
{
    return (size_t)c->source.width * (size_t)c->source.height;
}

/* Is anything in focus within the radius of pixel (x, y)? Every second pixel is asked,
 * within 32 px. */
static bool is_beside_focus(const struct comparison *c, const float *radius, int32_t x,
                            int32_t y)
{
    const int32_t width = c->source.width, height = c->source.height;
    const double r = fmin(fabsf(radius[(size_t)y * (size_t)width + (size_t)x]), 32);
    const int32_t reach = (int32_t)r;
    for (int32_t j = y - reach; j <= y + reach; j += 2)
        for (int32_t i = x - reach; i <= x + reach; i += 2)
            if (i >= 0 && j >= 0 && i < width && j < height &&
                (i - x) * (i - x) + (j - y) * (j - y) < r * r &&
                fabsf(radius[(size_t)j * (size_t)width + (size_t)i]) <=
                    c->params.coc_limit)
                return true;
    return false;
}

/* Of rows, whose radii are in c->out. */
static void note_exposed(void *data, int64_t begin, int64_t end, int thread)
{
    struct comparison *c = data;
    const int32_t width = c->source.width;
    for (int32_t y = (int32_t)begin; y < (int32_t)end; y++)
        for (int32_t x = 0; x < width; x++) {
            const size_t i = (size_t)y * (size_t)width + (size_t)x;
            c->is_exposed[i] =
                fabsf(c->out[i]) >= 2 && is_beside_focus(c, c->out, x, y);
        }
}

/* The headings of sheet and page; radii are in c->out. */
static void describe(struct comparison *c, const struct rf_lens *lens)
{
    struct methods_subject *subject = &c->subject;
    double least = INFINITY, most = -INFINITY;
    for (size_t i = 0; i < count_pixels(c); i++) {
        least = fmin(least, c->out[i]);
        most = fmax(most, c->out[i]);
    }
    subject->width = c->source.width;
    subject->height = c->source.height;
    snprintf(subject->title, sizeof subject->title, "%s, compared with %s",
             os_path_name(image_path(c->source.colour)),
             os_path_name(c->tool->reference));
    snprintf(subject->about, sizeof subject->about,
             "%d × %d, focus at %.4g, lens radius %.4g, blur radii %.1f to %.1f px",
             (int)subject->width, (int)subject->height, lens->focus_distance,
             lens->lens_radius, least, most);
}

/* Blurred by 2 px or more, and within that radius of something in focus. */
static int find_exposed(struct comparison *c)
{
    struct rf_filter *filter;
    struct rf_error error;
    const int32_t width = c->source.width, height = c->source.height;
    const struct rf_image depth = rf_image_packed(c->depth, width, height, 1);
    const struct rf_image to = rf_image_packed(c->out, width, height, 1);
    if (rf_filter_create(&filter, c->context, &c->params, width, height, &error) !=
        RF_OK)
        return fail_core(c, &error);
    const rf_result result = rf_filter_coc(filter, &depth, &to, &error);
    if (result == RF_OK)
        describe(c, rf_filter_lens(filter));
    rf_filter_destroy(filter);
    if (result != RF_OK)
        return fail_core(c, &error);
    c->is_exposed = app_memory(count_pixels(c), 1, NULL);
    if (!c->is_exposed)
        return exit_without_memory();
    os_parallel(0, height, 8, note_exposed, c);
    return EXIT_DONE;
}

/* Mean tone mapped error of the exposed pixels. */
static double measure_leak(const struct comparison *c)
{
    double sum = 0, n = 0;
    for (size_t i = 0; i < 3 * count_pixels(c); i++)
        if (c->is_exposed[i / 3]) {
            sum +=
                fabs(measure_tone(c->rgb[i]) - measure_tone(c->reference.samples[i]));
            n++;
        }
    return n > 0 ? 100 * sum / n : NAN;
}

/* Colour without alpha, as pictures are compared; grey three times. */
static void take_rgb(struct comparison *c, const float *from)
{
    const int n = c->source.n_channels;
    for (size_t i = 0; i < count_pixels(c); i++)
        for (size_t k = 0; k < 3; k++)
            c->rgb[3 * i + k] = from[(size_t)n * i + (n == 1 ? 0 : k)];
}

static bool takes_views(const struct comparison *c, int method)
{
    return c->list.n > 0 && rf_method_find(method)->max_views > 1;
}

static rf_result run_method(struct comparison *c, struct methods_entry *e,
                            struct rf_error *error)
{
    const struct source *s = &c->source;
    struct rf_params params = c->params;
    struct rf_filter *filter;
    params.method = e->method;
    params.blend = e->blend;
    rf_result result =
        rf_filter_create(&filter, c->context, &params, s->width, s->height, error);
    if (result != RF_OK)
        return result;
    const struct rf_view view = {
        .colour = rf_image_packed(c->colour, s->width, s->height, s->n_channels),
        .depth = rf_image_packed(c->depth, s->width, s->height, 1)};
    const struct rf_image out =
        rf_image_packed(c->out, s->width, s->height, s->n_channels);
    for (int i = 0; i < c->tool->n_repeats && result == RF_OK && !os_is_interrupted();
         i++) {
        const double start = os_clock_s();
        result = takes_views(c, e->method)
                     ? rf_filter_process(filter, c->views.views, c->views.n, &out, NULL,
                                         error)
                     : rf_filter_process(filter, &view, 1, &out, NULL, error);
        e->time_s = fmin(e->time_s, os_clock_s() - start);
    }
    rf_filter_destroy(filter);
    return result;
}

/* DIR/box_coc.exr */
static bool keep_result(struct comparison *c, const struct methods_entry *e,
                        struct image_error *error)
{
    char path[4096], name[sizeof e->name];
    const struct source *s = &c->source;
    const size_t n = count_pixels(c) * (size_t)s->n_channels;
    methods_file_name(e, name, sizeof name);
    snprintf(path, sizeof(path), "%s/%s.exr", c->tool->results, name);
    float *samples = app_memory(n, sizeof(float), error); /* writing packs in place */
    if (!samples)
        return false;
    memcpy(samples, e->method >= 0 ? c->out : c->colour, n * sizeof(float));
    const struct source_output how = {.type = IMAGE_SAMPLE_FLOAT,
                                      .made = e->method >= 0 ? e->name : NULL,
                                      .settings = e->method >= 0 ? &c->settings : NULL,
                                      .n_threads = thread_count(c->tool->n_threads)};
    const bool is_written = source_write_colour(s, path, samples, &how, error);
    free(samples);
    return is_written;
}

/* What is made of the reference (a NULL entry) or of a result: on the sheet and beside
 * the page. */
static bool show(struct comparison *c, const struct methods_entry *e,
                 const float *picture, struct image_error *error)
{
    if (c->tool->sheet)
        methods_sheet_put(&c->sheet, e, picture, c->reference.samples);
    if (!c->page_folder)
        return true;
    if (e)
        measure_heatmap(picture, c->reference.samples, c->source.width,
                        c->source.height, c->error_map);
    return methods_page_put(c->page_folder, &c->subject, e, picture,
                            e ? c->error_map : NULL, error);
}

static int run_entry(struct comparison *c, int index)
{
    struct methods_entry *e = &c->entries[index];
    const int32_t width = c->source.width, height = c->source.height;
    struct rf_error error;
    if (e->method >= 0 && run_method(c, e, &error) != RF_OK)
        return fail_core(c, &error);
    take_rgb(c, e->method >= 0 ? c->out : c->colour);
    if (!measure_pictures(c->rgb, c->reference.samples, width, height, &e->measures,
                          NULL) ||
        !flip_measure(c->rgb, c->reference.samples, width, height, &e->flip, NULL))
        return exit_without_memory();
    e->leak_percent = measure_leak(c);
    struct image_error image_error;
    if ((c->tool->results && !keep_result(c, e, &image_error)) ||
        !show(c, e, c->rgb, &image_error)) {
        message("%s", image_error.message);
        return EXIT_FAILED;
    }
    return EXIT_DONE;
}

static int run_entries(struct comparison *c)
{
    struct progress bar;
    int code = EXIT_DONE;
    progress_start(&bar, "comparing", c->tool->is_quiet);
    for (int i = 0; i < c->n_entries && code == EXIT_DONE; i++) {
        code = os_is_interrupted() ? os_interrupt_code() : run_entry(c, i);
        progress_report(&bar, (double)(i + 1) / c->n_entries);
    }
    progress_end(&bar);
    return code;
}

/* ---- output --------------------------------------------------------------------- */

static void print_text(const struct comparison *c)
{
    printf("%-24s %10s %9s %8s %8s %8s %7s\n", "method", "time ms", "tPSNR dB", "SSIM",
           "FLIP", "energy %", "leak %");
    for (int i = 0; i < c->n_entries; i++) {
        const struct methods_entry *e = &c->entries[i];
        char time[32] = "-", leak[32] = "-";
        if (e->method >= 0)
            snprintf(time, sizeof(time), "%.1f", e->time_s * 1e3);
        if (isfinite(e->leak_percent))
            snprintf(leak, sizeof(leak), "%.2f", e->leak_percent);
        printf("%-24s %10s %9.2f %8.4f %8.4f %+8.2f %7s\n", e->name, time,
               e->measures.tpsnr_db, e->measures.ssim, e->flip,
               100 * (e->measures.energy_ratio - 1), leak);
    }
}

static void print_json(const struct comparison *c)
{
    size_t n;
    const struct rf_method_info *methods = rf_method_list(&n);
    const struct rf_param_info *blends = rf_param_find("blend");
    struct json json = {0};
    json_open(&json, NULL, '[');
    for (int i = 0; i < c->n_entries; i++) {
        const struct methods_entry *e = &c->entries[i];
        json_open(&json, NULL, '{');
        json_text(&json, "name", e->name);
        if (e->method >= 0) {
            json_text(&json, "method", methods[e->method].name);
            json_text(&json, "blend", blends->choices[e->blend].name);
            json_number(&json, "time_s", e->time_s);
        }
        json_number(&json, "tpsnr", e->measures.tpsnr_db);
        json_number(&json, "ssim", e->measures.ssim);
        json_number(&json, "flip", e->flip);
        json_number(&json, "energy_ratio", e->measures.energy_ratio);
        json_number(&json, "leak_percent", e->leak_percent);
        json_close(&json, '}');
    }
    json_close(&json, ']');
}

static int finish(struct comparison *c)
{
    struct image_error error;
    if ((c->tool->sheet && !methods_sheet_write(&c->sheet, c->tool->sheet, &error)) ||
        (c->page_folder &&
         !methods_page_write(c->tool->html, c->page_folder, &c->subject, c->entries,
                             c->n_entries, &error))) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    if (c->page_folder)
        os_folder_keep(c->page_folder);
    if (c->tool->is_json)
        print_json(c);
    else
        print_text(c);
    return EXIT_DONE;
}

/* ---- the run -------------------------------------------------------------------- */

static bool read_facts(struct comparison *c, struct image_error *text, int *code)
{
    struct rf_error error;
    const int32_t n_threads = c->tool->n_threads;
    const struct rf_context_params run = {
        .size = sizeof(run), .cpu = getenv("RACKFOCUS_CPU"), .n_threads = n_threads};
    *code = EXIT_FAILED;
    if (!source_check(&c->source, text) ||
        !source_read_facts(&c->source, &c->settings, text->message,
                           sizeof(text->message)))
        return false;
    text->message[0] = '\0'; /* from here on messages are printed at once */
    if (settings_fit_window(&c->settings, &c->source.info, &c->params, &error) !=
            RF_OK ||
        rf_context_create(&c->context, &run, &error) != RF_OK) {
        *code = fail_core(c, &error);
        return false;
    }
    return true;
}

static bool read_pixels(struct comparison *c, struct image_error *error)
{
    const struct source *s = &c->source;
    const int n_threads = thread_count(c->tool->n_threads);
    c->colour = source_read_colour(s, n_threads, error);
    c->depth = c->colour ? source_read_depth(s, n_threads, error) : NULL;
    if (!c->depth ||
        !picture_read(c->tool->reference, NULL, n_threads, &c->reference, error))
        return false;
    if (c->reference.width != s->width || c->reference.height != s->height) {
        set_error(error,
                  "%s: is %d x %d, but %s is %d x %d; the reference must show the same",
                  c->tool->reference, c->reference.width, c->reference.height,
                  image_path(s->colour), s->width, s->height);
        return false;
    }
    if (c->reference.has_window &&
        !picture_check_place(c->tool->reference, &c->reference.window,
                             image_path(s->colour), &s->info.data_window, error))
        return false;
    const struct source_request request = {.layer = c->tool->layer,
                                           .depth_channel = c->tool->depth_channel};
    if (c->list.n > 0 &&
        !views_read(&c->views, s, &c->list, &request, n_threads, error))
        return false;
    c->out = app_memory(count_pixels(c) * (size_t)s->n_channels, sizeof(float), error);
    c->rgb = app_memory(count_pixels(c) * 3, sizeof(float), error);
    return c->out && c->rgb;
}

/* Where the sheet looks from near. */
static bool find_details(struct comparison *c, struct canvas_box details[N_DETAILS])
{
    int32_t width, height;
    take_rgb(c, c->colour);
    const struct canvas_picture pinhole = {c->rgb, c->source.width, c->source.height,
                                           true};
    const struct canvas_picture reference = {c->reference.samples, c->source.width,
                                             c->source.height, true};
    methods_sheet_detail_size(&c->subject, &width, &height);
    return methods_find_details(c->is_exposed, &pinhole, &reference, width, height,
                                details);
}

/* The sheet and the page's folder, with the reference. */
static int begin_pictures(struct comparison *c)
{
    struct canvas_box details[N_DETAILS];
    struct image_error error;
    if (c->tool->sheet && (!find_details(c, details) ||
                           !methods_sheet_make(&c->sheet, &c->subject, details,
                                               c->entries, c->n_entries)))
        return exit_without_memory();
    if (c->tool->html) {
        c->error_map = app_memory(3 * count_pixels(c), sizeof(float), NULL);
        if (!c->error_map)
            return exit_without_memory();
        c->page_folder = html_make_folder(c->tool->html, "_pictures", &error);
    }
    if ((c->tool->html && !c->page_folder) ||
        !show(c, NULL, c->reference.samples, &error)) {
        message("%s", error.message);
        return EXIT_FAILED;
    }
    return EXIT_DONE;
}

static int run_steps(struct comparison *c)
{
    struct image_error error = {.message = ""};
    int code = EXIT_FAILED;
    if ((c->tool->sheet && !picture_check_writable(c->tool->sheet, &error)) ||
        (c->tool->results &&
         !picture_need_folder(c->tool->results, OS_FOLDER_GOES_IF_EMPTY, &error)) ||
        !read_facts(c, &error, &code) || !read_pixels(c, &error)) {
        if (*error.message)
            message("%s", error.message);
        return code;
    }
    code = find_exposed(c);
    if (code != EXIT_DONE)
        return code;
    list_entries(c);
    code = begin_pictures(c);
    if (code == EXIT_DONE)
        code = run_entries(c);
    return code == EXIT_DONE ? finish(c) : code;
}

/* The views among the inputs: all but the first, and that too where it is one. False
 * where some of more than two are none. */
static bool find_views(struct comparison *c, const struct operands *operands,
                       struct image_error *error)
{
    const char *other = NULL;
    if (operands->n < 2 || c->tool->depth_file)
        return true;
    if (!views_list(operands->items, operands->n, &c->list, &other, error))
        return false;
    if (!other)
        return true;
    const bool is_first = strcmp(other, operands->items[0]) == 0;
    views_list_free(&c->list);
    other = NULL;
    if (is_first &&
        !views_list(operands->items + 1, operands->n - 1, &c->list, &other, error))
        return false;
    if (is_first && !other)
        return true;
    views_list_free(&c->list);
    if (operands->n == 2)
        return true;
    set_error(error,
              "%s: is no view from a point of the lens; compare-methods takes one file "
              "of colour, then its depth or views",
              other ? other : operands->items[0]);
    return false;
}

static bool check_number(const struct comparison *c, struct image_error *error)
{
    if (c->list.n <= RF_MAX_VIEWS)
        return true;
    set_error(error,
              "%s: %d views are too many; %d "
              "are the most",
              c->list.items[c->list.n - 1].path, c->list.n, RF_MAX_VIEWS);
    return false;
}

static int compare_methods(struct comparison *c, const struct operands *operands)
{
    const struct compare_methods_options *tool = c->tool;
    struct image_error error;
    if (!find_views(c, operands, &error) || !check_number(c, &error)) {
        views_list_free(&c->list);
        message("%s", error.message);
        return EXIT_FAILED;
    }
    const struct source_request request = {.paths = operands->items,
                                           .n_paths = c->list.n ? 1 : operands->n,
                                           .layer = tool->layer,
                                           .depth_file = tool->depth_file,
                                           .depth_channel = tool->depth_channel};
    if (!source_open(&c->source, &request, &error)) {
        views_list_free(&c->list);
        message("%s", error.message);
        return EXIT_FAILED;
    }
    const int code = run_steps(c);
    rf_context_destroy(c->context);
    views_free(&c->views);
    views_list_free(&c->list);
    picture_free(&c->reference);
    methods_sheet_free(&c->sheet);
    free(c->page_folder);
    free(c->error_map);
    free(c->is_exposed);
    free(c->rgb);
    free(c->out);
    free(c->depth);
    free(c->colour);
    source_close(&c->source);
    return code;
}

static int check_files(const struct compare_methods_options *tool,
                       const struct operands *operands)
{
    struct image_error error;
    struct outputs outputs = {.error = &error};
    outputs_add(&outputs, "sheet", tool->sheet);
    outputs_spare(&outputs, "reference", tool->reference);
    outputs_spare(&outputs, "depth-file", tool->depth_file);
    for (int i = 0; i < operands->n; i++)
        outputs_spare(&outputs, NULL, operands->items[i]);
    return exit_code(outputs.code, &error);
}

static bool check_usage(const struct compare_methods_options *tool,
                        const struct operands *operands)
{
    if (operands->n < 1 || (operands->n > 1 && tool->depth_file))
        message("compare-methods takes one file of colour, then one of depth or views; "
                "see rackfocus compare-methods --help");
    else if (!tool->reference)
        message("compare-methods needs --reference FILE, the picture to come near to; "
                "see rackfocus compare-methods --help");
    else if (!html_check_name(tool->html))
        return false;
    else if (tool->sheet && picture_kind(tool->sheet) != PICTURE_PNG)
        message("--sheet: '%s' does not end in .png; it is written as PNG",
                tool->sheet);
    else
        return check_files(tool, operands) == EXIT_DONE;
    return false;
}

static int cmd_compare_methods(int argc, char **argv)
{
    struct compare_methods_options tool = {.n_repeats = 3};
    struct operands operands;
    struct comparison *c = app_memory(1, sizeof(*c), NULL);
    if (!c)
        return exit_without_memory();
    int code = options_parse(&command_compare_methods, argc, argv, &tool, &c->settings,
                             &operands);
    if (code == OPTIONS_GO_ON) {
        c->tool = &tool;
        code =
            check_usage(&tool, &operands) ? compare_methods(c, &operands) : EXIT_USAGE;
        operands_free(&operands);
    }
    free(c);
    return code;
}

const struct command command_compare_methods = {
    .name = "compare-methods",
    .summary = "run every method and compare the results",
    .usage = "IN.exr [DEPTH.exr | VIEW.exr ...] --reference FILE [options]",
    .description =
        "Filters IN.exr with every method, the previews with every blend, and compares "
        "each result with the reference: time of the filter alone, tPSNR, SSIM and "
        "FLIP as in rackfocus compare, energy (sum of the result over that of the "
        "reference, "
        "less 1) and leak. The first line is the pinhole itself. --method and --blend "
        "leave one. Views from points of the lens, where they are given behind the "
        "picture, go through the methods that take several.\n\n"
        "Leak is the mean tone mapped error, in parts of 100, of the pixels that are "
        "blurred by 2 px or more and have something in focus within that radius (32 px "
        "at most): where the colours of sharp things run out, and theirs run in.",
    .examples = "rackfocus compare-methods pinhole.exr --reference lens.exr --sheet "
                "sheet.png\n"
                "rackfocus compare-methods pinhole.exr --reference lens.exr --html "
                "methods.html",
    .options = options,
    .n_options = sizeof(options) / sizeof(options[0]),
    .takes_params = true,
    .run = cmd_compare_methods,
};
