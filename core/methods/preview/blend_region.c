/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Blend region: sharp inside a region around the plane in focus, a linear ramp outside.
 *
 *   out = c + alpha (G(c; R) - c)
 *   alpha = clamp(k d, 0, 1),   d = max(n - z, z - f, 0)
 *
 *   c   the picture         G(c; R)   its copy blurred by R px everywhere
 *   z   planar depth        n, f      near and far end of the region: the focus
 * distance
 *                                     -+ --region-size, or the depth of field where
 *                                     that is 0
 *   k   --region-slope per scene unit, or 1 / focus distance where that is 0
 *   R   --blur-radius, or the radius of what lies at infinity where that is 0
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "focus-region alpha": two numbers, region size and slope (there alpha = 1 in focus).
 *
 * Depth comes from the radius, 1/z = (r - bias) / scale: where the largest radius cuts
 * the radii, it is that of the cut. Known artefacts: in between, a sharp picture shows
 * through a blurred one; the colour of sharp things leaks into blurred surroundings
 * (leak control: leak.c).
 *
 * Cost: the generator's, and reading the sharp picture once more.
 */
#include "methods/preview/blend_region.h"

#include <stdbool.h>
#include <stddef.h>

#include "input/frame.h"
#include "methods/preview/blur.h"
#include "methods/preview/leak.h"
#include "rackfocus/rackfocus.h"

struct region {
    float bias, inverse_scale; /* of the lens */
    float near, far, slope;
    bool is_orthographic;
};

static struct region region_of(const struct rf_frame *f)
{
    const struct rf_params *p = &f->params;
    double near, far, s = f->lens.focus_distance;
    rf_lens_depth_of_field(&f->lens, &near, &far);
    if (p->region_size > 0) {
        near = s - p->region_size;
        far = s + p->region_size;
    }
    bool is_orthographic = f->lens.projection == RF_PROJECTION_ORTHOGRAPHIC;
    return (struct region){
        .bias = (float)f->lens.bias_px,
        .inverse_scale = (float)(1 / f->lens.scale),
        .near = (float)near,
        .far = (float)far,
        .slope = (float)(p->region_slope > 0 ? p->region_slope : 1 / s),
        .is_orthographic = is_orthographic,
    };
}

static void alpha_of(const struct rf_preview *preview, const void *user, int x, int y,
                     int n, float *alpha)
{
    const struct region *g = user;
    const float *r =
        preview->work->radius + (size_t)y * (size_t)preview->sharp.width + (size_t)x;
    for (int i = 0; i < n; i++) {
        float t = (r[i] - g->bias) * g->inverse_scale;
        float z = g->is_orthographic ? t : 1 / rf_maxf(t, 1e-20f);
        float d = rf_maxf(rf_maxf(g->near - z, z - g->far), 0);
        alpha[i] = rf_minf(d * g->slope, 1);
    }
}

rf_result rf_blend_region(struct rf_preview *preview, struct rf_error *error)
{
    struct region region = region_of(preview->work->frame);
    struct rf_layer layer = {.preview = preview,
                             .radius_px = preview->radius_px,
                             .alpha = alpha_of,
                             .alpha_user = &region,
                             .progress_from = 0.1,
                             .progress_to = 1};
    return rf_layer_run(&layer, error);
}
