/* SPDX-License-Identifier: Apache-2.0 */
/*
 * What is a lamp, and what is dark, is told by luminances of a picture whose white is 1.
 * Others are multiplied by a power of two, which changes no bit of what comes of them:
 * a picture that is twice as bright, with twice the white, becomes one twice as bright.
 */
#include "input/white.h"

#include <math.h>
#include <stddef.h>

#include "base/context.h"
#include "base/error.h"
#include "base/parallel.h"
#include "base/pool.h"
#include "input/frame.h"
#include "input/image.h"
#include "rackfocus/rackfocus.h"

static float scale_of(const struct rf_frame *frame)
{
    return (float)ldexp(1, -(int)lrint(log2(frame->params.white)));
}

/* What the threads share that scale a picture. Alpha stays. */
struct scaling {
    const struct rf_image *from, *to;
    float scale;
};

static void scale_rows(void *data, int64_t begin, int64_t end, int thread)
{
    const struct scaling *s = data;
    for (int y = (int)begin; y < (int)end; y++)
        for (int x = 0; x < s->to->width; x++)
            for (int c = 0; c < s->to->channels; c++)
                *(float *)rf_image_at(s->to, x, y, c) =
                    *rf_image_at(s->from, x, y, c) * (c < 3 ? s->scale : 1);
}

static void scale_image(const struct rf_context *context, const struct rf_image *from,
                        const struct rf_image *to, float scale)
{
    struct scaling s = {from, to, scale};
    rf_parallel(context, to->height, RF_EQUAL_PARTS, scale_rows, &s);
}

/* Memory that belongs to w. */
static void *allocate(struct rf_whitened *w, size_t n, size_t size,
                      struct rf_error *error)
{
    void *memory = rf_alloc(w->context, n, size);
    if (memory)
        w->memory[w->n_memory++] = memory;
    else
        rf_fail_memory(error, n, size);
    return memory;
}

/* Puts a scaled copy in the place of an image, if there is one. */
static rf_result scale_copy(struct rf_whitened *w, struct rf_image *image,
                            struct rf_error *error)
{
    size_t n = (size_t)image->width * (size_t)image->height;
    if (!image->data)
        return RF_OK;
    float *copy = allocate(w, n, (size_t)image->channels * sizeof(float), error);
    if (!copy)
        return RF_ERROR_MEMORY;
    struct rf_image to =
        rf_image_packed(copy, image->width, image->height, image->channels);
    scale_image(w->context, image, &to, scale_of(&w->frame));
    *image = to;
    return RF_OK;
}

static rf_result scale_unseen(struct rf_whitened *w, struct rf_view *view,
                              struct rf_error *error)
{
    size_t n = view->n_unseen_lights;
    if (n == 0)
        return RF_OK;
    struct rf_unseen_light *lights = allocate(w, n, sizeof *lights, error);
    if (!lights)
        return RF_ERROR_MEMORY;
    for (size_t i = 0; i < n; i++) {
        lights[i] = view->unseen_lights[i];
        for (int c = 0; c < 3; c++)
            lights[i].colour[c] *= scale_of(&w->frame);
    }
    view->unseen_lights = lights;
    return RF_OK;
}

static rf_result scale_seen(struct rf_whitened *w, struct rf_view *view,
                            struct rf_error *error)
{
    size_t n = (size_t)view->n_seen;
    if (n == 0)
        return RF_OK;
    struct rf_seen_light *seen = allocate(w, n, sizeof *seen, error);
    rf_result result = seen ? RF_OK : RF_ERROR_MEMORY;
    for (size_t i = 0; i < n && result == RF_OK; i++) {
        seen[i] = view->seen[i];
        result = scale_copy(w, &seen[i].colour, error);
    }
    view->seen = seen;
    return result;
}

rf_result rf_whiten(struct rf_whitened *w, const struct rf_frame *frame,
                    const struct rf_view *views, int n, struct rf_error *error)
{
    float scale = scale_of(frame);
    rf_result result = RF_OK;
    w->frame = *frame;
    w->context = frame->context;
    w->n_memory = 0;
    for (int j = 0; j < n; j++)
        w->views[j] = views[j];
    if (scale == 1)
        return RF_OK;
    w->frame.params.highlight_clamp *= (double)scale;
    w->frame.params.highlight_threshold *= (double)scale;
    for (int j = 0; j < n && result == RF_OK; j++) {
        result = scale_copy(w, &w->views[j].colour, error);
        if (result == RF_OK)
            result = scale_copy(w, &w->views[j].behind_colour, error);
        if (result == RF_OK)
            result = scale_unseen(w, &w->views[j], error);
        if (result == RF_OK)
            result = scale_seen(w, &w->views[j], error);
    }
    return result;
}

void rf_whitened_free(struct rf_whitened *w)
{
    while (w->n_memory > 0)
        rf_free(w->context, w->memory[--w->n_memory]);
}

void rf_unwhiten(const struct rf_frame *frame, const struct rf_image *out)
{
    float scale = scale_of(frame);
    if (scale != 1)
        scale_image(frame->context, out, out, 1 / scale);
}

size_t rf_whitened_bytes(const struct rf_frame *frame)
{
    return scale_of(frame) != 1 ? 4 * sizeof(float) : 0;
}
