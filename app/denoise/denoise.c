/* SPDX-License-Identifier: Apache-2.0 */
#include "denoise/denoise.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "common/stop.h"
#include "denoise/denoise_grain.h"
#include "denoise/denoise_lamps.h"
#include "library.h"

/* ---- the library ----------------------------------------------------------------- */

/* Of its header, which is not needed to build: types are opaque, values fixed. */
enum { OIDN_DEVICE_CPU = 1, OIDN_FORMAT_FLOAT3 = 3, OIDN_ERROR_OUT_OF_MEMORY = 4 };

/* Its numbers of enum denoise_quality, since version 2.0, 2.3 for the last. */
static const int QUALITIES[] = {6, 5, 4};

struct denoiser {
    struct os_library *library;
    void *device;
    enum denoise_quality quality;
    int n_threads;
    bool is_smeared; /* the grain: see denoise_judge_grain() */
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
    void (*set_int)(void *filter, const char *name, int value);
    void (*commit_filter)(void *filter);
    void (*execute_filter)(void *filter);
    void (*release_filter)(void *filter);
    void (*set_monitor)(void *filter, bool (*ask)(void *user, double fraction),
                        void *user);
    const bool *stop; /* see denoiser_stop_at() */
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
    {offsetof(struct denoiser, set_int), "oidnSetFilterInt", "oidnSetFilter1i"},
    {offsetof(struct denoiser, commit_filter), "oidnCommitFilter", NULL},
    {offsetof(struct denoiser, execute_filter), "oidnExecuteFilter", NULL},
    {offsetof(struct denoiser, release_filter), "oidnReleaseFilter", NULL},
    {offsetof(struct denoiser, set_monitor), "oidnSetFilterProgressMonitorFunction",
     NULL},
};

static const char *const library_names[] = {
#ifdef _WIN32
    "OpenImageDenoise.dll",
#elif defined(__APPLE__)
    "libOpenImageDenoise.2.dylib",
    "libOpenImageDenoise.dylib",
#else
    "libOpenImageDenoise.so.2",
    "libOpenImageDenoise.so.1",
    "libOpenImageDenoise.so",
#endif
};

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
                             "the Open Image Denoise that was found has no "
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
    return set_error(error,
                     "Open Image Denoise is needed and was not found; install it (for "
                     "example with pip install pyoidn) and name the folder of its "
                     "libOpenImageDenoise in the environment's RACKFOCUS_OIDN");
}

struct denoiser *denoiser_open(const char *library, enum denoise_quality quality,
                               int n_threads, struct image_error *error)
{
    const char *place = getenv("RACKFOCUS_OIDN");
    place = place && *place ? place : library;
    struct denoiser *d = app_memory(1, sizeof(*d), error);
    if (!d)
        return NULL;
    d->quality = quality;
    d->n_threads = n_threads;
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
        set_error(error, "Open Image Denoise cannot use this processor");
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

void denoiser_stop_at(struct denoiser *d, const bool *stop)
{
    d->stop = stop;
}

/* ---- pictures -------------------------------------------------------------------- */

void denoise_free_guides(struct denoise_guides *guides)
{
    free(guides->albedo);
    free(guides->normal);
    *guides = (struct denoise_guides){0};
}

/* Every step-th pixel of every step-th row of a picture, from (x, y) on. */
struct part {
    const struct denoise_picture *picture;
    size_t x, y, step;
};

static void set_packed(struct denoiser *d, void *filter, const char *name,
                       float *samples, const struct part *part)
{
    const size_t width = (size_t)part->picture->width, step = part->step;
    const size_t height = (size_t)part->picture->height, pixel = 3 * sizeof(float);
    if (samples)
        d->set_image(
            filter, name, samples, OIDN_FORMAT_FLOAT3,
            (width - part->x + step - 1) / step, (height - part->y + step - 1) / step,
            (part->y * width + part->x) * pixel, step * pixel, step * width * pixel);
}

/* Whether to go on, on any thread. */
static bool goes_on(void *user, double fraction)
{
    const struct denoiser *d = user;
    (void)fraction;
    return !is_stopped(d->stop);
}

/* Runs a filter that has its images, and releases it. */
static bool execute(struct denoiser *d, void *filter, const struct part *part,
                    struct image_error *error)
{
    const char *text = NULL;
    if (d->quality != DENOISE_HIGH) /* which it has by default, and always had */
        d->set_int(filter, "quality", QUALITIES[d->quality]);
    if (d->stop)
        d->set_monitor(filter, goes_on, d);
    d->commit_filter(filter);
    d->execute_filter(filter);
    d->release_filter(filter);
    const int reason = d->get_error(d->device, &text);
    if (reason == 0)
        return true;
    return set_error(error, "%s: Open Image Denoise failed: %s%s", part->picture->path,
                     text ? text : "without a reason",
                     reason == OIDN_ERROR_OUT_OF_MEMORY
                         ? "; free some memory, or give a smaller picture"
                         : "");
}

/* What a filter has to work on; `rgb` NULL: the guides alone. */
struct job {
    float *rgb;
    const struct denoise_guides *guides; /* may be NULL */
};

/* Runs over the parts of a picture, or all of it. */
static bool run_parts(struct denoiser *d, const struct denoise_picture *picture,
                      const struct job *job,
                      bool (*run)(struct denoiser *d, const struct part *part,
                                  const struct job *job, struct image_error *error),
                      struct image_error *error)
{
    const bool is_one = !d->is_smeared || picture->width < 2 || picture->height < 2;
    const size_t step = is_one ? 1 : 2;
    for (size_t y = 0; y < step; y++)
        for (size_t x = 0; x < step; x++)
            if (!run(d, &(struct part){picture, x, y, step}, job, error))
                return false;
    return true;
}

void denoise_judge_grain(struct denoiser *d, const struct denoise_picture *picture,
                         const struct denoise_guides *guides)
{
    d->is_smeared = denoise_is_smeared(picture, guides);
}

static bool clean_part(struct denoiser *d, const struct part *part,
                       const struct job *job, struct image_error *error)
{
    float *const samples[] = {job->guides->albedo, job->guides->normal};
    static const char *const names[] = {"albedo", "normal"};
    for (int i = 0; i < 2; i++) {
        if (!samples[i])
            continue;
        void *filter = d->new_filter(d->device, "RT");
        set_packed(d, filter, names[i], samples[i], part);
        set_packed(d, filter, "output", samples[i], part);
        if (!execute(d, filter, part, error))
            return false;
    }
    return true;
}

bool denoise_clean_guides(struct denoiser *d, const struct denoise_picture *picture,
                          struct denoise_guides *guides, struct image_error *error)
{
    const struct job job = {.guides = guides};
    guides->are_clean = run_parts(d, picture, &job, clean_part, error);
    return guides->are_clean;
}

/* Filters packed RGB in place. */
static bool filter_part(struct denoiser *d, const struct part *part,
                        const struct job *job, struct image_error *error)
{
    const struct denoise_guides *guides = job->guides;
    void *filter = d->new_filter(d->device, "RT");
    set_packed(d, filter, "color", job->rgb, part);
    set_packed(d, filter, "output", job->rgb, part);
    if (guides && guides->albedo) {
        set_packed(d, filter, "albedo", guides->albedo, part);
        set_packed(d, filter, "normal", guides->normal, part);
        d->set_bool(filter, "cleanAux", guides->are_clean);
    }
    d->set_bool(filter, "hdr", true);
    return execute(d, filter, part, error);
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
            rgb[3 * i + c] =
                picture->samples[n_channels * i + (c < n_colours ? c : 0)] /
                picture->white;
    const struct job job = {rgb, guides};
    const bool is_done = run_parts(d, picture, &job, filter_part, error) &&
                         denoise_keep_lamps(picture, rgb, d->n_threads, error);
    for (size_t i = 0; i < n && is_done; i++)
        for (size_t c = 0; c < n_colours; c++)
            picture->samples[n_channels * i + c] = picture->white * rgb[3 * i + c];
    free(rgb);
    return is_done;
}
