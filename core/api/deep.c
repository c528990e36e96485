/* SPDX-License-Identifier: Apache-2.0 */
/* Deep frames: checks, and the way to the method. */
#include <stddef.h>

#include "api/chroma.h"
#include "api/filter.h"
#include "base/error.h"
#include "base/task.h"
#include "input/field.h"
#include "input/frame.h"
#include "compose/light_map.h"
#include "input/pixels.h"
#include "methods/layered/deep.h"
#include "rackfocus/rackfocus.h"

static rf_result check(const struct rf_filter *filter, const struct rf_deep *deep,
                       const struct rf_image *out, const char *name,
                       struct rf_error *error)
{
    if (!filter || !deep || !out || !deep->first ||
        (!deep->samples && deep->width > 0 && deep->height > 0 &&
         deep->first[(size_t)deep->width * (size_t)deep->height] > 0))
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter ? "filter"
                       : !out  ? name
                               : "deep",
                       "a pointer is NULL");
    const struct rf_frame *f = &filter->frame;
    if (deep->width != f->width || deep->height != f->height)
        return rf_fail(error, RF_ERROR_ARGUMENT, "deep",
                       "the deep frame is %d x %d px, but the filter was made for %d x "
                       "%d px",
                       deep->width, deep->height, f->width, f->height);
    return rf_image_check_out(out, name, f->width, f->height, 0, error);
}

rf_result rf_filter_process_deep(const struct rf_filter *filter,
                                 const struct rf_deep *deep, const struct rf_image *out,
                                 const struct rf_progress *progress,
                                 struct rf_error *error)
{
    rf_result result = check(filter, deep, out, "out", error);
    if (result != RF_OK)
        return result;
    if (!rf_method_find(filter->frame.params.method)->can_deep)
        return rf_fail(error, RF_ERROR_PARAMETER, "method",
                       "deep frames are filtered by the method layered only; flatten "
                       "them for the others");
    const struct rf_params *params = &filter->frame.params;
    if (rf_field_is_on(params))
        return rf_fail(error, RF_ERROR_PARAMETER, rf_field_param(params),
                       "tilt, field-curvature and split-diopter are not for deep "
                       "frames; set them to 0 or flatten the frames");
    if (rf_chroma_is_on(&filter->frame, out->channels))
        return rf_fail(error, RF_ERROR_PARAMETER, rf_chroma_field(&filter->frame),
                       "chroma and an aperture in colour are not for deep frames; set "
                       "it to 0 or flatten the frames");
    struct rf_task task;
    rf_task_begin(&task, progress);
    if (rf_task_is_cancelled(&task))
        return rf_fail(error, RF_ERROR_CANCELLED, "", "cancelled");
    result = rf_deep_run(&filter->frame, deep, out, &task, error);
    if (result == RF_OK)
        result = rf_take_vignette(&filter->frame, 0, 0, out, error);
    if (result == RF_OK)
        rf_task_end(&task);
    return result;
}

rf_result rf_deep_flatten(const struct rf_filter *filter, const struct rf_deep *deep,
                          const struct rf_image *colour, const struct rf_image *depth,
                          struct rf_error *error)
{
    rf_result result = check(filter, deep, colour, "colour", error);
    if (result == RF_OK && depth)
        result =
            rf_image_check_out(depth, "depth", deep->width, deep->height, 1, error);
    return result == RF_OK
               ? rf_deep_flatten_to(&filter->frame, deep, colour, depth, error)
               : result;
}
