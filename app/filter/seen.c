/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/seen.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "filter/filter_private.h"
#include "filter/seen_light.h"
#include "filter/seen_way.h"
#include "interrupt.h"
#include "sources/source.h"
#include "sources/views.h"

static const struct {
    const char *word, *depth_option;
} kinds[SEEN_KINDS] = {
    [SEEN_REFLECTION] = {"reflections", "reflection-depth"},
    [SEEN_TRANSMISSION] = {"through glass", "transmission-depth"},
};

bool seen_is_asked(const struct filter_options *tool)
{
    return tool->reflections_from || tool->reflection_depth ||
           tool->transmission_depth || tool->reflection_layers ||
           tool->transmission_layers || tool->reflections_at;
}

static const char *asked_depth(const struct filter_options *tool, enum seen_kind kind)
{
    return kind == SEEN_REFLECTION ? tool->reflection_depth : tool->transmission_depth;
}

/* ---- views ----------------------------------------------------------------------- */

/* What stands for the other views in --reflections-from. */
#define VIEWS "views"

static bool is_from_views(const struct filter_options *tool)
{
    return tool->reflections_from && strcmp(tool->reflections_from, VIEWS) == 0;
}

/* A view that is to be filtered; without several views the picture. */
struct subject {
    struct run *run;
    int index;
    const struct source *source;
    struct rf_view view;
};

static struct subject subject_of(struct run *run, int index)
{
    const struct source *source =
        run->has_views ? &run->views.sources[index] : &run->source;
    struct subject subject = {.run = run, .index = index, .source = source};
    if (run->has_views) {
        subject.view = run->views.views[index];
        return subject;
    }
    struct rf_view *view = &subject.view;
    view->size = sizeof(*view);
    view->colour =
        rf_image_packed(run->colour, source->width, source->height, source->n_channels);
    view->depth = rf_image_packed(run->depth, source->width, source->height, 1);
    views_find_place(source->colour, NULL, view->lens_offset, &view->shear_distance);
    return subject;
}

/* ---- depth from a layer or a file ------------------------------------------------ */

/* Reads a depth channel of the size of the colour, of the file that an option names or of
 * the views' own; NULL on failure. */
static float *read_channel(const struct subject *subject, const char *file,
                           const char *channel, const char *option)
{
    const struct run *run = subject->run;
    struct source_request request = run->request;
    struct source source;
    char *path = request.paths[0];
    if (run->has_views) {
        path = (char *)run->list.items[subject->index].path;
        request.view = run->list.items[subject->index].name;
    }
    request.paths = &path;
    request.n_paths = 1;
    request.depth_file = file;
    request.depth_channel = channel;
    request.depth_option = option;
    if (!source_open(&source, &request, run->error))
        return NULL;
    float *depth = source_check(&source, run->error)
                       ? source_read_depth(&source, run->n_threads, run->error)
                       : NULL;
    source_close(&source);
    return depth;
}

/* Of the ways of rays those that lie behind flat surfaces. */
static int keep_flat(const struct subject *subject, const char *option, float *light,
                     float *planar)
{
    const int width = subject->source->width, height = subject->source->height;
    const struct rf_image seen = rf_image_packed(light, width, height, 3);
    const struct rf_image way = rf_image_packed(planar, width, height, 1);
    struct rf_error error;
    if (rf_filter_seen_way(subject->run->filter, &subject->view, &seen, &way, &way,
                           &error) == RF_OK)
        return APP_DONE;
    return app_fail(subject->run->error, APP_FAILED, "--%s: %s", option, error.message);
}

static float sum_of(const float *rgb)
{
    return rgb[0] + rgb[1] + rgb[2];
}

/* The light of this kind, if it is asked for, too; else NULL. */
static const float *find_opened(const struct subject *subject, enum seen_kind kind)
{
    const struct seen *seen = &subject->run->seen;
    for (int i = 0; i < seen->n; i++)
        if (seen->kinds[i] == kind)
            return seen->views[subject->index].lights[i].colour.data;
    return NULL;
}

/* A ray goes one way: where a pane mirrors less than it lets through, the way is that
 * of what is seen through it, and the other way round. */
static int drop_weaker(const struct subject *subject, enum seen_kind kind,
                       const float *light, float *planar)
{
    const struct run *run = subject->run;
    const enum seen_kind other =
        kind == SEEN_REFLECTION ? SEEN_TRANSMISSION : SEEN_REFLECTION;
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    const float *stronger = find_opened(subject, other);
    float *read = NULL;
    if (!stronger && !seen_has_light(run, subject->source, other))
        return APP_DONE;
    if (!stronger)
        stronger = read = seen_read_light(run, subject->source, other);
    for (size_t i = 0; i < n && stronger; i++)
        if (sum_of(stronger + 3 * i) > sum_of(light + 3 * i))
            planar[i] = NAN;
    free(read);
    return stronger ? APP_DONE : app_code_of(run->error);
}

static bool is_file(const char *name)
{
    const size_t length = strlen(name);
    return length > 4 && strcasecmp(name + length - 4, ".exr") == 0;
}

/* Planar distances from what an option names: a file, a channel of the input's, or
 * Cycles' Denoising Depth. */
static int read_depth(const struct subject *subject, enum seen_kind kind, float *light,
                      float *planar)
{
    const struct run *run = subject->run;
    const char *name = asked_depth(run->tool, kind), *option = kinds[kind].depth_option;
    const bool is_way = strcmp(name, DENOISING) == 0;
    const char *channel = is_way ? seen_find_way(subject->source) : name;
    if (!channel)
        return app_fail(
            run->error, APP_FAILED,
            "--%s denoising: %s has no channel %s.Z; in Blender tick Passes > "
            "Data > Denoising Data",
            option, image_path(subject->source->colour), DENOISING_LAYER);
    bool fits;
    float *depth = is_file(name) ? read_channel(subject, name, NULL, option)
                                 : read_channel(subject, NULL, channel, option);
    if (!depth)
        return app_code_of(run->error);
    int code = seen_make_planar(run, option, is_way, depth, planar);
    if (code == APP_DONE && is_way)
        code = seen_complete_way(run, subject->source, &subject->view, option, light,
                                 planar, &fits);
    if (code == APP_DONE && is_way)
        code = drop_weaker(subject, kind, light, planar);
    if (code == APP_DONE && is_way)
        code = keep_flat(subject, option, light, planar);
    free(depth);
    return code;
}

/* ---- depth from other views ------------------------------------------------------ */

/* The files that --reflections-from names, opened. */
struct others {
    int n;
    struct source sources[RF_MAX_VIEWS];
    struct rf_view views[RF_MAX_VIEWS]; /* from 1 on; 0 is the picture */
};

static void close_others(struct others *others)
{
    for (int j = 1; j <= others->n; j++)
        source_close(&others->sources[j]);
}

static int check_other(const struct run *run, const struct source *other)
{
    const struct image_box *box = &other->info.data_window;
    if (memcmp(box, &run->source.info.data_window, sizeof(*box)) == 0)
        return APP_DONE;
    return app_fail(run->error, APP_FAILED,
                    "%s: is %d x %d, but %s is %d x %d; render both with one window",
                    image_path(other->colour), other->width, other->height,
                    image_path(run->source.colour), run->source.width,
                    run->source.height);
}

/* Reads the place of view j from --reflections-at; false where that has none. */
static bool read_place(const char *text, int j, double place[2])
{
    for (int i = 0; i < j; i++) {
        int used = 0;
        if (sscanf(text, "%lf,%lf%n", &place[0], &place[1], &used) != 2 ||
            (text[used] != ',' && text[used] != '\0') || !isfinite(place[0]) ||
            !isfinite(place[1]))
            return false;
        text += used + (text[used] == ',');
    }
    return true;
}

/* Where view j was taken: by the option, or else by its header. */
static int find_place(const struct run *run, const char *path, struct others *others,
                      int j)
{
    struct rf_view *view = &others->views[j];
    const char *text = run->tool->reflections_at;
    if (text && read_place(text, j, view->lens_offset)) {
        /* A camera that was moved by so much. */
        view->lens_offset[0] += others->views[0].lens_offset[0];
        view->lens_offset[1] += others->views[0].lens_offset[1];
        view->shear_distance = others->views[0].shear_distance;
        return APP_DONE;
    }
    if (text)
        return app_fail(run->error, APP_USAGE,
                        "--reflections-at: '%s' has no place for %s; give two numbers "
                        "for each view, such as 0.02,0",
                        text, path);
    if (views_find_place(others->sources[j].colour, NULL, view->lens_offset,
                         &view->shear_distance))
        return APP_DONE;
    return app_fail(run->error, APP_FAILED,
                    "%s: its header has no " VIEWS_OFFSET
                    ", which says where it was taken; give --reflections-at X,Y, how "
                    "far its camera was moved to the right and up, in scene units",
                    path);
}

/* Opens one of them. */
static int open_other(struct run *run, const char *path, struct others *others)
{
    char *paths[1] = {(char *)path};
    struct source_request request = {
        .paths = paths, .n_paths = 1, .layer = run->request.layer};
    const int j = others->n + 1;
    if (j >= RF_MAX_VIEWS)
        return app_fail(run->error, APP_USAGE,
                        "--reflections-from: %d views are the most", RF_MAX_VIEWS - 1);
    if (!source_open(&others->sources[j], &request, run->error))
        return app_code_of(run->error);
    others->n++;
    const int code = find_place(run, path, others, j);
    return code == APP_DONE ? check_other(run, &others->sources[j]) : code;
}

static int open_others(struct run *run, struct others *others)
{
    int code = APP_DONE;
    others->views[0] = subject_of(run, 0).view;
    for (const char *name = run->tool->reflections_from; *name && code == APP_DONE;) {
        const size_t length = strcspn(name, ",");
        char *path = app_memory(length + 1, 1, run->error);
        if (!path)
            return APP_NO_MEMORY;
        memcpy(path, name, length);
        if (length)
            code = open_other(run, path, others);
        free(path);
        name += length + (name[length] == ',');
    }
    return code;
}

/* The planar distances at which views show the same light; the first view's. */
static int match(const struct run *run, const struct rf_view *views, int n,
                 const struct rf_image *lights, float *planar)
{
    const struct rf_image out =
        rf_image_packed(planar, run->source.width, run->source.height, 1);
    struct rf_error error;
    if (rf_filter_seen_depth(run->filter, views, n, lights, &out, &error) == RF_OK)
        return APP_DONE;
    return app_fail(run->error, APP_FAILED, "--reflections-from: %s", error.message);
}

/* By the files that --reflections-from names. */
static int match_others(const struct run *run, struct others *others,
                        enum seen_kind kind, float *light, float *planar)
{
    const int width = run->source.width, height = run->source.height;
    struct rf_image lights[RF_MAX_VIEWS] = {rf_image_packed(light, width, height, 3)};
    int code = APP_DONE;
    for (int j = 1; j <= others->n && code == APP_DONE; j++) {
        float *other = seen_read_light(run, &others->sources[j], kind);
        lights[j] = rf_image_packed(other, width, height, 3);
        if (!other)
            code = app_code_of(run->error);
    }
    if (code == APP_DONE)
        code = match(run, others->views, others->n + 1, lights, planar);
    for (int j = 1; j <= others->n; j++)
        free(lights[j].data);
    return code;
}

/* Other views that tell a view's depths: those farthest from it on the lens. */
enum { N_MATCHED = 2 };

/* The farthest view from another of those that are not taken yet. */
static int find_farthest(const struct views *views, int from, uint64_t taken)
{
    const double *at = views->views[from].lens_offset;
    double most = -1;
    int best = from;
    for (int j = 0; j < views->n; j++) {
        const double *to = views->views[j].lens_offset;
        const double away = hypot(to[0] - at[0], to[1] - at[1]);
        if (taken >> j & 1 || away <= most)
            continue;
        most = away;
        best = j;
    }
    return best;
}

/* By the other views; light i of all of them is read. */
static int match_views(const struct subject *subject, int i, float *planar)
{
    const struct run *run = subject->run;
    struct rf_view views[N_MATCHED + 1];
    struct rf_image lights[N_MATCHED + 1];
    uint64_t taken = 0;
    int n = 0;
    for (int j = subject->index; n <= N_MATCHED && n < run->views.n; n++) {
        views[n] = run->views.views[j];
        lights[n] = run->seen.views[j].lights[i].colour;
        taken |= (uint64_t)1 << j;
        j = find_farthest(&run->views, subject->index, taken);
    }
    return match(run, views, n, lights, planar);
}

/* ---- the step -------------------------------------------------------------------- */

/* What does not go together with several views, or with one. */
static int check_views(const struct run *run, const char *path)
{
    const struct filter_options *tool = run->tool;
    if (!run->has_views && is_from_views(tool))
        return app_fail(run->error, APP_USAGE,
                        "--reflections-from " VIEWS ": %s is one view; give the file "
                        "of a second one in place of " VIEWS,
                        path);
    if (!run->has_views)
        return APP_DONE;
    if (tool->reflections_from && !is_from_views(tool))
        return app_fail(run->error, APP_USAGE,
                        "--reflections-from: %s is one of several views, which tell "
                        "each other's; give --reflections-from " VIEWS,
                        path);
    if (tool->reflections_at)
        return app_fail(run->error, APP_USAGE,
                        "--reflections-at: %s is one of several views, whose headers "
                        "say where they were taken; leave it out",
                        path);
    for (int kind = 0; kind < SEEN_KINDS; kind++) {
        const char *name = asked_depth(tool, kind);
        if (name && is_file(name))
            return app_fail(run->error, APP_USAGE,
                            "--%s: every view needs a channel of its own, in its file; "
                            "give its name in place of %s",
                            kinds[kind].depth_option, name);
        if (name && run->list.items[0].name && strcmp(name, DENOISING) != 0)
            return app_fail(run->error, APP_USAGE,
                            "--%s: %s holds several views, in which one name is no "
                            "channel of each; give --reflections-from " VIEWS
                            ", or each view as a file of its own",
                            kinds[kind].depth_option, path);
    }
    return APP_DONE;
}

int seen_check(const struct run *run)
{
    const char *path = image_path(run->source.colour);
    if (!seen_is_asked(run->tool))
        return APP_DONE;
    if (run->is_deep)
        return app_fail(
            run->error, APP_USAGE,
            "%s: is deep; reflections of their own depth are of flat pictures", path);
    if (run->source.is_grey)
        return app_fail(run->error, APP_USAGE,
                        "%s: is grey; reflections of their own depth need its colours",
                        path);
    if (run->tool->temporal)
        return app_fail(run->error, APP_USAGE,
                        "--temporal and --preset shot do not know reflections of their "
                        "own depth; leave one out");
    if (run->tool->reflections_at && !run->tool->reflections_from)
        return app_fail(run->error, APP_USAGE,
                        "--reflections-at: says where the views of --reflections-from "
                        "were taken; give both");
    if (!run->tool->reflections_from && !run->tool->reflection_depth &&
        !run->tool->transmission_depth)
        return app_fail(run->error, APP_USAGE,
                        "--reflection-layers and --transmission-layers need a depth: "
                        "--reflections-from VIEW.exr, --reflection-depth or "
                        "--transmission-depth");
    return check_views(run, path);
}

/* Is a depth of this kind asked for, and the light there? */
static bool is_wanted(const struct run *run, enum seen_kind kind)
{
    const struct filter_options *tool = run->tool;
    if (asked_depth(tool, kind) || seen_asked_layers(tool, kind))
        return true;
    return tool->reflections_from && seen_has_light(run, &run->source, kind);
}

static int fail_no_light(const struct run *run)
{
    char names[400];
    source_list_channels(run->source.colour, names, sizeof(names));
    return app_fail(
        run->error, APP_FAILED,
        "%s: has no light of mirrors or glass beside its colour; in Blender "
        "tick Passes > Light > Glossy and Transmission: Direct, Indirect, "
        "Color; other renderers' layers are named with --reflection-layers "
        "and --transmission-layers; its channels are %s",
        image_path(run->source.colour), names);
}

/* Of a light's pixels those that have a depth of their own, a share of the picture. */
static double share_of(const struct rf_seen_light *light)
{
    const size_t n = (size_t)light->depth.width * (size_t)light->depth.height;
    const float *z = light->depth.data, *rgb = light->colour.data;
    size_t n_own = 0;
    for (size_t k = 0; k < n; k++)
        n_own +=
            z[k] > 0 && (rgb[3 * k] > 0 || rgb[3 * k + 1] > 0 || rgb[3 * k + 2] > 0);
    return (double)n_own / (double)n;
}

/* What part of the colour the light is, which stays when the grain is gone. */
static float *find_part(const struct subject *subject, const float *light)
{
    const struct source *source = subject->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    const size_t n_channels = (size_t)source->n_channels;
    const float *colour = subject->view.colour.data;
    float *part = app_memory(n, 3 * sizeof(float), subject->run->error);
    for (size_t k = 0; k < n && part; k++)
        for (size_t c = 0; c < 3; c++) {
            const float all = colour[k * n_channels + c];
            part[3 * k + c] = all > 0 ? fminf(fmaxf(light[3 * k + c] / all, 0), 1) : 0;
        }
    return part;
}

/* Reads light i of a view, and makes room for its depth. */
static int open_light(struct run *run, int index, int i)
{
    const struct subject subject = subject_of(run, index);
    const int width = run->source.width, height = run->source.height;
    struct seen_view *view = &run->seen.views[index];
    float *light = seen_read_light(run, subject.source, run->seen.kinds[i]);
    view->lights[i].colour = rf_image_packed(light, width, height, 3);
    if (!light)
        return app_code_of(run->error);
    float *planar =
        app_memory((size_t)width * (size_t)height, sizeof(float), run->error);
    view->lights[i].depth = rf_image_packed(planar, width, height, 1);
    if (planar && run->tool->denoise)
        view->parts[i] = find_part(&subject, light);
    return planar && (!run->tool->denoise || view->parts[i]) ? APP_DONE : APP_NO_MEMORY;
}

/* Finds the depth of light i of a view. */
static int find_depth(struct run *run, struct others *others, int index, int i)
{
    const struct subject subject = subject_of(run, index);
    const enum seen_kind kind = run->seen.kinds[i];
    const struct rf_seen_light *light = &run->seen.views[index].lights[i];
    float *planar = light->depth.data;
    const int code = asked_depth(run->tool, kind)
                         ? read_depth(&subject, kind, light->colour.data, planar)
                     : run->has_views
                         ? match_views(&subject, i, planar)
                         : match_others(run, others, kind, light->colour.data, planar);
    if (code == APP_DONE)
        run->seen.shares[i] += share_of(light) / filter_n_views(run);
    return code == APP_DONE && os_is_interrupted() ? APP_INTERRUPTED : code;
}

/* Reads the light of a kind, of all views. */
static int open_kind(struct run *run, enum seen_kind kind)
{
    const int n = filter_n_views(run), i = run->seen.n;
    if (!seen_has_light(run, &run->source, kind))
        return fail_no_light(run);
    run->seen.kinds[i] = kind;
    run->seen.n++;
    int code = APP_DONE;
    for (int j = 0; j < n && code == APP_DONE; j++)
        code = open_light(run, j, i);
    return code;
}

/* All kinds that are asked for: first the light, by which that of the other kind is
 * judged, too. */
static int find_kinds(struct run *run, struct others *others)
{
    int code = run->tool->reflections_from && !run->has_views ? open_others(run, others)
                                                              : APP_DONE;
    for (int kind = 0; kind < SEEN_KINDS && code == APP_DONE; kind++)
        if (is_wanted(run, kind))
            code = open_kind(run, kind);
    for (int i = 0; i < run->seen.n; i++)
        for (int j = 0; j < filter_n_views(run) && code == APP_DONE; j++)
            code = find_depth(run, others, j, i);
    return code == APP_DONE && run->seen.n == 0 ? fail_no_light(run) : code;
}

int seen_find(struct run *run)
{
    if (!seen_is_asked(run->tool))
        return APP_DONE;
    struct others *others = app_memory(1, sizeof(*others), run->error);
    struct seen *seen = &run->seen;
    seen->n_views = filter_n_views(run);
    seen->views = app_memory((size_t)seen->n_views, sizeof(*seen->views), run->error);
    int code = others && seen->views ? find_kinds(run, others) : APP_NO_MEMORY;
    if (others)
        close_others(others);
    free(others);
    for (int i = 0; i < seen->n && code == APP_DONE; i++)
        if (seen->shares[i] == 0)
            code = app_warn(run->tool->host, run->error,
                            "%s: nothing seen %s has a depth of its own there",
                            image_path(run->source.colour),
                            seen->kinds[i] == SEEN_REFLECTION ? "in mirrors"
                                                              : "through glass");
    return code;
}

void seen_set(const struct run *run, int index, struct rf_view *view)
{
    const struct seen *seen = &run->seen;
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    const size_t n_channels = (size_t)run->source.n_channels;
    const float *colour = view->colour.data;
    for (int i = 0; i < seen->n; i++) {
        const float *part = seen->views[index].parts[i];
        float *light = seen->views[index].lights[i].colour.data;
        for (size_t k = 0; k < n && part; k++)
            for (size_t c = 0; c < 3; c++)
                light[3 * k + c] = part[3 * k + c] * colour[k * n_channels + c];
    }
    view->seen = seen->n ? seen->views[index].lights : NULL;
    view->n_seen = seen->n;
}

void seen_describe(const struct seen *seen, char *text, size_t n_bytes)
{
    *text = 0;
    for (int i = 0; i < seen->n; i++) {
        const size_t used = strlen(text);
        snprintf(text + used, n_bytes - used,
                 ", %s: %.1f %% of the picture by its own depth",
                 kinds[seen->kinds[i]].word, 100 * seen->shares[i]);
    }
}

void seen_free(struct seen *seen)
{
    for (int j = 0; j < seen->n_views && seen->views; j++)
        for (int i = 0; i < seen->n; i++) {
            free(seen->views[j].lights[i].colour.data);
            free(seen->views[j].lights[i].depth.data);
            free(seen->views[j].parts[i]);
        }
    free(seen->views);
    *seen = (struct seen){0};
}
