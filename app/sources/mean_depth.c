/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/mean_depth.h"

#include <stdlib.h>

#include "common/report.h"
#include "sources/beside.h"
#include "sources/planar_means.h"

static int find_channel(const struct source *source)
{
    int n;
    const struct image_channel_info *channels = image_channels(source->colour, &n);
    for (int c = 0; c < n; c++)
        if (beside_is(channels[c].name, "Denoising Depth", 2) &&
            beside_has_window(source, c))
            return c;
    return -1;
}

bool mean_depth_is_there(const struct source *source)
{
    return find_channel(source) >= 0;
}

bool mean_depth_read(const struct source *source, const struct rf_lens *lens,
                     double pixel_aspect, int n_threads, struct rf_view *view,
                     struct image_error *error)
{
    const size_t n = (size_t)source->width * (size_t)source->height;
    int channel = find_channel(source);
    if (channel < 0)
        return true;
    float *mean = app_memory(n, sizeof(float), error);
    float *scratch = mean ? app_memory(n, sizeof(float), error) : NULL;
    bool is_read =
        scratch && image_read(source->colour, &channel, 1, mean, n_threads, error);
    if (is_read && planar_means_make(lens, pixel_aspect, view, mean, scratch))
        view->mean_depth = rf_image_packed(mean, source->width, source->height, 1);
    else
        free(mean);
    free(scratch);
    return is_read;
}
