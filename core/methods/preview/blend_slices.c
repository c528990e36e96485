/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Blend slices: planes parallel to the screen on both sides of the focus; what lies
 * beyond one is replaced by a picture blurred by its own radius, back to front.
 *
 *   slice i = 1 .. S on either side: (i - 1/2) R/S <= |r| < (i + 1/2) R/S, the last one
 *   without end;  out = out + m_i (G(c; i R/S) - out),  m_i = 1 inside the slice, else
 * 0 order: behind the focus S .. 1, what is in focus, before the focus 1 .. S
 *
 *   c   the picture     r   signed radius, px     S   --slices
 *   R   --blur-radius, or the radius of what lies at infinity where that is 0
 *
 * With leak control m_i becomes the blurred mask, so that slices before the focus get
 * soft outlines over what is behind them. With --leave-focus-out all but the slice is
 * left out of its blurred picture.
 *
 * Source: master's thesis on depth of field in a surgical simulator (docs/methods.md),
 * "slice planes", at chosen distances; even steps of the radius, which is linear in
 * 1/z, are ours. Its stencil, which marks what has been blurred, is m_i.
 *
 * Known artefacts: borders between the slices; colour leaking.
 *
 * Cost: the generator's once per slice that has pixels, twice with leak control.
 */
#include "methods/preview/blend_slices.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

#include "base/error.h"
#include "base/pool.h"
#include "input/frame.h"
#include "input/views_in.h"
#include "methods/preview/blur.h"
#include "methods/preview/leak.h"
#include "rackfocus/rackfocus.h"

struct slice {
    float from, to; /* signed radius, from <= r < to */
};

static void alpha_of(const struct rf_preview *preview, const void *user, int x, int y,
                     int n, float *alpha)
{
    const struct slice *s = user;
    const float *r =
        preview->work->radius + (size_t)y * (size_t)preview->sharp.width + (size_t)x;
    for (int i = 0; i < n; i++)
        alpha[i] = r[i] >= s->from && r[i] < s->to;
}

static bool has_pixels(const struct rf_preview *p, const struct slice *s)
{
    size_t n = (size_t)p->sharp.width * (size_t)p->sharp.height;
    for (size_t i = 0; i < n; i++)
        if (p->work->radius[i] >= s->from && p->work->radius[i] < s->to)
            return true;
    return false;
}

struct slices {
    struct rf_preview *preview;
    struct rf_grid out;
    int n; /* on either side */
};

/* Slice i, from -n before the focus to n behind it. */
static struct slice slice_at(const struct slices *s, int i)
{
    float step = s->preview->radius_px / (float)s->n;
    struct slice slice = {((float)i - 0.5f) * step, ((float)i + 0.5f) * step};
    if (i == s->n)
        slice.to = INFINITY;
    if (i == -s->n)
        slice.from = -INFINITY;
    return slice;
}

static void copy_band(void *user, int from, int to, int thread)
{
    struct slices *s = user;
    size_t at = (size_t)from * (size_t)s->out.width;
    memcpy(s->out.at + at, s->preview->sharp.at + at,
           (size_t)(to - from) * (size_t)s->out.width * sizeof *s->out.at);
}

/* What is in focus comes back over what was blurred behind it. */
static void focus_band(void *user, int from, int to, int thread)
{
    struct slices *s = user;
    struct slice focus = slice_at(s, 0);
    size_t end = (size_t)to * (size_t)s->out.width;
    for (size_t i = (size_t)from * (size_t)s->out.width; i < end; i++) {
        float r = s->preview->work->radius[i];
        if (r >= focus.from && r < focus.to)
            s->out.at[i] = s->preview->sharp.at[i];
    }
}

static void unpack_band(void *user, int from, int to, int thread)
{
    struct slices *s = user;
    struct rf_work *work = s->preview->work;
    size_t at = (size_t)from * (size_t)s->out.width;
    rf_unpack(s->out.at + at, (to - from) * s->out.width, work->colour, work->n_planes,
              at);
}

static void on_rows(struct slices *s, double progress, rf_band_fn fn)
{
    struct rf_blur pass = {.frame = s->preview->work->frame,
                           .task = s->preview->work->task,
                           .progress_from = progress,
                           .progress_to = progress};
    rf_blur_pass(&pass, 0, 1, s->out.height, RF_BAND_ROWS, fn, s);
}

static rf_result draw_slice(struct slices *s, int i, struct rf_error *error)
{
    double step = 0.9 / (2 * s->n + 1), from = 0.1 + step * (s->n - i);
    struct slice slice = slice_at(s, i);
    if (i == 0)
        on_rows(s, from, focus_band);
    if (i == 0 || !has_pixels(s->preview, &slice))
        return RF_OK;
    struct rf_layer layer = {.preview = s->preview,
                             .base = &s->out,
                             .radius_px =
                                 fabsf((float)i) * s->preview->radius_px / (float)s->n,
                             .alpha = alpha_of,
                             .alpha_user = &slice,
                             .slice = i,
                             .progress_from = from,
                             .progress_to = from + step};
    return rf_layer_run(&layer, error);
}

rf_result rf_blend_slices(struct rf_preview *preview, struct rf_error *error)
{
    const struct rf_frame *f = preview->work->frame;
    struct slices s = {.preview = preview, .n = f->params.slices};
    if (!rf_grid_alloc(f->context, &s.out, f->width, f->height))
        return rf_fail_memory(error, (size_t)f->width * (size_t)f->height,
                              sizeof *s.out.at);
    on_rows(&s, 0.1, copy_band);
    rf_result result = RF_OK;
    for (int i = s.n; i >= -s.n && result == RF_OK; i--)
        result = draw_slice(&s, i, error);
    on_rows(&s, 1, unpack_band);
    rf_free(f->context, s.out.at);
    return result;
}
