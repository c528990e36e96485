/* SPDX-License-Identifier: Apache-2.0 */
#include "aov.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "report.h"

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
    for (int c = 0; c < n; c++) {
        if (channels[c].part != source->part ||
            !is_of_layer(channels[c].name, layer, length))
            continue;
        if (channels[c].type == IMAGE_SAMPLE_UINT ||
            strcasestr(channels[c].name, "crypto"))
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

/*
 * Three channels from `first` on, without the contrast at which the filter takes bright
 * light for itself: so it is linear, and what was added up stays so. Returns k.
 */
static float take_group(const struct aovs *aovs, int first, size_t n_pixels, float *rgb)
{
    float most = 0;
    for (size_t i = 0; i < n_pixels; i++)
        for (int c = 0; c < 3; c++) {
            const int k = first + c;
            const float v =
                k < aovs->n ? aovs->samples[i * (size_t)aovs->n + (size_t)k] : 0;
            rgb[3 * i + (size_t)c] = v;
            most = fmaxf(most, fabsf(v));
        }
    const float scale = most > 0 && isfinite(most) ? MIDDLE / 2 / most : 1;
    for (size_t i = 0; i < 3 * n_pixels; i++)
        rgb[i] = rgb[i] * scale + MIDDLE;
    return scale;
}

static void put_group(struct aovs *aovs, int first, size_t n_pixels, const float *rgb,
                      float scale)
{
    for (size_t i = 0; i < n_pixels; i++)
        for (int c = 0; c < 3 && first + c < aovs->n; c++)
            aovs->samples[i * (size_t)aovs->n + (size_t)(first + c)] =
                (rgb[3 * i + (size_t)c] - MIDDLE) / scale;
}

static rf_result filter_groups(struct aovs *aovs, const struct source *source,
                               const struct rf_filter *filter, const float *depth,
                               struct rf_error *error)
{
    const size_t n_pixels = (size_t)source->width * (size_t)source->height;
    struct image_error memory;
    float *rgb = app_memory(n_pixels, 3 * sizeof(float), &memory);
    if (!rgb) {
        error->code = RF_ERROR_MEMORY;
        snprintf(error->message, sizeof(error->message), "%.200s", memory.message);
        return RF_ERROR_MEMORY;
    }
    const struct rf_view view = {
        .colour = rf_image_packed(rgb, source->width, source->height, 3),
        .depth = rf_image_packed((float *)depth, source->width, source->height, 1)};
    rf_result result = RF_OK;
    for (int first = 0; first < aovs->n && result == RF_OK; first += 3) {
        const float scale = take_group(aovs, first, n_pixels, rgb);
        result = rf_filter_process(filter, &view, 1, &view.colour, NULL, error);
        put_group(aovs, first, n_pixels, rgb, scale);
    }
    free(rgb);
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
    struct rf_params plain = *params;
    plain.split_edges = plain.exact_highlights = 0;
    plain.blend_gamma = 1;
    struct rf_filter *filter = NULL;
    struct rf_error core_error;
    rf_result result = rf_filter_create(&filter, context, &plain, source->width,
                                        source->height, &core_error);
    if (result == RF_OK)
        result = filter_groups(aovs, source, filter, depth, &core_error);
    rf_filter_destroy(filter);
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
