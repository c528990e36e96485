/* SPDX-License-Identifier: Apache-2.0 */
#include "denoise.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "library.h"
#include "report.h"

/* ---- the library ----------------------------------------------------------------- */

/* Of its header, which is not needed to build: types are opaque, values fixed. */
enum { OIDN_DEVICE_CPU = 1, OIDN_FORMAT_FLOAT3 = 3 };

struct denoiser {
    struct os_library *library;
    void *device;
    void *(*new_device)(int type);
    void (*commit_device)(void *device);
    void (*release_device)(void *device);
    int (*get_error)(void *device, const char **text);
    void (*set_device_int)(void *device, const char *name, int value);
    void *(*new_filter)(void *device, const char *type);
    void (*set_image)(void *filter, const char *name, void *memory, int format,
                      size_t width, size_t height, size_t offset, size_t pixel_bytes,
                      size_t row_bytes);
    void (*set_bool)(void *filter, const char *name, bool value);
    void (*commit_filter)(void *filter);
    void (*execute_filter)(void *filter);
    void (*release_filter)(void *filter);
};

/* Names that the library has; version 1 had others for two functions. */
static const struct {
    size_t at;
    const char *name, *old_name;
} functions[] = {
    {offsetof(struct denoiser, new_device), "oidnNewDevice", NULL},
    {offsetof(struct denoiser, commit_device), "oidnCommitDevice", NULL},
    {offsetof(struct denoiser, release_device), "oidnReleaseDevice", NULL},
    {offsetof(struct denoiser, get_error), "oidnGetDeviceError", NULL},
    {offsetof(struct denoiser, set_device_int), "oidnSetDeviceInt", "oidnSetDevice1i"},
    {offsetof(struct denoiser, new_filter), "oidnNewFilter", NULL},
    {offsetof(struct denoiser, set_image), "oidnSetSharedFilterImage", NULL},
    {offsetof(struct denoiser, set_bool), "oidnSetFilterBool", "oidnSetFilter1b"},
    {offsetof(struct denoiser, commit_filter), "oidnCommitFilter", NULL},
    {offsetof(struct denoiser, execute_filter), "oidnExecuteFilter", NULL},
    {offsetof(struct denoiser, release_filter), "oidnReleaseFilter", NULL},
};

static const char *const library_names[] = {
    "libOpenImageDenoise.so.2", "libOpenImageDenoise.so.1", "libOpenImageDenoise.so"};

enum { N_LIBRARY_NAMES = sizeof(library_names) / sizeof(library_names[0]) };

/* The library in a folder, or the file itself, or what the system finds. */
static struct os_library *open_library(const char *place)
{
    struct os_library *library = place ? os_library_open(place) : NULL;
    for (int i = 0; i < N_LIBRARY_NAMES && !library; i++) {
        char path[4096];
        snprintf(path, sizeof(path), "%s%s%s", place ? place : "", place ? "/" : "",
                 library_names[i]);
        library = os_library_open(path);
    }
    return library;
}

static bool find_functions(struct denoiser *d, struct image_error *error)
{
    for (size_t i = 0; i < sizeof(functions) / sizeof(functions[0]); i++) {
        void *at = os_library_find(d->library, functions[i].name);
        if (!at && functions[i].old_name)
            at = os_library_find(d->library, functions[i].old_name);
        if (!at)
            return set_error(error,
                             "--denoise: the Open Image Denoise that was found has no "
                             "%s; install version 1.4 or later",
                             functions[i].name);
        memcpy((char *)d + functions[i].at, &at, sizeof(at));
    }
    return true;
}

static bool fail_library(const char *place, struct image_error *error)
{
    if (place)
        return set_error(error,
                         "RACKFOCUS_OIDN: there is no Open Image Denoise that can be "
                         "loaded at %s; name its libOpenImageDenoise or the folder "
                         "that has it",
                         place);
    return set_error(
        error, "--denoise: needs Open Image Denoise, which was not found; install "
               "it (for example with pip install pyoidn) and name the folder of "
               "its libOpenImageDenoise in the environment's RACKFOCUS_OIDN");
}

struct denoiser *denoiser_open(int n_threads, struct image_error *error)
{
    const char *place = getenv("RACKFOCUS_OIDN");
    place = place && *place ? place : NULL;
    struct denoiser *d = app_memory(1, sizeof(*d), error);
    if (!d)
        return NULL;
    d->library = open_library(place);
    const bool is_found =
        d->library ? find_functions(d, error) : fail_library(place, error);
    if (is_found) {
        d->device = d->new_device(OIDN_DEVICE_CPU);
        if (d->device) {
            d->set_device_int(d->device, "numThreads", n_threads);
            d->commit_device(d->device);
            return d;
        }
        set_error(error, "--denoise: Open Image Denoise cannot use this processor");
    }
    os_library_close(d->library);
    free(d);
    return NULL;
}

void denoiser_close(struct denoiser *d)
{
    if (!d)
        return;
    d->release_device(d->device);
    os_library_close(d->library);
    free(d);
}

/* ---- guides ---------------------------------------------------------------------- */

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

void denoise_free_guides(struct denoise_guides *guides)
{
    free(guides->albedo);
    free(guides->normal);
    *guides = (struct denoise_guides){0};
}

/* ---- pictures -------------------------------------------------------------------- */

static void set_packed(struct denoiser *d, void *filter, const char *name,
                       float *samples, const struct denoise_picture *picture)
{
    if (samples)
        d->set_image(filter, name, samples, OIDN_FORMAT_FLOAT3, (size_t)picture->width,
                     (size_t)picture->height, 0, 0, 0);
}

/* Filters packed RGB in place. */
static bool run_filter(struct denoiser *d, const struct denoise_picture *picture,
                       float *rgb, const struct denoise_guides *guides,
                       struct image_error *error)
{
    const char *text = NULL;
    void *filter = d->new_filter(d->device, "RT");
    set_packed(d, filter, "color", rgb, picture);
    set_packed(d, filter, "output", rgb, picture);
    if (guides && guides->albedo) {
        set_packed(d, filter, "albedo", guides->albedo, picture);
        set_packed(d, filter, "normal", guides->normal, picture);
        d->set_bool(filter, "cleanAux", guides->are_clean);
    }
    d->set_bool(filter, "hdr", true);
    d->commit_filter(filter);
    d->execute_filter(filter);
    d->release_filter(filter);
    if (d->get_error(d->device, &text) == 0)
        return true;
    return set_error(error, "%s: Open Image Denoise failed: %s", picture->path,
                     text ? text : "without a reason");
}

bool denoise_picture(struct denoiser *d, const struct denoise_picture *picture,
                     const struct denoise_guides *guides, struct image_error *error)
{
    const size_t n = (size_t)picture->width * (size_t)picture->height;
    const size_t n_channels = (size_t)picture->n_channels;
    const size_t n_colours = n_channels >= 3 ? 3 : 1;
    for (size_t i = 0; i < n * n_channels; i++)
        if (!isfinite(picture->samples[i]))
            return true;
    float *rgb = app_memory(n, 3 * sizeof(float), error);
    if (!rgb)
        return false;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < 3; c++)
            rgb[3 * i + c] = picture->samples[n_channels * i + (c < n_colours ? c : 0)];
    const bool is_done = run_filter(d, picture, rgb, guides, error);
    for (size_t i = 0; i < n && is_done; i++)
        for (size_t c = 0; c < n_colours; c++)
            picture->samples[n_channels * i + c] = rgb[3 * i + c];
    free(rgb);
    return is_done;
}
