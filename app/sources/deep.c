/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/deep.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"

enum { R, G, B, A, Z, BACK, N_WANTED };

/* Samples of one file, in the order above. */
static bool read_file(struct image_input *input, const struct image_layer *layer, int z,
                      int n_threads, struct image_deep *deep, struct image_error *error)
{
    const int wanted[N_WANTED] = {layer->r, layer->g, layer->b,
                                  layer->a, z,        image_find_z_back(input, z)};
    return image_read_deep(input, wanted, N_WANTED, deep, n_threads, error);
}

static struct rf_deep_sample make_sample(const float *in,
                                         const struct image_layer *layer, bool has_back,
                                         bool is_holdout)
{
    struct rf_deep_sample s = {.depth = in[Z],
                               .depth_back = has_back ? in[BACK] : in[Z],
                               .opacity = layer->a >= 0 ? in[A] : 1};
    if (!is_holdout) {
        memcpy(s.colour, in, 3 * sizeof(float));
        s.colour[3] = s.opacity;
    }
    return s;
}

/* One file's samples, appended pixel by pixel by merge(). */
struct layer_samples {
    struct image_deep deep;
    struct image_layer layer;
    bool has_back, is_holdout;
};

static void put_pixel(const struct layer_samples *from, size_t pixel,
                      struct deep_frame *to, size_t *n)
{
    for (size_t k = from->deep.first[pixel]; k < from->deep.first[pixel + 1]; k++)
        to->samples[(*n)++] =
            make_sample(from->deep.samples + k * N_WANTED, &from->layer, from->has_back,
                        from->is_holdout);
}

static bool merge(struct deep_frame *to, const struct layer_samples *files, int n_files,
                  struct image_error *error)
{
    const struct image_deep *size = &files[0].deep;
    const size_t n_pixels = (size_t)size->width * (size_t)size->height;
    size_t n_samples = 0, n = 0;
    for (int i = 0; i < n_files; i++)
        n_samples += files[i].deep.first[n_pixels];
    to->first = app_memory(n_pixels + 1, sizeof(*to->first), error);
    to->samples = to->first ? app_memory(n_samples, sizeof(*to->samples), error) : NULL;
    if (!to->samples)
        return false;
    for (size_t pixel = 0; pixel < n_pixels; pixel++) {
        to->first[pixel] = n;
        for (int i = 0; i < n_files; i++)
            put_pixel(&files[i], pixel, to, &n);
    }
    to->first[n_pixels] = n;
    to->frame = (struct rf_deep){.width = size->width,
                                 .height = size->height,
                                 .first = to->first,
                                 .samples = to->samples};
    return true;
}

static bool fail_holdout(const char *path, const char *text, struct image_error *error)
{
    return set_error(error, "%s: %s", path, text);
}

/* The plain A of the part that has channel z, where no colour leads to it. */
static int find_alpha(const struct image_input *input, int z)
{
    int n;
    const struct image_channel_info *channels = image_channels(input, &n);
    for (int c = 0; c < n; c++)
        if (channels[c].part == channels[z].part && strcmp(channels[c].name, "A") == 0)
            return c;
    return -1;
}

/* A holdout needs depth and alpha only. */
static bool read_holdout(const char *path, const struct source *source, int n_threads,
                         struct layer_samples *samples, struct image_error *error)
{
    struct image_input *input;
    if (!image_open(&input, path, error))
        return app_missing(error, "holdout", path);
    struct image_layer *layer = &samples->layer;
    bool is_good = image_find_layer(input, NULL, NULL, true, layer, error);
    int n;
    const struct image_channel_info *channels = image_channels(input, &n);
    const struct image_part_info *parts = image_parts(input, &n);
    if (is_good && (layer->z < 0 || !parts[channels[layer->z].part].is_deep))
        is_good =
            fail_holdout(path, "has no deep samples; a holdout needs them", error);
    if (is_good && memcmp(&parts[channels[layer->z].part].data_window,
                          &source->info.data_window, sizeof(struct image_box)) != 0)
        is_good = fail_holdout(path,
                               "its data window is not that of the picture; render "
                               "both with one",
                               error);
    if (is_good && layer->a < 0)
        layer->a = find_alpha(input, layer->z);
    samples->has_back = is_good && image_find_z_back(input, layer->z) >= 0;
    samples->is_holdout = true;
    is_good =
        is_good && read_file(input, layer, layer->z, n_threads, &samples->deep, error);
    image_close(input);
    return is_good;
}

bool deep_read(struct deep_frame *deep, const struct source *source,
               const char *holdout, int n_threads, struct image_error *error)
{
    struct layer_samples files[2] = {
        {.layer = source->layer,
         .has_back = image_find_z_back(source->colour, source->z) >= 0}};
    bool is_good = read_file(source->colour, &source->layer, source->z, n_threads,
                             &files[0].deep, error);
    if (is_good && holdout)
        is_good = read_holdout(holdout, source, n_threads, &files[1], error);
    is_good = is_good && merge(deep, files, holdout ? 2 : 1, error);
    for (int i = 0; i < 2; i++)
        image_deep_free(&files[i].deep);
    return is_good;
}

void deep_free(struct deep_frame *deep)
{
    free(deep->first);
    free(deep->samples);
    *deep = (struct deep_frame){0};
}

rf_result deep_flatten(const struct deep_frame *deep, const struct rf_filter *filter,
                       const struct source *source, float *colour, float *depth,
                       struct rf_error *error)
{
    const size_t n_pixels = (size_t)source->width * (size_t)source->height;
    float *unwanted = NULL;
    if (!colour)
        colour = unwanted =
            app_memory(n_pixels * (size_t)source->n_channels, sizeof(float), NULL);
    if (!colour) {
        error->code = RF_ERROR_MEMORY;
        snprintf(error->message, sizeof(error->message), "out of memory");
        return RF_ERROR_MEMORY;
    }
    const struct rf_image image =
        rf_image_packed(colour, source->width, source->height, source->n_channels);
    const struct rf_image map =
        rf_image_packed(depth, source->width, source->height, 1);
    const rf_result result =
        rf_deep_flatten(filter, &deep->frame, &image, depth ? &map : NULL, error);
    free(unwanted);
    return result;
}
