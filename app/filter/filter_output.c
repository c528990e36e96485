/* SPDX-License-Identifier: Apache-2.0 */
/* What a run of the filter writes. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/outputs.h"
#include "common/report.h"
#include "filter/filter_output.h"
#include "filter/filter_private.h"
#include "sources/beside.h"
#include "sources/picture.h"
#include "sources/png_picture.h"

/* ---- names ---------------------------------------------------------------------- */

/* How each kind of FILTER_OPTIONS is looked at. */
#define CHECK_OUTPUT(name) outputs_add(&outputs, #name, tool->name)
#define CHECK_INPUT(name) outputs_spare(&outputs, #name, tool->name)
#define CHECK_INPUTS(name) outputs_spare_list(&outputs, #name, tool->name)
#define CHECK_INPUT_OR_TEXT(name) CHECK_INPUT(name)
#define CHECK_TEXT(name)
#define CHECK_NUMBER(name)
#define CHECK_ASIDE(name)
#define CHECK_OPTION(kind, type, name) CHECK_##kind(name);

int filter_check_files(const struct filter_options *tool, char *const *paths,
                       int n_paths, const struct frame_list *frames,
                       struct image_error *error)
{
    struct outputs outputs = {.frames = frames, .error = error};
    FILTER_OPTIONS(CHECK_OPTION)
    outputs_spare(&outputs, "params", tool->params);
    for (int i = 0; i < n_paths; i++)
        outputs_spare(&outputs, NULL, paths[i]);
    return outputs.code;
}

/* ---- files ---------------------------------------------------------------------- */

static const char *const compressions[] = {NULL,  "none",  "rle", "zips", "zip",
                                           "piz", "pxr24", "b44", "b44a"};

const char *filter_compression(const struct run *run)
{
    return compressions[run->tool->compression];
}

/* Attributes that the lens's picture does not have: it is no view, and one merged from
 * a multi-view file is alone in its file, as is one eye of it. The first only goes where
 * the input was larger: its focal length is counted in other pixels. */
#define OF_LARGE "rackfocus:focalLengthPx*"
static const char *const of_view[] = {OF_LARGE, VIEWS_OFFSET "*", VIEWS_SHEAR "*",
                                      NULL};
static const char *const of_eye[] = {OF_LARGE, VIEWS_OFFSET "*", VIEWS_SHEAR "*",
                                     "multiView", NULL};
static const char *const of_multi_view[] = {
    OF_LARGE, VIEWS_OFFSET "*", VIEWS_SHEAR "*", "view", "multiView", "name", NULL};

/* Of the view of a multi-view file that the result is like; else NULL. */
static const char *view_name(const struct run *run)
{
    return run->has_views ? run->list.items[0].name : run->tool->view;
}

/* The only view of a multi-view file that is written, without having been asked for by
 * --stereo; else NULL. */
static const char *eye_name(const struct run *run)
{
    const struct source *source = &run->source;
    if (run->has_views || run->tool->view || run->tool->pass_through ||
        image_view_count(source->colour) < 2)
        return NULL;
    return image_view_of(source->colour, source->layer.r);
}

static const char *const *dropped_of(const struct run *run)
{
    const char *const *all = view_name(run)  ? of_multi_view
                             : eye_name(run) ? of_eye
                                             : of_view;
    return run->tool->supersample > 1 ? all : all + 1;
}

/* The distance of the plane that stays in place in the views of a mean; 0: none does. */
static double shear_of(const struct run *run)
{
    return run->has_views ? run->views.views[0].shear_distance : 0;
}

/* What the header says of the lens, and which eye it is, where that of the part does
 * not. A mean of views has theirs. */
static void add_facts(const struct run *run, struct header_facts *facts)
{
    const char *eye = eye_name(run);
    if (eye && !run->source.info.view[0])
        header_facts_add_text(facts, "view", eye);
    if (run->settings->params.method == RF_METHOD_ACCUMULATE)
        header_facts_add_focus(facts, shear_of(run));
    else if (!run->is_of_own_lens)
        header_facts_add_params(facts, run->settings, &run->source,
                                run->tool->supersample > 1);
}

void filter_drop_view(const struct run *run, struct source_description *to)
{
    const char *view = view_name(run) ? view_name(run) : eye_name(run);
    to->output.dropped = dropped_of(run);
    add_facts(run, &to->facts);
    to->output.n_attributes = to->facts.n;
    for (int i = 0; i < to->output.n_channels && view; i++) {
        char name[sizeof(to->own_names[i])];
        beside_drop_view(to->own_names[i], view, name, sizeof(name));
        strcpy(to->own_names[i], name);
    }
}

/* The colour with the filtered layers beside it; the colour itself where there are
 * none. */
static float *add_aovs(const struct run *run, int n_channels, struct image_error *error)
{
    const struct aovs *aovs = &run->aovs;
    const size_t n = (size_t)run->source.width * (size_t)run->source.height;
    const size_t n_colour = (size_t)n_channels, n_aovs = (size_t)aovs->n;
    if (n_aovs == 0)
        return run->colour;
    float *samples = app_memory(n, (n_colour + n_aovs) * sizeof(float), error);
    for (size_t i = 0; samples && i < n; i++) {
        float *to = samples + i * (n_colour + n_aovs);
        memcpy(to, run->colour + i * n_colour, n_colour * sizeof(float));
        memcpy(to + n_colour, aovs->samples + i * n_aovs, n_aovs * sizeof(float));
    }
    return samples;
}

/* Channels of the size and the place of what was read. */
static struct image_output output_of(const struct source *source, int n_channels,
                                     const char *const *names,
                                     const enum image_sample_type *types,
                                     const float *samples)
{
    return (struct image_output){.width = source->width,
                                 .height = source->height,
                                 .data_window = source->info.data_window,
                                 .display_window = source->info.display_window,
                                 .pixel_aspect = source->info.pixel_aspect,
                                 .n_channels = n_channels,
                                 .channel_names = names,
                                 .types = types,
                                 .samples = samples};
}

/* What the channels of the output are called: as in the input, but a lone view's and
 * those that luminance and chroma stood for. */
struct channel_names {
    char own[4][256];
    const char **all; /* of run's colour, n of them, then of its other layers */
};

static void name_channels(const struct run *run, int n_colours,
                          struct channel_names *names)
{
    const struct source *source = &run->source;
    const struct image_layer *layer = &source->layer;
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const int rgba[4] = {layer->r, layer->g, layer->b, layer->a};
    const int grey_alpha[2] = {layer->r, layer->a};
    const int *indices = source->is_grey ? grey_alpha : rgba;
    const char *view = view_name(run) ? view_name(run) : eye_name(run);
    for (int i = 0; i < n_colours && i < 4; i++) {
        names->all[i] = names->own[i];
        if (layer->is_chroma && i < 3)
            source_channel_name(source, i, names->own[i], sizeof(names->own[i]));
        else if (view)
            beside_drop_view(channels[indices[i]].name, view, names->own[i],
                             sizeof(names->own[i]));
        else
            names->all[i] = channels[indices[i]].name;
    }
    for (int i = 0; i < run->aovs.n; i++)
        names->all[n_colours + i] = channels[run->aovs.channels[i]].name;
}

/* Writes n_colours channels of run->colour and the other layers. `types` has room. */
static bool write_channels(const struct run *run, int n_colours, const float *samples,
                           struct channel_names *names, enum image_sample_type *types,
                           const struct header_facts *facts, struct image_error *error)
{
    const bool is_half = run->tool->type == FILTER_TYPE_HALF;
    const int n_all = n_colours + run->aovs.n;
    name_channels(run, n_colours, names);
    for (int i = 0; i < n_all; i++)
        types[i] = is_half ? IMAGE_SAMPLE_HALF : IMAGE_SAMPLE_FLOAT;
    struct image_output output =
        output_of(&run->source, n_all, names->all, types, samples);
    output.compression = filter_compression(run);
    output.attributes = facts->items;
    output.n_attributes = facts->n;
    output.dropped = dropped_of(run);
    output.like = run->source.colour;
    output.like_part = run->source.part;
    output.has_own_windows = run->tool->supersample > 1;
    output.pass_through = run->tool->pass_through;
    return image_write(run->tool->output, &output, run->n_threads, error);
}

static bool write_exr(const struct run *run, const struct header_facts *facts,
                      struct image_error *error)
{
    const struct source *source = &run->source;
    const size_t n_pixels = (size_t)source->width * (size_t)source->height;
    int n_colours = source->n_channels;
    if (source->is_grey && n_colours == 4) {
        source_pack_grey_alpha(run->colour, n_pixels);
        n_colours = 2;
    }
    const size_t n_all = (size_t)(n_colours + run->aovs.n);
    struct channel_names names = {.all = app_memory(n_all, sizeof(*names.all), error)};
    enum image_sample_type *types = app_memory(n_all, sizeof(*types), error);
    float *samples = names.all && types ? add_aovs(run, n_colours, error) : NULL;
    bool is_good = samples != NULL;
    if (is_good && run->tool->type == FILTER_TYPE_HALF)
        is_good = picture_warn_clipped(run->tool->host, run->tool->output,
                                       picture_clip_to_half(samples, n_pixels * n_all),
                                       error) == APP_DONE;
    is_good =
        is_good && write_channels(run, n_colours, samples, &names, types, facts, error);
    if (samples != run->colour)
        free(samples);
    free(names.all);
    free(types);
    return is_good;
}

bool filter_write_flattened(const struct run *run, struct image_error *error)
{
    static const char *const names[] = {"R", "G", "B", "A", "Z"};
    static const char *const grey[] = {"Y", "Z"};
    static const enum image_sample_type types[5] = {
        IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT, IMAGE_SAMPLE_FLOAT,
        IMAGE_SAMPLE_FLOAT};
    const struct source *source = &run->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    const int n_colours = source->n_channels, n_channels = n_colours + 1;
    float *samples = app_memory(n, (size_t)n_channels * sizeof(float), error);
    for (size_t i = 0; samples && i < n; i++) {
        memcpy(samples + i * (size_t)n_channels, run->colour + i * (size_t)n_colours,
               (size_t)n_colours * sizeof(float));
        samples[i * (size_t)n_channels + (size_t)n_colours] = run->depth[i];
    }
    const char *channels[5];
    for (int i = 0; i < n_channels; i++)
        channels[i] = n_colours == 1 ? grey[i] : i == n_colours ? names[4] : names[i];
    struct image_output output =
        output_of(source, n_channels, channels, types, samples);
    output.compression = "zip";
    output.like = source->colour;
    output.like_part = source->part;
    const bool is_written =
        samples && image_write(run->tool->flattened, &output, run->n_threads, error);
    free(samples);
    return is_written;
}

static bool write_coc(const struct run *run, const struct header_facts *facts,
                      struct image_error *error)
{
    static const char *const name = "Y";
    static const enum image_sample_type type = IMAGE_SAMPLE_FLOAT;
    const struct source *source = &run->source;
    struct image_output output = output_of(source, 1, &name, &type, run->depth);
    output.compression = "zip";
    output.attributes = facts->items;
    output.n_attributes = 1; /* what it was made with, as the first */
    return image_write(run->tool->output_coc, &output, run->n_threads, error);
}

static bool write_picture(const struct run *run, const struct header_facts *facts,
                          struct image_error *error)
{
    if (picture_kind(run->tool->output) == PICTURE_EXR)
        return write_exr(run, facts, error);
    const struct png_picture png = {.source = &run->source,
                                    .samples = run->colour,
                                    .bits =
                                        run->tool->png_bits == FILTER_PNG_16 ? 16 : 8,
                                    .is_of_scene = run->tool->scene != NULL};
    return png_picture_write(run->tool->host, run->tool->output, &png, error);
}

void filter_describe(const struct run *run, char *text, size_t n_bytes)
{
    char used[4000];
    settings_print_options(&run->settings->params, used, sizeof(used));
    snprintf(text, n_bytes, "rackfocus %s%s%s", rf_version(), *used ? " " : "", used);
}

bool filter_write_files(const struct run *run, struct image_error *error)
{
    char text[4096];
    filter_describe(run, text, sizeof(text));
    struct header_facts facts = {.n = 0};
    header_facts_add_text(&facts, "rackfocus:filtered", text);
    add_facts(run, &facts);
    return write_picture(run, &facts, error) &&
           (!run->tool->output_coc || write_coc(run, &facts, error));
}

bool filter_write(const struct filter_options *tool, struct settings *settings,
                  const struct source *source, bool is_of_own_lens, float *pixels,
                  struct image_error *error)
{
    const struct run run = {.tool = tool,
                            .settings = settings,
                            .is_of_own_lens = is_of_own_lens,
                            .source = *source,
                            .colour = pixels,
                            .n_threads = thread_count(tool->n_threads)};
    return filter_write_files(&run, error);
}
