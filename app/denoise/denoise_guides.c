/* SPDX-License-Identifier: Apache-2.0 */
/* Albedo and normals beside the colour of a source, by the names that renderers give. */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "denoise/denoise.h"
#include "sources/beside.h"
#include "sources/picture.h"
#include "sources/source.h"

/* Names of layers in the order in which they are taken. */
static const char *const albedo_names[] = {"Denoising Albedo", "denoise_albedo",
                                           "albedo", NULL};
static const char *const normal_names[] = {"Denoising Normal", "denoise_normal",
                                           "normal", "N", NULL};

/* The three channels of the first of some layers that the file has, of one data window
 * with the colour. */
static bool find_guide(const struct source *source, const char *const *names,
                       int channels[3])
{
    int n;
    const struct image_channel_info *info = image_channels(source->colour, &n);
    for (; *names; names++) {
        int n_found = 0;
        for (int base = 0; base < 3; base++)
            for (int c = 0; c < n && n_found == base; c++)
                if (beside_is(source, c, *names, base) &&
                    (base == 0 || info[c].part == info[channels[0]].part))
                    channels[n_found++] = c;
        if (n_found == 3)
            return true;
    }
    return false;
}

/* The picture of a file, or its X Y Z. */
static bool find_only(const struct source *file, int channels[3])
{
    int n, n_found = 0;
    const struct image_channel_info *info = image_channels(file->colour, &n);
    channels[0] = file->layer.r;
    channels[1] = file->layer.g;
    channels[2] = file->layer.b;
    if (file->layer.r >= 0 && file->n_channels >= 3)
        return true;
    for (int base = 0; base < 3; base++)
        for (int c = 0; c < n && n_found == base; c++)
            if (toupper((unsigned char)info[c].name[strlen(info[c].name) - 1]) ==
                "XYZ"[base])
                channels[n_found++] = c;
    return n_found == 3;
}

/* Reads three channels; what is not finite becomes 0. */
static bool read_channels(struct image_input *input, const int channels[3], size_t n,
                          int n_threads, float **samples, struct image_error *error)
{
    *samples = app_memory(n, 3 * sizeof(float), error);
    if (!*samples || !image_read(input, channels, 3, *samples, n_threads, error))
        return false;
    for (size_t i = 0; i < 3 * n; i++)
        if (!isfinite((*samples)[i]))
            (*samples)[i] = 0;
    return true;
}

/* Reads a guide from a file of its own. */
static bool read_file(const struct source *source, const char *path, const char *option,
                      const char *const *names, int n_threads, float **samples,
                      struct image_error *error)
{
    char *paths[] = {(char *)path};
    struct source file;
    int channels[3];
    if (!source_open(&file, &(struct source_request){.paths = paths, .n_paths = 1},
                     error))
        return app_missing(error, option + 2, path); /* without its dashes */
    bool is_read = find_guide(&file, names, channels) || find_only(&file, channels);
    if (!is_read)
        set_error(error, "%s: %s has neither R G B nor X Y Z", option, path);
    else if (file.width != source->width || file.height != source->height)
        is_read = set_error(error,
                            "%s: %s is %d x %d px and %s %d x %d; render both in "
                            "one size",
                            option, path, file.width, file.height,
                            image_path(source->colour), source->width, source->height);
    else
        is_read = picture_check_place(path, &file.info.data_window,
                                      image_path(source->colour),
                                      &source->info.data_window, error) &&
                  read_channels(file.colour, channels,
                                (size_t)file.width * (size_t)file.height, n_threads,
                                samples, error);
    source_close(&file);
    return is_read;
}

static bool read_guide(const struct source *source, const char *const *names,
                       int n_threads, float **samples, struct image_error *error)
{
    int channels[3];
    if (!find_guide(source, names, channels) || !beside_has_window(source, channels[0]))
        return true;
    return read_channels(source->colour, channels,
                         (size_t)source->width * (size_t)source->height, n_threads,
                         samples, error);
}

bool denoise_read_guides(const struct source *source, const struct denoise_files *files,
                         int n_threads, struct denoise_guides *guides,
                         struct image_error *error)
{
    *guides = (struct denoise_guides){0};
    bool is_read =
        files && files->albedo
            ? read_file(source, files->albedo, "--albedo-file", albedo_names, n_threads,
                        &guides->albedo, error)
            : read_guide(source, albedo_names, n_threads, &guides->albedo, error);
    /* Normals without an albedo are of no use to OIDN. */
    if (!is_read || !guides->albedo)
        return is_read;
    return files && files->normal
               ? read_file(source, files->normal, "--normal-file", normal_names,
                           n_threads, &guides->normal, error)
               : read_guide(source, normal_names, n_threads, &guides->normal, error);
}
