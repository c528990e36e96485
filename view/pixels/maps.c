/* SPDX-License-Identifier: Apache-2.0 */
#include "pixels/maps.h"

#include <math.h>

#include "pixels/input.h"

bool maps_radius(const struct rf_context *context, const struct job *job, float *radius,
                 struct rf_error *error)
{
    struct rf_filter *filter;
    const struct input *input = job->input;
    struct rf_params params = job->params;
    if (!input->raw) {
        params.depth = RF_DEPTH_PLANAR;
        params.depth_scale = 1;
        params.depth_offset = 0;
    }
    if (rf_filter_create(&filter, context, &params, input->width, input->height,
                         error) != RF_OK)
        return false;
    const struct rf_image out = rf_image_packed(radius, input->width, input->height, 1);
    struct rf_image depth = out;
    depth.data = (void *)(input->raw ? input->raw : input->planar);
    const rf_result result = rf_filter_coc(filter, &depth, &out, error);
    rf_filter_destroy(filter);
    return result == RF_OK;
}

double maps_full_radius(const float *radius, size_t n)
{
    float largest = 0;
    for (size_t i = 0; i < n; i++)
        largest = fmaxf(largest, fabsf(radius[i]));
    return fmax(largest, 2);
}
