/* SPDX-License-Identifier: Apache-2.0 */
#include "input/image.h"

#include "base/error.h"

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
    return RF_OK;
}
