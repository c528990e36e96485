/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/source.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "sources/settings.h"

void source_channel_name(const struct source *source, int i, char *text, size_t n_bytes)
{
    int n;
    const struct image_layer *layer = &source->layer;
    const int indices[4] = {layer->r, layer->g, layer->b, layer->a};
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const char *name = channels[indices[i]].name;
    if (layer->is_chroma && i < 3)
        snprintf(text, n_bytes, "%.*s%c", (int)strlen(channels[layer->r].name) - 1,
                 channels[layer->r].name, "RGB"[i]);
    else
        snprintf(text, n_bytes, "%s", name);
}

void source_tool_file(const struct image_input *input, int i, char *text)
{
    int n, n_parts;
    const int part = image_channels(input, &n)[i].part;
    char subimage[24] = "";
    image_parts(input, &n_parts);
    if (n_parts > 1)
        snprintf(subimage, sizeof(subimage), " --subimage %d", part);
    snprintf(text, TOOL_FILE_BYTES, "%.400s%s", image_path(input), subimage);
}

void source_list_channels(const struct image_input *input, char *text, size_t n_bytes)
{
    int n;
    size_t used = 0;
    const struct image_channel_info *channels = image_channels(input, &n);
    *text = 0;
    for (int i = 0; i < n; i++) {
        const char *name = channels[i].name;
        if (used + strlen(name) + 8 > n_bytes) {
            snprintf(text + used, n_bytes - used, ", ...");
            return;
        }
        used += (size_t)snprintf(text + used, n_bytes - used, "%s%s", used ? ", " : "",
                                 name);
    }
}

/* ---- what channels have in common ------------------------------------------------- */

static bool has_one_size(const struct image_input *input, int a, int b)
{
    int n;
    const struct image_channel_info *channels = image_channels(input, &n);
    const struct image_part_info *parts = image_parts(input, &n);
    return channels[a].part == channels[b].part ||
           memcmp(&parts[channels[a].part].data_window,
                  &parts[channels[b].part].data_window, sizeof(struct image_box)) == 0;
}

/* Looks at pixels of channels, interleaved; false: enough was seen. */
typedef bool (*look_fn)(void *user, const float *samples, size_t n_pixels);

/* Strip by strip, of channels of one size; false where they cannot be read. */
static bool look_at(struct image_input *input, const int *channels, int n_channels,
                    look_fn look, void *user)
{
    int n;
    const int part = image_channels(input, &n)[channels[0]].part;
    const struct image_box *box = &image_parts(input, &n)[part].data_window;
    const int32_t width = box->max_x - box->min_x + 1;
    const int32_t height = box->max_y - box->min_y + 1;
    const int32_t step = image_row_step(input, part);
    struct image_error ignored;
    float *rows = app_memory((size_t)width * (size_t)step,
                             (size_t)n_channels * sizeof(float), &ignored);
    bool is_read = rows != NULL, goes_on = true;
    for (int32_t y = 0; is_read && goes_on && y < height; y += step) {
        const struct image_rows some = {y, step < height - y ? step : height - y};
        is_read = image_read_rows(input, channels, n_channels, some, rows, 1, &ignored);
        goes_on = is_read && look(user, rows, (size_t)width * (size_t)some.n);
    }
    free(rows);
    return is_read;
}

/* Half floats of the one are the floats of the other. */
static const float AS_GOOD_AS_EQUAL = 1.0F / 1024;

/* Two depths: do they differ, does the one go on beyond 1, the other not? */
struct rivalry {
    bool is_other, is_above_one, is_rival_above_one;
};

static bool is_as_good_as(float a, float b)
{
    return a == b || (a != a && b != b) || fabsf(a - b) <= AS_GOOD_AS_EQUAL * fabsf(a);
}

static bool compare_depths(void *user, const float *pairs, size_t n)
{
    struct rivalry *found = user;
    for (size_t i = 0; i < n; i++) {
        const float z = pairs[2 * i], rival = pairs[2 * i + 1];
        found->is_other |= !is_as_good_as(z, rival);
        found->is_above_one |= z > 1;
        found->is_rival_above_one |= rival > 1 || rival < 0;
    }
    return true;
}

bool source_has_rival(const struct source *source)
{
    struct rivalry found = {0};
    const int pair[2] = {source->z, source->z_rival};
    if (source->z_rival < 0 || !has_one_size(source->depth, source->z, source->z_rival))
        return source->z_rival >= 0;
    const bool is_read = look_at(source->depth, pair, 2, compare_depths, &found);
    const bool is_for_viewing =
        source->is_rival_weak && found.is_above_one && !found.is_rival_above_one;
    return !is_read || (found.is_other && !is_for_viewing);
}

static bool compare_colours(void *user, const float *rgb, size_t n)
{
    bool *are_equal = user;
    for (size_t i = 0; i < n && *are_equal; i++)
        *are_equal = is_as_good_as(rgb[3 * i], rgb[3 * i + 1]) &&
                     is_as_good_as(rgb[3 * i], rgb[3 * i + 2]);
    return *are_equal;
}

/* Does a file of R G B hold one number three times, as LuxCore's depth does, or nearly so, as
 * colour conversions leave it (Mitsuba's integrator "depth")? */
static bool is_one_number(struct image_input *input, const struct image_layer *layer)
{
    bool are_equal = true;
    const int rgb[3] = {layer->r, layer->g, layer->b};
    return layer->r >= 0 && layer->g >= 0 && layer->b >= 0 && !layer->is_chroma &&
           look_at(input, rgb, 3, compare_colours, &are_equal) && are_equal;
}

/* ---- opening ---------------------------------------------------------------------- */

/* Opens a file that is there for its depth; `depth_channel` may be NULL. */
static bool open_depth(struct source *source, const struct source_request *request,
                       const char *path, struct image_error *error)
{
    const char *depth_channel = request->depth_channel;
    struct image_layer found;
    if (!image_open(&source->depth, path, error))
        return false;
    if (!image_find_layer(source->depth, NULL, depth_channel, true, &found, error))
        return false;
    /* The reader falls back on the red of a picture; only a grey one can be meant. */
    const bool is_red = found.r >= 0 && found.z == found.r && found.r != found.g;
    source->is_red = is_red && !depth_channel && request->depth_file &&
                     is_one_number(source->depth, &found);
    source->z = is_red && !depth_channel && !source->is_red ? -1 : found.z;
    source->z_rival = found.z_rival;
    source->is_rival_weak = found.is_rival_weak;
    if (source->z >= 0)
        return true;
    int n;
    char channels[400], hint[300] = "";
    source_list_channels(source->depth, channels, sizeof(channels));
    if (is_red)
        snprintf(hint, sizeof(hint), " (--depth-channel %s if the picture is it)",
                 image_channels(source->depth, &n)[found.r].name);
    return set_error(
        error,
        "%s: there is no depth channel; its channels are %s; name the depth "
        "with --depth-channel%s",
        path, channels, hint);
}

/* The second file where it is nothing but depth, or where the first has none. With two
 * whole pictures it is a guess which depth is meant. */
static bool open_second(struct source *source, const struct source_request *request,
                        struct image_error *error)
{
    struct image_layer found;
    const char *path = request->paths[1];
    if (!open_depth(source, request, path, error))
        return false;
    const bool has_colour =
        image_find_layer(source->depth, NULL, NULL, false, &found, error) &&
        found.r != found.g;
    if (source->layer.z >= 0 && has_colour)
        return set_error(
            error,
            "%s: has colour and depth, and so has %s; to take the depth of the "
            "one and the colour of the other, say --depth-file",
            path, image_path(source->colour));
    return true;
}

/*
 * Is the depth, Back.Depth.Z, that of another layer than the colour, Fore.Combined.R, with
 * a picture of the same kind, Back.Combined.R? A layer that is there for its data, without
 * one, has the depth of all.
 */
static bool is_of_other_layer(const struct source *source)
{
    int n;
    char other[256];
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    if (source->layer.r < 0)
        return false;
    const char *colour = channels[source->layer.r].name;
    const char *depth = channels[source->layer.z].name;
    const size_t n_colour = strcspn(colour, "."), n_depth = strcspn(depth, ".");
    if (!strchr(colour, '.') || strchr(colour, '.') == strrchr(colour, '.') ||
        depth[n_depth] != '.' ||
        (n_colour == n_depth && strncmp(colour, depth, n_colour) == 0))
        return false;
    snprintf(other, sizeof(other), "%.*s%s", (int)n_depth, depth, colour + n_colour);
    for (int c = 0; c < n; c++)
        if (strcmp(channels[c].name, other) == 0)
            return true;
    return false;
}

/* Is the depth of no view or of the first, and the colour of another one? */
static bool is_of_no_view(const struct source *source)
{
    const char *view =
        source->layer.r < 0 ? NULL : image_view_of(source->colour, source->layer.r);
    const char *of_depth = view ? image_view_of(source->colour, source->layer.z) : NULL;
    return of_depth && strcmp(view, of_depth) != 0;
}

/* Depth: --depth-file, else the second file, else the colour's own. */
static bool find_depth(struct source *source, const struct source_request *request,
                       struct image_error *error)
{
    if (request->depth_file)
        return open_depth(source, request, request->depth_file, error) ||
               app_missing(error,
                           request->depth_option ? request->depth_option : "depth-file",
                           request->depth_file);
    if (request->n_paths > 1)
        return open_second(source, request, error);
    if (source->layer.z >= 0) {
        source->depth = source->colour;
        source->z = source->layer.z;
        source->z_rival = source->layer.z_rival;
        source->is_rival_weak = source->layer.is_rival_weak;
        source->is_of_other = !request->depth_channel && is_of_other_layer(source);
        source->is_of_no_view = !request->depth_channel && is_of_no_view(source);
    }
    return true;
}

/* Colour and depth of the first file; files of mere depth have r = -1. */
static bool find_colour(struct source *source, const struct source_request *request,
                        const char *depth_channel, struct image_error *error)
{
    if (image_find_view_layer(source->colour, request->view, request->layer,
                              depth_channel, false, &source->layer, error))
        return true;
    if (request->layer)
        return false;
    if (!image_find_view_layer(source->colour, request->view, NULL, depth_channel, true,
                               &source->layer, error)) {
        source->layer = (struct image_layer){
            .r = -1, .g = -1, .b = -1, .a = -1, .z = -1, .z_rival = -1};
        return depth_channel == NULL;
    }
    return true;
}

static void describe(struct source *source)
{
    const bool has_colour = source->layer.r >= 0;
    const struct image_input *input =
        has_colour || !source->depth ? source->colour : source->depth;
    const int first = has_colour ? source->layer.r : source->z;
    int n;
    source->part = first >= 0 ? image_channels(input, &n)[first].part : 0;
    source->info = image_parts(input, &n)[source->part];
    const struct image_box *box = &source->info.data_window;
    source->width = box->max_x - box->min_x + 1;
    source->height = box->max_y - box->min_y + 1;
    source->is_grey = source->layer.r >= 0 && source->layer.r == source->layer.g;
    const bool has_alpha = source->layer.a >= 0;
    source->n_channels = has_alpha ? 4 : source->is_grey ? 1 : 3;
}

bool source_open(struct source *source, const struct source_request *request,
                 struct image_error *error)
{
    /* A depth channel that is asked for may be in the second file. */
    const bool has_own_depth = !request->depth_file && request->n_paths == 1;
    const char *own_channel = has_own_depth ? request->depth_channel : NULL;
    *source = (struct source){.z = -1, .z_rival = -1, .view = request->view};
    if (!image_open(&source->colour, request->paths[0], error))
        return false;
    if (!find_colour(source, request, own_channel, error) ||
        !find_depth(source, request, error)) {
        source_close(source);
        return false;
    }
    describe(source);
    return true;
}

void source_close(struct source *source)
{
    if (source->depth && source->depth != source->colour)
        image_close(source->depth);
    if (source->colour)
        image_close(source->colour);
    source->colour = source->depth = NULL;
}

bool source_read_facts(const struct source *source, struct settings *settings,
                       char *text, size_t n_bytes)
{
    if (!settings_read_header(settings, source->colour, source->part, text, n_bytes))
        return false;
    if (!source->depth || source->depth == source->colour)
        return true;
    int n;
    const int part = image_channels(source->depth, &n)[source->z].part;
    return settings_read_header(settings, source->depth, part, text, n_bytes);
}

static const struct image_box *depth_window(const struct source *source)
{
    int n;
    const int part = image_channels(source->depth, &n)[source->z].part;
    return &image_parts(source->depth, &n)[part].data_window;
}

static bool covers(const struct image_box *box, const struct image_box *inner)
{
    return box->min_x <= inner->min_x && box->min_y <= inner->min_y &&
           box->max_x >= inner->max_x && box->max_y >= inner->max_y;
}

/* A depth that was cropped to where something is, in a display window that is all of the
 * colour. */
static bool fail_cropped(const struct source *source, struct image_error *error)
{
    const struct image_box *depth = depth_window(source);
    char file[TOOL_FILE_BYTES];
    source_tool_file(source->depth, source->z, file);
    return set_error(error,
                     "%s: the depth is cropped to (%d, %d) to (%d, %d), the colour in "
                     "%s is not; where nothing was hit beyond, make it 0 there: "
                     "oiiotool %s --croptofull -d float -o depth.exr, and say "
                     "--depth-file depth.exr",
                     image_path(source->depth), depth->min_x, depth->min_y,
                     depth->max_x, depth->max_y, image_path(source->colour), file);
}

/* Pictures of another size from the same corner: of the larger a part would be taken. */
static bool is_scaled(const struct image_box *a, const struct image_box *b)
{
    return a->min_x == b->min_x && a->min_y == b->min_y &&
           (a->max_x != b->max_x || a->max_y != b->max_y);
}

/* The depth must cover the colour; an overscan of it is of no use and no harm. */
static bool check_windows(const struct source *source, struct image_error *error)
{
    int n;
    const struct image_box *depth = depth_window(source);
    const struct image_box *colour = &source->info.data_window;
    const int part = image_channels(source->depth, &n)[source->z].part;
    const struct image_box *display =
        &image_parts(source->depth, &n)[part].display_window;
    const bool is_other_size =
        is_scaled(display, &source->info.display_window) && is_scaled(depth, colour);
    if (covers(depth, colour) && !is_other_size)
        return true;
    if (!is_other_size && covers(display, colour) && covers(display, depth))
        return fail_cropped(source, error);
    const int32_t width = depth->max_x - depth->min_x + 1;
    const int32_t height = depth->max_y - depth->min_y + 1;
    if (width != source->width || height != source->height)
        return set_error(
            error,
            "%s: the depth is %d x %d, but the colour in %s is %d x %d; render "
            "both in one size",
            image_path(source->depth), width, height, image_path(source->colour),
            source->width, source->height);
    return set_error(error,
                     "%s: the depth begins at pixel (%d, %d), but the colour in %s at "
                     "(%d, %d); write both with one data window",
                     image_path(source->depth), depth->min_x, depth->min_y,
                     image_path(source->colour), colour->min_x, colour->min_y);
}

bool source_has_only_data(const struct source *source, char *text, size_t n_bytes)
{
    const struct image_layer *layer = &source->layer;
    if (layer->is_data)
        snprintf(text, n_bytes,
                 "there is no picture: by their names all layers hold data (%s); to "
                 "take one all the same, name it with --layer",
                 layer->fitting[0] ? layer->fitting : layer->name);
    return layer->is_data;
}

/* A part of deep samples beside a flat picture; NULL: none. */
static const char *find_deep_part(const struct source *source)
{
    int n;
    const struct image_part_info *parts = image_parts(source->colour, &n);
    for (int p = 0; p < n && !source->info.is_deep; p++)
        if (parts[p].is_deep)
            return parts[p].name;
    return NULL;
}

static bool fail_without_depth(const struct source *source, struct image_error *error)
{
    char channels[400];
    const char *deep = find_deep_part(source);
    source_list_channels(source->colour, channels, sizeof(channels));
    return set_error(
        error,
        "%s: there is no depth channel%s%s%s; its channels are %s; name the depth "
        "with --depth-channel, or give the file that has it with --depth-file%s%s",
        image_path(source->colour), source->view ? " of the view " : "",
        source->view ? source->view : "", deep ? " beside the flat picture" : "",
        channels, deep ? ", or filter the deep part with --layer " : "",
        deep ? deep : "");
}

bool source_check_depth(const struct source *source, struct image_error *error)
{
    if (source->z < 0)
        return fail_without_depth(source, error);
    if (source->info.is_deep && source->depth != source->colour)
        return set_error(
            error,
            "%s: holds deep samples, which have depths of their own; leave "
            "the file of the depth out",
            image_path(source->colour));
    return source->layer.r < 0 || check_windows(source, error);
}

bool source_check(const struct source *source, struct image_error *error)
{
    char channels[400], text[500];
    source_list_channels(source->colour, channels, sizeof(channels));
    if (source->layer.r < 0)
        return set_error(
            error,
            "%s: there is no colour; its channels are %s; give the file of the "
            "picture first, and that of the depth with --depth-file",
            image_path(source->colour), channels);
    if (source_has_only_data(source, text, sizeof(text)))
        return set_error(error, "%s: %s", image_path(source->colour), text);
    return source_check_depth(source, error);
}

bool source_is_doubtful(const struct source *source, char *text, size_t n_bytes)
{
    const struct image_layer *layer = &source->layer;
    if (layer->is_data || !layer->fitting[0])
        return false;
    snprintf(text, n_bytes,
             "is the first of the layers %s, which fit equally well; name one with "
             "--layer",
             layer->fitting);
    return true;
}

bool source_was_filtered(const struct source *source, char *text, size_t n_bytes)
{
    const char *by;
    if (!image_attribute_string(source->colour, "rackfocus:filtered", &by))
        return false;
    snprintf(text, n_bytes,
             "was filtered before (%.200s); filter the pinhole render instead", by);
    return true;
}

bool source_is_environment(const struct source *source, char *text, size_t n_bytes)
{
    int n;
    const struct image_part_info *parts = image_parts(source->colour, &n);
    const int part = image_channels(source->colour, &n)[source->layer.r].part;
    const char *kind = parts[part].environment;
    if (!kind)
        return false;
    snprintf(text, n_bytes,
             "is an environment map (envmap %s in its header), but is blurred as a "
             "flat picture of a camera, wrong at the %s; filter the views that are "
             "taken out of it instead",
             kind,
             strcmp(kind, "cube") == 0 ? "edges of the cube's sides"
                                       : "poles and at the seam");
    return true;
}

/* Names of OpenEXR (srgb_rec709_scene), OpenImageIO (sRGB, Gamma2.2) and OpenColorIO
 * ("Utility - sRGB - Texture"); those of light have "lin" in them, or none of these. */
static bool is_coded(const char *space)
{
    static const char *const words[] = {"srgb",   "g18_",   "g22_",   "g24_",
                                        "gamma",  "rec709", "acescc", "logc",
                                        "cineon", "slog",   "bt1886"};
    bool is_found = false;
    for (size_t i = 0; i < sizeof(words) / sizeof(words[0]); i++)
        is_found |= strcasestr(space, words[i]) != NULL;
    return is_found && !strcasestr(space, "lin");
}

bool source_is_coded(const struct source *source, char *text, size_t n_bytes)
{
    static const char *const names[] = {"colorInteropID", "oiio:ColorSpace"};
    int n;
    if (source->layer.r >= 0 &&
        image_channels(source->colour, &n)[source->layer.r].type == IMAGE_SAMPLE_UINT) {
        snprintf(text, n_bytes,
                 "is of whole numbers (UINT), taken for light as they are: 255 is 255 "
                 "times white, not white; make light of them: oiiotool FILE --ch R,G,B "
                 "-d float --mulc 16843009 -o linear.exr of 8 bits, --mulc 65537 of 16 "
                 "bits, and --colorconvert sRGB linear after it where they are coded "
                 "for a screen");
        return true;
    }
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        const char *space;
        if (!image_attribute_string(source->colour, names[i], &space) ||
            !is_coded(space))
            continue;
        snprintf(
            text, n_bytes,
            "is not linear light, by %s %.80s in its header, but is blurred as if "
            "it were, and what is bright comes out too dark; make it linear first: "
            "oiiotool FILE --ch R,G,B --colorconvert sRGB linear -d half -o "
            "linear.exr",
            names[i], space);
        return true;
    }
    return false;
}

void source_say_doubts(const struct source *source,
                       void (*say)(void *user, const char *text), void *user)
{
    static bool (*const doubts[])(const struct source *, char *,
                                  size_t) = {source_was_filtered, source_is_environment,
                                             source_is_coded, source_is_doubtful};
    char why[500], text[600];
    for (size_t i = 0; i < sizeof(doubts) / sizeof(doubts[0]); i++) {
        if (!doubts[i](source, why, sizeof(why)))
            continue;
        snprintf(text, sizeof(text), "the picture %s", why);
        say(user, text);
    }
}

bool source_explains_depth(const struct source *source, char *text, size_t n_bytes)
{
    int n;
    if (!source->is_red && !source->is_of_other && !source->is_of_no_view)
        return false;
    const char *name = image_channels(source->depth, &n)[source->z].name;
    if (source->is_red)
        snprintf(text, n_bytes,
                 "is taken from %s of a picture whose red, green and blue are equal; "
                 "--depth-channel %s says that it is meant",
                 name, name);
    else if (source->is_of_no_view)
        snprintf(text, n_bytes,
                 "is %s, which says no view, and what %s sees lies elsewhere; render "
                 "each view with its depth, or say --depth-channel %s if that is meant",
                 name, image_view_of(source->colour, source->layer.r), name);
    else
        snprintf(text, n_bytes,
                 "is %s, of another layer with a picture of its own: %s has none; "
                 "render it with its depth, or say --depth-channel %s if that is meant",
                 name, source->layer.name, name);
    return true;
}

float *source_read_colour(const struct source *source, int n_threads,
                          struct image_error *error)
{
    const size_t n_pixels = (size_t)source->width * (size_t)source->height;
    float *samples =
        app_memory(n_pixels, (size_t)source->n_channels * sizeof(float), error);
    if (samples && image_read_layer(source->colour, &source->layer, source->n_channels,
                                    samples, n_threads, error))
        return samples;
    free(samples);
    return NULL;
}

bool source_has_one_window(const struct source *source)
{
    return memcmp(depth_window(source), &source->info.data_window,
                  sizeof(struct image_box)) == 0;
}

/* Moves the colour's part of a larger depth to its beginning. */
static void crop_depth(const struct source *source, float *samples)
{
    const struct image_box *depth = depth_window(source);
    const struct image_box *colour = &source->info.data_window;
    const size_t stride = (size_t)(depth->max_x - depth->min_x + 1);
    const float *from = samples + (size_t)(colour->min_y - depth->min_y) * stride +
                        (size_t)(colour->min_x - depth->min_x);
    for (int32_t y = 0; y < source->height; y++)
        memmove(samples + (size_t)y * (size_t)source->width, from + (size_t)y * stride,
                (size_t)source->width * sizeof(float));
}

float *source_read_depth(const struct source *source, int n_threads,
                         struct image_error *error)
{
    const struct image_box *box = depth_window(source);
    const size_t n_pixels =
        (size_t)(box->max_x - box->min_x + 1) * (size_t)(box->max_y - box->min_y + 1);
    float *samples = app_memory(n_pixels, sizeof(float), error);
    if (samples &&
        image_read(source->depth, &source->z, 1, samples, n_threads, error)) {
        if (source->layer.r >= 0)
            crop_depth(source, samples);
        return samples;
    }
    free(samples);
    return NULL;
}

void source_settle_grey(const struct source *source, struct rf_params *params)
{
    if (source->is_grey)
        params->axial_chroma = params->lateral_chroma = 0;
}

void source_pack_grey_alpha(float *samples, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        samples[2 * i] = samples[4 * i];
        samples[2 * i + 1] = samples[4 * i + 3];
    }
}

void source_describe(const struct source *like, const struct source_output *how,
                     struct source_description *d)
{
    const bool is_grey_alpha = like->is_grey && like->n_channels == 4;
    const int n_channels = is_grey_alpha ? 2 : like->n_channels;
    for (int i = 0; i < n_channels; i++) {
        source_channel_name(like, is_grey_alpha ? 3 * i : i, d->own_names[i],
                            sizeof(d->own_names[i]));
        d->names[i] = d->own_names[i];
        d->types[i] = how->type;
    }
    d->facts.n = 0;
    if (how->made)
        header_facts_add_text(&d->facts, "rackfocus:filtered", how->made);
    if (how->settings)
        header_facts_add_params(&d->facts, how->settings, like, false);
    d->output = (struct image_output){
        .width = like->width,
        .height = like->height,
        .data_window = like->info.data_window,
        .display_window = like->info.display_window,
        .pixel_aspect = like->info.pixel_aspect,
        .n_channels = n_channels,
        .channel_names = d->names,
        .types = d->types,
        .compression = how->compression,
        .attributes = d->facts.items,
        .n_attributes = d->facts.n,
        .like = like->colour,
        .like_part = like->part,
    };
}

bool source_write_described(const struct source *like, const char *path, float *samples,
                            struct source_description *description, int n_threads,
                            struct image_error *error)
{
    if (description->output.n_channels == 2)
        source_pack_grey_alpha(samples, (size_t)like->width * (size_t)like->height);
    description->output.samples = samples;
    return image_write(path, &description->output, n_threads, error);
}

bool source_write_colour(const struct source *like, const char *path, float *samples,
                         const struct source_output *how, struct image_error *error)
{
    struct source_description description;
    source_describe(like, how, &description);
    return source_write_described(like, path, samples, &description, how->n_threads,
                                  error);
}
