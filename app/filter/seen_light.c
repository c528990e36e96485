/* SPDX-License-Identifier: Apache-2.0 */
#include "filter/seen_light.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "filter/filter_private.h"
#include "sources/source.h"

/* ---- what renderers call it ------------------------------------------------------ */

/* Light as a renderer writes it: the sum of some layers, times another. */
struct light_layers {
    const char *sum[3]; /* up to the first NULL */
    const char *factor; /* or NULL */
};

enum { N_KNOWN = 4 };

/* In the order in which they are taken. */
static const struct light_layers known_layers[SEEN_KINDS][N_KNOWN] = {
    [SEEN_REFLECTION] = {{{"GlossDir", "GlossInd"}, "GlossCol"}, /* Blender to 4.x */
                         {{"Glossy Direct", "Glossy Indirect"}, "Glossy Color"},
                         {{"specular"}, NULL},    /* Arnold */
                         {{"reflection"}, NULL}}, /* V-Ray, Redshift */
    [SEEN_TRANSMISSION] = {{{"TransDir", "TransInd"}, "TransCol"},
                           {{"Transmission Direct", "Transmission Indirect"},
                            "Transmission Color"},
                           {{"transmission"}, NULL},
                           {{"refraction"}, NULL}},
};

/* ---- layers ---------------------------------------------------------------------- */

/* The length of a channel's name without "." and its letter, and without the view that
 * stands before these where views share a part; 0: it has another letter. */
static size_t layer_length(const char *channel, const char *view, char letter)
{
    const size_t n = strlen(channel), n_view = view ? strlen(view) : 0;
    if (n < 3 || channel[n - 2] != '.' || channel[n - 1] != letter)
        return 0;
    const size_t end = n - 2, start = end - n_view;
    const bool has_view = n_view > 0 && end > n_view + 1 && channel[start - 1] == '.' &&
                          strncmp(channel + start, view, n_view) == 0;
    return has_view ? start - 1 : end;
}

int seen_find_channel(const struct source *source, const char *layer, size_t length,
                      char letter, int part)
{
    int n;
    const struct image_channel_info *all = image_channels(source->colour, &n);
    const char *view = image_view_of(source->colour, source->layer.r);
    for (int i = 0; i < n; i++) {
        const char *own = image_view_of(source->colour, i), *name = all[i].name;
        const size_t end = layer_length(name, view, letter);
        if (end < length || (part >= 0 && all[i].part != part) ||
            (view && (!own || strcmp(own, view) != 0)))
            continue;
        /* Words may stand before the layer. */
        const char *at = name + end - length;
        if (strncasecmp(at, layer, length) == 0 && (at == name || at[-1] == '.'))
            return i;
    }
    return -1;
}

/* The three channels of a layer in a file, in the part of the colour; false: none. */
static bool find_layer(const struct source *source, const char *layer, size_t length,
                       int channels[3])
{
    for (int c = 0; c < 3; c++)
        channels[c] =
            seen_find_channel(source, layer, length, "RGB"[c], source -> part);
    return channels[0] >= 0 && channels[1] >= 0 && channels[2] >= 0;
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
        if (has_layers(source, &known_layers[kind][i]))
            return &known_layers[kind][i];
    return NULL;
}

const char *seen_asked_layers(const struct filter_options *tool, enum seen_kind kind)
{
    return kind == SEEN_REFLECTION ? tool->reflection_layers
                                   : tool->transmission_layers;
}

bool seen_has_light(const struct run *run, const struct source *source,
                    enum seen_kind kind)
{
    return seen_asked_layers(run->tool, kind) || find_known(source, kind);
}

/* ---- light ----------------------------------------------------------------------- */

/* The layers of a light: all but the factor add up. */
struct sum {
    int *channels; /* three for each layer */
    int n_layers;
    bool has_factor; /* the last one */
};

static bool add_layer(const struct run *run, const struct source *source,
                      const char *layer, size_t length, struct sum *sum)
{
    if (find_layer(source, layer, length, sum->channels + 3 * sum->n_layers)) {
        sum->n_layers++;
        return true;
    }
    char names[400];
    source_list_channels(source->colour, names, sizeof(names));
    return set_error(run->error,
                     "%s: there are no channels %.*s.R, .G and .B beside the colour; "
                     "its channels are %s",
                     image_path(source->colour), (int)length, layer, names);
}

static bool add_known(const struct run *run, const struct source *source,
                      const struct light_layers *layers, struct sum *sum)
{
    for (int i = 0; i < 3 && layers->sum[i]; i++)
        if (!add_layer(run, source, layers->sum[i], strlen(layers->sum[i]), sum))
            return false;
    sum->has_factor = layers->factor != NULL;
    return !layers->factor ||
           add_layer(run, source, layers->factor, strlen(layers->factor), sum);
}

static bool add_named(const struct run *run, const struct source *source,
                      const char *names, struct sum *sum)
{
    for (const char *name = names; *name;) {
        const size_t length = strcspn(name, ",");
        if (length && !add_layer(run, source, name, length, sum))
            return false;
        name += length + (name[length] == ',');
    }
    return true;
}

/* Which layers are the light; false with a message. */
static bool list_layers(const struct run *run, const struct source *source,
                        enum seen_kind kind, struct sum *sum)
{
    const char *names = seen_asked_layers(run->tool, kind);
    const struct light_layers *known = names ? NULL : find_known(source, kind);
    size_t n_most = 4; /* of known ones */
    for (const char *at = names; at && *at; at++)
        n_most += *at == ',';
    sum->channels = app_memory(3 * n_most, sizeof(*sum->channels), run->error);
    if (!sum->channels)
        return false;
    if (names)
        return add_named(run, source, names, sum);
    if (known)
        return add_known(run, source, known, sum);
    return set_error(run->error,
                     "%s: has no layers of what is seen in %s, as %s has; "
                     "render all with the same passes",
                     image_path(source->colour),
                     kind == SEEN_REFLECTION ? "mirrors" : "glass",
                     image_path(run->source.colour));
}

/* The light of pixels whose layers lie one behind the other in each. */
static void add_up(const struct sum *sum, const float *layers, size_t n_pixels,
                   float *light)
{
    const int n = sum->n_layers;
    for (size_t i = 0; i < n_pixels; i++, layers += 3 * n, light += 3)
        for (int c = 0; c < 3; c++)
            for (int k = 0; k < n; k++) {
                const float v = isfinite(layers[3 * k + c]) ? layers[3 * k + c] : 0;
                if (k == n - 1 && sum->has_factor)
                    light[c] *= v;
                else
                    light[c] += v;
            }
}

/* All layers at once, since a chunk of a file holds all of them, and some rows at a time,
 * since so many layers take much memory. */
static bool read_sum(const struct run *run, const struct source *source,
                     const struct sum *sum, float *light)
{
    enum { ROWS_AT_ONCE = 256 };
    const size_t width = (size_t)source->width;
    const int n = 3 * sum->n_layers;
    const int32_t step = image_row_step(source->colour, source->part);
    const int32_t n_chunks = (ROWS_AT_ONCE + step - 1) / step;
    /* A chunk for each thread at the least. */
    const int64_t most =
        (int64_t)step * (n_chunks > run->n_threads ? n_chunks : run->n_threads);
    const int32_t n_rows = most < source->height ? (int32_t)most : source->height;
    if (n == 0)
        return true;
    float *room =
        app_memory((size_t)n_rows * width, (size_t)n * sizeof(float), run->error);
    bool is_read = room != NULL;
    for (int32_t y = 0; y < source->height && is_read; y += n_rows) {
        const int32_t left = source->height - y;
        const struct image_rows rows = {y, left < n_rows ? left : n_rows};
        is_read = image_read_rows(source->colour, sum->channels, n, rows, room,
                                  run->n_threads, run->error);
        if (is_read)
            add_up(sum, room, (size_t)rows.n * width, light + 3 * (size_t)y * width);
    }
    free(room);
    return is_read;
}

float *seen_read_light(const struct run *run, const struct source *source,
                       enum seen_kind kind)
{
    const size_t n = (size_t)source->width * (size_t)source->height;
    struct sum sum = {.n_layers = 0};
    float *light = list_layers(run, source, kind, &sum)
                       ? app_memory(n, 3 * sizeof(float), run->error)
                       : NULL;
    if (light && !read_sum(run, source, &sum, light)) {
        free(light);
        light = NULL;
    }
    free(sum.channels);
    return light;
}
