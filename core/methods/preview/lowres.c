/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lowres: the picture at 1/F of its size, magnified bilinearly.
 *
 *   L(j, i) = mean of the F x F' pixels of the block (j, i)
 *   B(x, y) = bilinear in L, whose samples lie at the centres of the blocks
 *   out = c + a (B - c),   a = min(1, r^2 / F^2)
 *
 *   c   the pixel        r   its radius, px        F   --lowres-factor
 *   F'  F times the pixel aspect in whole rows, 1 at the least
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "low resolution": 128 x 128 of 1024 x 1024. There the small picture is rendered; here
 * it is averaged, which is the same picture with anti-aliasing. There is one strength
 * of blur; that smaller radii mix it with the sharp picture is ours (a keeps the mean
 * square distance: B alone is like a disc of radius F).
 *
 * Known artefacts: blocky stars around highlights, which creep when things move;
 * smaller radii show a sharp picture in a veil; nothing gets softer than F.
 *
 * Cost: the same for every radius and nearly for every F; the cheapest of all.
 */
#include "methods/preview/lowres.h"

#include <math.h>
#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

struct lowres {
    const struct rf_blur *blur;
    int factor[2]; /* columns and rows of a block */
    struct rf_grid small;
};

static rf_f4 block_mean(const struct rf_grid *from, int x0, int y0, const int factor[2])
{
    int x1 = rf_min_int(x0 + factor[0], from->width);
    int y1 = rf_min_int(y0 + factor[1], from->height);
    rf_f4 sum = {0};
    for (int y = y0; y < y1; y++) {
        const rf_f4 *row = from->at + (size_t)y * (size_t)from->width;
        rf_f4 line = {0};
        for (int x = x0; x < x1; x++)
            line += row[x];
        sum += line;
    }
    return sum * rf_f4_of(1 / (float)((x1 - x0) * (y1 - y0)));
}

static void reduce_band(void *user, int from, int to, int thread)
{
    struct lowres *l = user;
    for (int j = from; j < to; j++)
        for (int i = 0; i < l->small.width; i++)
            l->small.at[(size_t)j * (size_t)l->small.width + (size_t)i] = block_mean(
                l->blur->source, i * l->factor[0], j * l->factor[1], l->factor);
}

static void magnify_piece(const struct lowres *l, int x0, int y, int n, rf_f4 *out)
{
    const struct rf_grid *small = &l->small;
    float scale = 1 / (float)l->factor[0], radius[RF_PIECE];
    float v = ((float)y + 0.5f) * (1 / (float)l->factor[1]) + 0.5f;
    int j = (int)v;
    rf_f4 fy = rf_f4_of(v - (float)j);
    const rf_f4 *top = small->at + (size_t)rf_clamp_int(j - 1, 0, small->height - 1) *
                                       (size_t)small->width;
    const rf_f4 *low = small->at + (size_t)rf_clamp_int(j, 0, small->height - 1) *
                                       (size_t)small->width;
    const rf_f4 *sharp =
        l->blur->source->at + (size_t)y * (size_t)l->blur->source->width + x0;
    rf_blur_radii(l->blur, x0, y, n, radius);
    for (int k = 0; k < n; k++)
        radius[k] = rf_minf(radius[k] * radius[k] * scale * scale, 1);
    for (int k = 0; k < n; k++) {
        float u = ((float)(x0 + k) + 0.5f) * scale + 0.5f;
        int i = (int)u, left = rf_clamp_int(i - 1, 0, small->width - 1);
        int right = rf_min_int(i, small->width - 1);
        rf_f4 fx = rf_f4_of(u - (float)i);
        rf_f4 a = top[left] + fy * (low[left] - top[left]);
        rf_f4 b = top[right] + fy * (low[right] - top[right]);
        rf_f4 blurred = a + fx * (b - a);
        out[k] = sharp[k] + rf_f4_of(radius[k]) * (blurred - sharp[k]);
    }
}

static void magnify_band(void *user, int from, int to, int thread)
{
    const struct lowres *l = user;
    int width = l->blur->source->width;
    for (int y = from; y < to; y++)
        for (int x = 0; x < width; x += RF_PIECE) {
            rf_f4 out[RF_PIECE];
            int n = rf_min_int(RF_PIECE, width - x);
            magnify_piece(l, x, y, n, out);
            l->blur->put(l->blur, x, y, n, out);
        }
}

rf_result rf_generate_lowres(const struct rf_blur *blur, struct rf_error *error)
{
    const struct rf_context *context = blur->frame->context;
    const struct rf_params *p = &blur->frame->params;
    int rows = (int)rint(p->lowres_factor * p->pixel_aspect);
    struct lowres l = {.blur = blur, .factor = {p->lowres_factor, rf_max_int(rows, 1)}};
    int width = (blur->source->width + l.factor[0] - 1) / l.factor[0];
    int height = (blur->source->height + l.factor[1] - 1) / l.factor[1];
    if (!rf_grid_alloc(context, &l.small, width, height))
        return rf_fail_memory(error, (size_t)width * (size_t)height,
                              sizeof *l.small.at);
    rf_blur_pass(blur, 0, 2, height, 1, reduce_band, &l);
    rf_blur_pass(blur, 1, 2, blur->source->height, RF_BAND_ROWS, magnify_band, &l);
    rf_free(context, l.small.at);
    return RF_OK;
}
