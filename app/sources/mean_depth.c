/* SPDX-License-Identifier: Apache-2.0 */
#include "sources/mean_depth.h"

#include <stdlib.h>
#include <string.h>

#include "common/report.h"
#include "sources/beside.h"
#include "sources/planar_means.h"

static int find_channel(const struct source *source)
{
    int n;
    image_channels(source->colour, &n);
    for (int c = 0; c < n; c++)
        if (beside_is(source, c, "Denoising Depth", 2) && beside_has_window(source, c))
            return c;
    return -1;
}

bool mean_depth_is_there(const struct source *source)
{
    return find_channel(source) >= 0;
}

bool mean_depth_is_used(const struct rf_params *params)
{
    return rf_method_find(params->method)->has_layers && params->split_edges &&
           params->quality != RF_QUALITY_PREVIEW && params->depth == RF_DEPTH_PLANAR;
}

bool mean_depth_read_rays(const struct source *source, int n_threads, float **rays,
                          struct image_error *error)
{
    const size_t n = (size_t)source->width * (size_t)source->height;
    const int channel = find_channel(source);
    *rays = NULL;
    if (channel < 0)
        return true;
    *rays = app_memory(n, sizeof(float), error);
    return *rays && image_read(source->colour, &channel, 1, *rays, n_threads, error);
}

bool mean_depth_make(const struct rf_lens *lens, const struct rf_params *params,
                     const float *rays, struct rf_view *view, struct image_error *error)
{
    const int32_t width = view->depth.width, height = view->depth.height;
    const size_t n = (size_t)width * (size_t)height;
    float *mean = app_memory(n, sizeof(float), error);
    float *scratch = mean ? app_memory(n, sizeof(float), error) : NULL;
    const bool has_room = scratch;
    if (has_room)
        memcpy(mean, rays, n * sizeof(*mean));
    if (has_room && planar_means_make(lens, params, view, mean, scratch))
        view->mean_depth = rf_image_packed(mean, width, height, 1);
    else
        free(mean);
    free(scratch);
    return has_room;
}
