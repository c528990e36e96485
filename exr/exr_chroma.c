/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Luminance and chroma (Y RY BY) to R G B. With w the weights of R, G and B in Y,
 *
 *   RY = (R - Y) / Y,  BY = (B - Y) / Y
 *   R = (RY + 1) Y,    B = (BY + 1) Y,    G = (Y - w_r R - w_b B) / w_g
 *
 * Chroma is stored at every second pixel of every second row; what lies between comes
 * from the filter of 13 taps per side that OpenEXR's own reader uses (ImfRgbaYca),
 * first along the rows, then along the columns. The weights follow from the header's
 * chromaticities, those of Rec. 709 without.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "exr_private.h"

static const float taps[] = {0.627123f, -0.186077f, 0.087929f, -0.043159f,
                             0.019597f, -0.007540f, 0.002128f};
enum { N_TAPS = sizeof taps / sizeof taps[0] };

/* Fills odd places 1, 3, ... of a line of n values from the even ones. */
static void fill_line(const float *line, size_t stride, int32_t n, float *out)
{
    int32_t last = (n - 1) / 2 * 2;
    for (int32_t i = 0; i < n; i++) {
        if (i % 2 == 0) {
            out[i] = line[(size_t)i * stride];
            continue;
        }
        float sum = 0;
        for (int32_t k = 0; k < N_TAPS; k++) {
            int32_t a = i - 1 - 2 * k, b = i + 1 + 2 * k;
            a = a < 0 ? 0 : a;
            b = b > last ? last : b;
            sum += taps[k] * (line[(size_t)a * stride] + line[(size_t)b * stride]);
        }
        out[i] = sum;
    }
}

/* One chroma channel, of which only even places of even rows are its own. */
static bool fill_channel(float *samples, size_t n, int32_t width, int32_t height,
                         bool has_half_x, bool has_half_y)
{
    size_t row = (size_t)width * n;
    float *line = malloc(sizeof *line * (size_t)(width > height ? width : height));
    if (!line)
        return false;
    for (int32_t y = 0; y < height && has_half_x; y += has_half_y ? 2 : 1) {
        float *at = samples + (size_t)y * row;
        fill_line(at, n, width, line);
        for (int32_t x = 0; x < width; x++)
            at[(size_t)x * n] = line[x];
    }
    for (int32_t x = 0; x < width && has_half_y; x++) {
        float *at = samples + (size_t)x * n;
        fill_line(at, row, height, line);
        for (int32_t y = 0; y < height; y++)
            at[(size_t)y * row] = line[y];
    }
    free(line);
    return true;
}

/* Weights of R, G, B in Y: the Y row of RGB to XYZ for white at Y = 1. */
static void find_weights(const struct image_input *input, int part, double w[3])
{
    double c[8] = {0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.3127, 0.329};
    float given[8];
    if (image_find_chromaticities(input, part, given))
        for (int i = 0; i < 8; i++)
            c[i] = (double)given[i];
    double x = c[6] / c[7], z = (1 - c[6] - c[7]) / c[7], m[3][3], sum = 0;
    for (int i = 0; i < 3; i++) { /* XYZ of each primary per unit of its Y */
        m[0][i] = c[2 * i] / c[2 * i + 1];
        m[1][i] = 1;
        m[2][i] = (1 - c[2 * i] - c[2 * i + 1]) / c[2 * i + 1];
    }
    for (int i = 0; i < 3; i++) { /* Cramer: m w = (x, 1, z) */
        int j = (i + 1) % 3, k = (i + 2) % 3;
        w[i] = x * (m[1][j] * m[2][k] - m[1][k] * m[2][j]) -
               (m[0][j] * m[2][k] - m[0][k] * m[2][j]) +
               z * (m[0][j] * m[1][k] - m[0][k] * m[1][j]);
        sum += w[i];
    }
    for (int i = 0; i < 3; i++)
        w[i] /= sum;
    if (isfinite(w[0]) && w[0] > 0 && w[1] > 0.01 && w[2] > 0)
        return;
    w[0] = 0.2126, w[1] = 0.7152, w[2] = 0.0722;
}

static void to_rgb(float *p, const double w[3])
{
    double y = (double)p[0], r = ((double)p[1] + 1) * y, b = ((double)p[2] + 1) * y;
    bool is_grey = p[1] == 0 && p[2] == 0;
    p[0] = (float)(is_grey ? y : r);
    p[1] = (float)(is_grey ? y : (y - w[0] * r - w[2] * b) / w[1]);
    p[2] = (float)(is_grey ? y : b);
}

bool image_read_layer(struct image_input *input, const struct image_layer *layer, int n,
                      float *samples, int n_threads, struct image_error *error)
{
    const int channels[4] = {layer->r, layer->g, layer->b, layer->a};
    if (!image_read(input, channels, n, samples, n_threads, error))
        return false;
    if (!layer->is_chroma || n < 3)
        return true;
    int part = input->channels[layer->r].part;
    const struct image_box *box = &input->parts[part].data_window;
    int32_t width = box->max_x - box->min_x + 1, height = box->max_y - box->min_y + 1;
    for (int c = 1; c < 3; c++) {
        const struct image_channel_info *info = &input->channels[channels[c]];
        if (!fill_channel(samples + c, (size_t)n, width, height, info->x_sampling == 2,
                          info->y_sampling == 2))
            return image_lacks_memory(error, input->path);
    }
    double w[3];
    find_weights(input, part, w);
    size_t n_pixels = (size_t)width * (size_t)height;
    for (size_t i = 0; i < n_pixels; i++)
        to_rgb(samples + i * (size_t)n, w);
    return true;
}
