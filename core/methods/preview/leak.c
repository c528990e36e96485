/* SPDX-License-Identifier: Apache-2.0 */
/*
 * One blurred copy put over a picture, with control of the colours that leak.
 *
 *   out = base + w (B - base),   B = G(c; r)
 *
 *   none      w = alpha
 *   product   w = (1 - u) mean(a_1 .. a_4) + u a_1 a_2 a_3 a_4,
 *             a_i = A(p + (+-r/2, +-r/2)), to the nearest pixel
 *   hint      w = A
 *   A = G(alpha; r): alpha blurred along with the colour tells how much has leaked
 *
 *   leave out    B = G(alpha c; r) / A, and c where A is 0
 *
 *   alpha   0 in focus, 1 out of it, as the blend defines it    c   the picture
 *   G       the generator          r   radius of the copy, px   u   --leak-weight
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * leak control 1 (there the four are those of its four shifts), leak control 2, and
 * "leave the focused part out of the blurred picture".
 *
 * Known artefacts: with a blurred alpha the rim of what is in focus softens as well;
 * the product keeps it sharper and leaves a sharp fringe around it.
 *
 * Cost: a second run of the generator, for A.
 */
#include "methods/preview/leak.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/context.h"
#include "base/error.h"
#include "base/math.h"
#include "base/pool.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "methods/preview/blur.h"
#include "rackfocus/rackfocus.h"

static const float LEAST_PAINT = 0.3f;  /* brightness of the slice next to the focus */
static const float LEAST_ALPHA = 1e-3f; /* below, too little is left to divide by */

struct mix {
    const struct rf_layer *layer;
    struct rf_grid weighted; /* alpha times colour; at NULL where nothing is left out */
    struct rf_grid alphas;   /* alpha in all four lanes */
    float *blurred;          /* A; NULL where it is not needed */
    bool is_left_out;
};

static const float *layer_alpha(const struct mix *m, int x, int y, int n, float *alpha)
{
    const struct rf_layer *layer = m->layer;
    layer->alpha(layer->preview, layer->alpha_user, x, y, n, alpha);
    return alpha;
}

static void put_alpha(const struct rf_blur *blur, int x, int y, int n, rf_f4 *pixels)
{
    struct mix *m = blur->user;
    float *to = m->blurred + (size_t)y * (size_t)blur->source->width + (size_t)x;
    for (int i = 0; i < n; i++)
        to[i] = pixels[i][0];
}

static void weigh_band(void *user, int from, int to, int thread)
{
    struct mix *m = user;
    const struct rf_grid *sharp = &m->layer->preview->sharp;
    for (int y = from; y < to; y++)
        for (int x = 0; x < sharp->width; x += RF_PIECE) {
            float alpha[RF_PIECE];
            int n = rf_min_int(RF_PIECE, sharp->width - x);
            size_t at = (size_t)y * (size_t)sharp->width + (size_t)x;
            layer_alpha(m, x, y, n, alpha);
            for (int i = 0; i < n; i++)
                m->alphas.at[at + (size_t)i] = rf_f4_of(alpha[i]);
            for (int i = 0; m->is_left_out && i < n; i++)
                m->weighted.at[at + (size_t)i] =
                    sharp->at[at + (size_t)i] * rf_f4_of(alpha[i]);
        }
}

static float product_weight(const struct mix *m, int x, int y, float r)
{
    const struct rf_grid *sharp = &m->layer->preview->sharp;
    float u = (float)m->layer->preview->work->frame->params.leak_weight;
    int d = (int)(r * 0.5f + 0.5f), w = sharp->width, h = sharp->height;
    const float *top = m->blurred + (size_t)rf_max_int(y - d, 0) * (size_t)w;
    const float *low = m->blurred + (size_t)rf_min_int(y + d, h - 1) * (size_t)w;
    int left = rf_max_int(x - d, 0), right = rf_min_int(x + d, w - 1);
    float mean = 0.25f * ((top[left] + top[right]) + (low[left] + low[right]));
    return (1 - u) * mean + u * (top[left] * top[right]) * (low[left] * low[right]);
}

/* w of n pixels; `alpha` receives it. */
static void find_weights(const struct mix *m, const struct rf_blur *blur, int x, int y,
                         int n, float *alpha)
{
    const struct rf_params *p = &blur->frame->params;
    const float *blurred =
        m->blurred ? m->blurred + (size_t)y * (size_t)blur->source->width + (size_t)x
                   : NULL;
    if (p->leak_control == RF_LEAK_HINT) {
        memcpy(alpha, blurred, (size_t)n * sizeof *alpha);
    } else if (p->leak_control == RF_LEAK_PRODUCT) {
        rf_blur_radii(blur, x, y, n, alpha);
        for (int i = 0; i < n; i++)
            alpha[i] = product_weight(m, x + i, y, alpha[i]);
    } else {
        layer_alpha(m, x, y, n, alpha);
    }
}

/*
 * What is put in place of the blurred picture where a stage is asked for: white, so that
 * the result is the weight of the blend; with stage slices a colour for slice i of n
 * (below 0 before the focus), orange before and blue behind it, the brighter the more
 * it is blurred.
 */
static rf_f4 paint(const struct rf_params *params, int i, int n)
{
    if (params->stage != RF_STAGE_SLICES || params->blend != RF_BLEND_SLICES)
        return rf_f4_of(1);
    float v = LEAST_PAINT + (1 - LEAST_PAINT) * (float)(i < 0 ? -i : i) / (float)n;
    return i < 0 ? (rf_f4){v, 0.5f * v, 0.1f * v, 1}
                 : (rf_f4){0.1f * v, 0.4f * v, v, 1};
}

static void put_mix(const struct rf_blur *blur, int x, int y, int n, rf_f4 *pixels)
{
    const struct mix *m = blur->user;
    const struct rf_layer *layer = m->layer;
    size_t at = (size_t)y * (size_t)blur->source->width + (size_t)x;
    const rf_f4 *sharp = layer->preview->sharp.at + at;
    const rf_f4 *base = layer->base ? layer->base->at + at : sharp;
    float weight[RF_PIECE];
    for (int i = 0; m->is_left_out && i < n; i++) {
        float a = m->blurred[at + (size_t)i];
        pixels[i] = a > LEAST_ALPHA ? pixels[i] * rf_f4_of(1 / a) : sharp[i];
    }
    find_weights(m, blur, x, y, n, weight);
    const struct rf_params *params = &blur->frame->params;
    for (int i = 0; params->stage != RF_STAGE_RESULT && i < n; i++)
        pixels[i] = paint(params, layer->slice, params->slices);
    for (int i = 0; i < n; i++)
        pixels[i] = base[i] + rf_f4_of(weight[i]) * (pixels[i] - base[i]);
    struct rf_work *work = layer->preview->work;
    if (layer->base)
        memcpy(layer->base->at + at, pixels, (size_t)n * sizeof *pixels);
    else
        rf_unpack(pixels, n, work->colour, work->n_planes, at);
}

static bool allocate(struct mix *m, const struct rf_grid *like)
{
    const struct rf_context *context = m->layer->preview->work->frame->context;
    m->blurred = rf_alloc(context, (size_t)like->width * (size_t)like->height,
                          sizeof *m->blurred);
    return m->blurred &&
           rf_grid_alloc(context, &m->alphas, like->width, like->height) &&
           (!m->is_left_out ||
            rf_grid_alloc(context, &m->weighted, like->width, like->height));
}

/* Both runs; `blur` is that of the colour. */
static rf_result run_twice(struct mix *m, struct rf_blur *blur, struct rf_error *error)
{
    const struct rf_layer *layer = m->layer;
    const struct rf_grid *sharp = &layer->preview->sharp;
    if (!allocate(m, sharp))
        return rf_fail_memory(error, (size_t)sharp->width * (size_t)sharp->height,
                              2 * sizeof(rf_f4));
    double middle = (layer->progress_from + layer->progress_to) / 2;
    struct rf_blur alpha = *blur;
    alpha.progress_to = middle;
    alpha.source = &m->alphas;
    alpha.put = put_alpha;
    rf_blur_pass(&alpha, 0, 100, sharp->height, RF_BAND_ROWS, weigh_band, m);
    rf_result result = layer->preview->generate(&alpha, error);
    if (result != RF_OK)
        return result;
    blur->progress_from = middle;
    if (m->is_left_out)
        blur->source = &m->weighted;
    return layer->preview->generate(blur, error);
}

rf_result rf_layer_run(const struct rf_layer *layer, struct rf_error *error)
{
    const struct rf_frame *f = layer->preview->work->frame;
    struct mix m = {.layer = layer, .is_left_out = f->params.leave_focus_out != 0};
    struct rf_blur blur = {.frame = f,
                           .task = layer->preview->work->task,
                           .source = &layer->preview->sharp,
                           .radius_map = layer->radius_map,
                           .radius_px = layer->radius_px,
                           .progress_from = layer->progress_from,
                           .progress_to = layer->progress_to,
                           .put = put_mix,
                           .user = &m};
    bool is_plain = f->params.leak_control == RF_LEAK_NONE && !m.is_left_out;
    rf_result result =
        is_plain ? layer->preview->generate(&blur, error) : run_twice(&m, &blur, error);
    rf_free(f->context, m.weighted.at);
    rf_free(f->context, m.alphas.at);
    rf_free(f->context, m.blurred);
    return result;
}
