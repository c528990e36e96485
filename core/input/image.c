/* SPDX-License-Identifier: Apache-2.0 */
#include "input/image.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/error.h"

enum { N_STRIDES = 3 };

/* A way through an image: n values, `bytes` from one to the next. */
struct way {
    size_t bytes;
    int n;
};

static struct way way_of(ptrdiff_t stride, int n)
{
    size_t bytes = stride < 0 ? 0 - (size_t)stride : (size_t)stride;
    return (struct way){n > 1 ? bytes : 0, n};
}

/* From the shortest to the longest stride. */
static void find_ways(const struct rf_image *image, struct way ways[N_STRIDES])
{
    ways[0] = way_of(image->channel_bytes, image->channels);
    ways[1] = way_of(image->pixel_bytes, image->width);
    ways[2] = way_of(image->row_bytes, image->height);
    for (int i = 1; i < N_STRIDES; i++)
        for (int k = i; k > 0 && ways[k].bytes < ways[k - 1].bytes; k--) {
            struct way shorter = ways[k];
            ways[k] = ways[k - 1];
            ways[k - 1] = shorter;
        }
}

/* Does the image fit into an address space, however its strides are signed? */
static bool is_within_memory(const struct rf_image *image)
{
    struct way ways[N_STRIDES];
    size_t n_bytes = sizeof(float), step;
    find_ways(image, ways);
    for (int i = 0; i < N_STRIDES; i++)
        if (__builtin_mul_overflow(ways[i].bytes, (size_t)ways[i].n - 1, &step) ||
            __builtin_add_overflow(n_bytes, step, &n_bytes))
            return false;
    return n_bytes <= (size_t)PTRDIFF_MAX / 2;
}

/* Has every value a place of its own? Each stride goes beyond all shorter ones. */
static bool is_spread_out(const struct rf_image *image)
{
    struct way ways[N_STRIDES];
    size_t n_bytes = sizeof(float);
    find_ways(image, ways);
    for (int i = 0; i < N_STRIDES; i++) {
        if (ways[i].n > 1 && ways[i].bytes < n_bytes)
            return false;
        n_bytes += ways[i].bytes * ((size_t)ways[i].n - 1);
    }
    return true;
}

rf_result rf_image_check(const struct rf_image *image, const char *name, int width,
                         int height, struct rf_error *error)
{
    if (!image || !image->data)
        return rf_fail(error, RF_ERROR_ARGUMENT, name, "the image %s has no pixels",
                       name);
    if (image->width != width || image->height != height)
        return rf_fail(error, RF_ERROR_ARGUMENT, name,
                       "%s is %d x %d px, but the picture is %d x %d px: both must be "
                       "renders of the same size",
                       name, image->width, image->height, width, height);
    int n = image->channels;
    if (n != 1 && n != 3 && n != 4)
        return rf_fail(error, RF_ERROR_ARGUMENT, name,
                       "%s has %d channels; it takes 1, 3 or 4", name, n);
    ptrdiff_t strides[] = {image->channel_bytes, image->pixel_bytes, image->row_bytes};
    for (int i = 0; i < 3; i++)
        if (strides[i] % (ptrdiff_t)sizeof(float))
            return rf_fail(error, RF_ERROR_ARGUMENT, name,
                           "the strides of %s are not multiples of 4 bytes", name);
    if (!is_within_memory(image))
        return rf_fail(
            error, RF_ERROR_ARGUMENT, name,
            "the strides of %s lead out of memory: set them in bytes, or use "
            "rf_image_packed()",
            name);
    return RF_OK;
}

rf_result rf_image_check_one(const struct rf_image *image, const char *name, int width,
                             int height, struct rf_error *error)
{
    rf_result result = rf_image_check(image, name, width, height, error);
    if (result == RF_OK && image->channels != 1)
        result = rf_fail(error, RF_ERROR_ARGUMENT, name,
                         "%s has %d channels, but it takes one: give that which holds "
                         "the distances",
                         name, image->channels);
    return result;
}

rf_result rf_image_check_out(const struct rf_image *image, const char *name, int width,
                             int height, int channels, struct rf_error *error)
{
    rf_result result = rf_image_check(image, name, width, height, error);
    if (result != RF_OK)
        return result;
    if (channels != 0 && image->channels != channels)
        return rf_fail(error, RF_ERROR_ARGUMENT, name,
                       "%s has %d channels, but it gets %d: give a view of as many",
                       name, image->channels, channels);
    if ((width > 1 && image->pixel_bytes == 0) ||
        (height > 1 && image->row_bytes == 0) ||
        (image->channels > 1 && image->channel_bytes == 0))
        return rf_fail(error, RF_ERROR_ARGUMENT, name,
                       "a stride of %s is 0, so that all it gets lands in one place: "
                       "set the strides, or use rf_image_packed()",
                       name);
    if (!is_spread_out(image))
        return rf_fail(error, RF_ERROR_ARGUMENT, name,
                       "the strides of %s put several values in one place: set them in "
                       "bytes, or use rf_image_packed()",
                       name);
    return RF_OK;
}
