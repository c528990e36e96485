/* SPDX-License-Identifier: Apache-2.0 */
/* Albedo and normals beside the colour of a source, by the names that renderers give. */
#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "denoise.h"
#include "report.h"
#include "source.h"

/* Names of layers in the order in which they are taken. */
static const char *const albedo_names[] = {"Denoising Albedo", "denoise_albedo",
                                           "albedo", NULL};
static const char *const normal_names[] = {"Denoising Normal", "denoise_normal",
                                           "normal", "N", NULL};

/* Is a channel that of `base` (0 to 2, x y z or r g b) in a layer of that name? */
static bool is_guide(const char *channel, const char *layer, int base)
{
    const char *dot = strrchr(channel, '.');
    if (!dot || dot[1] == '\0' || dot[2] != '\0')
        return false;
    const int c = toupper((unsigned char)dot[1]);
    if (c != "XYZ"[base] && c != "RGB"[base])
        return false;
    const size_t n = strlen(layer), before = (size_t)(dot - channel);
    return before >= n && strncasecmp(dot - n, layer, n) == 0 &&
           (before == n || dot[-(ptrdiff_t)n - 1] == '.');
}

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
                if (is_guide(info[c].name, *names, base) &&
                    (base == 0 || info[c].part == info[channels[0]].part))
                    channels[n_found++] = c;
        if (n_found == 3)
            return true;
    }
    return false;
}

static bool has_window_of(const struct source *source, int channel)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    const struct image_box *box =
        &image_parts(source->colour, &n)[channels[channel].part].data_window;
    return memcmp(box, &source->info.data_window, sizeof(*box)) == 0;
}

static bool read_guide(const struct source *source, const char *const *names,
                       int n_threads, float **samples, struct image_error *error)
{
    int channels[3];
    if (!find_guide(source, names, channels) || !has_window_of(source, channels[0]))
        return true;
    const size_t n = (size_t)source->width * (size_t)source->height;
    *samples = app_memory(n, 3 * sizeof(float), error);
    if (!*samples ||
        !image_read(source->colour, channels, 3, *samples, n_threads, error))
        return false;
    for (size_t i = 0; i < 3 * n; i++)
        if (!isfinite((*samples)[i]))
            (*samples)[i] = 0;
    return true;
}

bool denoise_read_guides(const struct source *source, int n_threads,
                         struct denoise_guides *guides, struct image_error *error)
{
    *guides = (struct denoise_guides){0};
    /* Normals without an albedo are of no use to OIDN. */
    return read_guide(source, albedo_names, n_threads, &guides->albedo, error) &&
           (!guides->albedo ||
            read_guide(source, normal_names, n_threads, &guides->normal, error));
}
