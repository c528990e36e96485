/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Blend coc: every pixel is blurred by its own circle of confusion.
 *
 *   out(p) = G(c; |r_p|)(p)        alpha(p) = min(1, |r_p|)
 *
 *   G   the generator     c   the picture     r_p   radius of the pixel, px
 *   alpha   how far the pixel is out of focus; used by leak control only, see leak.c
 *
 * Source: ours; the thesis (docs/methods.md) has one strength of blur and mixes, a
 * level of detail chosen by the depth of the pixel is what it names as the way on.
 *
 * Approximates scattering by gathering: right where the radius hardly changes from
 * pixel to pixel. Known artefacts: blurred foregrounds end at their outline; what is in
 * focus runs into the blurred surroundings.
 *
 * Cost: the generator's and nothing else.
 */
#include "methods/preview/blend_coc.h"

#include <math.h>
#include <stddef.h>

#include "methods/preview/blur.h"
#include "methods/preview/leak.h"
#include "rackfocus/rackfocus.h"

static void alpha_of(const struct rf_preview *preview, const void *user, int x, int y,
                     int n, float *alpha)
{
    const float *r =
        preview->work->radius + (size_t)y * (size_t)preview->sharp.width + (size_t)x;
    for (int i = 0; i < n; i++)
        alpha[i] = rf_minf(fabsf(r[i]), 1);
}

rf_result rf_blend_coc(struct rf_preview *preview, struct rf_error *error)
{
    const struct rf_params *p = &preview->work->frame->params;
    if (p->leak_control != RF_LEAK_NONE || p->leave_focus_out ||
        p->stage != RF_STAGE_RESULT) {
        struct rf_layer layer = {.preview = preview,
                                 .radius_map = preview->work->radius,
                                 .alpha = alpha_of,
                                 .progress_from = 0.1,
                                 .progress_to = 1};
        return rf_layer_run(&layer, error);
    }
    struct rf_blur blur = {.frame = preview->work->frame,
                           .task = preview->work->task,
                           .source = &preview->sharp,
                           .radius_map = preview->work->radius,
                           .progress_from = 0.1,
                           .progress_to = 1,
                           .put = rf_put_planes,
                           .user = preview->work};
    return preview->generate(&blur, error);
}
