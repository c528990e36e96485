/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/filter_private.h"
#include "filter/seen_way.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/frame_list.h"
#include "common/report.h"
#include "file.h"
#include "filter/filter_run.h"
#include "filter/windows.h"
#include "interrupt.h"
#include "sources/depth_repair.h"
#include "sources/mean_depth.h"
#include "sources/picture.h"

/* ---- messages ------------------------------------------------------------------- */

/* The code of what was put into run->error. */
static int fail_image(const struct run *run)
{
    return app_code_of(run->error);
}

/* ---- one view or several -------------------------------------------------------- */

static int fail_method(const struct run *run)
{
    char name[32];
    rf_params_get(&run->settings->params, "method", name, sizeof(name));
    return app_fail(
        run->error, APP_USAGE,
        "--method: %s takes one view, and here are %d; leave it out, or say views",
        name, run->list.n);
}

/* Reads --aperture-at, which only views have. */
static int read_aperture(struct run *run)
{
    const char *text = run->tool->aperture_at;
    int used = 0;
    if (!text)
        return APP_DONE;
    if (!run->has_views) {
        return app_fail(
            run->error, APP_USAGE,
            "--aperture-at: the input is one view, whose aperture cannot be moved; "
            "give several views from points of the lens");
    }
    if (sscanf(text, "%lf,%lf%n", &run->aperture_at[0], &run->aperture_at[1], &used) ==
            2 &&
        text[used] == 0 && isfinite(run->aperture_at[0]) &&
        isfinite(run->aperture_at[1]))
        return APP_DONE;
    return app_fail(
        run->error, APP_USAGE,
        "--aperture-at: '%s' is no place; give two numbers such as 0.01,-0.02", text);
}

/* A pattern and a name beside it may give a view twice. */
static int warn_of_twins(const struct run *run)
{
    const struct view_list *list = &run->list;
    for (int i = 0; i < list->n; i++)
        for (int k = 0; k < i && !list->items[i].name; k++)
            if (!list->items[k].name &&
                os_file_is_same(list->items[i].path, list->items[k].path))
                return app_warn(run->tool->host, run->error,
                                "%s: is given twice, as two views; name each view once",
                                list->items[i].path);
    return APP_DONE;
}

static int check_views(const struct run *run)
{
    if (run->list.n > RF_MAX_VIEWS) {
        return app_fail(
            run->error, APP_FAILED, "%s: %d views are too many; %d are the most",
            run->list.items[run->list.n - 1].path, run->list.n, RF_MAX_VIEWS);
    }
    if (run->request.depth_file) {
        return app_fail(run->error, APP_USAGE,
                        "--depth-file: every view needs depth of its own, in its file");
    }
    if (run->tool->albedo_file || run->tool->normal_file) {
        return app_fail(run->error, APP_USAGE,
                        "--albedo-file and --normal-file: every view needs albedo and "
                        "normals of its own, in its file");
    }
    if (run->tool->pass_through && run->list.items[0].name) {
        return app_fail(
            run->error, APP_USAGE,
            "--pass-through: of several views in one file one picture is made; "
            "leave it out");
    }
    if (settings_origin(run->settings, "method") == ORIGIN_COMMAND_LINE &&
        rf_method_find(run->settings->params.method)->max_views == 1)
        return fail_method(run);
    return warn_of_twins(run);
}

/* Are the inputs views, or a picture and perhaps its depth? One view is a picture, and
 * --layer names one. */
static int find_views(struct run *run)
{
    const char *other = NULL;
    char pattern[4096];
    const int n_paths = run->request.n_paths;
    if (n_paths == 1 && run->request.layer)
        return APP_DONE;
    if (!views_list(run->request.paths, n_paths, &run->list, &other, run->error))
        return fail_image(run);
    run->has_views = !other && run->list.n > 1;
    if (other &&
        frame_guess_sequence(run->request.paths, n_paths, pattern, sizeof(pattern)))
        return app_fail(
            run->error, APP_USAGE,
            "%s: is no view from a point of the lens, its header has no " VIEWS_OFFSET
            "; the frames of a sequence are filtered with "
            "'%s' as the input and #### in the output",
            other, pattern);
    if (other && n_paths > 2) {
        return app_fail(
            run->error, run->list.n > 0 ? APP_FAILED : APP_USAGE,
            "%s: is no view from a point of the lens, its header has no " VIEWS_OFFSET
            "; filter takes one file of colour and one of depth, or only views",
            other);
    }
    return run->has_views ? check_views(run) : APP_DONE;
}

/* Other layers that are to be filtered. */
static int find_layers(struct run *run)
{
    if (!run->tool->filter_layers)
        return APP_DONE;
    if (run->is_deep || run->has_views) {
        return app_fail(run->error, APP_USAGE,
                        "--filter-layers: takes one flat picture, and %s %s",
                        image_path(run->source.colour),
                        run->is_deep ? "is deep" : "is one of several views");
    }
    if (run->tool->aperture_image)
        return app_fail(
            run->error, APP_USAGE,
            "--filter-layers: does not know pictures of the aperture; leave out "
            "--aperture-image, or make each layer a picture of its own with --layer");
    return aovs_find(&run->aovs, &run->source, run->tool->filter_layers, run->error)
               ? APP_DONE
               : fail_image(run);
}

static int filter_layers(struct run *run)
{
    return aovs_filter(&run->aovs, &run->source, run->context, &run->params, run->depth,
                       run->n_threads, run->error)
               ? APP_DONE
               : fail_image(run);
}

/* ---- steps ---------------------------------------------------------------------- */

/* --aperture-image says which aperture or, of scatter, which distribution. */
static int check_aperture_image(struct run *run)
{
    const struct rf_params *params = &run->settings->params;
    const struct rf_method_info *method = rf_method_find(params->method);
    bool has_image = run->tool->aperture_image != NULL;
    if (!has_image && params->aperture == RF_APERTURE_IMAGE && method->has_layers &&
        !run->tool->distribution_image)
        return app_fail(run->error, APP_USAGE,
                        "--aperture image: needs its picture, --aperture-image FILE");
    if (!has_image)
        return APP_DONE;
    if (run->tool->distribution_image)
        return app_fail(run->error, APP_USAGE,
                        "--aperture-image: give it or --distribution-image, not both");
    const char *name = method->has_layers ? "aperture" : "distribution";
    const int32_t value = method->has_layers ? params->aperture : params->distribution;
    const int32_t image =
        method->has_layers ? RF_APERTURE_IMAGE : RF_DISTRIBUTION_IMAGE;
    if (!method->has_layers && params->method != RF_METHOD_SCATTER)
        return app_fail(run->error, APP_USAGE,
                        "--aperture-image: is for the methods layered, views and "
                        "scatter; %s has no aperture of its own",
                        method->name);
    if (settings_origin(run->settings, name) == ORIGIN_COMMAND_LINE && value != image)
        return app_fail(run->error, APP_USAGE,
                        "--aperture-image: goes with --%s image, which can be left out",
                        name);
    settings_set(run->settings, name, "image", NULL);
    return APP_DONE;
}

/* --distribution-image says which distribution, and is of use to one method only. */
static int check_distribution(struct run *run)
{
    const bool has_image = run->tool->distribution_image != NULL;
    const struct rf_params *params = &run->settings->params;
    const bool is_typed =
        settings_origin(run->settings, "distribution") == ORIGIN_COMMAND_LINE;
    if (has_image && params->method != RF_METHOD_SCATTER) {
        return app_fail(
            run->error, APP_USAGE,
            "--distribution-image: is for the method scatter; add --method scatter");
    }
    if (has_image && is_typed && params->distribution != RF_DISTRIBUTION_IMAGE) {
        return app_fail(
            run->error, APP_USAGE,
            "--distribution-image: goes with --distribution image, which can be "
            "left out");
    }
    if (has_image)
        settings_set(run->settings, "distribution", "image", NULL);
    else if (!run->tool->aperture_image &&
             params->distribution == RF_DISTRIBUTION_IMAGE &&
             params->method == RF_METHOD_SCATTER) {
        return app_fail(
            run->error, APP_USAGE,
            "--distribution image: needs its picture, --distribution-image FILE");
    }
    return APP_DONE;
}

/* A falloff is undone on values from 0 to 1; distances it would spoil. */
static int check_mist(const struct run *run)
{
    if (run->tool->mist_falloff == RF_MIST_NONE ||
        run->settings->params.depth == RF_DEPTH_NORMALISED)
        return APP_DONE;
    return app_fail(run->error, APP_USAGE,
                    "--mist-falloff: is for depth from 0 to 1; add --depth normalised "
                    "--depth-near START --depth-far END, or leave it out");
}

/*
 * Beside the denoiser more sub-apertures cost next to nothing: 16 for 4 are worth 0.1 to
 * 0.5 dB with one view, 0.0 to 1.1 with eight (docs/notebook/views.md).
 */
static void open_lens(struct run *run)
{
    enum { SUB_APERTURES = 16 };
    if (run->tool->denoise &&
        settings_origin(run->settings, "sub-apertures") == ORIGIN_DEFAULT)
        settings_set_header(run->settings, "sub-apertures", SUB_APERTURES, "--denoise",
                            NULL);
}

static int read_facts(struct run *run)
{
    char text[1024];
    const struct source *source = &run->source;
    if (!source_read_facts(source, run->settings, text, sizeof(text))) {
        return app_fail(run->error, APP_FAILED, "%s", text);
    }
    if (run->has_views)
        settings_set_header(run->settings, "method", RF_METHOD_VIEWS, VIEWS_OFFSET,
                            NULL);
    open_lens(run);
    int code = APP_DONE;
    if (run->settings->params.method == RF_METHOD_ACCUMULATE && !run->has_views)
        code = app_warn(run->tool->host, run->error, VIEWS_ONE_IS_MEAN,
                        image_path(source->colour));
    if (code == APP_DONE && source_was_filtered(source, text, sizeof text))
        code = app_warn(run->tool->host, run->error, "%s: %s",
                        image_path(source->colour), text);
    if (code == APP_DONE)
        code = filter_warn_attributes(run);
    if (code == APP_DONE)
        code = filter_warn_choice(run);
    if (code == APP_DONE)
        code = filter_warn_eyes(run);
    if (code == APP_DONE)
        code = check_mist(run);
    if (code == APP_DONE)
        code = check_distribution(run);
    if (code == APP_DONE)
        code = check_aperture_image(run);
    if (code != APP_DONE)
        return code;
    struct rf_error error;
    if (settings_fit_window(run->settings, &source->info, &run->params, &error) !=
        RF_OK)
        return filter_fail_core(run, &error);
    source_settle_grey(source, &run->params);
    code = filter_warn_unread(run);
    if (code == APP_DONE)
        code = filter_warn_aspect(run);
    if (code == APP_DONE)
        code = filter_warn_window(run);
    if (code == APP_DONE)
        code = filter_warn_environment(run);
    if (code == APP_DONE)
        code = filter_warn_coded(run);
    return code == APP_DONE ? filter_warn_layers(run) : code;
}

/* Of a picture in memory. */
static int find_white(struct run *run)
{
    const struct source *source = &run->source;
    struct white_tally tally = {.n_unlit = 0};
    if (run->windows || !filter_needs_white(run))
        return APP_DONE;
    white_tally_add(&tally, run->colour, (size_t)source->width * (size_t)source->height,
                    source->n_channels);
    return filter_take_white(run, &tally);
}

static int make_filter(struct run *run)
{
    return filter_make(run, (size_t)run->tool->max_memory_mib << 20);
}

/*
 * Is the aperture where views were taken? Beside them all pictures get worse by and by:
 * of posts, whose eight reach 0.03, stopped down to a pinhole, 0.5 % of the pixels have
 * nothing 1 reach from the middle, 2.7 % at 2, 7 % at 3 and 37 % at 16.
 */
static int check_aperture_place(const struct run *run)
{
    static const double MOST_REACHES = 3;
    double middle[2], reach = views_reach(&run->views, middle);
    const double *at = run->aperture_at, ratio = run->params.aperture_ratio;
    const double radius = rf_filter_lens(run->filter)->lens_radius * fmax(1, 1 / ratio);
    const double distance = hypot(at[0] - middle[0], at[1] - middle[1]);
    if (!run->tool->aperture_at || distance <= reach + radius ||
        run->params.method == RF_METHOD_ACCUMULATE)
        return APP_DONE;
    if (distance > MOST_REACHES * reach + radius)
        return app_fail(run->error, APP_USAGE,
                        "--aperture-at: no view saw the scene from near %g,%g: they "
                        "lie within %.3g of %.3g,%.3g; with this lens radius, %.3g, "
                        "give a place within %.3g of that",
                        at[0], at[1], reach, middle[0], middle[1], radius,
                        reach + radius);
    return app_warn(run->tool->host, run->error,
                    "--aperture-at: an aperture of radius %.3g at %g,%g is beside the "
                    "views, which lie within %.3g of %.3g,%.3g: what they do not show "
                    "is missing or guessed",
                    radius, at[0], at[1], reach, middle[0], middle[1]);
}

/* Opens the files of several views, places counted from the aperture's middle. */
static int open_views(struct run *run)
{
    if (!run->has_views)
        return APP_DONE;
    if (!views_open(&run->views, &run->source, &run->list, &run->request, run->error))
        return fail_image(run);
    const int code = check_aperture_place(run);
    for (int i = 0; i < run->views.n; i++)
        for (int k = 0; k < 2; k++)
            run->views.views[i].lens_offset[k] -= run->aperture_at[k];
    return code;
}

static int read_pixels(struct run *run)
{
    if (run->is_deep)
        return filter_read_deep(run);
    if (windows_are_needed(run))
        return windows_open(run);
    if (run->has_views) {
        if (!views_read_pixels(&run->views, run->n_threads, run->error))
            return fail_image(run);
        run->colour = run->views.views[0].colour.data;
        run->depth = run->views.views[0].depth.data;
        return os_is_interrupted() ? APP_INTERRUPTED : filter_repair_depth(run);
    }
    run->colour = source_read_colour(&run->source, run->n_threads, run->error);
    if (!run->colour)
        return fail_image(run);
    run->depth = source_read_depth(&run->source, run->n_threads, run->error);
    if (!run->depth)
        return fail_image(run);
    return os_is_interrupted() ? APP_INTERRUPTED : filter_repair_depth(run);
}

/* The mean distances of a view. */
static int read_mean_depth(struct run *run, const struct source *source,
                           struct rf_view *view)
{
    float *rays;
    int code = mean_depth_read_rays(source, run->n_threads, &rays, run->error)
                   ? APP_DONE
                   : fail_image(run);
    if (code == APP_DONE && rays && !run->has_views && !seen_is_asked(run->tool))
        code = seen_warn(run, rays);
    if (code == APP_DONE && rays &&
        !mean_depth_make(rf_filter_lens(run->filter), &run->params, rays, view,
                         run->error))
        code = fail_image(run);
    free(rays);
    return code;
}

/* Mean distances, where the files have some and the picture is made with them. */
static int read_mean_depths(struct run *run)
{
    struct rf_view alone = {
        .depth = rf_image_packed(run->depth, run->source.width, run->source.height, 1)};
    if (run->is_deep || !mean_depth_is_used(&run->params))
        return APP_DONE;
    if (run->windows)
        return mean_depth_is_there(&run->source)
                   ? app_warn(run->tool->host, run->error,
                              "%s: Denoising Depth is not read in windows, and edges "
                              "are a little worse for it; raise --max-memory, or leave "
                              "it out",
                              image_path(run->source.colour))
                   : APP_DONE;
    int code = APP_DONE;
    for (int i = 0; i < filter_n_views(run) && code == APP_DONE; i++)
        code =
            read_mean_depth(run, run->has_views ? &run->views.sources[i] : &run->source,
                            run->has_views ? &run->views.views[i] : &alone);
    run->mean_depth = alone.mean_depth;
    return code;
}

/* Makes the lens's picture of the pixels at hand in `samples`, packed. */
static int make_picture(struct run *run, float *samples)
{
    const struct source *source = &run->source;
    struct rf_view view = {
        .colour = rf_image_packed(run->colour, source->width, source->height,
                                  source->n_channels),
        .depth = rf_image_packed(run->depth, source->width, source->height, 1),
        .mean_depth = run->mean_depth};
    for (int i = 0; i < filter_n_views(run); i++) {
        struct rf_view *to = run->has_views ? &run->views.views[i] : &view;
        temporal_set_behind(run, i, to);
        seen_set(run, i, to);
    }
    if (run->border)
        return temporal_border_filter(run, &view, samples);
    const struct rf_image out =
        rf_image_packed(samples, source->width, source->height, source->n_channels);
    struct rf_error error;
    const struct app_host *host = run->tool->host;
    app_begin(host, "filtering");
    const struct rf_progress progress = {app_progress, (void *)host};
    const rf_result result =
        run->is_deep
            ? rf_filter_process_deep(run->filter, &run->deep.frame, &out, &progress,
                                     &error)
            : rf_filter_process(run->filter, run->has_views ? run->views.views : &view,
                                filter_n_views(run), &out, &progress, &error);
    app_end(host);
    if (result != RF_OK)
        return filter_fail_core(run, &error);
    return os_is_interrupted() ? APP_INTERRUPTED : APP_DONE;
}

static int process(struct run *run)
{
    if (run->windows)
        return windows_filter(run);
    return run->tool->denoise ? denoise_and_filter(run, make_picture)
                              : make_picture(run, run->colour);
}

/* ---- output --------------------------------------------------------------------- */

/* Turns the depth, which is of no more use, into radii. */
static int make_coc(struct run *run)
{
    const struct rf_image image =
        rf_image_packed(run->depth, run->source.width, run->source.height, 1);
    struct rf_error error;
    if (rf_filter_coc(run->filter, &image, &image, &error) != RF_OK)
        return filter_fail_core(run, &error);
    return APP_DONE;
}

/* Half a set of files is of no use: on failure and interruption those that were not
 * there before go. An old file stays replaced, since it may have been the input. */
static int write_output(struct run *run)
{
    if (run->windows)
        return windows_finish(run);
    const char *output = run->tool->output, *coc = run->tool->output_coc;
    const bool is_new = os_file_facts(output).kind == OS_FILE_NONE;
    const bool is_coc_new = coc && os_file_facts(coc).kind == OS_FILE_NONE;
    int code = coc ? make_coc(run) : APP_DONE;
    if (code != APP_DONE)
        return code;
    if (!filter_write_files(run, run->error))
        code = fail_image(run);
    else if (os_is_interrupted())
        code = APP_INTERRUPTED;
    if (code != APP_DONE && is_new)
        remove(output);
    if (code != APP_DONE && is_coc_new)
        remove(coc);
    return code;
}

/* ---- the run -------------------------------------------------------------------- */

/* How large the blur is, and that values which nobody gave make it so. */
static int warn_facts(struct run *run)
{
    if (!run->windows)
        filter_measure_radii(run);
    int code = filter_warn_highlights(run);
    if (code == APP_DONE)
        code = filter_warn_defaults(run);
    if (code == APP_DONE)
        code = filter_warn_target(run);
    if (code == APP_DONE)
        code = filter_warn_view(run);
    if (code == APP_DONE)
        code = filter_warn_unit_scale(run);
    if (code == APP_DONE)
        code = filter_warn_ends(run);
    if (code == APP_DONE)
        code = filter_warn_cut(run);
    if (code == APP_DONE)
        code = filter_warn_shown_view(run);
    return code == APP_DONE ? filter_warn_doubts(run) : code;
}

static int say_done(struct run *run)
{
    filter_say_done(run);
    return APP_DONE;
}

/* One step; what the core remarked meanwhile may be an error to the host. */
static int do_step(struct run *run, int (*step)(struct run *))
{
    const int code = step(run);
    return code == APP_DONE ? run->remark : code;
}

static int run_steps(struct run *run)
{
    static int (*const steps[])(struct run *) = {
        find_layers, read_facts,    make_filter,   open_views,   read_pixels,
        find_white,  warn_facts,    temporal_find, seen_find,    read_mean_depths,
        process,     filter_layers, filter_shrink, write_output, say_done};
    if (!source_check(&run->source, run->error) ||
        !picture_check_writable(run->tool->output, run->error) ||
        (run->tool->output_coc &&
         !picture_check_writable(run->tool->output_coc, run->error)) ||
        (run->tool->flattened &&
         !picture_check_writable(run->tool->flattened, run->error)))
        return fail_image(run);
    int code = filter_check_deep(run);
    if (code == APP_DONE)
        code = seen_check(run);
    if (code == APP_DONE)
        code = filter_check_supersample(run);
    for (size_t i = 0; code == APP_DONE && i < sizeof(steps) / sizeof(steps[0]); i++)
        code = do_step(run, steps[i]);
    return code;
}

/* Adds the file, where it is not named, and the way out. */
static void explain_memory(struct run *run)
{
    const char *path = image_path(run->source.colour);
    const bool is_named = strncmp(run->error->message, path, strlen(path)) == 0;
    const struct image_error before = *run->error;
    app_fail(run->error, APP_NO_MEMORY, "%s%s%s; %s", is_named ? "" : path,
             is_named ? "" : ": ", before.message[0] ? before.message : "out of memory",
             !windows_are_possible(run) ? "free some memory, or give a smaller picture"
             : run->tool->max_memory_mib
                 ? "allow less by --max-memory"
                 : "--max-memory MIB reads, filters and writes it in parts");
}

static void free_run(struct run *run)
{
    windows_free(run);
    doubts_free(run->doubts);
    temporal_free(run);
    rf_filter_destroy(run->filter);
    filter_kept_free(&run->own);
    if (!run->has_views) {
        free(run->colour);
        free(run->depth);
        free(run->mean_depth.data);
    }
    views_free(&run->views);
    views_list_free(&run->list);
    deep_free(&run->deep);
    aovs_free(&run->aovs);
    seen_free(&run->seen);
    source_close(&run->source);
}

int filter_run(const struct filter_options *tool, struct settings *settings,
               char *const *paths, int n_paths, struct image_error *error)
{
    struct run run = {
        .tool = tool,
        .error = error,
        .settings = settings,
        .request = {.paths = paths,
                    .n_paths = n_paths,
                    .layer = tool->layer,
                    .depth_file = tool->depth_file,
                    .depth_channel = tool->depth_channel},
        .n_threads = thread_count(tool->n_threads),
    };
    int code = tool->view ? APP_DONE : find_views(&run);
    if (code == APP_DONE)
        code = read_aperture(&run);
    struct source_request first = run.request;
    first.n_paths = run.has_views ? 1 : n_paths;
    first.view = run.has_views ? run.list.items[0].name : tool->view;
    if (code == APP_DONE && !source_open(&run.source, &first, error))
        code = app_code_of(error);
    if (code != APP_DONE) {
        views_list_free(&run.list);
        return code;
    }
    if (tool->kept) {
        /* Data windows of a shot may differ: compositors crop to what is there. */
        const struct image_box *display = &run.source.info.display_window;
        tool->kept->width = display->max_x - display->min_x + 1;
        tool->kept->height = display->max_y - display->min_y + 1;
    }
    code = run_steps(&run);
    if (code == APP_NO_MEMORY)
        explain_memory(&run);
    free_run(&run);
    return code;
}
