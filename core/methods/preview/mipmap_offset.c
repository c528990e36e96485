/* SPDX-License-Identifier: Apache-2.0 */
/*
 * mipmap-offset: four diagonally shifted copies of one level of detail, averaged.
 *
 *   Q_l(p) = mean of P_l(p + d) over d = (+-T/2, +-T/2),  P_l as in mipmap.c, T = 2^l
 *   Q_0 = the picture
 *   T = sqrt(1 + (2^b r)^2 / 2),  l and t from T, (1 - t) Q_l + t Q_l+1 as there
 *
 * Shifted by half a sample either way, the corners of the bilinear surface P_l fall
 * onto the corners between the samples in all four copies; so Q_l is itself bilinear
 * there, its value at a corner the mean of the four samples around. It is built once
 * per level, and a pixel costs what it costs in mipmap.
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "offset on mipmaps": one level, four diagonal shifts, average of the four. The mix of
 * two levels, which hides the steps of the blend coc, is ours, and so is the shift,
 * which the thesis leaves open. Mean square distance: T^2/4 of mipmap and T^2/4 of the
 * shifts are that of a disc of radius sqrt(2) T.
 *
 * Known artefacts: softer squares than mipmap's; gathers by the pixel's own radius.
 *
 * Cost: the same for every radius; two thirds of the picture more to build, eight taps.
 */
#include "methods/preview/mipmap_offset.h"

#include <math.h>

#include "input/frame.h"
#include "methods/preview/blur.h"
#include "methods/preview/pyramid.h"
#include "rackfocus/rackfocus.h"

rf_result rf_generate_mipmap_offset(const struct rf_blur *blur, struct rf_error *error)
{
    const struct rf_frame *f = blur->frame;
    float scale = (float)(pow(4, f->params.mipmap_bias) / 2);
    struct rf_pyramid pyramid;
    rf_result result = rf_pyramid_build(&pyramid, blur, true, error);
    if (result == RF_OK)
        rf_pyramid_sample(&pyramid, blur, scale);
    rf_pyramid_free(&pyramid, f->context);
    return result;
}
