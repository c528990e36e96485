/* SPDX-License-Identifier: Apache-2.0 */
#include "png_rows.h"

#include <math.h>

#include "srgb.h"

/* NaN becomes 0. */
static float clip01(float value)
{
    return value > 0.0f ? (value < 1.0f ? value : 1.0f) : 0.0f;
}

void png_encode_row(const float *in, int32_t width, int n_channels, int bits,
                    bool is_encoded, uint8_t *out)
{
    float top = bits == 8 ? 255.0f : 65535.0f;
    for (int32_t x = 0; x < width; x++, in += n_channels) {
        float alpha = n_channels == 4 ? clip01(in[3]) : 1.0f;
        for (int c = 0; c < n_channels; c++) {
            float value = in[c];
            if (c == 3)
                value = alpha;
            else if (!is_encoded)
                value = srgb_encode(clip01(alpha > 0.0f ? value / alpha : value));
            long whole = lrintf(clip01(value) * top);
            if (bits == 16)
                *out++ = (uint8_t)(whole >> 8);
            *out++ = (uint8_t)(whole & 0xff);
        }
    }
}

void png_decode_row(const uint8_t *in, int32_t width, int bits, float *out)
{
    float scale = bits == 8 ? 1.0f / 255.0f : 1.0f / 65535.0f;
    for (int32_t x = 0; x < width; x++, out += 4) {
        for (int c = 0; c < 4; c++) {
            unsigned whole = *in++;
            if (bits == 16)
                whole = whole << 8 | *in++;
            out[c] = (float)whole * scale;
        }
        for (int c = 0; c < 3; c++)
            out[c] = srgb_decode(out[c]) * out[3];
    }
}
