/* SPDX-License-Identifier: Apache-2.0 */
#include "methods/preview/pyramid.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

/* ---- building ------------------------------------------------------------------ */

struct step {
    const struct rf_grid *from;
    struct rf_grid *to;
};

static void halve_band(void *user, int first, int last, int thread)
{
    const struct step *s = user;
    const struct rf_grid *from = s->from;
    for (int j = first; j < last; j++) {
        const rf_f4 *top = from->at + (size_t)(2 * j) * (size_t)from->width;
        const rf_f4 *low = from->at + (size_t)rf_min_int(2 * j + 1, from->height - 1) *
                                          (size_t)from->width;
        rf_f4 *out = s->to->at + (size_t)j * (size_t)s->to->width;
        for (int i = 0; i < from->width / 2; i++)
            out[i] = ((top[2 * i] + top[2 * i + 1]) + (low[2 * i] + low[2 * i + 1])) *
                     rf_f4_of(0.25f);
        if (from->width % 2) {
            int i = from->width - 1;
            out[i / 2] = (top[i] + low[i]) * rf_f4_of(0.5f);
        }
    }
}

/* The mean of the four samples around every corner; the border counts twice. */
static void corners_band(void *user, int first, int last, int thread)
{
    const struct step *s = user;
    const struct rf_grid *from = s->from;
    int w = from->width, h = from->height;
    for (int j = first; j < last; j++) {
        const rf_f4 *top = from->at + (size_t)rf_max_int(j - 1, 0) * (size_t)w;
        const rf_f4 *low = from->at + (size_t)rf_min_int(j, h - 1) * (size_t)w;
        rf_f4 *out = s->to->at + (size_t)j * (size_t)(w + 1);
        rf_f4 left = top[0] + low[0];
        for (int i = 0; i < w; i++) {
            rf_f4 right = top[i] + low[i];
            out[i] = (left + right) * rf_f4_of(0.25f);
            left = right;
        }
        out[w] = left * rf_f4_of(0.5f);
    }
}

static int count_levels(const struct rf_blur *blur)
{
    int n = 1;
    for (int side = rf_max_int(blur->source->width, blur->source->height); side > 1;
         side = (side + 1) / 2)
        n++;
    return n;
}

rf_result rf_pyramid_build(struct rf_pyramid *p, const struct rf_blur *blur,
                           bool is_offset, struct rf_error *error)
{
    const struct rf_context *context = blur->frame->context;
    struct rf_grid plain = *blur->source, next = {0};
    struct rf_blur half = *blur;
    half.progress_to = (blur->progress_from + blur->progress_to) / 2;
    *p = (struct rf_pyramid){.n_levels = count_levels(blur),
                             .origin = is_offset ? 0 : 0.5f};
    p->level[0] = plain;
    bool is_complete = true;
    for (int i = 1; i < p->n_levels && is_complete; i++) {
        int w = (plain.width + 1) / 2, h = (plain.height + 1) / 2, n = p->n_levels;
        is_complete = rf_grid_alloc(context, &next, w, h);
        if (!is_complete)
            break;
        rf_blur_pass(&half, 2 * i - 2, 2 * n, h, RF_BAND_ROWS, halve_band,
                     &(struct step){&plain, &next});
        if (is_offset && i > 1)
            rf_free(context, plain.at);
        plain = next;
        if (!is_offset) {
            p->level[i] = plain;
            continue;
        }
        is_complete = rf_grid_alloc(context, &p->level[i], w + 1, h + 1);
        if (is_complete)
            rf_blur_pass(&half, 2 * i - 1, 2 * n, h + 1, RF_BAND_ROWS, corners_band,
                         &(struct step){&plain, &p->level[i]});
    }
    if (is_offset && plain.at != blur->source->at)
        rf_free(context, plain.at);
    return is_complete ? RF_OK
                       : rf_fail_memory(error, (size_t)plain.width / 2,
                                        (size_t)plain.height / 2 * sizeof(rf_f4));
}

void rf_pyramid_free(struct rf_pyramid *p, const struct rf_context *context)
{
    for (int i = 1; i < p->n_levels; i++)
        rf_free(context, p->level[i].at);
}

/* ---- sampling ------------------------------------------------------------------ */

struct sampler {
    const struct rf_pyramid *pyramid;
    const struct rf_blur *blur;
    float scale;
};

/* Bilinear in level l at the centre of pixel (x, y). */
static inline rf_f4 sample(const struct rf_pyramid *p, int l, int x, int y)
{
    const struct rf_grid *g = &p->level[l];
    uint32_t bits = (uint32_t)(127 - l) << 23;
    float scale; /* 2^-l */
    memcpy(&scale, &bits, sizeof scale);
    /* One more than the place in samples, so that it is never negative. */
    float u = ((float)x + 0.5f) * scale + 1 - p->origin;
    float v = ((float)y + 0.5f) * scale + 1 - p->origin;
    int i = (int)u, j = (int)v;
    rf_f4 fx = rf_f4_of(u - (float)i), fy = rf_f4_of(v - (float)j);
    int left = rf_max_int(i - 1, 0), right = rf_min_int(i, g->width - 1);
    const rf_f4 *top = g->at + (size_t)rf_max_int(j - 1, 0) * (size_t)g->width;
    const rf_f4 *low = g->at + (size_t)rf_min_int(j, g->height - 1) * (size_t)g->width;
    rf_f4 a = top[left] + fy * (low[left] - top[left]);
    rf_f4 b = top[right] + fy * (low[right] - top[right]);
    return a + fx * (b - a);
}

/* Level and the weight of the next one: T = 2^l (1 + t). */
static inline int level_of(float t_px, int n_levels, float *t)
{
    uint32_t bits;
    memcpy(&bits, &t_px, sizeof bits);
    int l = (int)(bits >> 23) - 127;
    bits = (bits & 0x7fffffu) | 0x3f800000u;
    float m;
    memcpy(&m, &bits, sizeof m);
    *t = m - 1;
    if (l < n_levels - 1)
        return l;
    *t = 0;
    return n_levels - 1;
}

static void sample_piece(const struct sampler *s, int x0, int y, int n, rf_f4 *out)
{
    const struct rf_pyramid *p = s->pyramid;
    const rf_f4 *sharp =
        s->blur->source->at + (size_t)y * (size_t)s->blur->source->width + x0;
    float t_px[RF_PIECE];
    rf_blur_radii(s->blur, x0, y, n, t_px);
    for (int k = 0; k < n; k++)
        t_px[k] = sqrtf(1 + s->scale * t_px[k] * t_px[k]);
    for (int k = 0; k < n; k++) {
        float t;
        int l = level_of(t_px[k], p->n_levels, &t);
        rf_f4 a = l ? sample(p, l, x0 + k, y) : sharp[k];
        if (t > 0)
            a += rf_f4_of(t) * (sample(p, l + 1, x0 + k, y) - a);
        out[k] = a;
    }
}

static void sample_band(void *user, int from, int to, int thread)
{
    const struct sampler *s = user;
    int width = s->blur->source->width;
    for (int y = from; y < to; y++)
        for (int x = 0; x < width; x += RF_PIECE) {
            rf_f4 out[RF_PIECE];
            int n = rf_min_int(RF_PIECE, width - x);
            sample_piece(s, x, y, n, out);
            s->blur->put(s->blur, x, y, n, out);
        }
}

void rf_pyramid_sample(const struct rf_pyramid *pyramid, const struct rf_blur *blur,
                       float scale)
{
    struct sampler s = {pyramid, blur, scale};
    rf_blur_pass(blur, 1, 2, blur->source->height, RF_BAND_ROWS, sample_band, &s);
}
