/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/seen.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "filter/filter_private.h"
#include "sources/source.h"
#include "sources/views.h"

/* ---- what renderers call it ------------------------------------------------------ */

/* Light as a renderer writes it: the sum of some layers, times another. */
struct light_layers {
    const char *sum[3]; /* up to the first NULL */
    const char *factor; /* or NULL */
};

enum { N_KNOWN = 4 };

static const struct {
    const char *word, *option, *depth_option;
    struct light_layers known[N_KNOWN]; /* in the order in which they are taken */
} kinds[SEEN_KINDS] = {
    [SEEN_REFLECTION] = {"reflections",
                         "reflection-layers",
                         "reflection-depth",
                         {{{"GlossDir", "GlossInd"}, "GlossCol"}, /* Blender to 4.x */
                          {{"Glossy Direct", "Glossy Indirect"}, "Glossy Color"},
                          {{"specular"}, NULL},     /* Arnold */
                          {{"reflection"}, NULL}}}, /* V-Ray, Redshift */
    [SEEN_TRANSMISSION] = {"through glass",
                           "transmission-layers",
                           "transmission-depth",
                           {{{"TransDir", "TransInd"}, "TransCol"},
                            {{"Transmission Direct", "Transmission Indirect"},
                             "Transmission Color"},
                            {{"transmission"}, NULL},
                            {{"refraction"}, NULL}}},
};

bool seen_is_asked(const struct filter_options *tool)
{
    return tool->reflections_from || tool->reflection_depth ||
           tool->transmission_depth || tool->reflection_layers ||
           tool->transmission_layers || tool->reflections_at;
}

static const char *asked_layers(const struct filter_options *tool, enum seen_kind kind)
{
    return kind == SEEN_REFLECTION ? tool->reflection_layers
                                   : tool->transmission_layers;
}

static const char *asked_depth(const struct filter_options *tool, enum seen_kind kind)
{
    return kind == SEEN_REFLECTION ? tool->reflection_depth : tool->transmission_depth;
}

/* ---- layers ---------------------------------------------------------------------- */

/* Is a channel the R, G or B of a layer? A layer's name may have words before it. */
static bool is_of(const char *channel, const char *layer, size_t length, char letter)
{
    const size_t n = strlen(channel);
    if (n < length + 2 || channel[n - 2] != '.' || channel[n - 1] != letter)
        return false;
    const char *name = channel + n - 2 - length;
    return strncasecmp(name, layer, length) == 0 &&
           (name == channel || name[-1] == '.');
}

/* The three channels of a layer in a file, in the part of the colour; false: none. */
static bool find_layer(const struct source *source, const char *layer, size_t length,
                       int channels[3])
{
    int n, n_found = 0;
    const struct image_channel_info *all = image_channels(source->colour, &n);
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < n && n_found == c; i++)
            if (all[i].part == source->part &&
                is_of(all[i].name, layer, length, "RGB"[c]))
                channels[n_found++] = i;
    return n_found == 3;
}

static bool has_layers(const struct source *source, const struct light_layers *layers)
{
    int channels[3];
    for (int i = 0; i < 3 && layers->sum[i]; i++)
        if (!find_layer(source, layers->sum[i], strlen(layers->sum[i]), channels))
            return false;
    return !layers->factor ||
           find_layer(source, layers->factor, strlen(layers->factor), channels);
}

/* Which of the known layers a file has; NULL: none. */
static const struct light_layers *find_known(const struct source *source,
                                             enum seen_kind kind)
{
    for (int i = 0; i < N_KNOWN; i++)
        if (has_layers(source, &kinds[kind].known[i]))
            return &kinds[kind].known[i];
    return NULL;
}

/* ---- light ----------------------------------------------------------------------- */

/* Three floats per pixel. */
struct light {
    float *samples, *room;
    size_t n_pixels;
};

static bool read_layer(const struct run *run, const struct source *source,
                       const char *layer, size_t length, float *to)
{
    int channels[3];
    if (find_layer(source, layer, length, channels))
        return image_read(source->colour, channels, 3, to, run->n_threads, run->error);
    char names[400];
    source_list_channels(source->colour, names, sizeof(names));
    return set_error(run->error,
                     "%s: there are no channels %.*s.R, .G and .B beside the colour; "
                     "its channels are %s",
                     image_path(source->colour), (int)length, layer, names);
}

static void clean(float *samples, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(samples[i]))
            samples[i] = 0;
}

/* Adds a layer to the light. */
static bool add_layer(const struct run *run, const struct source *source,
                      const char *layer, size_t length, struct light *light)
{
    if (!read_layer(run, source, layer, length, light->room))
        return false;
    clean(light->room, 3 * light->n_pixels);
    for (size_t i = 0; i < 3 * light->n_pixels; i++)
        light->samples[i] += light->room[i];
    return true;
}

static bool read_known(const struct run *run, const struct source *source,
                       const struct light_layers *layers, struct light *light)
{
    for (int i = 0; i < 3 && layers->sum[i]; i++)
        if (!add_layer(run, source, layers->sum[i], strlen(layers->sum[i]), light))
            return false;
    if (!layers->factor)
        return true;
    if (!read_layer(run, source, layers->factor, strlen(layers->factor), light->room))
        return false;
    clean(light->room, 3 * light->n_pixels);
    for (size_t i = 0; i < 3 * light->n_pixels; i++)
        light->samples[i] *= light->room[i];
    return true;
}

static bool read_named(const struct run *run, const struct source *source,
                       const char *names, struct light *light)
{
    for (const char *name = names; *name;) {
        const size_t length = strcspn(name, ",");
        if (length && !add_layer(run, source, name, length, light))
            return false;
        name += length + (name[length] == ',');
    }
    return true;
}

/* The light of a kind in a file, three floats per pixel; NULL on failure. */
static float *read_light(const struct run *run, const struct source *source,
                         enum seen_kind kind)
{
    const char *names = asked_layers(run->tool, kind);
    const struct light_layers *known = names ? NULL : find_known(source, kind);
    struct light light = {.n_pixels = (size_t)source->width * (size_t)source->height};
    light.samples = app_memory(light.n_pixels, 3 * sizeof(float), run->error);
    light.room = app_memory(light.n_pixels, 3 * sizeof(float), run->error);
    bool is_read = light.samples && light.room;
    if (is_read && names) {
        is_read = read_named(run, source, names, &light);
    } else if (is_read && known) {
        is_read = read_known(run, source, known, &light);
    } else if (is_read) {
        is_read = set_error(run->error,
                            "%s: has no layers of what is seen in %s, as %s has; "
                            "render both with the same passes",
                            image_path(source->colour),
                            kind == SEEN_REFLECTION ? "mirrors" : "glass",
                            image_path(run->source.colour));
    }
    free(light.room);
    if (is_read)
        return light.samples;
    free(light.samples);
    return NULL;
}

/* ---- depth from a layer or a file ------------------------------------------------ */

/* What stands for the channel of Cycles that knows the way of rays through mirrors. */
#define DENOISING "denoising"
static const char denoising_channel[] = "Denoising Depth.Z";

/* The full name of that channel in the colour's file; NULL: it has none. */
static const char *find_denoising(const struct source *source)
{
    int n;
    const size_t length = sizeof(denoising_channel) - 1;
    const struct image_channel_info *all = image_channels(source->colour, &n);
    for (int i = 0; i < n; i++) {
        const size_t own = strlen(all[i].name);
        if (own >= length && strcmp(all[i].name + own - length, denoising_channel) == 0)
            return all[i].name;
    }
    return NULL;
}

/* Reads a depth channel of the size of the colour; NULL on failure. */
static float *read_channel(const struct run *run, const char *file, const char *channel)
{
    struct source_request request = run->request;
    struct source source;
    request.n_paths = 1;
    request.depth_file = file;
    request.depth_channel = channel;
    if (!source_open(&source, &request, run->error))
        return NULL;
    float *depth = source_check(&source, run->error)
                       ? source_read_depth(&source, run->n_threads, run->error)
                       : NULL;
    source_close(&source);
    return depth;
}

/* Planar distances from depths of a kind (of the parameters: -1), NAN where they are 0
 * or less. */
static int make_planar(const struct run *run, const char *option, int kind,
                       const float *depth, float *planar)
{
    struct rf_params params = run->params;
    struct rf_filter *filter = NULL;
    struct rf_error error;
    const int width = run->source.width, height = run->source.height;
    const size_t n = (size_t)width * (size_t)height;
    if (kind >= 0) {
        params.depth = kind;
        params.depth_scale = 1;
        params.depth_offset = 0;
    }
    /* 0: nothing is seen so. */
    for (size_t i = 0; i < n; i++)
        planar[i] = depth[i] > 0 ? depth[i] : 0;
    const struct rf_image image = rf_image_packed(planar, width, height, 1);
    rf_result result =
        rf_filter_create(&filter, run->context, &params, width, height, &error);
    if (result == RF_OK)
        result = rf_filter_planar_depth(filter, &image, &image, &error);
    rf_filter_destroy(filter);
    for (size_t i = 0; i < n; i++)
        if (!(depth[i] > 0))
            planar[i] = NAN;
    return result == RF_OK
               ? APP_DONE
               : app_fail(run->error, APP_FAILED, "--%s: %s", option, error.message);
}

/* Of the ways of rays those that lie behind flat surfaces. */
static int keep_flat(const struct run *run, const char *option, float *light,
                     float *planar)
{
    const struct source *source = &run->source;
    const int width = source->width, height = source->height;
    const struct rf_view view = {
        .size = sizeof(view),
        .colour = rf_image_packed(run->colour, width, height, source->n_channels),
        .depth = rf_image_packed(run->depth, width, height, 1)};
    const struct rf_image seen = rf_image_packed(light, width, height, 3);
    const struct rf_image way = rf_image_packed(planar, width, height, 1);
    struct rf_error error;
    if (rf_filter_seen_way(run->filter, &view, &seen, &way, &way, &error) == RF_OK)
        return APP_DONE;
    return app_fail(run->error, APP_FAILED, "--%s: %s", option, error.message);
}

static float sum_of(const float *rgb)
{
    return rgb[0] + rgb[1] + rgb[2];
}

/* A ray goes one way: where a pane mirrors less than it lets through, the way is that
 * of what is seen through it, and the other way round. */
static int drop_weaker(const struct run *run, enum seen_kind kind, const float *light,
                       float *planar)
{
    const enum seen_kind other =
        kind == SEEN_REFLECTION ? SEEN_TRANSMISSION : SEEN_REFLECTION;
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    if (!asked_layers(run->tool, other) && !find_known(&run->source, other))
        return APP_DONE;
    float *stronger = read_light(run, &run->source, other);
    for (size_t i = 0; i < n && stronger; i++)
        if (sum_of(stronger + 3 * i) > sum_of(light + 3 * i))
            planar[i] = NAN;
    const bool is_read = stronger != NULL;
    free(stronger);
    return is_read ? APP_DONE : app_code_of(run->error);
}

/* Planar distances from what an option names: a file, a channel of the input's, or
 * Cycles' Denoising Depth. */
static int read_depth(struct run *run, enum seen_kind kind, float *light, float *planar)
{
    const char *name = asked_depth(run->tool, kind), *option = kinds[kind].depth_option;
    const size_t length = strlen(name);
    const bool is_way = strcmp(name, DENOISING) == 0;
    const bool is_file = length > 4 && strcasecmp(name + length - 4, ".exr") == 0;
    const char *channel = is_way ? find_denoising(&run->source) : name;
    if (!channel)
        return app_fail(
            run->error, APP_FAILED,
            "--%s denoising: %s has no channel %s; in Blender tick Passes > "
            "Data > Denoising Data",
            option, image_path(run->source.colour), denoising_channel);
    float *depth = read_channel(run, is_file ? name : NULL, is_file ? NULL : channel);
    if (!depth)
        return app_code_of(run->error);
    int code = make_planar(run, option, is_way ? RF_DEPTH_RADIAL : -1, depth, planar);
    if (code == APP_DONE && is_way)
        code = drop_weaker(run, kind, light, planar);
    if (code == APP_DONE && is_way)
        code = keep_flat(run, option, light, planar);
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
    struct rf_view *own = &others->views[0];
    const struct source *source = &run->source;
    views_find_place(source->colour, NULL, own->lens_offset, &own->shear_distance);
    own->colour =
        rf_image_packed(run->colour, source->width, source->height, source->n_channels);
    own->depth = rf_image_packed(run->depth, source->width, source->height, 1);
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

/* The planar distances at which the views show the same light. */
static int match(struct run *run, struct others *others, enum seen_kind kind,
                 float *light, float *planar)
{
    const int width = run->source.width, height = run->source.height;
    struct rf_image lights[RF_MAX_VIEWS] = {rf_image_packed(light, width, height, 3)};
    const struct rf_image out = rf_image_packed(planar, width, height, 1);
    struct rf_error error;
    int code = APP_DONE;
    for (int j = 1; j <= others->n && code == APP_DONE; j++) {
        float *other = read_light(run, &others->sources[j], kind);
        lights[j] = rf_image_packed(other, width, height, 3);
        if (!other)
            code = app_code_of(run->error);
    }
    if (code == APP_DONE &&
        rf_filter_seen_depth(run->filter, others->views, others->n + 1, lights, &out,
                             &error) != RF_OK)
        code =
            app_fail(run->error, APP_FAILED, "--reflections-from: %s", error.message);
    for (int j = 1; j <= others->n; j++)
        free(lights[j].data);
    return code;
}

/* ---- the step -------------------------------------------------------------------- */

int seen_check(const struct run *run)
{
    const char *path = image_path(run->source.colour);
    if (!seen_is_asked(run->tool))
        return APP_DONE;
    if (run->is_deep || run->has_views)
        return app_fail(
            run->error, APP_USAGE,
            "%s: %s; reflections of their own depth are of one flat picture", path,
            run->is_deep ? "is deep" : "is one of several views");
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
    return APP_DONE;
}

/* Is a depth of this kind asked for, and the light there? */
static bool is_wanted(const struct run *run, enum seen_kind kind)
{
    const struct filter_options *tool = run->tool;
    if (asked_depth(tool, kind) || asked_layers(tool, kind))
        return true;
    return tool->reflections_from && find_known(&run->source, kind);
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

static void count_share(struct seen *seen, int i)
{
    const struct rf_seen_light *light = &seen->lights[i];
    const size_t n = (size_t)light->depth.width * (size_t)light->depth.height;
    const float *z = light->depth.data, *rgb = light->colour.data;
    size_t n_own = 0;
    for (size_t k = 0; k < n; k++)
        n_own +=
            z[k] > 0 && (rgb[3 * k] > 0 || rgb[3 * k + 1] > 0 || rgb[3 * k + 2] > 0);
    seen->shares[i] = (double)n_own / (double)n;
}

/* What part of the colour the light is, which stays when the grain is gone. */
static bool keep_parts(struct run *run, int i)
{
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    const size_t n_channels = (size_t)run->source.n_channels;
    const float *light = run->seen.lights[i].colour.data;
    float *part = run->seen.parts[i] = app_memory(n, 3 * sizeof(float), run->error);
    for (size_t k = 0; k < n && part; k++)
        for (size_t c = 0; c < 3; c++) {
            const float all = run->colour[k * n_channels + c];
            part[3 * k + c] = all > 0 ? fminf(fmaxf(light[3 * k + c] / all, 0), 1) : 0;
        }
    return part != NULL;
}

static int find_kind(struct run *run, struct others *others, enum seen_kind kind)
{
    struct seen *seen = &run->seen;
    const int width = run->source.width, height = run->source.height, i = seen->n;
    const char *names = asked_layers(run->tool, kind);
    if (!names && !find_known(&run->source, kind))
        return fail_no_light(run);
    float *light = read_light(run, &run->source, kind);
    if (!light)
        return app_code_of(run->error);
    seen->n++;
    seen->kinds[i] = kind;
    seen->lights[i].colour = rf_image_packed(light, width, height, 3);
    float *planar =
        app_memory((size_t)width * (size_t)height, sizeof(float), run->error);
    seen->lights[i].depth = rf_image_packed(planar, width, height, 1);
    if (!planar || (run->tool->denoise && !keep_parts(run, i)))
        return APP_NO_MEMORY;
    int code = asked_depth(run->tool, kind) ? read_depth(run, kind, light, planar)
                                            : match(run, others, kind, light, planar);
    if (code == APP_DONE)
        count_share(seen, i);
    return code;
}

int seen_find(struct run *run)
{
    struct others *others;
    int n_wanted = 0;
    if (!seen_is_asked(run->tool))
        return APP_DONE;
    others = app_memory(1, sizeof(*others), run->error);
    if (!others)
        return APP_NO_MEMORY;
    int code = run->tool->reflections_from ? open_others(run, others) : APP_DONE;
    for (int kind = 0; kind < SEEN_KINDS && code == APP_DONE; kind++) {
        if (!is_wanted(run, kind))
            continue;
        n_wanted++;
        code = find_kind(run, others, kind);
    }
    close_others(others);
    free(others);
    if (code == APP_DONE && n_wanted == 0)
        return fail_no_light(run);
    for (int i = 0; i < run->seen.n && code == APP_DONE; i++)
        if (run->seen.shares[i] == 0)
            code = app_warn(run->tool->host, run->error,
                            "%s: nothing seen %s has a depth of its own there",
                            image_path(run->source.colour),
                            run->seen.kinds[i] == SEEN_REFLECTION ? "in mirrors"
                                                                  : "through glass");
    return code;
}

void seen_set(struct run *run, struct rf_view *view)
{
    struct seen *seen = &run->seen;
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    const size_t n_channels = (size_t)run->source.n_channels;
    for (int i = 0; i < seen->n; i++)
        for (size_t k = 0; k < n && seen->parts[i]; k++)
            for (size_t c = 0; c < 3; c++)
                ((float *)seen->lights[i].colour.data)[3 * k + c] =
                    seen->parts[i][3 * k + c] * run->colour[k * n_channels + c];
    view->seen = seen->lights;
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
    for (int i = 0; i < seen->n; i++) {
        free(seen->lights[i].colour.data);
        free(seen->lights[i].depth.data);
        free(seen->parts[i]);
    }
    *seen = (struct seen){0};
}
