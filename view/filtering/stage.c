/* SPDX-License-Identifier: Apache-2.0 */
#include "filtering/stage.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "filter/filter_output.h"
#include "filter/filter_run.h"
#include "pixels/input_read.h"
#include "povray/povray_files.h"
#include "povray/povray_lens.h"
#include "sources/depth_repair.h"
#include "sources/picture.h"
#include "sources/picture_doubts.h"
#include "sources/views.h"
#include "sources/views_fit.h"
#include "sources/views_light.h"
#include "sources/white.h"

/* ---- scenes of POV-Ray ----------------------------------------------------------- */

static bool is_cancelled(void *user)
{
    return ((struct stage *)user)->is_cancelled;
}

static void show_progress(void *user, double fraction)
{
    ((struct stage *)user)->fraction = fraction;
}

static bool is_typed(const struct settings *typed, const char *name)
{
    return settings_origin(typed, name) == ORIGIN_COMMAND_LINE;
}

static void make_scene_options(struct stage *stage, const struct settings *typed)
{
    struct povray_options *o = &stage->povray_options;
    *o = (struct povray_options){.scene = stage->files->paths[0],
                                 .program = stage->options->povray,
                                 .args = stage->povray_args,
                                 .n_args = stage->n_povray_args,
                                 .frame = -1,
                                 .supersample = 1, /* a pixel of the window each */
                                 .is_cancelled = is_cancelled,
                                 .progress = show_progress,
                                 .user = stage,
                                 .n_threads = thread_count(stage->options->n_threads)};
    struct settings lens = *typed;
    struct povray_stop stop = {.f_stop = 0};
    stage->has_stop = povray_lens_take_stop(&lens, &stop);
    povray_lens_options(o, &lens, &stop);
    /* One view has no need of a lens; several are taken over one. */
    o->wants_lens = stage->options->n_views > 1 && !stage->has_stop;
}

/* What was typed, for passes of a scene with a lens: an f-stop is POV-Ray's lens radius,
 * which they have, or, where it came later, another one. */
static struct settings typed_of_passes(const struct stage *stage,
                                       const struct settings *typed)
{
    struct settings left = *typed;
    struct povray_stop now = {.f_stop = 0};
    const struct povray_stop *rendered = &stage->povray_options.stop;
    const int is_ortho = stage->camera.is_orthographic;
    if (!stage->has_stop && !(stage->is_scene && stage->camera.aperture > 0))
        return left;
    if (povray_lens_take_stop(&left, &now) &&
        now.radius[is_ortho] != rendered->radius[is_ortho]) {
        char radius[40];
        snprintf(radius, sizeof(radius), "%.17g", now.radius[is_ortho]);
        settings_set(&left, "lens-radius", radius, NULL);
    } else if (stage->has_stop) {
        povray_lens_drop_stop(&left);
    }
    if (!is_ortho && stage->camera.aperture != 0)
        povray_lens_keep(&left, stage->camera.aperture / 4, stage->focal_px);
    return left;
}

static void add_remark(void *user, const char *text)
{
    struct stage *stage = user;
    const size_t n = strlen(stage->remark);
    if (text[0])
        snprintf(stage->remark + n, sizeof(stage->remark) - n, "%s%s",
                 n > 0 ? "; " : "", text);
}

static bool write_pass(struct stage *stage, const struct povray_passes *passes, int i,
                       bool is_view, struct image_error *error)
{
    char path[4200];
    const char *folder =
        stage->options->keep ? stage->options->keep : povray_folder(stage->scene);
    const char *slash = folder[strlen(folder) - 1] == '/' ? "" : "/";
    if (is_view)
        snprintf(path, sizeof(path), "%s%spasses_v%02d.exr", folder, slash, i);
    else
        snprintf(path, sizeof(path), "%s%spasses.exr", folder, slash);
    char *copy = strdup(path);
    if (!copy)
        return set_error(error, "out of memory");
    stage->scene_paths[stage->n_scene_paths++] = copy;
    return povray_file_write(path, passes,
                             is_view ? POVRAY_FILE_VIEW : POVRAY_FILE_PASSES, NULL,
                             thread_count(stage->options->n_threads), error);
}

static bool receive_view(void *user, int view, const struct povray_passes *passes,
                         struct povray_error *error)
{
    struct image_error image_error;
    if (view == 0)
        add_remark(user, passes->warning);
    if (write_pass(user, passes, view, true, &image_error))
        return true;
    snprintf(error->message, sizeof(error->message), "%s", image_error.message);
    return false;
}

static bool render_scene(struct stage *stage, const struct settings *typed,
                         struct image_error *error)
{
    struct povray_error povray_error;
    struct povray_passes passes = {0};
    double seconds;
    snprintf(stage->label, sizeof(stage->label), "rendering %.200s",
             stage->files->paths[0]);
    if (stage->options->keep &&
        !picture_need_folder(stage->options->keep, OS_FOLDER_GOES_IF_EMPTY, error))
        return false;
    make_scene_options(stage, typed);
    if (stage->options->n_views > 1 && stage->povray_options.has_f_stop &&
        !stage->has_stop)
        return set_error(error, "--views needs the lens as --lens-radius, not as "
                                "--f-stop, with these --optics");
    bool is_good = povray_open(&stage->scene, &stage->povray_options, &povray_error);
    if (is_good)
        add_remark(stage, povray_remark(stage->scene));
    if (is_good && stage->options->n_views > 1)
        is_good = povray_files_views(stage->scene, stage->options->n_views,
                                     receive_view, stage, &seconds, &povray_error);
    else if (is_good)
        is_good = povray_render(stage->scene, &passes, &povray_error);
    if (!is_good)
        return set_error(error, "%s", povray_error.message);
    if (stage->options->n_views > 1)
        povray_describe(stage->scene, &passes);
    add_remark(stage, povray_lens_remark(&passes.camera));
    stage->camera = passes.camera;
    stage->focal_px = povray_file_focal_px(&passes);
    if (stage->options->n_views == 1) {
        add_remark(stage, passes.warning);
        is_good = write_pass(stage, &passes, 0, false, error);
    }
    povray_passes_free(&passes);
    return is_good;
}

/* ---- files ----------------------------------------------------------------------- */

/* Where the white of one of the sources is kept; 0 until its light was read. */
static int white_at(const struct stage *stage, const struct source *source)
{
    return source == &stage->source ? 0 : 1 + (int)(source - stage->others);
}

/* What a source says of its camera, and what was typed. */
static bool resolve_source(const struct stage *stage, const struct source *source,
                           const struct settings *typed, struct settings *settings,
                           struct rf_params *params, char *text, size_t n_bytes)
{
    struct rf_error error;
    const double white = stage->whites[white_at(stage, source)];
    *settings = typed_of_passes(stage, typed);
    if (!source_read_facts(source, settings, text, n_bytes))
        return false;
    if (stage->has_views)
        settings_set_header(settings, "method", RF_METHOD_VIEWS, VIEWS_OFFSET, NULL);
    if (white > 0)
        settings_set_header(settings, "white", white, "the picture", NULL);
    const bool is_good =
        settings_fit_window(settings, &source->info, params, &error) == RF_OK;
    if (is_good)
        source_settle_grey(source, params);
    else
        snprintf(text, n_bytes, "%s", error.message);
    return is_good;
}

/* What the core refuses to blur, with the way out that `rackfocus filter` has for it. */
static void remark_refused(struct stage *stage, const struct source *source,
                           const struct rf_params *params, const struct input *input)
{
    const struct rf_image *colour = &input->views[0].colour;
    const float *pixels = colour->data;
    const size_t n = (size_t)colour->width * (size_t)colour->height;
    struct depth_numbers numbers = {0};
    size_t n_bad = 0;
    char text[700];
    for (size_t i = 0; i < n * (size_t)colour->channels; i++)
        n_bad += !isfinite(pixels[i]);
    depth_numbers_add(&numbers, params, input->views[0].depth.data, n);
    depth_explain(&numbers, source, params, stage->way_out, sizeof(stage->way_out));
    snprintf(text, sizeof(text), "the depth has numbers that are no distances%s",
             stage->way_out);
    if (stage->way_out[0])
        add_remark(stage, text);
    if (n_bad == 0)
        return;
    picture_explain_pixels(source, stage->way_out, sizeof(stage->way_out));
    snprintf(text, sizeof(text), "the colour has numbers that are NaN or infinite%s",
             stage->way_out);
    add_remark(stage, text);
}

/* The depth of all views of a source, as `rackfocus filter` takes it. */
static bool mend_depth(struct stage *stage, const struct settings *typed,
                       const struct source *source, const struct input *input,
                       struct image_error *error)
{
    const struct view_options *options = stage->options;
    const size_t n = (size_t)input->width * (size_t)input->height;
    struct settings settings;
    struct rf_params params;
    char mended[200], text[300];
    for (int i = 0; i < input->n_views; i++)
        rf_depth_undo_mist(input->views[i].depth.data, n,
                           (enum rf_mist)options->mist_falloff);
    const bool is_resolved = resolve_source(stage, source, typed, &settings, &params,
                                            error->message, sizeof(error->message));
    if (is_resolved && !stage->scene && input->n_views == 1)
        remark_refused(stage, source, &params, input);
    if (!is_resolved || options->depth_repair == DEPTH_REPAIR_OFF)
        return is_resolved || options->depth_repair == DEPTH_REPAIR_OFF;
    const struct depth_picture picture = {source, &settings, &params, input->views,
                                          input->n_views};
    const struct depth_listener listener = {add_remark, stage};
    if (!depth_mend(&picture, mended, sizeof(mended), listener, error))
        return false;
    if (!stage->scene)
        picture_say_doubts(&picture, add_remark, stage);
    if (mended[0]) {
        snprintf(text, sizeof(text), "%s (--depth-repair off takes it as it is)",
                 mended);
        add_remark(stage, text);
    }
    return true;
}

/* One view of a file of several, which nobody named. */
static bool shows_one_eye(const struct stage *stage, const struct source *source,
                          char *text, size_t n_bytes)
{
    const char *eye = image_view_of(source->colour, source->layer.r);
    if (!eye || stage->has_views || stage->options->is_stereo ||
        stage->options->layer || image_view_count(source->colour) < 2)
        return false;
    snprintf(text, n_bytes,
             "the picture is the view %.60s, one of %d; view --stereo shows both eyes",
             eye, image_view_count(source->colour));
    return true;
}

/* What `rackfocus filter` warns of before it reads the picture. */
static void remark_doubts(struct stage *stage, const struct source *source)
{
    char why[500];
    source_say_doubts(source, add_remark, stage);
    if (shows_one_eye(stage, source, why, sizeof(why)))
        add_remark(stage, why);
}

static void find_white(struct stage *stage, const struct source *source,
                       const struct input *input)
{
    const struct rf_image *colour = &input->views[0].colour;
    const size_t n = (size_t)colour->width * (size_t)colour->height;
    stage->whites[white_at(stage, source)] =
        white_of_pixels(colour->data, n, colour->channels);
}

static bool open_source(struct stage *stage, const struct source_request *request,
                        const struct view_list *list, struct image_error *error)
{
    struct source_request first = *request;
    first.n_paths = stage->has_views ? 1 : request->n_paths;
    first.view = stage->has_views ? list->items[0].name : NULL;
    stage->is_open = source_open(&stage->source, &first, error);
    return stage->is_open && source_check(&stage->source, error);
}

static struct input *read_deep(const struct stage *stage, const struct settings *typed,
                               int n_threads, struct image_error *error)
{
    struct settings settings;
    struct rf_params params;
    if (!stage_resolve(stage, typed, &settings, &params, error->message,
                       sizeof(error->message)))
        return NULL;
    return input_read_deep(&stage->source, &params, n_threads, error);
}

/* A remark on one of the views, or on all: view < 0. */
static void remark_view(struct stage *stage, const struct view_list *list, int view,
                        const char *what)
{
    char text[700];
    snprintf(text, sizeof(text), "%s%s%s", view >= 0 ? list->items[view].path : "",
             view >= 0 ? ": " : "", what);
    add_remark(stage, text);
}

/* That views have another exposure, or lie elsewhere than their headers say, as
 * `rackfocus filter` warns. */
static void remark_views(struct stage *stage, const struct settings *typed,
                         const struct view_list *list)
{
    const struct input *input = stage->input;
    struct settings settings;
    struct rf_params params;
    struct rf_lens lens;
    struct views_light_found light;
    struct views_fit fit;
    char what[500];
    if (!stage->has_views || stage->scene)
        return;
    if (views_light_is_other(input->views, input->n_views, &light)) {
        views_light_explain(&light, what, sizeof(what));
        remark_view(stage, list, light.view, what);
    }
    if (!stage_resolve(stage, typed, &settings, &params, what, sizeof(what)) ||
        rf_lens_init(&lens, &params, input->width, input->height, NULL) != RF_OK)
        return;
    const struct views_fit_given given = {input->views, input->n_views,   0, &params,
                                          &lens,        &views_in_headers};
    if (!views_fit_is_wrong(&given, &fit))
        return;
    views_fit_explain(&fit, &views_in_headers, what, sizeof(what));
    remark_view(stage, list, fit.wrong_view, what);
}

static bool read_files(struct stage *stage, const struct settings *typed,
                       char *const *paths, int n_paths, struct image_error *error)
{
    struct source_request request = {.paths = paths,
                                     .n_paths = n_paths,
                                     .layer = stage->options->layer,
                                     .depth_file = stage->options->depth_file,
                                     .depth_channel = stage->options->depth_channel};
    struct view_list list = {0};
    const char *other = NULL;
    snprintf(stage->label, sizeof(stage->label), "reading %.200s", paths[0]);
    const bool is_one = n_paths == 1 && request.layer;
    if (!is_one && !views_list(paths, n_paths, &list, &other, error))
        return false;
    stage->has_views = !is_one && !other && list.n > 1;
    bool is_good = stage->has_views || n_paths <= 2;
    if (!is_good)
        set_error(
            error,
            "%s: is no view from a point of the lens, its header has no " VIEWS_OFFSET
            "; view takes one file of colour and one of depth, or only views",
            other);
    is_good = is_good && open_source(stage, &request, &list, error);
    if (is_good)
        remark_doubts(stage, &stage->source);
    const int n_threads = thread_count(stage->options->n_threads);
    const bool is_deep = is_good && stage->source.info.is_deep && !stage->has_views;
    if (is_deep)
        stage->input = read_deep(stage, typed, n_threads, error);
    else if (is_good)
        stage->input = stage->has_views ? input_read_views(&stage->source, &list,
                                                           &request, n_threads, error)
                                        : input_read(&stage->source, n_threads, error);
    is_good =
        is_good && stage->input &&
        (is_deep || mend_depth(stage, typed, &stage->source, stage->input, error));
    if (is_good)
        remark_views(stage, typed, &list);
    if (is_good && !is_deep)
        find_white(stage, &stage->source, stage->input);
    views_list_free(&list);
    return is_good;
}

/* ---- layers and eyes --------------------------------------------------------------- */

/* One picture of a stack: its source and its pixels. */
static struct input *read_one(struct stage *stage, const struct settings *typed,
                              struct source_request *request, struct source *source,
                              struct image_error *error)
{
    const int n_threads = thread_count(stage->options->n_threads);
    if (!source_open(source, request, error))
        return NULL;
    struct input *input = NULL;
    if (!source_check(source, error))
        input = NULL;
    else if (source->info.is_deep)
        set_error(error, "%s: holds deep samples, which need no --over or --stereo",
                  request->paths[0]);
    else
        input = input_read(source, n_threads, error);
    if (input)
        remark_doubts(stage, source);
    if (input && !mend_depth(stage, typed, source, input, error)) {
        input_drop(input);
        input = NULL;
    }
    if (input)
        find_white(stage, source, input);
    return input;
}

static bool add_other(struct stage *stage, const struct settings *typed,
                      struct source_request *request, struct image_error *error)
{
    struct input *first = stage->input;
    struct source *source = &stage->others[stage->n_others];
    struct input *input = read_one(stage, typed, request, source, error);
    if (source->colour)
        stage->n_others++; /* to be closed */
    if (!input)
        return false;
    first->others[first->n_others++] = input;
    if (input->width != first->width || input->height != first->height)
        return set_error(error, "%s: is %d x %d, the others %d x %d", request->paths[0],
                         input->width, input->height, first->width, first->height);
    if (stage->options->is_over ? input->n_channels != 4
                                : input->n_channels != first->n_channels)
        return set_error(error,
                         stage->options->is_over
                             ? "%s: has no alpha, so nothing below it would be seen"
                             : "%s: has other channels than the left eye",
                         request->paths[0]);
    return true;
}

static int find_view(const struct image_input *input, const char *name)
{
    for (int i = 0; i < image_view_count(input); i++)
        if (strcasecmp(image_view_name(input, i), name) == 0)
            return i;
    return -1;
}

/* The views "left" and "right" of a multi-view file; without them its first two. */
static bool list_eyes(const char *path, char names[2][64], struct image_error *error)
{
    struct image_input *input;
    if (!image_open(&input, path, error))
        return false;
    const int n = image_view_count(input);
    const int found[2] = {find_view(input, "left"), find_view(input, "right")};
    const bool has_names = found[0] >= 0 && found[1] >= 0;
    for (int i = 0; i < 2 && n >= 2; i++)
        snprintf(names[i], 64, "%s", image_view_name(input, has_names ? found[i] : i));
    image_close(input);
    return n >= 2 || set_error(error,
                               "%s: holds one view; --stereo takes a file of two, or "
                               "two files, left and right",
                               path);
}

/* The i-th picture from the one that is read first: layers from below, eyes from the
 * left. Views of one file have a name. */
static bool read_stack(struct stage *stage, const struct settings *typed,
                       struct image_error *error)
{
    char *const *paths = stage->files->paths;
    const bool is_over = stage->options->is_over;
    const bool is_inside = !is_over && stage->files->n_paths == 1;
    const int n = is_inside ? 2 : stage->files->n_paths;
    char names[2][64] = {"", ""};
    snprintf(stage->label, sizeof(stage->label), "reading %.200s", paths[0]);
    if (is_inside && !list_eyes(paths[0], names, error))
        return false;
    for (int i = 0; i < n; i++) {
        char *path = paths[is_inside ? 0 : is_over ? n - 1 - i : i];
        struct source_request request = {
            .paths = &path, .n_paths = 1, .view = is_inside ? names[i] : NULL};
        if (i > 0 && !add_other(stage, typed, &request, error))
            return false;
        if (i > 0)
            continue;
        stage->input = read_one(stage, typed, &request, &stage->source, error);
        stage->is_open = stage->source.colour != NULL;
        if (!stage->input)
            return false;
    }
    return true;
}

bool stage_load(struct stage *stage, const struct settings *typed,
                struct image_error *error)
{
    stage->is_scene =
        stage->files->n_paths == 1 && picture_is_scene(stage->files->paths[0]);
    if (stage->options->is_over || stage->options->is_stereo)
        return read_stack(stage, typed, error);
    if (!stage->is_scene)
        return read_files(stage, typed, stage->files->paths, stage->files->n_paths,
                          error);
    return render_scene(stage, typed, error) &&
           read_files(stage, typed, stage->scene_paths, stage->n_scene_paths, error);
}

void stage_close(struct stage *stage)
{
    input_drop(stage->input);
    if (stage->is_open)
        source_close(&stage->source);
    for (int i = 0; i < stage->n_others; i++)
        source_close(&stage->others[i]);
    if (stage->scene)
        povray_close(stage->scene);
    for (int i = 0; i < stage->n_scene_paths; i++)
        free(stage->scene_paths[i]);
    *stage = (struct stage){0};
}

bool stage_resolve(const struct stage *stage, const struct settings *typed,
                   struct settings *settings, struct rf_params *params, char *text,
                   size_t n_bytes)
{
    return resolve_source(stage, &stage->source, typed, settings, params, text,
                          n_bytes);
}

bool stage_stack(const struct stage *stage, const struct settings *typed,
                 const struct rf_params *params, struct stack *stack, char *text,
                 size_t n_bytes)
{
    struct settings settings;
    const int32_t eyes = stack->eyes;
    memset(stack, 0, sizeof(*stack)); /* compared byte by byte */
    if (stage->n_others == 0)
        return true;
    stack->kind = stage->options->is_over ? STACK_OVER : STACK_STEREO;
    stack->eyes = eyes;
    stack->n = stage->n_others;
    for (int i = 0; i < stage->n_others; i++) {
        /* A stereo pair has the lens of its first eye. */
        if (stack->kind == STACK_STEREO)
            stack->params[i] = *params;
        else if (!resolve_source(stage, &stage->others[i], typed, &settings,
                                 &stack->params[i], text, n_bytes))
            return false;
    }
    return true;
}

/* ---- the command line ------------------------------------------------------------ */

/* Text that grows within a buffer; what does not fit is cut. */
struct line {
    char *text;
    size_t n_bytes, used;
};

static void append(struct line *line, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

static void append(struct line *line, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    if (line->used < line->n_bytes)
        line->used += (size_t)vsnprintf(line->text + line->used,
                                        line->n_bytes - line->used, format, arguments);
    va_end(arguments);
}

/* A word as a shell reads it back. */
static void append_word(struct line *line, const char *word)
{
    bool is_plain = *word != 0;
    for (const char *c = word; *c; c++)
        is_plain = is_plain && (isalnum((unsigned char)*c) || strchr("/._-+=,:@%", *c));
    append(line, is_plain ? " %s" : " '", word);
    for (const char *c = word; !is_plain && *c; c++) {
        if (*c == '\'')
            append(line, "'\\''");
        else
            append(line, "%c", *c);
    }
    if (!is_plain)
        append(line, "'");
}

static void append_typed(struct line *line, const struct settings *typed)
{
    size_t n;
    const struct rf_param_info *list = rf_param_list(&n);
    for (size_t i = 0; i < n; i++) {
        char value[64];
        if (!is_typed(typed, list[i].key))
            continue;
        rf_params_get(&typed->params, list[i].key, value, sizeof(value));
        if (list[i].type == RF_TYPE_BOOL)
            append(line, " --%s%s", strcmp(value, "true") == 0 ? "" : "no-",
                   list[i].key);
        else
            append(line, " --%s %s", list[i].key, value);
    }
}

bool stage_uses_light(const struct rf_params *params)
{
    return params->method == RF_METHOD_SCATTER &&
           params->distribution == RF_DISTRIBUTION_IMAGE;
}

static void append_input_options(struct line *line, const struct view_options *options)
{
    const struct {
        const char *name, *value;
    } list[] = {{"--layer", options->layer},
                {"--depth-file", options->depth_file},
                {"--depth-channel", options->depth_channel}};
    for (size_t i = 0; i < sizeof(list) / sizeof(list[0]); i++) {
        if (!list[i].value)
            continue;
        append(line, " %s", list[i].name);
        append_word(line, list[i].value);
    }
    if (options->depth_repair == DEPTH_REPAIR_OFF)
        append(line, " --depth-repair off");
    static const char *const mists[] = {"", "linear", "quadratic", "inverse-quadratic"};
    if (options->mist_falloff != RF_MIST_NONE)
        append(line, " --mist-falloff %s", mists[options->mist_falloff]);
}

/* The lens radius with which the scene is to be rendered again; 0: it has its own.
 * Where neither the scene nor the first command line has a lens, it is the lens that is
 * shown, and the filter finds it in the passes. */
static double rendered_radius(const struct stage *stage, struct settings *left)
{
    char stop[40];
    struct povray_stop shown = {.f_stop = 0};
    const double own = stage->camera.aperture / 4;
    if (own > 0)
        return stage->has_stop || stage->povray_options.has_aperture ? own : 0;
    if (is_typed(left, "lens-radius"))
        return left->params.lens_radius;
    snprintf(stop, sizeof(stop), "%.17g", (double)left->params.f_stop);
    settings_set(left, "f-stop", stop, NULL);
    povray_lens_take_stop(left, &shown);
    return shown.radius[stage->camera.is_orthographic];
}

/* Passes that go with the window are rendered again, into a folder that stays. */
static void append_rendering(struct line *line, const struct stage *stage,
                             double radius)
{
    append(line, "rackfocus povray");
    append_word(line, stage->files->paths[0]);
    append(line, " --keep passes -o lens.exr");
    if (stage->options->n_views > 1)
        append(line, " --views %d", stage->options->n_views);
    if (radius > 0)
        append(line, " --lens-radius %.17g", radius);
    if (stage->povray_options.has_focus_distance)
        append(line, " --focus-distance %.17g", stage->povray_options.focus_distance);
    if (stage->n_povray_args > 0)
        append(line, " --");
    for (int i = 0; i < stage->n_povray_args; i++)
        append_word(line, stage->povray_args[i]);
    append(line, " && ");
}

void stage_command(const struct stage *stage, const struct settings *typed,
                   const struct stage_output *output, char *text, size_t n_bytes)
{
    struct line line = {.text = text, .n_bytes = n_bytes};
    struct settings left = typed_of_passes(stage, typed);
    const bool is_lost = stage->is_scene && !stage->options->keep;
    *text = 0;
    if (is_lost)
        append_rendering(&line, stage, rendered_radius(stage, &left));
    append(&line, "rackfocus filter");
    if (is_lost && stage->n_scene_paths > 1)
        append(&line, " passes/passes_v*.exr");
    else if (is_lost)
        append(&line, " passes/passes.exr");
    else if (stage->is_scene)
        for (int i = 0; i < stage->n_scene_paths; i++)
            append_word(&line, stage->scene_paths[i]);
    else
        for (int i = 0; i < stage->files->n_paths; i++)
            append_word(&line, stage->files->paths[i]);
    append(&line, " -o");
    append_word(&line, output->path);
    if (output->type == FILTER_TYPE_FLOAT && picture_kind(output->path) == PICTURE_EXR)
        append(&line, " --type float");
    if (stage->options->is_over || stage->options->is_stereo)
        append(&line, stage->options->is_over ? " --over" : " --stereo");
    append_input_options(&line, stage->options);
    if (stage->options->distribution_image && stage_uses_light(&typed->params)) {
        append(&line, " --distribution-image");
        append_word(&line, stage->options->distribution_image);
    }
    append_typed(&line, &left);
}

/* ---- saving ---------------------------------------------------------------------- */

/* The remarks on a file that is written, without its name. */
struct save_remarks {
    const char *path;
    char *text;
    size_t n_bytes;
};

static bool take_remark(void *user, const char *text)
{
    const struct save_remarks *remarks = user;
    const size_t n_used = strlen(remarks->text), n_path = strlen(remarks->path);
    const bool is_named = strncmp(text, remarks->path, n_path) == 0 &&
                          strncmp(text + n_path, ": ", 2) == 0;
    snprintf(remarks->text + n_used, remarks->n_bytes - n_used, "%s%s",
             n_used > 0 ? "; " : "", is_named ? text + n_path + 2 : text);
    return true;
}

bool stage_save(const struct stage *stage, const struct settings *settings,
                const struct stage_output *output, float *pixels, char *remarks,
                size_t n_bytes, struct image_error *error)
{
    struct save_remarks told = {output->path, remarks, n_bytes};
    const struct app_host host = {.user = &told, .warn = take_remark};
    const struct filter_options tool = {.output = output->path,
                                        .type = output->type,
                                        .n_threads = stage->options->n_threads,
                                        .host = &host};
    remarks[0] = 0;
    struct settings copy = *settings;
    return filter_write(&tool, &copy, &stage->source, false, pixels, error);
}

bool stage_reads(const struct stage *stage, const char *path)
{
    const char *const others[] = {stage->options->depth_file,
                                  stage->options->distribution_image};
    bool is_read = false;
    for (int i = 0; i < stage->files->n_paths; i++)
        is_read |= os_file_is_same(stage->files->paths[i], path);
    for (int i = 0; i < 2; i++)
        is_read |= others[i] && os_file_is_same(others[i], path);
    return is_read;
}

const char *stage_find_missing(const struct stage *stage)
{
    for (int i = 0; stage->files && i < stage->files->n_paths; i++)
        if (os_file_facts(stage->files->paths[i]).kind == OS_FILE_NONE)
            return stage->files->paths[i];
    return NULL;
}
