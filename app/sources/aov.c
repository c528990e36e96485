/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/aov.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "sources/beside.h"

/* ---- finding -------------------------------------------------------------------- */

/* "DiffDir" and "ViewLayer.DiffDir" name the layer of ViewLayer.DiffDir.R. */
static bool is_of_layer(const char *channel, const char *layer, size_t n)
{
    if (strncmp(channel, layer, n) == 0 && channel[n] == '\0')
        return true;
    for (const char *word = channel; word; word = strchr(word, '.')) {
        word += *word == '.';
        if (strncmp(word, layer, n) == 0 && word[n] == '.')
            return strchr(word + n + 1, '.') == NULL;
    }
    return false;
}

static bool fail_layer(const struct source *source, const char *layer, size_t n,
                       const char *text, struct image_error *error)
{
    char channels[400];
    source_list_channels(source->colour, channels, sizeof(channels));
    return set_error(error, "%s: layer \"%.*s\" %s; its channels are %s",
                     image_path(source->colour), (int)n, layer, text, channels);
}

static bool is_colour(const struct source *source, int channel)
{
    const struct image_layer *layer = &source->layer;
    return channel == layer->r || channel == layer->g || channel == layer->b ||
           channel == layer->a;
}

static bool is_known(const struct aovs *aovs, int channel)
{
    for (int i = 0; i < aovs->n; i++)
        if (aovs->channels[i] == channel)
            return true;
    return false;
}

static bool find_one(struct aovs *aovs, const struct source *source, const char *layer,
                     size_t length, struct image_error *error)
{
    int n, n_found = 0;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const char *view = beside_view(source);
    for (int c = 0; c < n; c++) {
        char name[256];
        beside_drop_view(channels[c].name, view ? view : "", name, sizeof(name));
        if (channels[c].part != source->part || !beside_is_of_view(source, c) ||
            (!is_of_layer(name, layer, length) &&
             !is_of_layer(channels[c].name, layer, length)))
            continue;
        if (image_is_identifier(&channels[c]))
            return fail_layer(source, layer, length,
                              "holds identifiers, which cannot be blurred; use "
                              "--pass-through",
                              error);
        n_found++;
        if (!is_colour(source, c) && !is_known(aovs, c))
            aovs->channels[aovs->n++] = c;
    }
    return n_found ||
           fail_layer(source, layer, length, "is not beside the colour", error);
}

bool aovs_find(struct aovs *aovs, const struct source *source, const char *names,
               struct image_error *error)
{
    int n;
    image_channels(source->colour, &n);
    *aovs = (struct aovs){.channels = app_memory((size_t)n, sizeof(int), error)};
    if (!aovs->channels)
        return false;
    if (names[strspn(names, ",")] == '\0')
        return set_error(error,
                         "--filter-layers: '%s' names no layer; give the names "
                         "of layers, separated by commas",
                         names);
    for (const char *name = names; *name;) {
        const size_t length = strcspn(name, ",");
        if (length && !find_one(aovs, source, name, length, error))
            return false;
        name += length + (name[length] == ',');
    }
    return true;
}

/* ---- filtering ------------------------------------------------------------------ */

/* How the values of a group are brought into [1/3, 1]: v k + 2/3. */
static const float MIDDLE = 2.0f / 3;

/* The channels of a group, up to three of those of an `aovs`, and their shared scale. */
struct group {
    int at[3], n;
    bool is_colour; /* red, green and blue of one layer, in this order */
    float scale;
};

/* Which channel has the name of `channel` but for its last letter; -1: none. */
static int find_sibling(const struct aovs *aovs, const struct image_channel_info *all,
                        int channel, char letter)
{
    const char *name = all[aovs->channels[channel]].name;
    const size_t n = strlen(name) - 1;
    for (int i = 0; i < aovs->n; i++) {
        const char *other = all[aovs->channels[i]].name;
        if (strlen(other) == n + 1 && strncmp(other, name, n) == 0 &&
            other[n] == letter)
            return i;
    }
    return -1;
}

/* The colours whose red, green or blue this channel is: "key.R", not "AOR". */
static bool find_colours(const struct aovs *aovs, const struct image_channel_info *all,
                         int channel, struct group *group)
{
    const char *name = all[aovs->channels[channel]].name;
    const size_t n = strlen(name);
    if (n > 1 && name[n - 2] != '.')
        return false;
    for (int c = 0; c < 3; c++)
        group->at[c] = find_sibling(aovs, all, channel, "RGB"[c]);
    group->n = 3;
    group->is_colour = true;
    const int *at = group->at;
    return at[0] >= 0 && at[1] >= 0 && at[2] >= 0 &&
           (channel == at[0] || channel == at[1] || channel == at[2]);
}

/*
 * The next group of colours, or of what is none; a channel that is done is -1 in
 * `left`. A lens disperses colours alone: what else is filtered has the green's lens.
 */
static bool next_group(const struct aovs *aovs, const struct image_channel_info *all,
                       int *left, struct group *group)
{
    struct group data = {.n = 0};
    for (int i = 0; i < aovs->n; i++) {
        if (left[i] < 0)
            continue;
        if (find_colours(aovs, all, i, group)) {
            for (int c = 0; c < 3; c++)
                left[group->at[c]] = -1;
            return true;
        }
        if (data.n < 3)
            data.at[data.n++] = i;
    }
    *group = data;
    for (int c = 0; c < data.n; c++)
        left[data.at[c]] = -1;
    return data.n > 0;
}

/*
 * The channels of a group, without the contrast at which the filter takes bright light
 * for itself: so it is linear, and what was added up stays so.
 */
static void take_group(const struct aovs *aovs, struct group *group, size_t n_pixels,
                       float *rgb)
{
    float most = 0;
    for (size_t i = 0; i < n_pixels; i++)
        for (int c = 0; c < 3; c++) {
            const size_t at = i * (size_t)aovs->n;
            const float v = c < group->n ? aovs->samples[at + (size_t)group->at[c]] : 0;
            rgb[3 * i + (size_t)c] = v;
            most = fmaxf(most, fabsf(v));
        }
    group->scale = most > 0 && isfinite(most) ? MIDDLE / 2 / most : 1;
    for (size_t i = 0; i < 3 * n_pixels; i++)
        rgb[i] = rgb[i] * group->scale + MIDDLE;
}

static void put_group(struct aovs *aovs, const struct group *group, size_t n_pixels,
                      const float *rgb)
{
    for (size_t i = 0; i < n_pixels; i++)
        for (int c = 0; c < group->n; c++)
            aovs->samples[i * (size_t)aovs->n + (size_t)group->at[c]] =
                (rgb[3 * i + (size_t)c] - MIDDLE) / group->scale;
}

/* The filters of colours and of what is none, and what they filter. */
struct lenses {
    struct rf_filter *colours, *data;
    struct rf_view view;
};

static rf_result filter_groups(struct aovs *aovs, const struct source *source,
                               const struct lenses *lenses, int *left,
                               struct rf_error *error)
{
    const size_t n_pixels = (size_t)source->width * (size_t)source->height;
    const struct rf_view *view = &lenses->view;
    float *rgb = view->colour.data;
    int n;
    const struct image_channel_info *all = image_channels(source->colour, &n);
    struct group group;
    rf_result result = RF_OK;
    while (result == RF_OK && next_group(aovs, all, left, &group)) {
        take_group(aovs, &group, n_pixels, rgb);
        result = rf_filter_process(group.is_colour ? lenses->colours : lenses->data,
                                   view, 1, &view->colour, NULL, error);
        put_group(aovs, &group, n_pixels, rgb);
    }
    return result;
}

static rf_result make_lenses(struct lenses *lenses, const struct rf_context *context,
                             const struct rf_params *params, const struct source *s,
                             struct rf_error *error)
{
    struct rf_params plain = *params;
    plain.split_edges = plain.exact_highlights = 0;
    plain.blend_gamma = 1;
    plain.highlight_clamp = 0;
    plain.highlight_gain = plain.highlight_saturation = 1;
    rf_result result =
        rf_filter_create(&lenses->colours, context, &plain, s->width, s->height, error);
    plain.white = 1;
    plain.axial_chroma = plain.lateral_chroma = 0;
    if (result == RF_OK)
        result = rf_filter_create(&lenses->data, context, &plain, s->width, s->height,
                                  error);
    return result;
}

bool aovs_filter(struct aovs *aovs, const struct source *source,
                 const struct rf_context *context, const struct rf_params *params,
                 const float *depth, int n_threads, struct image_error *error)
{
    const size_t n_pixels = (size_t)source->width * (size_t)source->height;
    if (aovs->n == 0)
        return true;
    aovs->samples = app_memory(n_pixels, (size_t)aovs->n * sizeof(float), error);
    if (!aovs->samples || !image_read(source->colour, aovs->channels, aovs->n,
                                      aovs->samples, n_threads, error))
        return false;
    float *rgb = app_memory(n_pixels, 3 * sizeof(float), error);
    int *left = rgb ? app_memory((size_t)aovs->n, sizeof(int), error) : NULL;
    if (!left) {
        free(rgb);
        return false;
    }
    for (int i = 0; i < aovs->n; i++)
        left[i] = i;
    struct lenses lenses = {
        .view = {.colour = rf_image_packed(rgb, source->width, source->height, 3),
                 .depth = rf_image_packed((float *)depth, source->width, source->height,
                                          1)}};
    struct rf_error core_error;
    rf_result result = make_lenses(&lenses, context, params, source, &core_error);
    if (result == RF_OK)
        result = filter_groups(aovs, source, &lenses, left, &core_error);
    rf_filter_destroy(lenses.colours);
    rf_filter_destroy(lenses.data);
    free(left);
    free(rgb);
    if (result != RF_OK)
        app_fail(error, result == RF_ERROR_MEMORY ? APP_NO_MEMORY : APP_FAILED,
                 "%s: in the layers to filter: %s", image_path(source->colour),
                 core_error.message);
    return result == RF_OK;
}

void aovs_free(struct aovs *aovs)
{
    free(aovs->channels);
    free(aovs->samples);
    *aovs = (struct aovs){0};
}
