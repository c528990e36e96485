/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/png_picture.h"

#include <stdlib.h>
#include <string.h>

#include "sources/picture.h"
#include "sources/primaries.h"

static const char *name_of(const struct png_picture *picture)
{
    return picture->name ? picture->name : image_path(picture->source->colour);
}

/* ---- what a PNG cannot hold ------------------------------------------------------- */

/*
 * Pixels that a PNG shows as transparent though they have light: more than UNSEEN, of an
 * alpha that 8 bits round to 0.
 */
static size_t count_unseen(const struct png_picture *picture)
{
    static const float UNSEEN = 0.02f, NO_ALPHA = 0.5f / 255;
    const struct source *source = picture->source;
    const size_t n = (size_t)source->width * (size_t)source->height;
    size_t n_unseen = 0;
    for (size_t i = 0; source->n_channels == 4 && i < n; i++) {
        const float *c = picture->samples + 4 * i;
        n_unseen +=
            c[3] < NO_ALPHA && (c[0] > UNSEEN || c[1] > UNSEEN || c[2] > UNSEEN);
    }
    return n_unseen;
}

static int warn_of_unseen(const struct app_host *host, const char *path,
                          const struct png_picture *picture, struct image_error *error)
{
    const struct source *source = picture->source;
    const double n = (double)source->width * (double)source->height;
    const double share = (double)count_unseen(picture) / n;
    if (share < 0.01)
        return APP_DONE;
    return app_warn(
        host, error,
        "%s: %.0f %% of the picture have light but no alpha, as skies of "
        "V-Ray and Arnold do, and a PNG shows them as transparent; write "
        ".exr, or take the alpha out of the input: oiiotool %s --ch R,G,B,Z "
        "-d Z=float -o opaque.exr",
        path, 100 * share, name_of(picture));
}

/* Colours of ACEScg and the like, which a PNG shows paler. */
static int warn_of_primaries(const struct app_host *host, const char *path,
                             const struct png_picture *picture,
                             struct image_error *error)
{
    const struct source *source = picture->source;
    struct primaries found;
    primaries_read(source->colour, source->part, &found);
    return found.by && !picture->is_of_scene
               ? app_warn(host, error,
                          "%s: the colours are not of Rec. 709, by %s in the header of "
                          "%s, and a PNG shows them as if they were, paler; write .exr "
                          "and make the PNG of it, for ACEScg: oiiotool out.exr "
                          "--colorconvert ACEScg sRGB -o out.png",
                          path, found.by, name_of(picture))
               : APP_DONE;
}

/* ---- the display window ------------------------------------------------------------ */

/* The pixels of the display window, to be freed; NULL on failure. */
static float *place(const char *path, const struct png_picture *picture,
                    struct image_error *error)
{
    const struct source *source = picture->source;
    const struct image_box *data = &source->info.data_window;
    const struct image_box *display = &source->info.display_window;
    struct image_box both;
    if (picture_windows_meet(data, display, &both))
        return picture_show_window(picture->samples, (size_t)source->n_channels, data,
                                   display, error);
    set_error(error,
              "%s: a PNG shows the display window of %s, in which nothing of its "
              "data window lies; write .exr",
              path, name_of(picture));
    return NULL;
}

/* A window that is larger than any picture is damaged or no window of a picture. */
static bool check_size(const char *path, const struct png_picture *picture,
                       int64_t width, int64_t height, struct image_error *error)
{
    return (width > 0 && height > 0 && width <= IMAGE_MAX_SIDE &&
            height <= IMAGE_MAX_SIDE) ||
           set_error(error,
                     "%s: a PNG shows the display window of %s, which has %lld x %lld "
                     "px; write .exr",
                     path, name_of(picture), (long long)width, (long long)height);
}

bool png_picture_write(const struct app_host *host, const char *path,
                       const struct png_picture *picture, struct image_error *error)
{
    const struct source *source = picture->source;
    const struct image_box *display = &source->info.display_window;
    const int64_t width = (int64_t)display->max_x - display->min_x + 1;
    const int64_t height = (int64_t)display->max_y - display->min_y + 1;
    if (warn_of_unseen(host, path, picture, error) != APP_DONE ||
        warn_of_primaries(host, path, picture, error) != APP_DONE ||
        !check_size(path, picture, width, height, error))
        return false;
    const bool is_whole =
        memcmp(display, &source->info.data_window, sizeof(*display)) == 0;
    float *placed = is_whole ? NULL : place(path, picture, error);
    const bool is_written =
        (is_whole || placed) &&
        image_write_png(path, placed ? placed : picture->samples, (int32_t)width,
                        (int32_t)height, source->n_channels, picture->bits, false,
                        error);
    free(placed);
    return is_written;
}
