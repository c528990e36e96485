/* SPDX-License-Identifier: Apache-2.0 */
#ifndef APP_LUMINANCE_H
#define APP_LUMINANCE_H

/* Of a scene-linear pixel with the primaries of BT.709; of fewer than three channels the
 * first is all light. */
static inline float luminance_of(const float *c, int n_channels)
{
    return n_channels < 3 ? c[0] : 0.2126f * c[0] + 0.7152f * c[1] + 0.0722f * c[2];
}

#endif
