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

float *seen_read_light(const struct run *run, const struct source *source,
                       enum seen_kind kind)
{
    const char *names = seen_asked_layers(run->tool, kind);
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
                            "render all with the same passes",
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
