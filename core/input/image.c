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
