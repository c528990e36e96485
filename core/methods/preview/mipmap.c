/* SPDX-License-Identifier: Apache-2.0 */
/*
 * mipmap: a coarser level of detail, magnified; trilinear.
 *
 *   P_0 = the picture,  P_l+1 = means of 2 x 2 of P_l,  sample width 2^l px
 *   T = sqrt(1 + (2^b r)^2),  l = floor(log2 T),  t = T / 2^l - 1
 *   out = (1 - t) P_l + t P_l+1,  both bilinear at the pixel's centre
 *
 *   r   radius of the pixel, px      T   width of the samples to show, px
 *   b   bias, --mipmap-bias: levels added
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "mipmap": a coarser level by a bias, magnified by the graphics card. T follows from
 * the mean square distance: a sample's square (T^2/12) and the bilinear tent (T^2/6)
 * make T^2/4 per axis, that of a disc of radius T; T = 1 is the sharp picture.
 *
 * Known artefacts: squares that follow the grid of the levels and creep when things
 * move; gathers by the pixel's own radius, as all of this family.
 *
 * Cost: the same for every radius: a third of the picture more to build, eight taps.
 */
#include "methods/preview/mipmap.h"

#include <math.h>

#include "input/frame.h"
#include "methods/preview/blur.h"
#include "methods/preview/pyramid.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_mipmap(const struct rf_blur *blur, struct rf_error *error)
{
    const struct rf_frame *f = blur->frame;
    float scale = (float)pow(4, f->params.mipmap_bias);
    struct rf_pyramid pyramid;
    rf_result result = rf_pyramid_build(&pyramid, blur, false, error);
    if (result == RF_OK)
        rf_pyramid_sample(&pyramid, blur, scale);
    rf_pyramid_free(&pyramid, f->context);
    return result;
}
