/* SPDX-License-Identifier: Apache-2.0 */
/* What rf_filter_seen_depth() takes, checked. */
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "api/filter.h"
#include "api/seen.h"
#include "base/context.h"
#include "base/error.h"
#include "base/pool.h"
#include "input/image.h"
#include "input/pixels.h"
#include "input/seen_depth.h"
#include "input/views_in.h"
#include "rackfocus/rackfocus.h"

static rf_result check_search(const struct rf_filter *filter,
                              const struct rf_view *views, int32_t n_views,
                              const struct rf_image *lights, const struct rf_image *out,
                              struct rf_error *error)
{
    if (!filter || !views || !lights || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT,
                       !filter   ? "filter"
                       : !views  ? "views"
                       : !lights ? "lights"
                                 : "out",
                       "a pointer is NULL");
    if (n_views < 2 || n_views > RF_MAX_VIEWS)
        return rf_fail(error, RF_ERROR_ARGUMENT, "n_views",
                       "%d views were given; what is seen in mirrors is found from 2 "
                       "to %d",
                       n_views, RF_MAX_VIEWS);
    return rf_view_check_size(views, error);
}

static rf_result check_images(const struct rf_frame *f, const struct rf_view *views,
                              int n_views, const struct rf_image *lights,
                              const struct rf_image *out, struct rf_error *error)
{
    int w = f->width, h = f->height;
    rf_result result = rf_image_check_out(out, "out", w, h, 1, error);
    if (result == RF_OK)
        result = rf_image_check(&views[0].colour, "colour", w, h, error);
    if (result == RF_OK)
        result = rf_image_check_one(&views[0].depth, "depth", w, h, error);
    for (int j = 0; j < n_views && result == RF_OK; j++) {
        const struct rf_seen_light light = {lights[j], views[0].depth};
        result = rf_seen_check_light(f, views, &light, error);
        if (result == RF_OK)
            result = rf_view_check_place(&views[j], error);
    }
    return result;
}

rf_result rf_filter_seen_depth(const struct rf_filter *filter,
                               const struct rf_view *views, int32_t n_views,
                               const struct rf_image *lights,
                               const struct rf_image *out, struct rf_error *error)
{
    struct rf_view known[RF_MAX_VIEWS];
    rf_result result = check_search(filter, views, n_views, lights, out, error);
    if (result != RF_OK)
        return result;
    const struct rf_frame *f = &filter->frame;
    rf_views_copy(known, views, n_views);
    result = check_images(f, known, n_views, lights, out, error);
    if (result != RF_OK)
        return result;
    size_t n = (size_t)f->width * (size_t)f->height;
    float *planar = rf_alloc(f->context, n, sizeof *planar);
    if (!planar)
        return rf_fail_memory(error, n, sizeof *planar);
    result = rf_seen_find(f, known, n_views, lights, planar, error);
    const struct rf_image packed = rf_image_packed(planar, f->width, f->height, 1);
    if (result == RF_OK)
        rf_image_copy(&packed, out);
    rf_free(f->context, planar);
    return result;
}

rf_result rf_filter_seen_way(const struct rf_filter *filter, const struct rf_view *view,
                             const struct rf_image *light, const struct rf_image *way,
                             const struct rf_image *out, struct rf_error *error)
{
    struct rf_view known;
    if (!filter || !view || !light || !way || !out)
        return rf_fail(error, RF_ERROR_ARGUMENT, "", "a pointer is NULL");
    const struct rf_frame *f = &filter->frame;
    rf_result result = rf_view_check_size(view, error);
    if (result != RF_OK)
        return result;
    rf_views_copy(&known, view, 1);
    result = check_images(f, &known, 1, light, out, error);
    if (result == RF_OK)
        result = rf_image_check_one(way, "way", f->width, f->height, error);
    if (result != RF_OK)
        return result;
    size_t n = (size_t)f->width * (size_t)f->height;
    float *planar = rf_alloc(f->context, n, sizeof *planar);
    if (!planar)
        return rf_fail_memory(error, n, sizeof *planar);
    const struct rf_image packed = rf_image_packed(planar, f->width, f->height, 1);
    rf_image_copy(way, &packed);
    result = rf_seen_keep_flat(f, &known, light, planar, error);
    if (result == RF_OK)
        rf_image_copy(&packed, out);
    rf_free(f->context, planar);
    return result;
}
