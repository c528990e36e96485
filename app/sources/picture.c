/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/picture.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "common/report.h"
#include "file.h"
#include "path.h"
#include "sources/choice.h"

static bool is_png(const char *path)
{
    static const unsigned char magic[8] = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    unsigned char bytes[8] = {0};
    const bool is_file = os_file_facts(path).kind == OS_FILE_REGULAR;
    FILE *file = is_file ? fopen(path, "rb") : NULL;
    if (!file)
        return false; /* the reader says why */
    const size_t n = fread(bytes, 1, sizeof(bytes), file);
    fclose(file);
    return n == sizeof(bytes) && memcmp(bytes, magic, sizeof(bytes)) == 0;
}

static bool read_png(const char *path, struct picture *picture,
                     struct image_error *error)
{
    float *rgba;
    if (!image_read_png(path, &rgba, &picture->width, &picture->height, error))
        return false;
    const size_t n = (size_t)picture->width * (size_t)picture->height;
    memcpy(picture->primaries.xy, image_rec709, sizeof(image_rec709));
    picture->samples = app_memory(3 * n, sizeof(float), error);
    for (size_t i = 0; picture->samples && i < n; i++)
        for (size_t c = 0; c < 3; c++)
            picture->samples[3 * i + c] = rgba[4 * i + c];
    free(rgba);
    return picture->samples != NULL;
}

static bool read_open_exr(struct image_input *input, const char *layer, int n_threads,
                          struct picture *picture, struct image_error *error)
{
    struct image_layer found;
    if (!image_find_layer(input, layer, NULL, false, &found, error))
        return false;
    int n;
    const int part = image_channels(input, &n)[found.r].part;
    const struct image_part_info *info = &image_parts(input, &n)[part];
    const struct image_box box = info->data_window;
    picture->window = box;
    picture->display = info->display_window;
    picture->pixel_aspect = info->pixel_aspect;
    picture->has_window = true;
    primaries_read(input, part, &picture->primaries);
    choice_is_doubtful(input, &found, layer, picture->doubt, sizeof(picture->doubt));
    picture->width = box.max_x - box.min_x + 1;
    picture->height = box.max_y - box.min_y + 1;
    const size_t n_pixels = (size_t)picture->width * (size_t)picture->height;
    picture->samples = app_memory(3 * n_pixels, sizeof(float), error);
    return picture->samples &&
           image_read_layer(input, &found, 3, picture->samples, n_threads, error);
}

static bool check_finite(const char *path, const struct picture *picture,
                         struct image_error *error)
{
    const size_t n = 3 * (size_t)picture->width * (size_t)picture->height;
    size_t n_bad = 0, first = 0;
    for (size_t i = 0; i < n; i++)
        if (!isfinite(picture->samples[i]) && n_bad++ == 0)
            first = i / 3;
    if (n_bad == 0)
        return true;
    set_error(error,
              "%s: %zu values are NaN or infinite, the first at pixel (%d, %d); "
              "pictures with such values have no distance, render or repair them first",
              path, n_bad,
              picture->window.min_x + (int)(first % (size_t)picture->width),
              picture->window.min_y + (int)(first / (size_t)picture->width));
    return false;
}

bool picture_read(const char *path, const char *layer, int n_threads,
                  struct picture *picture, struct image_error *error)
{
    *picture = (struct picture){0};
    bool is_read;
    if (is_png(path)) {
        is_read = read_png(path, picture, error);
    } else {
        struct image_input *input;
        is_read = image_open(&input, path, error);
        if (is_read) {
            is_read = read_open_exr(input, layer, n_threads, picture, error);
            image_close(input);
        }
    }
    if (is_read && check_finite(path, picture, error))
        return true;
    picture_free(picture);
    return false;
}

bool picture_windows_meet(const struct image_box *a, const struct image_box *b,
                          struct image_box *both)
{
    both->min_x = a->min_x > b->min_x ? a->min_x : b->min_x;
    both->min_y = a->min_y > b->min_y ? a->min_y : b->min_y;
    both->max_x = a->max_x < b->max_x ? a->max_x : b->max_x;
    both->max_y = a->max_y < b->max_y ? a->max_y : b->max_y;
    return both->min_x <= both->max_x && both->min_y <= both->max_y;
}

float *picture_show_window(const float *samples, size_t n_channels,
                           const struct image_box *own, const struct image_box *other,
                           struct image_error *error)
{
    const size_t own_width = (size_t)(own->max_x - own->min_x + 1);
    const size_t width = (size_t)(other->max_x - other->min_x + 1);
    const size_t height = (size_t)(other->max_y - other->min_y + 1);
    struct image_box both;
    float *shown = app_memory(width * height, n_channels * sizeof(float), error);
    if (!shown || !picture_windows_meet(own, other, &both))
        return shown;
    const size_t n_row = (size_t)(both.max_x - both.min_x + 1) * n_channels;
    for (int32_t y = both.min_y; y <= both.max_y; y++) {
        const size_t from =
            (size_t)(y - own->min_y) * own_width + (size_t)(both.min_x - own->min_x);
        const size_t to =
            (size_t)(y - other->min_y) * width + (size_t)(both.min_x - other->min_x);
        memcpy(shown + to * n_channels, samples + from * n_channels,
               n_row * sizeof(float));
    }
    return shown;
}

bool picture_check_place(const char *path, const struct image_box *window,
                         const char *other, const struct image_box *other_window,
                         struct image_error *error)
{
    if (window->min_x == other_window->min_x && window->min_y == other_window->min_y)
        return true;
    const struct image_box *a = window, *b = other_window;
    return set_error(
        error,
        "%.300s: its data window is (%d, %d) to (%d, %d), that of %.300s (%d, "
        "%d) to (%d, %d): they are of one size, but not of one place; "
        "write both with one window, or move one that has lost its place: "
        "oiiotool %.100s --origin %+d%+d -o moved.exr",
        path, (int)a->min_x, (int)a->min_y, (int)a->max_x, (int)a->max_y, other,
        (int)b->min_x, (int)b->min_y, (int)b->max_x, (int)b->max_y, path, (int)b->min_x,
        (int)b->min_y);
}

void picture_free(struct picture *picture)
{
    free(picture->samples);
    picture->samples = NULL;
}

enum picture_kind picture_kind(const char *path)
{
    const char *dot = strrchr(path, '.');
    if (dot && strcasecmp(dot, ".exr") == 0)
        return PICTURE_EXR;
    if (dot && strcasecmp(dot, ".png") == 0)
        return PICTURE_PNG;
    return PICTURE_UNKNOWN;
}

bool picture_check_kind(const char *path, struct image_error *error)
{
    /* What people ask for, and what makes it of what is written. */
    static const struct {
        const char *ending, *name, *instead, *command;
    } others[] = {
        {".jpg", "JPEG", ".png", "magick NAME.png NAME.jpg"},
        {".jpeg", "JPEG", ".png", "magick NAME.png NAME.jpeg"},
        {".tif", "TIFF", ".exr", "oiiotool NAME.exr -o NAME.tif"},
        {".tiff", "TIFF", ".exr", "oiiotool NAME.exr -o NAME.tiff"},
        {".hdr", "Radiance HDR", ".exr", "oiiotool NAME.exr -o NAME.hdr"},
        {".webp", "WebP", ".png", "magick NAME.png NAME.webp"},
    };
    const char *dot = strrchr(path, '.');
    if (picture_kind(path) != PICTURE_UNKNOWN)
        return true;
    for (size_t i = 0; dot && i < sizeof(others) / sizeof(others[0]); i++)
        if (strcasecmp(dot, others[i].ending) == 0)
            return set_error(
                error,
                "%s: pictures are written as EXR or PNG, not as %s; end the "
                "name in %s and convert the picture: %s",
                path, others[i].name, others[i].instead, others[i].command);
    if (os_file_facts(path).kind == OS_FILE_OTHER)
        return set_error(error,
                         "%s: is no file on a disk; name the standard output -, as in "
                         "rackfocus filter in.exr -o - --format png > out.png",
                         path);
    return set_error(
        error, "%s: pictures are written as EXR or PNG; end the name in .exr or .png",
        path);
}

bool picture_is_scene(const char *path)
{
    const char *dot = strrchr(path, '.');
    return dot && (strcasecmp(dot, ".pov") == 0 || strcasecmp(dot, ".ini") == 0);
}

bool picture_check_writable(const char *path, struct image_error *error)
{
    const char *name = os_path_name(path);
    char *folder = name > path ? strndup(path, (size_t)(name - path)) : strdup(".");
    const int reason = folder ? os_folder_is_writable(folder) : ENOMEM;
    free(folder);
    const enum os_file_kind kind = os_file_facts(path).kind;
    const int why_none = errno;
    if (reason != 0)
        set_error(error,
                  "%s: cannot write into its folder: %s; create it or choose another",
                  path, strerror(reason));
    else if (kind == OS_FILE_FOLDER)
        set_error(error, "%s: is a folder; give the name of a file in it", path);
    else if (kind == OS_FILE_NONE && why_none == ENAMETOOLONG)
        set_error(
            error,
            "%.300s: the name is too long for its file system; give a shorter one",
            path);
    else
        return true;
    return false;
}

bool picture_need_folder(const char *path, enum os_folder_end end,
                         struct image_error *error)
{
    const int reason = os_folder_make_to_fill(path, end);
    return reason == 0 || os_file_facts(path).kind == OS_FILE_FOLDER ||
           set_error(error, "%s: cannot make the folder: %s", path, strerror(reason));
}

size_t picture_clip_to_half(float *samples, size_t n)
{
    const float half_max = 65504;
    size_t n_clipped = 0;
    for (size_t i = 0; i < n; i++) {
        if (fabsf(samples[i]) <= half_max)
            continue;
        samples[i] = copysignf(half_max, samples[i]);
        n_clipped++;
    }
    return n_clipped;
}

int picture_warn_clipped(const struct app_host *host, const char *path,
                         size_t n_clipped, struct image_error *error)
{
    return n_clipped == 0 ? APP_DONE
                          : app_warn(host, error,
                                     "%s: %zu values above 65504 were clipped to it, "
                                     "the largest half; float samples (--type float) "
                                     "keep them",
                                     path, n_clipped);
}
