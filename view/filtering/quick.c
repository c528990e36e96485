/* SPDX-License-Identifier: Apache-2.0 */
#include "filtering/quick.h"

#include "pixels/input.h"

bool quick_is_preview(int32_t method)
{
    return rf_method_find(method)->has_blend;
}

struct rf_params quick_params(const struct job *job)
{
    struct rf_params params = job->params;
    if (quick_is_preview(params.method))
        return params;
    if (!job->input->raw || params.optics == RF_OPTICS_BUFFER) {
        /* One picture with planar depth stands for the views. */
        params.depth = RF_DEPTH_PLANAR;
        params.depth_scale = 1;
        params.depth_offset = 0;
        if (params.optics == RF_OPTICS_BUFFER)
            params.optics = RF_OPTICS_CAMERA;
    }
    if (params.method == RF_METHOD_LAYERED || params.method == RF_METHOD_VIEWS) {
        params.method = RF_METHOD_LAYERED;
        params.quality = RF_QUALITY_PREVIEW;
        return params;
    }
    params.method = RF_METHOD_MIPMAP_OFFSET;
    params.blend = RF_BLEND_COC;
    params.leak_control = RF_LEAK_NONE;
    params.leave_focus_out = 0;
    return params;
}
